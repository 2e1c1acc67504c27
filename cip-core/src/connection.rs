//! The Connection object (class 5): the values of its attributes and their defaults in the predefined connection set.

use core::fmt;

use crate::code::InstanceId;
use crate::text::{write_decimal, write_hex8};

crate::code::codes! {
    /// The state of a connection (attribute 1).
    pub struct ConnectionState(u8), "connection state" in decimal {
        NON_EXISTENT = 0, "Non-existent";
        CONFIGURING = 1, "Configuring";
        WAITING_FOR_CONNECTION_ID = 2, "Waiting for connection ID";
        ESTABLISHED = 3, "Established";
        TIMED_OUT = 4, "Timed out";
        DEFERRED_DELETE = 5, "Deferred delete";
        /// Not on DeviceNet.
        CLOSING = 6, "Closing";
    }
}

crate::code::codes! {
    /// The type of a connection (attribute 2).
    pub struct InstanceType(u8), "instance type" in decimal {
        EXPLICIT = 0, "Explicit messaging";
        IO = 1, "I/O";
        BRIDGED = 2, "Bridged";
    }
}

crate::code::codes! {
    /// What happens when a connection times out (attribute 12).
    pub struct WatchdogAction(u8), "watchdog action" in decimal {
        TRANSITION_TO_TIMED_OUT = 0, "Transition to timed out";
        AUTO_DELETE = 1, "Auto delete";
        AUTO_RESET = 2, "Auto reset";
        DEFERRED_DELETE = 3, "Deferred delete";
    }
}

/// transportClass_trigger (attribute 3).
///
/// | Bits | Content |
/// |---|---|
/// | 7 | 0 client, 1 server |
/// | 6-4 | [`ProductionTrigger`] |
/// | 3-0 | transport class 0-6 |
///
/// ```
/// use cip_core::connection::TransportClassTrigger;
///
/// assert_eq!(TransportClassTrigger(0x83).to_string(), "0x83 server, Cyclic, class 3");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TransportClassTrigger(pub u8);

crate::code::codes! {
    /// What makes a client produce: bits 6-4 of [`TransportClassTrigger`].
    pub struct ProductionTrigger(u8), "production trigger" in decimal {
        CYCLIC = 0, "Cyclic";
        CHANGE_OF_STATE = 1, "Change of state";
        APPLICATION_OBJECT = 2, "Application object";
    }
}

impl TransportClassTrigger {
    /// True for a server, false for a client.
    pub const fn is_server(self) -> bool {
        self.0 & 0x80 != 0
    }

    /// What makes a client produce.
    pub const fn trigger(self) -> ProductionTrigger {
        ProductionTrigger((self.0 >> 4) & 0x07)
    }

    /// The transport class: 0 without duplicate detection, 2 acknowledged, 3 acknowledged and verified.
    pub const fn class(self) -> u8 {
        self.0 & 0x0F
    }
}

impl fmt::Display for TransportClassTrigger {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("0x")?;
        write_hex8(f, self.0)?;
        f.write_str(if self.is_server() { " server, " } else { " client, " })?;
        fmt::Display::fmt(&self.trigger(), f)?;
        f.write_str(", class ")?;
        write_decimal(f, self.class().into())
    }
}

/// initial_comm_characteristics (attribute 6): bits 7-4 how it produces, bits 3-0 how it consumes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CommCharacteristics(pub u8);

crate::code::codes! {
    /// One nibble of [`CommCharacteristics`].
    pub struct CommDirection(u8), "communication" in decimal {
        GROUP_1 = 0, "Group 1";
        GROUP_2_DESTINATION = 1, "Group 2 with destination MAC ID";
        GROUP_2_SOURCE = 2, "Group 2 with source MAC ID";
        GROUP_3 = 3, "Group 3";
        NONE = 15, "none";
    }
}

impl CommCharacteristics {
    /// How the connection produces.
    pub const fn produce(self) -> CommDirection {
        CommDirection(self.0 >> 4)
    }

    /// How the connection consumes.
    pub const fn consume(self) -> CommDirection {
        CommDirection(self.0 & 0x0F)
    }
}

impl fmt::Display for CommCharacteristics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("0x")?;
        write_hex8(f, self.0)?;
        f.write_str(" produces: ")?;
        fmt::Display::fmt(&self.produce(), f)?;
        f.write_str(", consumes: ")?;
        fmt::Display::fmt(&self.consume(), f)
    }
}

/// connection_timeout_multiplier (attribute 18): the inactivity timeout is the expected packet rate times 4, 8, 16
/// and so on up to 512.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TimeoutMultiplier(pub u8);

impl TimeoutMultiplier {
    /// The factor, 4-512; `None` for the reserved values above 7.
    pub const fn factor(self) -> Option<u16> {
        Some(match self.0 {
            0 => 4,
            1 => 8,
            2 => 16,
            3 => 32,
            4 => 64,
            5 => 128,
            6 => 256,
            7 => 512,
            _ => return None,
        })
    }
}

impl fmt::Display for TimeoutMultiplier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(factor) = self.factor() else {
            f.write_str("reserved multiplier ")?;
            return write_decimal(f, self.0.into());
        };
        f.write_str("x")?;
        write_decimal(f, factor.into())
    }
}

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
        let (class_trigger, characteristics) = match self {
            Self::Explicit => (0x83, 0x21),
            Self::Poll => (0x82, 0x01),
            Self::ConsumeOnly => (0x80, 0xF1),
            Self::BitStrobe | Self::MulticastPoll => (0x82, 0x02),
            Self::ChangeOfState { acknowledged: true } => (0x12, 0x01),
            Self::ChangeOfState { acknowledged: false } => (0x10, 0x0F),
            Self::Cyclic { acknowledged: true } => (0x02, 0x01),
            Self::Cyclic { acknowledged: false } => (0x00, 0x0F),
        };
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
            instance_type: if explicit { InstanceType::EXPLICIT } else { InstanceType::IO },
            transport_class_trigger: TransportClassTrigger(class_trigger),
            comm_characteristics: CommCharacteristics(characteristics),
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

/// The expected packet rate of an explicit connection after its allocation, in ms.
pub const EXPLICIT_PACKET_RATE: u16 = 2500;

/// The path to the Acknowledge Handler.
const ACK_HANDLER_PATH: [u8; 4] = [0x20, 0x2B, 0x24, 0x01];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::epath::Epath;
    use std::string::ToString;

    #[test]
    fn attributes_in_text() {
        assert_eq!(TransportClassTrigger(0x12).to_string(), "0x12 client, Change of state, class 2");
        let text = CommCharacteristics(0xF1).to_string();
        assert_eq!(text, "0xF1 produces: none, consumes: Group 2 with destination MAC ID");
        assert_eq!(TimeoutMultiplier(7).to_string(), "x512");
        assert_eq!(TimeoutMultiplier(8).to_string(), "reserved multiplier 8");
    }

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
