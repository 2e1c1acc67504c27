//! The waits of the manager itself; those of a device are in its [slot](super::slot).

use link_core::timers::TimerKey;

/// The waits of the manager itself.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Timer {
    /// The next Mini-who.
    MiniWho,
    /// Hellos without an address are answers.
    Answers,
    /// The next Mini-who may be sent.
    Spacing,
    /// Silence of the other manager.
    Takeover,
    /// The application's request.
    Talk,
    /// What was heard of unknown devices with an address.
    Strangers,
    /// Without an address.
    Rejoin,
}

impl TimerKey<7> for Timer {
    const ALL: [Self; 7] = [
        Self::MiniWho,
        Self::Answers,
        Self::Spacing,
        Self::Takeover,
        Self::Talk,
        Self::Strangers,
        Self::Rejoin,
    ];
    const WHY: [&'static str; 7] = [
        "Mini-who",
        "answers to the Mini-who",
        "a pause after the Mini-who",
        "silence of the other manager",
        "explicit response",
        "whether unknown devices are there still",
        "another address for the manager",
    ];

    fn index(self) -> usize {
        match self {
            Self::MiniWho => 0,
            Self::Answers => 1,
            Self::Spacing => 2,
            Self::Takeover => 3,
            Self::Talk => 4,
            Self::Strangers => 5,
            Self::Rejoin => 6,
        }
    }
}
