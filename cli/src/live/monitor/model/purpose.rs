//! What a frame is on the bus for.

use devicenet_core::monitor::Kind;

/// What the bus is used for. Every frame has one purpose.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::live::monitor) enum Purpose {
    /// Poll and multicast poll: commands and responses.
    Poll,
    /// Bit-strobe: commands and responses.
    Strobe,
    /// Change of state and cyclic, and their acknowledges.
    Change,
    /// I/O on identifiers of its own.
    OtherIo,
    /// Explicit messages, their fragments, UCMM, the unconnected port.
    Explicit,
    /// Duplicate MAC ID check.
    Access,
    /// Device Heartbeat and Device Shutdown.
    Heartbeat,
    /// Offline connection set.
    Offline,
    /// 29-bit and remote frames, identifiers without a use.
    Foreign,
    /// Error frames.
    Errors,
}

impl Purpose {
    /// In the order in which they are shown.
    pub(in crate::live::monitor) const ALL: [Self; 10] = [
        Self::Poll,
        Self::Strobe,
        Self::Change,
        Self::OtherIo,
        Self::Explicit,
        Self::Access,
        Self::Heartbeat,
        Self::Offline,
        Self::Foreign,
        Self::Errors,
    ];
    pub(in crate::live::monitor) const COUNT: usize = Self::ALL.len();

    pub(in crate::live::monitor) const fn of(kind: Kind) -> Self {
        match kind {
            Kind::PollCommand
            | Kind::PollResponse
            | Kind::MulticastPollCommand
            | Kind::MulticastPollResponse => Self::Poll,
            Kind::BitStrobeCommand | Kind::BitStrobeResponse => Self::Strobe,
            Kind::CosCyclic | Kind::CosCyclicAck => Self::Change,
            Kind::Io => Self::OtherIo,
            Kind::ExplicitRequest
            | Kind::ExplicitResponse
            | Kind::UnconnectedRequest
            | Kind::UnconnectedResponse
            | Kind::Group2UnconnectedRequest
            | Kind::Fragment
            | Kind::FragmentAck => Self::Explicit,
            Kind::DupMacRequest | Kind::DupMacResponse => Self::Access,
            Kind::Heartbeat | Kind::Shutdown => Self::Heartbeat,
            Kind::OfflineFaultRequest
            | Kind::OfflineFaultResponse
            | Kind::OfflineOwnershipRequest
            | Kind::OfflineOwnershipResponse => Self::Offline,
            Kind::Reserved | Kind::Invalid | Kind::Foreign => Self::Foreign,
        }
    }

    /// For programs.
    pub(in crate::live::monitor) const fn name(self) -> &'static str {
        match self {
            Self::Poll => "poll",
            Self::Strobe => "bit_strobe",
            Self::Change => "cos_cyclic",
            Self::OtherIo => "other_io",
            Self::Explicit => "explicit",
            Self::Access => "network_access",
            Self::Heartbeat => "heartbeat",
            Self::Offline => "offline",
            Self::Foreign => "foreign",
            Self::Errors => "errors",
        }
    }

    /// For people.
    pub(in crate::live::monitor) const fn words(self) -> &'static str {
        match self {
            Self::Poll => "poll",
            Self::Strobe => "bit-strobe",
            Self::Change => "COS/cyclic",
            Self::OtherIo => "other I/O",
            Self::Explicit => "explicit",
            Self::Access => "net access",
            Self::Heartbeat => "heartbeat",
            Self::Offline => "offline set",
            Self::Foreign => "foreign",
            Self::Errors => "errors",
        }
    }

    pub(in crate::live::monitor) const fn index(self) -> usize {
        self as usize
    }
}

#[cfg(test)]
mod tests {
    use devicenet_core::doctor::{Exchange, Facts};
    use devicenet_core::master::IoInstance;
    use devicenet_core::monitor::Predefined;

    use super::*;

    /// One word for people and one for programs, whoever speaks of it.
    #[test]
    fn change_of_state_and_cyclic_are_called_the_same_everywhere() {
        let names = [Predefined::CosCyclic.to_string(), IoInstance::ChangeOfState.to_string()];
        assert_eq!(names, ["COS/cyclic"; 2]);
        assert_eq!(Purpose::Change.words(), "COS/cyclic");
        assert_eq!(Purpose::Change.name(), "cos_cyclic");
        let patience = core::time::Duration::from_millis(400);
        let facts = Facts::Silence { exchange: Exchange::ChangeOfState, patience };
        let facts = serde_json::to_value(facts).unwrap();
        assert_eq!(facts, serde_json::json!({ "silence": { "exchange": "cos_cyclic", "patience": 0.4 } }));
    }
}
