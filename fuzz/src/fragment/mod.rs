//! The machines of fragmentation, each against a reference with which it shares nothing.
//!
//! Byte 0 is the limit of the receivers; then each operation is one byte, modulo 8, with its arguments behind it:
//!
//! | Byte | Operation | Arguments |
//! |---|---|---|
//! | 0-2 | a frame for both receivers | fragmentation byte, then 0 to 7 bytes by the bits 6-4 of the operation |
//! | 3 | the expected next fragment of the explicit receiver; bit 7: the last | 0 to 6 bytes |
//! | 4 | the receivers drop what they have, or forget what they had | |
//! | 5 | a message to be sent begins | its length, 16 bits modulo 512 |
//! | 6 | an acknowledge; bit 7: of the present fragment | count, status |
//! | 7 | the acknowledge timer expires; bit 7: the message is given up | |

pub(crate) mod reference;

use arbitrary::{Result, Unstructured};
use cip_core::fragment::{
    AckStatus, EmptyMessage, ExplicitOutcome, ExplicitReassembly, ExplicitTransmit, IoFragments, IoOutcome,
    IoReassembly, TransmitOutcome,
};

use reference::{Explicit, ExplicitReceiver, Io, IoReceiver};

/// Does to the machines what the bytes say.
pub fn run(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let Ok(limit) = input.arbitrary::<u8>() else { return };
    let mut pair = Pair::new(usize::from(limit));
    while !input.is_empty() && pair.step(&mut input).is_ok() {}
}

struct Pair {
    explicit: ExplicitReassembly<CAPACITY>,
    explicit_reference: ExplicitReceiver,
    /// The count that the explicit receiver expects, as the operations know it.
    next: u8,
    io: IoReassembly<CAPACITY>,
    io_reference: IoReceiver,
    transmit: ExplicitTransmit,
    message: Vec<u8>,
    /// The pieces still to be acknowledged, and whether the first of them was sent again.
    unsent: Vec<(u8, Vec<u8>)>,
    again: bool,
}

impl Pair {
    fn new(limit: usize) -> Self {
        Self {
            explicit: ExplicitReassembly::new(limit),
            explicit_reference: ExplicitReceiver::new(limit.min(CAPACITY)),
            next: 1,
            io: IoReassembly::new(limit),
            io_reference: IoReceiver::new(limit.min(CAPACITY)),
            transmit: ExplicitTransmit::new(),
            message: Vec::new(),
            unsent: Vec::new(),
            again: false,
        }
    }

    fn step(&mut self, input: &mut Unstructured<'_>) -> Result<()> {
        let op: u8 = input.arbitrary()?;
        let len = usize::from(op >> 4 & 7);
        match op % 8 {
            0..=2 => {
                let byte = input.arbitrary()?;
                let mut data = [0; 7];
                input.fill_buffer(&mut data[..len])?;
                self.receive_explicit(op >> 7 == 1, byte, &data[..len.min(6)]);
                self.receive_io(&[&[byte][..], &data[..len]].concat()[usize::from(op >> 3 & 1 & op >> 7)..]);
            }
            3 => {
                let kind = if op >> 7 == 1 {
                    0x80
                } else if self.explicit.is_receiving() {
                    0x40
                } else {
                    0x00
                };
                let count = if kind == 0 { 0 } else { self.next };
                let mut data = [0; 6];
                input.fill_buffer(&mut data[..len.min(6)])?;
                self.receive_explicit(false, kind | count, &data[..len.min(6)]);
            }
            4 if op >> 7 == 1 => {
                self.explicit.forget_completed();
                self.explicit_reference.forget_completed();
            }
            4 => {
                self.explicit.discard();
                self.explicit_reference.discard();
                self.io.discard();
                self.io_reference.discard();
            }
            5 => self.begin(usize::from(input.arbitrary::<u16>()? % 512)),
            6 => {
                let (count, status): (u8, u8) = (input.arbitrary()?, input.arbitrary()?);
                let present = self.unsent.first().map_or(0, |(byte, _)| byte % 64);
                self.acknowledge(if op >> 7 == 1 { present } else { count % 64 }, status);
            }
            _ if op >> 7 == 1 => {
                assert_eq!(self.transmit.abort(), !self.unsent.is_empty());
                self.unsent.clear();
            }
            _ => self.time_out(),
        }
        self.compare();
        Ok(())
    }

    fn receive_explicit(&mut self, xid: bool, byte: u8, data: &[u8]) {
        let expected = self.explicit_reference.fragment(xid, byte, data);
        let outcome = self.explicit.fragment(xid, byte.into(), data);
        let found = match (outcome.ack(), &outcome) {
            (_, ExplicitOutcome::Acknowledge) => Explicit::ForSender,
            (None, _) => Explicit::Silent,
            (Some(status), ExplicitOutcome::Complete(message)) => {
                Explicit::Acknowledge(status.into(), Some(message.to_vec()))
            }
            (Some(status), _) => Explicit::Acknowledge(status.into(), None),
        };
        match outcome {
            ExplicitOutcome::Stored => self.next = (byte % 64 + 1) % 64,
            ExplicitOutcome::OutOfSequence { expected, found } => {
                assert_eq!((expected, found), (self.next, byte % 64));
            }
            _ => {}
        }
        assert_eq!(found, expected, "{byte:02X}");
    }

    fn receive_io(&mut self, field: &[u8]) {
        let expected = self.io_reference.frame(field);
        let found = match self.io.frame(field) {
            IoOutcome::Stored => Io::Stored,
            IoOutcome::Complete(message) => Io::Complete(message.to_vec()),
            IoOutcome::TooLong => Io::TooLong,
            IoOutcome::OutOfSequence { .. }
            | IoOutcome::IgnoredNoFirst
            | IoOutcome::InvalidFirst { .. }
            | IoOutcome::UnexpectedAcknowledge => Io::Discarded,
        };
        assert_eq!(found, expected, "{field:02X?}");
    }

    fn begin(&mut self, len: usize) {
        self.message = (0..len).map(|at| (at % 251) as u8).collect();
        self.unsent = reference::explicit_pieces(&self.message);
        self.again = false;
        assert_eq!(self.transmit.start(&self.message), !self.unsent.is_empty());
        for (empty, as_3f) in [(EmptyMessage::NoData, false), (EmptyMessage::FirstAndOnly, true)] {
            match IoFragments::new(&self.message, empty) {
                Some(fields) => {
                    let fields: Vec<Vec<u8>> = fields.map(|field| field.to_vec()).collect();
                    assert_eq!(fields, reference::io_fields(&self.message, as_3f));
                }
                None => assert!(len > 448),
            }
        }
    }

    fn acknowledge(&mut self, count: u8, status: u8) {
        let expected = match self.unsent.first() {
            Some((byte, _)) if byte % 64 == count => {
                self.again = false;
                if status != 0 {
                    self.unsent.clear();
                    TransmitOutcome::Refused(AckStatus::from(status))
                } else {
                    self.unsent.remove(0);
                    if self.unsent.is_empty() { TransmitOutcome::Complete } else { TransmitOutcome::Send }
                }
            }
            _ => TransmitOutcome::Ignored,
        };
        assert_eq!(self.transmit.acknowledge(&self.message, count, AckStatus::from(status)), expected);
    }

    fn time_out(&mut self) {
        let expected = if self.unsent.is_empty() {
            TransmitOutcome::Ignored
        } else if self.again {
            self.unsent.clear();
            TransmitOutcome::Abandoned
        } else {
            self.again = true;
            TransmitOutcome::Send
        };
        assert_eq!(self.transmit.time_out(), expected);
    }

    fn compare(&self) {
        assert_eq!(self.explicit.is_receiving(), self.explicit_reference.is_receiving());
        assert_eq!(self.explicit.received(), self.explicit_reference.received());
        assert_eq!(self.explicit.remembers_completed(), self.explicit_reference.remembers_completed());
        assert_eq!(self.io.is_receiving(), self.io_reference.is_receiving());
        let present = self.transmit.fragment(&self.message);
        let present = present.map(|fragment| (u8::from(fragment.byte), fragment.data.to_vec()));
        assert_eq!(present.as_ref(), self.unsent.first());
        assert_eq!(self.transmit.is_sending(), present.is_some());
    }
}

/// Less than the greatest limit, so that both are met.
const CAPACITY: usize = 200;

#[cfg(test)]
mod tests {
    use super::*;

    fn after(bytes: &[u8]) -> Pair {
        run(bytes);
        let mut input = Unstructured::new(bytes);
        let mut pair = Pair::new(usize::from(input.arbitrary::<u8>().unwrap()));
        while !input.is_empty() {
            pair.step(&mut input).unwrap();
        }
        pair
    }

    #[test]
    fn fragments_are_received() {
        let first = [0x63, 1, 2, 3, 4, 5, 6];
        assert_eq!(after(&[&[40][..], &first].concat()).explicit.received(), 6);
        let complete = after(&[&[40][..], &first, &[0x93, 7]].concat());
        assert!(complete.explicit.remembers_completed());
        // More than the limit.
        assert!(!after(&[&[9][..], &first, &first].concat()).explicit.is_receiving());
    }

    #[test]
    fn a_message_is_sent() {
        let sending = after(&[0, 5, 20, 0, 0x86, 0, 0, 7]);
        assert_eq!((sending.unsent.len(), sending.again), (3, true));
        assert!(after(&[0, 5, 20, 0, 7, 7]).unsent.is_empty());
        assert!(after(&[0, 5, 20, 0, 0x86, 0, 1]).unsent.is_empty());
    }
}
