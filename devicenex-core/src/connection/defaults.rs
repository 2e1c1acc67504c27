//! What the connections of the predefined set are by default.

use cip_core::connection::TransportClassTrigger;

use crate::message::{ConnectionInstance, Predefined, Production};

impl Predefined {
    /// Attribute 3 **\[D\]**; the table is in the text of [`connection`](crate::connection).
    #[must_use]
    pub const fn transport_class_trigger(self) -> TransportClassTrigger {
        TransportClassTrigger(match self {
            Self::Explicit => 0x83,
            Self::Implicit(Production::Polled, _) => 0x82,
            Self::Implicit(Production::Broadcast | Production::MulticastProducer, _) => 0x10,
            Self::Implicit(Production::ChangeOfState, _) => 0x12,
            Self::Implicit(Production::Cyclic, _) => 0x02,
            Self::Implicit(Production::MulticastConsumer, _) => 0x80,
        })
    }
}

impl ConnectionInstance {
    /// The values that attribute 3 of an I/O connection can be set to. Of the predefined set, change of state and cyclic can do
    /// with or without acknowledges, at any time; a dynamic one takes all that there are, while it is being configured.
    #[must_use]
    pub const fn allowed_triggers(self) -> &'static [TransportClassTrigger] {
        match self {
            Self::Predefined(Predefined::Implicit(Production::ChangeOfState, _)) => {
                &[TransportClassTrigger(0x10), TransportClassTrigger(0x12)]
            }
            Self::Predefined(Predefined::Implicit(Production::Cyclic, _)) => {
                &[TransportClassTrigger(0x00), TransportClassTrigger(0x02)]
            }
            Self::Predefined(_) | Self::Reserved(_) => &[],
            Self::Dynamic(_) => &ALLOWED_TRIGGERS,
        }
    }
}

/// What attribute 3 of a dynamic I/O connection can be **\[D\]**.
pub const ALLOWED_TRIGGERS: [TransportClassTrigger; 7] = [
    TransportClassTrigger(0x00),
    TransportClassTrigger(0x02),
    TransportClassTrigger(0x10),
    TransportClassTrigger(0x12),
    TransportClassTrigger(0x80),
    TransportClassTrigger(0x82),
    ACKNOWLEDGES,
];

/// What it is until it is set: as a polled one **\[D\]**.
pub const DYNAMIC_TRIGGER: TransportClassTrigger = TransportClassTrigger(0x82);

/// Consumes what another node produces by change of state or cyclic, and acknowledges it.
pub(crate) const ACKNOWLEDGES: TransportClassTrigger = TransportClassTrigger(0x92);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::IdentifierLength;
    use cip_core::connection::ProductionTrigger;

    /// The table in the text of the module, row by row.
    #[test]
    fn defaults_are_those_of_the_table() {
        let of = |production| {
            let [one, other] = [IdentifierLength::Standard, IdentifierLength::Extended]
                .map(|length| Predefined::Implicit(production, length).transport_class_trigger().0);
            assert_eq!(one, other);
            one
        };
        assert_eq!(Production::ALL.map(of), [0x82, 0x10, 0x10, 0x12, 0x02, 0x80]);
        assert_eq!(Predefined::Explicit.transport_class_trigger().0, 0x83);
    }

    #[test]
    fn a_trigger_says_what_a_connection_does() {
        for trigger in ALLOWED_TRIGGERS {
            let by_change = trigger.trigger() == ProductionTrigger::CHANGE_OF_STATE;
            assert_eq!(by_change, matches!(trigger.0, 0x10 | 0x12 | 0x92));
            assert_eq!(trigger.is_server(), trigger.0 >= 0x80);
        }
    }
}
