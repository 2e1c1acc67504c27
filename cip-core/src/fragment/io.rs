//! Reassembly of I/O messages, which are never acknowledged.

use super::{COUNT_MASK, FragmentByte, FragmentKind, IO_MESSAGE_MAX};

/// What became of a frame on an I/O connection that fragments.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum IoOutcome<'b> {
    /// Stored; more must follow.
    Stored,
    /// The message is complete. An empty message (a frame without data, or the single byte 0x3F) means idle.
    Complete(&'b [u8]),
    /// The message exceeds the limit and was dropped.
    TooLong,
    /// A fragment was lost or repeated; the message was dropped.
    OutOfSequence {
        /// The count that would have continued the message; 64 after the last possible fragment.
        expected: u8,
        /// The count found.
        found: u8,
    },
    /// A middle or last fragment without a first one.
    IgnoredNoFirst,
    /// A first fragment with a count other than 0 and 63; what was stored before is dropped.
    InvalidFirst {
        /// The count found.
        count: u8,
    },
    /// An acknowledge, which does not exist in I/O messages; what was stored before is dropped.
    UnexpectedAcknowledge,
}

/// Puts I/O messages of up to `N` bytes together. A message is delivered whole or not at all.
///
/// | State | Frame | Outcome | Next |
/// |---|---|---|---|
/// | any | no data | [`Complete`](IoOutcome::Complete), empty | idle |
/// | any | first, count 63 | [`Complete`](IoOutcome::Complete) | idle |
/// | any | first, count 0 | [`Stored`](IoOutcome::Stored) | receiving 1 |
/// | any | first, other count | [`InvalidFirst`](IoOutcome::InvalidFirst) | idle |
/// | receiving e | middle, count e | [`Stored`](IoOutcome::Stored) | receiving e+1 |
/// | receiving e | last, count e | [`Complete`](IoOutcome::Complete) | idle |
/// | receiving e | middle or last, other count | [`OutOfSequence`](IoOutcome::OutOfSequence) | idle |
/// | idle | middle or last | [`IgnoredNoFirst`](IoOutcome::IgnoredNoFirst) | idle |
/// | any | acknowledge | [`UnexpectedAcknowledge`](IoOutcome::UnexpectedAcknowledge) | idle |
/// | any | more bytes than the connection size | [`TooLong`](IoOutcome::TooLong) | idle |
///
/// ```
/// use cip_core::fragment::{IoOutcome, IoReassembly};
///
/// let mut reassembly = IoReassembly::<16>::new(10);
/// assert_eq!(reassembly.frame(&[0x00, 1, 2, 3, 4, 5, 6, 7]), IoOutcome::Stored);
/// assert_eq!(reassembly.frame(&[0x81, 8, 9, 10]), IoOutcome::Complete(&[1, 2, 3, 4, 5, 6, 7, 8, 9, 10]));
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct IoReassembly<const N: usize> {
    buffer: heapless::Vec<u8, N>,
    limit: usize,
    /// The count expected next, 1-64, while a message is being received.
    expected: Option<u8>,
}

impl<const N: usize> IoReassembly<N> {
    /// An idle machine. `limit` is the consumed connection size; the capacity `N` and [`IO_MESSAGE_MAX`] limit as well.
    pub const fn new(limit: usize) -> Self {
        let limit = if limit < IO_MESSAGE_MAX { limit } else { IO_MESSAGE_MAX };
        Self { buffer: heapless::Vec::new(), limit, expected: None }
    }

    /// True while a message is being received.
    pub const fn is_receiving(&self) -> bool {
        self.expected.is_some()
    }

    /// Drops a message in progress.
    pub fn discard(&mut self) {
        self.buffer.clear();
        self.expected = None;
    }

    /// Takes the data field of a frame.
    pub fn frame(&mut self, field: &[u8]) -> IoOutcome<'_> {
        let Some((&byte, data)) = field.split_first() else {
            self.discard();
            return IoOutcome::Complete(&[]);
        };
        let byte = FragmentByte::from(byte);
        let count = byte.count();
        match (byte.kind, self.expected) {
            (FragmentKind::Acknowledge, _) => {
                self.discard();
                IoOutcome::UnexpectedAcknowledge
            }
            (FragmentKind::First, _) => {
                self.discard();
                match count {
                    0 => self.store(data, Some(1)),
                    COUNT_MASK => self.store(data, None),
                    _ => IoOutcome::InvalidFirst { count },
                }
            }
            (FragmentKind::Middle, Some(expected)) if count == expected => {
                self.store(data, Some(expected.saturating_add(1)))
            }
            (FragmentKind::Last, Some(expected)) if count == expected => self.store(data, None),
            (FragmentKind::Middle | FragmentKind::Last, Some(expected)) => {
                self.discard();
                IoOutcome::OutOfSequence { expected, found: count }
            }
            (FragmentKind::Middle | FragmentKind::Last, None) => IoOutcome::IgnoredNoFirst,
        }
    }

    fn store(&mut self, data: &[u8], expected: Option<u8>) -> IoOutcome<'_> {
        let fits = self.buffer.len().saturating_add(data.len()) <= self.limit;
        if !fits || self.buffer.extend_from_slice(data).is_err() {
            self.discard();
            return IoOutcome::TooLong;
        }
        self.expected = expected;
        match expected {
            Some(_) => IoOutcome::Stored,
            None => IoOutcome::Complete(&self.buffer),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_while_idle() {
        let mut machine = IoReassembly::<16>::new(16);
        assert_eq!(machine.frame(&[]), IoOutcome::Complete(&[]));
        assert_eq!(machine.frame(&[0x3F]), IoOutcome::Complete(&[]));
        assert_eq!(machine.frame(&[0x3F, 7]), IoOutcome::Complete(&[7]));
        assert_eq!(machine.frame(&[0x41, 7]), IoOutcome::IgnoredNoFirst);
        assert_eq!(machine.frame(&[0x81, 7]), IoOutcome::IgnoredNoFirst);
        assert_eq!(machine.frame(&[0x02, 7]), IoOutcome::InvalidFirst { count: 2 });
        assert_eq!(machine.frame(&[0xC0, 0]), IoOutcome::UnexpectedAcknowledge);
        assert!(!machine.is_receiving());
    }

    #[test]
    fn every_row_while_receiving() {
        let mut receiving = IoReassembly::<16>::new(16);
        assert_eq!(receiving.frame(&[0x00, 1]), IoOutcome::Stored);
        let cases: [(&[u8], IoOutcome<'_>, bool); 10] = [
            (&[0x41, 2], IoOutcome::Stored, true),
            (&[0x81, 2], IoOutcome::Complete(&[1, 2]), false),
            (&[0x40, 2], IoOutcome::OutOfSequence { expected: 1, found: 0 }, false),
            (&[0x82, 2], IoOutcome::OutOfSequence { expected: 1, found: 2 }, false),
            (&[], IoOutcome::Complete(&[]), false),
            (&[0x3F, 9], IoOutcome::Complete(&[9]), false),
            (&[0x00, 9], IoOutcome::Stored, true),
            (&[0x3E, 9], IoOutcome::InvalidFirst { count: 0x3E }, false),
            (&[0xC1, 0], IoOutcome::UnexpectedAcknowledge, false),
            (&[0x41; 17], IoOutcome::TooLong, false),
        ];
        for (field, outcome, receives) in cases {
            let mut machine = receiving.clone();
            assert_eq!(machine.frame(field), outcome, "{field:02X?}");
            assert_eq!(machine.is_receiving(), receives, "{field:02X?}");
        }
    }

    #[test]
    fn sixty_four_fragments_are_the_end() {
        let mut machine = IoReassembly::<512>::new(512);
        assert_eq!(machine.frame(&[0x00, 0]), IoOutcome::Stored);
        for count in 1..=63 {
            assert_eq!(machine.frame(&[0x40 | count, 0]), IoOutcome::Stored);
        }
        assert_eq!(machine.frame(&[0x80, 0]), IoOutcome::OutOfSequence { expected: 64, found: 0 });
    }

    #[test]
    fn the_connection_size_limits() {
        let mut machine = IoReassembly::<16>::new(9);
        machine.frame(&[0x00, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(machine.frame(&[0x81, 8, 9, 10]), IoOutcome::TooLong);
        assert!(!machine.is_receiving());
    }
}
