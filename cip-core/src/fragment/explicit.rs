//! Reassembly of explicit messages, every fragment of which is acknowledged.

use super::{FragmentByte, FragmentKind, next_count};

/// The third byte of a fragment acknowledge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AckStatus {
    /// 0: the fragment was taken.
    Success,
    /// 1: the message is too long for the receiver, which has dropped it.
    TooMuchData,
    /// 2-255: reserved.
    Reserved(u8),
}

impl From<u8> for AckStatus {
    fn from(byte: u8) -> Self {
        match byte {
            0 => Self::Success,
            1 => Self::TooMuchData,
            other => Self::Reserved(other),
        }
    }
}

impl From<AckStatus> for u8 {
    fn from(status: AckStatus) -> Self {
        match status {
            AckStatus::Success => 0,
            AckStatus::TooMuchData => 1,
            AckStatus::Reserved(other) => other,
        }
    }
}

/// What became of a fragment of an explicit message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ExplicitOutcome<'b> {
    /// Stored; more must follow.
    Stored,
    /// The message is complete: the body from the service byte on. Acknowledge the fragment first, then process it.
    Complete(&'b [u8]),
    /// The middle fragment before the one expected, repeated because its acknowledge was lost: not stored again.
    Repeated,
    /// The last fragment of the message just completed, repeated: not processed again.
    RepeatedLast,
    /// The message exceeds the limit and was dropped.
    TooLong,
    /// Not the fragment expected; the message was dropped.
    OutOfSequence {
        /// The count that would have continued the message.
        expected: u8,
        /// The count found.
        found: u8,
    },
    /// A middle or last fragment without a first one.
    IgnoredNoFirst,
    /// A first fragment with a count other than 0; what was stored before is dropped.
    InvalidFirst {
        /// The count found.
        count: u8,
    },
    /// An acknowledge, which belongs to the sender's side of the connection.
    Acknowledge,
}

impl ExplicitOutcome<'_> {
    /// The acknowledge that the fragment is answered with, if any. It carries the fragment's own count.
    pub const fn ack(&self) -> Option<AckStatus> {
        match self {
            Self::Stored | Self::Complete(_) | Self::Repeated | Self::RepeatedLast => {
                Some(AckStatus::Success)
            }
            Self::TooLong => Some(AckStatus::TooMuchData),
            Self::OutOfSequence { .. }
            | Self::IgnoredNoFirst
            | Self::InvalidFirst { .. }
            | Self::Acknowledge => None,
        }
    }
}

/// Puts explicit messages of up to `N` bytes together.
///
/// | State | Fragment | Outcome | Next |
/// |---|---|---|---|
/// | any | first, count 0 | [`Stored`](ExplicitOutcome::Stored) or [`TooLong`](ExplicitOutcome::TooLong) | receiving 1, or idle |
/// | any | first, other count | [`InvalidFirst`](ExplicitOutcome::InvalidFirst) | idle |
/// | idle | the last fragment of the completed message again | [`RepeatedLast`](ExplicitOutcome::RepeatedLast) | idle |
/// | idle | middle or last | [`IgnoredNoFirst`](ExplicitOutcome::IgnoredNoFirst) | idle |
/// | receiving e | middle, count e | [`Stored`](ExplicitOutcome::Stored) or [`TooLong`](ExplicitOutcome::TooLong) | receiving e+1, or idle |
/// | receiving e | middle, count e-1 | [`Repeated`](ExplicitOutcome::Repeated) | receiving e |
/// | receiving e | last, count e | [`Complete`](ExplicitOutcome::Complete) or [`TooLong`](ExplicitOutcome::TooLong) | idle |
/// | receiving e | middle or last, other count | [`OutOfSequence`](ExplicitOutcome::OutOfSequence) | idle |
/// | any | acknowledge | [`Acknowledge`](ExplicitOutcome::Acknowledge) | same |
///
/// Counts are modulo 64. The machine keeps no time: its owner calls [`discard`](Self::discard) when an unfragmented
/// message arrives, when the connection ends, or when its receive timer expires, and
/// [`forget_completed`](Self::forget_completed) one second after a completed message.
///
/// ```
/// use cip_core::fragment::{ExplicitOutcome, ExplicitReassembly};
///
/// let mut reassembly = ExplicitReassembly::<32>::new(32);
/// assert_eq!(reassembly.fragment(false, 0x00.into(), b"\x8E\x08GRT1"), ExplicitOutcome::Stored);
/// assert_eq!(reassembly.fragment(false, 0x81.into(), b"-DRT"), ExplicitOutcome::Complete(b"\x8E\x08GRT1-DRT"));
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ExplicitReassembly<const N: usize> {
    buffer: heapless::Vec<u8, N>,
    limit: usize,
    state: State,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum State {
    Idle { completed: Option<Completed> },
    Receiving { expected: u8 },
}

/// Enough of a completed message to know its last fragment again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Completed {
    xid: bool,
    count: u8,
}

impl<const N: usize> ExplicitReassembly<N> {
    /// An idle machine. `limit` is the consumed connection size, counted from the service byte; the capacity `N`
    /// limits as well.
    pub const fn new(limit: usize) -> Self {
        Self { buffer: heapless::Vec::new(), limit, state: IDLE }
    }

    /// True while a message is being received.
    pub const fn is_receiving(&self) -> bool {
        matches!(self.state, State::Receiving { .. })
    }

    /// True while the last fragment of the completed message would be known again.
    pub const fn remembers_completed(&self) -> bool {
        matches!(self.state, State::Idle { completed: Some(_) })
    }

    /// The number of bytes received of the message in progress.
    pub fn received(&self) -> usize {
        if self.is_receiving() { self.buffer.len() } else { 0 }
    }

    /// Drops a message in progress and forgets the completed one.
    pub fn discard(&mut self) {
        self.buffer.clear();
        self.state = IDLE;
    }

    /// Forgets the completed message, so that a repetition of its last fragment is no longer acknowledged. A message
    /// in progress is not touched.
    pub fn forget_completed(&mut self) {
        if let State::Idle { completed: Some(_) } = self.state {
            self.discard();
        }
    }

    /// Takes a fragment: the transaction ID of its header, the fragmentation byte, and the bytes after it.
    pub fn fragment(&mut self, xid: bool, byte: FragmentByte, data: &[u8]) -> ExplicitOutcome<'_> {
        let count = byte.count();
        match (byte.kind, self.state) {
            (FragmentKind::Acknowledge, _) => ExplicitOutcome::Acknowledge,
            (FragmentKind::First, _) if count != 0 => {
                self.discard();
                ExplicitOutcome::InvalidFirst { count }
            }
            (FragmentKind::First, _) => {
                self.buffer.clear();
                self.store(data, State::Receiving { expected: 1 })
            }
            (FragmentKind::Middle, State::Receiving { expected }) if count == expected => {
                self.store(data, State::Receiving { expected: next_count(expected) })
            }
            (FragmentKind::Middle, State::Receiving { expected }) if next_count(count) == expected => {
                ExplicitOutcome::Repeated
            }
            (FragmentKind::Last, State::Receiving { expected }) if count == expected => {
                self.store(data, State::Idle { completed: Some(Completed { xid, count }) })
            }
            (FragmentKind::Middle | FragmentKind::Last, State::Receiving { expected }) => {
                self.discard();
                ExplicitOutcome::OutOfSequence { expected, found: count }
            }
            (FragmentKind::Last, State::Idle { completed })
                if completed == Some(Completed { xid, count }) =>
            {
                ExplicitOutcome::RepeatedLast
            }
            (FragmentKind::Middle | FragmentKind::Last, State::Idle { .. }) => {
                ExplicitOutcome::IgnoredNoFirst
            }
        }
    }

    fn store(&mut self, data: &[u8], next: State) -> ExplicitOutcome<'_> {
        let fits = self.buffer.len().saturating_add(data.len()) <= self.limit;
        if !fits || self.buffer.extend_from_slice(data).is_err() {
            self.discard();
            return ExplicitOutcome::TooLong;
        }
        self.state = next;
        match next {
            State::Idle { .. } => ExplicitOutcome::Complete(&self.buffer),
            State::Receiving { .. } => ExplicitOutcome::Stored,
        }
    }
}

const IDLE: State = State::Idle { completed: None };

#[cfg(test)]
mod tests {
    use super::*;

    type Outcome<'b> = ExplicitOutcome<'b>;

    fn feed<const N: usize>(machine: &mut ExplicitReassembly<N>, byte: u8) -> Outcome<'_> {
        machine.fragment(false, byte.into(), &[byte; 2])
    }

    #[test]
    fn every_row_while_idle() {
        let mut machine = ExplicitReassembly::<8>::new(8);
        assert_eq!(feed(&mut machine, 0x41), Outcome::IgnoredNoFirst);
        assert_eq!(feed(&mut machine, 0x81), Outcome::IgnoredNoFirst);
        assert_eq!(feed(&mut machine, 0x3F), Outcome::InvalidFirst { count: 63 });
        assert_eq!(feed(&mut machine, 0xC1), Outcome::Acknowledge);
        assert!(!machine.is_receiving());
        assert_eq!(feed(&mut machine, 0x00), Outcome::Stored);
        assert!(machine.is_receiving());
    }

    #[test]
    fn every_row_while_receiving() {
        let mut receiving = ExplicitReassembly::<8>::new(8);
        feed(&mut receiving, 0x00);
        feed(&mut receiving, 0x41);

        assert_eq!(feed(&mut receiving.clone(), 0x42), Outcome::Stored);
        let mut machine = receiving.clone();
        assert_eq!(feed(&mut machine, 0x41), Outcome::Repeated);
        assert_eq!(machine, receiving);
        assert_eq!(feed(&mut machine, 0xC1), Outcome::Acknowledge);
        assert_eq!(machine, receiving);
        assert_eq!(feed(&mut machine, 0x82), Outcome::Complete(&[0x00, 0x00, 0x41, 0x41, 0x82, 0x82]));

        for byte in [0x40, 0x43, 0x81, 0x83] {
            let mut machine = receiving.clone();
            assert_eq!(feed(&mut machine, byte), Outcome::OutOfSequence { expected: 2, found: byte & 0x3F });
            assert!(!machine.is_receiving());
        }
        let mut machine = receiving.clone();
        assert_eq!(feed(&mut machine, 0x00), Outcome::Stored);
        assert_eq!(machine.received(), 2);
        assert_eq!(feed(&mut machine, 0x01), Outcome::InvalidFirst { count: 1 });
        assert_eq!(machine, ExplicitReassembly::new(8));
    }

    #[test]
    fn the_limit_counts_and_so_does_the_capacity() {
        for mut machine in [ExplicitReassembly::<8>::new(3), ExplicitReassembly::<8>::new(1)] {
            let first = feed(&mut machine, 0x00);
            let last = if first == Outcome::Stored { feed(&mut machine, 0x81) } else { first };
            assert_eq!(last, Outcome::TooLong);
            assert_eq!(last.ack(), Some(AckStatus::TooMuchData));
            assert!(!machine.is_receiving());
        }
        let mut machine = ExplicitReassembly::<3>::new(100);
        feed(&mut machine, 0x00);
        assert_eq!(feed(&mut machine, 0x81), Outcome::TooLong);
    }

    #[test]
    fn the_last_fragment_is_known_again_until_it_is_forgotten() {
        let mut machine = ExplicitReassembly::<8>::new(8);
        feed(&mut machine, 0x00);
        assert!(matches!(feed(&mut machine, 0x81), Outcome::Complete(_)));
        assert_eq!(feed(&mut machine, 0x81), Outcome::RepeatedLast);
        assert_eq!(feed(&mut machine, 0x81).ack(), Some(AckStatus::Success));
        assert_eq!(machine.fragment(true, 0x81.into(), &[]), Outcome::IgnoredNoFirst);
        assert_eq!(feed(&mut machine, 0x82), Outcome::IgnoredNoFirst);
        machine.forget_completed();
        assert_eq!(feed(&mut machine, 0x81), Outcome::IgnoredNoFirst);
        assert_eq!(machine, ExplicitReassembly::new(8));
    }

    #[test]
    fn forgetting_leaves_a_message_in_progress_alone() {
        let mut machine = ExplicitReassembly::<8>::new(8);
        feed(&mut machine, 0x00);
        machine.forget_completed();
        assert!(machine.is_receiving());
        machine.discard();
        assert!(!machine.is_receiving());
    }
}
