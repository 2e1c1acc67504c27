//! The waits of a slave.

use link_core::timers::TimerKey;

use super::application::IoKind;

/// The waits of a slave, besides those of network access.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[repr(u8)]
pub enum Timer {
    /// Of instance 1, or of a connection that was opened dynamically.
    Explicit,
    /// Of instances 2 to 5.
    Io(IoKind),
    /// Transmission trigger of instance 4.
    Trigger,
    /// Production inhibit of instance 4.
    Inhibit,
    /// Acknowledge of the production of instance 4.
    Acknowledge,
    /// Heartbeat interval; before the node is on line, the bit rate that is being tried.
    Heartbeat,
    /// A fragment of a response waits for its acknowledge.
    FragmentAcknowledge,
    /// What arrived of a request in fragments is dropped, or the last one forgotten.
    Reassembly,
}

/// All of them.
impl TimerKey<11> for Timer {
    const ALL: [Self; 11] = [
        Self::Explicit,
        Self::Io(IoKind::Poll),
        Self::Io(IoKind::BitStrobe),
        Self::Io(IoKind::ChangeOfState),
        Self::Io(IoKind::MulticastPoll),
        Self::Trigger,
        Self::Inhibit,
        Self::Acknowledge,
        Self::Heartbeat,
        Self::FragmentAcknowledge,
        Self::Reassembly,
    ];
    const WHY: [&'static str; 11] = names(Self::ALL);

    fn index(self) -> usize {
        match self {
            Self::Explicit => 0,
            Self::Io(IoKind::Poll) => 1,
            Self::Io(IoKind::BitStrobe) => 2,
            Self::Io(IoKind::ChangeOfState) => 3,
            Self::Io(IoKind::MulticastPoll) => 4,
            Self::Trigger => 5,
            Self::Inhibit => 6,
            Self::Acknowledge => 7,
            Self::Heartbeat => 8,
            Self::FragmentAcknowledge => 9,
            Self::Reassembly => 10,
        }
    }
}

/// Those of a device that has poll and no other I/O.
impl TimerKey<5> for Timer {
    const ALL: [Self; 5] = [
        Self::Explicit,
        Self::Io(IoKind::Poll),
        Self::Heartbeat,
        Self::FragmentAcknowledge,
        Self::Reassembly,
    ];
    const WHY: [&'static str; 5] = names(Self::ALL);

    fn index(self) -> usize {
        match self {
            Self::Explicit => 0,
            Self::Io(_) => 1,
            Self::Heartbeat => 2,
            Self::FragmentAcknowledge => 3,
            Self::Reassembly => 4,
            Self::Trigger | Self::Inhibit | Self::Acknowledge => usize::MAX,
        }
    }
}

/// Those of one explicit connection that was opened dynamically.
impl TimerKey<3> for Timer {
    const ALL: [Self; 3] = [Self::Explicit, Self::FragmentAcknowledge, Self::Reassembly];
    const WHY: [&'static str; 3] = names(Self::ALL);

    fn index(self) -> usize {
        match self {
            Self::Explicit => 0,
            Self::FragmentAcknowledge => 1,
            Self::Reassembly => 2,
            Self::Io(_) | Self::Trigger | Self::Inhibit | Self::Acknowledge | Self::Heartbeat => usize::MAX,
        }
    }
}

impl Timer {
    const fn name(self) -> &'static str {
        match self {
            Self::Explicit => "time-out of an explicit connection",
            Self::Io(IoKind::Poll) => "time-out of poll",
            Self::Io(IoKind::BitStrobe) => "time-out of bit-strobe",
            Self::Io(IoKind::ChangeOfState) => "time-out of COS/cyclic",
            Self::Io(IoKind::MulticastPoll) => "time-out of multicast poll",
            Self::Trigger => "transmission trigger",
            Self::Inhibit => "production inhibit time",
            Self::Acknowledge => "acknowledge of COS/cyclic",
            Self::Heartbeat => "heartbeat or bit rate detection",
            Self::FragmentAcknowledge => "acknowledge of a fragment",
            Self::Reassembly => "next fragment",
        }
    }
}

/// The names of these timers, found when the program is compiled.
const fn names<const N: usize>(timers: [Timer; N]) -> [&'static str; N] {
    let mut names = [""; N];
    let (mut timers, mut rest): (&[Timer], &mut [&'static str]) = (&timers, &mut names);
    while let ([timer, later @ ..], [name, after @ ..]) = (timers, rest) {
        *name = timer.name();
        (timers, rest) = (later, after);
    }
    names
}
