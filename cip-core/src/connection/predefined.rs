//! The predefined master/slave connection set: which connections there are, and their defaults.

use super::values::{
    CommCharacteristics, ConnectionState, InstanceType, TransportClassTrigger, WatchdogAction,
};
use crate::code::InstanceId;

/// A connection of the predefined master/slave connection set, with what makes its defaults differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PredefinedConnection {
    /// Instance 1.
    Explicit,
    /// Instance 2.
    Poll,
    /// Instance 2 as the direction to the slave of change-of-state or cyclic messages that are not acknowledged, when
    /// poll is not allocated: it consumes and never produces.
    ConsumeOnly,
    /// Instance 3.
    BitStrobe,
    /// Instance 4, with change of state.
    ChangeOfState {
        /// False with acknowledge suppression.
        acknowledged: bool,
    },
    /// Instance 4, cyclic.
    Cyclic {
        /// False with acknowledge suppression.
        acknowledged: bool,
    },
    /// Instance 5.
    MulticastPoll,
}

/// The attributes that a connection of the predefined set has after its allocation, apart from those that depend on the
/// device (sizes and assemblies) and on MAC IDs (connection IDs). The production inhibit time is always 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ConnectionDefaults {
    /// Attribute 1.
    pub state: ConnectionState,
    /// Attribute 2.
    pub instance_type: InstanceType,
    /// Attribute 3.
    pub transport_class_trigger: TransportClassTrigger,
    /// Attribute 6.
    pub comm_characteristics: CommCharacteristics,
    /// Attribute 9, in ms.
    pub expected_packet_rate: u16,
    /// Attribute 12.
    pub watchdog_action: WatchdogAction,
    /// Attribute 16 where the device has no choice: the Acknowledge Handler that consumes the acknowledges.
    pub consumed_path: &'static [u8],
}

impl PredefinedConnection {
    /// The instance of the Connection object.
    pub const fn instance(self) -> InstanceId {
        InstanceId(match self {
            Self::Explicit => 1,
            Self::Poll | Self::ConsumeOnly => 2,
            Self::BitStrobe => 3,
            Self::ChangeOfState { .. } | Self::Cyclic { .. } => 4,
            Self::MulticastPoll => 5,
        })
    }

    /// Attribute 2.
    pub const fn instance_type(self) -> InstanceType {
        if matches!(self, Self::Explicit) { InstanceType::EXPLICIT } else { InstanceType::IO }
    }

    /// Attribute 3.
    pub const fn transport_class_trigger(self) -> TransportClassTrigger {
        TransportClassTrigger(match self {
            Self::Explicit => 0x83,
            Self::Poll | Self::BitStrobe | Self::MulticastPoll => 0x82,
            Self::ConsumeOnly => 0x80,
            Self::ChangeOfState { acknowledged: true } => 0x12,
            Self::ChangeOfState { acknowledged: false } => 0x10,
            Self::Cyclic { acknowledged: true } => 0x02,
            Self::Cyclic { acknowledged: false } => 0x00,
        })
    }

    /// Attribute 6.
    pub const fn comm_characteristics(self) -> CommCharacteristics {
        CommCharacteristics(match self {
            Self::Explicit => 0x21,
            Self::Poll | Self::ChangeOfState { acknowledged: true } | Self::Cyclic { acknowledged: true } => {
                0x01
            }
            Self::BitStrobe | Self::MulticastPoll => 0x02,
            Self::ConsumeOnly => 0xF1,
            Self::ChangeOfState { acknowledged: false } | Self::Cyclic { acknowledged: false } => 0x0F,
        })
    }

    /// The defaults, as printed by most product manuals (Rockwell 1329I, 193-EDN and 855T, ICP DAS I-7242D, Omron E5AR,
    /// INFICON Composer Elite).
    ///
    /// | Connection | state | type | class/trigger | characteristics | EPR | watchdog | consumed path |
    /// |---|---|---|---|---|---|---|---|
    /// | explicit | 3 | 0 | 0x83 | 0x21 | 2500 | 1 | |
    /// | poll | 1 | 1 | 0x82 | 0x01 | 0 | 0 | device |
    /// | consume only | 1 | 1 | 0x80 | 0xF1 | 0 | 0 | device |
    /// | bit-strobe | 1 | 1 | 0x82 | 0x02 | 0 | 0 | device |
    /// | change of state | 1 | 1 | 0x12 | 0x01 | 0 | 0 | `20 2B 24 01` |
    /// | cyclic | 1 | 1 | 0x02 | 0x01 | 0 | 0 | `20 2B 24 01` |
    /// | change of state, not acknowledged | 1 | 1 | 0x10 | 0x0F | 0 | 0 | empty |
    /// | cyclic, not acknowledged | 1 | 1 | 0x00 | 0x0F | 0 | 0 | empty |
    /// | multicast poll | 1 | 1 | 0x82 | 0x02 | 0 | 0 | device |
    pub const fn defaults(self) -> ConnectionDefaults {
        let consumed_path: &[u8] = match self {
            Self::ChangeOfState { acknowledged: true } | Self::Cyclic { acknowledged: true } => {
                &ACK_HANDLER_PATH
            }
            Self::Explicit
            | Self::Poll
            | Self::ConsumeOnly
            | Self::BitStrobe
            | Self::ChangeOfState { acknowledged: false }
            | Self::Cyclic { acknowledged: false }
            | Self::MulticastPoll => &[],
        };
        let explicit = matches!(self, Self::Explicit);
        ConnectionDefaults {
            state: if explicit { ConnectionState::ESTABLISHED } else { ConnectionState::CONFIGURING },
            instance_type: self.instance_type(),
            transport_class_trigger: self.transport_class_trigger(),
            comm_characteristics: self.comm_characteristics(),
            expected_packet_rate: if explicit { EXPLICIT_PACKET_RATE } else { 0 },
            watchdog_action: if explicit {
                WatchdogAction::AUTO_DELETE
            } else {
                WatchdogAction::TRANSITION_TO_TIMED_OUT
            },
            consumed_path,
        }
    }
}

impl From<PredefinedConnection> for TransportClassTrigger {
    fn from(connection: PredefinedConnection) -> Self {
        connection.transport_class_trigger()
    }
}

/// The expected packet rate of an explicit connection after its allocation, in ms.
pub const EXPLICIT_PACKET_RATE: u16 = 2500;

/// The path to the Acknowledge Handler.
const ACK_HANDLER_PATH: [u8; 4] = [0x20, 0x2B, 0x24, 0x01];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::connection::{CommDirection, ProductionTrigger};
    use crate::epath::Epath;
    use std::string::ToString;

    /// Attributes 3 and 6 as the manuals named at [`PredefinedConnection::defaults`] print them.
    #[test]
    fn defaults_are_those_of_the_manuals() {
        let cases = [
            (PredefinedConnection::Explicit, 1, 0x83, 0x21),
            (PredefinedConnection::Poll, 2, 0x82, 0x01),
            (PredefinedConnection::ConsumeOnly, 2, 0x80, 0xF1),
            (PredefinedConnection::BitStrobe, 3, 0x82, 0x02),
            (PredefinedConnection::ChangeOfState { acknowledged: true }, 4, 0x12, 0x01),
            (PredefinedConnection::Cyclic { acknowledged: true }, 4, 0x02, 0x01),
            (PredefinedConnection::ChangeOfState { acknowledged: false }, 4, 0x10, 0x0F),
            (PredefinedConnection::Cyclic { acknowledged: false }, 4, 0x00, 0x0F),
            (PredefinedConnection::MulticastPoll, 5, 0x82, 0x02),
        ];
        for (connection, instance, trigger, characteristics) in cases {
            let defaults = connection.defaults();
            assert_eq!(connection.instance(), InstanceId(instance), "{connection:?}");
            assert_eq!(defaults.transport_class_trigger.0, trigger, "{connection:?}");
            assert_eq!(defaults.comm_characteristics.0, characteristics, "{connection:?}");
        }
    }

    #[test]
    fn defaults_agree_with_the_kind_of_connection() {
        let explicit = PredefinedConnection::Explicit.defaults();
        assert_eq!((explicit.state, explicit.expected_packet_rate), (ConnectionState::ESTABLISHED, 2500));
        assert_eq!(explicit.watchdog_action, WatchdogAction::AUTO_DELETE);

        for acknowledged in [false, true] {
            let cos = PredefinedConnection::ChangeOfState { acknowledged }.defaults();
            let cyclic = PredefinedConnection::Cyclic { acknowledged }.defaults();
            assert_eq!(cos.transport_class_trigger.trigger(), ProductionTrigger::CHANGE_OF_STATE);
            assert_eq!(cyclic.transport_class_trigger.trigger(), ProductionTrigger::CYCLIC);
            for defaults in [cos, cyclic] {
                assert!(!defaults.transport_class_trigger.is_server());
                assert_eq!(defaults.comm_characteristics.consume() == CommDirection::NONE, !acknowledged);
                assert_eq!(defaults.transport_class_trigger.class(), if acknowledged { 2 } else { 0 });
                assert_eq!(defaults.consumed_path.is_empty(), !acknowledged);
            }
        }
        let path =
            Epath::packed(PredefinedConnection::Cyclic { acknowledged: true }.defaults().consumed_path);
        assert_eq!(path.to_string(), "class 43 instance 1");
    }
}
