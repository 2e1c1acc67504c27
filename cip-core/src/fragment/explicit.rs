//! Reassembly of explicit messages, every fragment of which is acknowledged.

use core::hash::{Hash, Hasher};

use super::{ExplicitReceive, FragmentByte};

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

/// Puts explicit messages of up to `N` bytes together: an [`ExplicitReceive`] with its buffer.
///
/// ```
/// use cip_core::fragment::{ExplicitOutcome, ExplicitReassembly};
///
/// let mut reassembly = ExplicitReassembly::<32>::new(32);
/// assert_eq!(reassembly.fragment(false, 0x00.into(), b"\x8E\x08GRT1"), ExplicitOutcome::Stored);
/// assert_eq!(reassembly.fragment(false, 0x81.into(), b"-DRT"), ExplicitOutcome::Complete(b"\x8E\x08GRT1-DRT"));
/// ```
#[derive(Debug, Clone)]
pub struct ExplicitReassembly<const N: usize> {
    buffer: [u8; N],
    receive: ExplicitReceive,
}

impl<const N: usize> ExplicitReassembly<N> {
    /// An idle machine. `limit` is the consumed connection size, counted from the service byte; the capacity `N`
    /// limits as well.
    pub const fn new(limit: usize) -> Self {
        Self { buffer: [0; N], receive: ExplicitReceive::new(limit) }
    }

    /// True while a message is being received.
    pub const fn is_receiving(&self) -> bool {
        self.receive.is_receiving()
    }

    /// True while the last fragment of the completed message would be known again.
    pub const fn remembers_completed(&self) -> bool {
        self.receive.remembers_completed()
    }

    /// The number of bytes received of the message in progress.
    pub fn received(&self) -> usize {
        self.receive.received().into()
    }

    /// Drops a message in progress and forgets the completed one.
    pub const fn discard(&mut self) {
        self.receive.discard();
    }

    /// Forgets the completed message, so that a repetition of its last fragment is no longer acknowledged. A message
    /// in progress is not touched.
    pub const fn forget_completed(&mut self) {
        self.receive.forget_completed();
    }

    /// Takes a fragment: the transaction ID of its header, the fragmentation byte, and the bytes after it.
    pub fn fragment(&mut self, xid: bool, byte: FragmentByte, data: &[u8]) -> ExplicitOutcome<'_> {
        self.receive.fragment(&mut self.buffer, xid, byte, data)
    }

    /// What has arrived of the message in progress. What earlier ones have left behind it is no part of the state.
    fn message(&self) -> &[u8] {
        self.buffer.get(..self.received()).unwrap_or_default()
    }
}

impl<const N: usize> PartialEq for ExplicitReassembly<N> {
    fn eq(&self, other: &Self) -> bool {
        (&self.receive, self.message()) == (&other.receive, other.message())
    }
}

impl<const N: usize> Eq for ExplicitReassembly<N> {}

impl<const N: usize> Hash for ExplicitReassembly<N> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (&self.receive, self.message()).hash(state);
    }
}

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
