//! What every controller does with the bits it samples, senders included: destuffing, fields, CRC, form.

use link_core::frame::{extended_id, standard_id};
use link_core::wire::{Field, TRAILER_BITS, crc15};
use link_core::{Frame, Id};

/// What a bit told.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Step {
    /// All is well, and more is to come.
    Fine,
    /// The sixth equal bit where bits are stuffed.
    StuffError,
    /// An illegal bit in a field of fixed form.
    FormError,
    /// The CRC did not match; told after the ACK delimiter, where the error flag is due.
    CrcError,
    /// The last bit of the end of frame was dominant: for a receiver the frame is valid, and this is an overload
    /// condition.
    CompleteThenDominant,
    /// The end of the frame.
    Complete,
}

/// A frame in the course of reception.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub(crate) struct Decoder {
    /// From start of frame to CRC, destuffed, right-aligned.
    bits: u128,
    /// How many of them.
    count: u32,
    /// How many there will be; 0 until the data length code is known.
    total: u32,
    /// Bits of the trailer: CRC delimiter, ACK slot, ACK delimiter, end of frame.
    trailer: u32,
    /// All bits so far, stuff bits included.
    position: u32,
    run: u32,
    last: bool,
    crc_matches: bool,
}

impl Decoder {
    /// Takes a bit.
    pub(crate) fn push(&mut self, recessive: bool) -> Step {
        self.position += 1;
        if self.in_trailer() {
            return self.push_trailer(recessive);
        }
        if self.run == STUFF_RUN {
            if recessive == self.last {
                return Step::StuffError;
            }
            (self.run, self.last) = (1, recessive);
            return Step::Fine;
        }
        self.run = if recessive == self.last { self.run + 1 } else { 1 };
        self.last = recessive;
        self.bits = self.bits << 1 | u128::from(recessive);
        self.count += 1;
        if self.count == self.layout().data_start() {
            self.total = self.count + 8 * self.data_len() + CRC_BITS;
        }
        if self.count == self.total {
            self.crc_matches =
                crc15(self.bits >> CRC_BITS, self.total - CRC_BITS) == (self.bits & 0x7FFF) as u16;
        }
        Step::Fine
    }

    /// How many bits were taken since the start of frame, stuff bits included.
    pub(crate) const fn position(&self) -> u32 {
        self.position
    }

    /// The field of the next bit.
    pub(crate) fn field(&self) -> Field {
        if self.in_trailer() {
            return trailer_field(self.trailer);
        }
        // A stuff bit belongs to the field of the bit before it.
        let index = if self.run == STUFF_RUN { self.count - 1 } else { self.count };
        let layout = self.layout();
        if index == 0 {
            Field::StartOfFrame
        } else if index < layout.arbitration_end() {
            Field::Arbitration
        } else if index < layout.data_start() {
            Field::Control
        } else if index + CRC_BITS < self.total {
            Field::Data
        } else {
            Field::Crc
        }
    }

    /// Where the last bit was that was taken, if it was an error or in the trailer.
    pub(crate) fn last_place(&self) -> (u32, Field) {
        let field = match self.trailer.checked_sub(1) {
            // A wrong stuff bit was not taken in: it would still be next.
            None => self.field(),
            Some(index) => trailer_field(index),
        };
        (self.position - 1, field)
    }

    /// The next bit is the one in which an error-free receiver acknowledges.
    pub(crate) fn acknowledges_now(&self) -> bool {
        self.trailer == 1 && self.crc_matches
    }

    /// The next bit is the last but one of the end of frame, the last in which a receiver may object.
    pub(crate) const fn at_last_but_one_bit(&self) -> bool {
        self.trailer == TRAILER_BITS - 2
    }

    /// The frame. It has meaning once its CRC was taken.
    pub(crate) fn frame(&self) -> Option<Frame> {
        let data_len = self.data_len();
        let field = |from: u32, len: u32| self.bits >> (self.total - from - len) & ((1 << len) - 1);
        let layout = self.layout();
        let dlc = field(layout.data_start() - 4, 4) as u8;
        let remote = field(layout.rtr(), 1) == 1;
        let id: Id = match layout {
            Layout::Standard => standard_id(field(1, 11) as u16).into(),
            Layout::Extended => extended_id((field(1, 11) << 18 | field(14, 18)) as u32).into(),
        };
        if remote {
            return Frame::remote(id, dlc);
        }
        let value = field(layout.data_start(), 8 * data_len) as u64;
        if data_len == 8 {
            return Frame::with_dlc(id, dlc, value.to_be_bytes());
        }
        Frame::new(id, &value.to_be_bytes()[8 - data_len as usize..])
    }

    fn push_trailer(&mut self, recessive: bool) -> Step {
        let index = self.trailer;
        self.trailer += 1;
        match (index, recessive) {
            (ACK_SLOT, _) => Step::Fine,
            (ACK_DELIMITER, true) if !self.crc_matches => Step::CrcError,
            (LAST, true) => Step::Complete,
            (LAST, false) => Step::CompleteThenDominant,
            (_, true) => Step::Fine,
            (_, false) => Step::FormError,
        }
    }

    fn in_trailer(&self) -> bool {
        // A stuff bit may follow the last bit of the CRC.
        self.total > 0 && self.count == self.total && (self.trailer > 0 || self.run != STUFF_RUN)
    }

    fn layout(&self) -> Layout {
        if self.count > IDE && self.bit(IDE) { Layout::Extended } else { Layout::Standard }
    }

    fn data_len(&self) -> u32 {
        let layout = self.layout();
        if self.bit(layout.rtr()) {
            return 0;
        }
        let dlc = self.bits >> (self.count - layout.data_start()) & 0xF;
        (dlc as u32).min(8)
    }

    /// Destuffed bit `index` of those taken.
    fn bit(&self, index: u32) -> bool {
        self.bits >> (self.count - 1 - index) & 1 == 1
    }
}

const fn trailer_field(index: u32) -> Field {
    match index {
        0 => Field::CrcDelimiter,
        ACK_SLOT => Field::AckSlot,
        ACK_DELIMITER => Field::AckDelimiter,
        _ => Field::EndOfFrame,
    }
}

/// Where the fields are, by the destuffed bits from the start of frame.
#[derive(Clone, Copy)]
enum Layout {
    Standard,
    Extended,
}

impl Layout {
    const fn rtr(self) -> u32 {
        match self {
            Self::Standard => 12,
            Self::Extended => 32,
        }
    }

    /// One past RTR and IDE.
    const fn arbitration_end(self) -> u32 {
        match self {
            Self::Standard => 14,
            Self::Extended => 33,
        }
    }

    /// One past the data length code.
    const fn data_start(self) -> u32 {
        match self {
            Self::Standard => 19,
            Self::Extended => 39,
        }
    }
}

const STUFF_RUN: u32 = 5;
const CRC_BITS: u32 = 15;
const IDE: u32 = 13;
const ACK_SLOT: u32 = 1;
const ACK_DELIMITER: u32 = 2;
const LAST: u32 = TRAILER_BITS - 1;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::any_frame;
    use link_core::wire::bits;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_sent_is_received(frame in any_frame()) {
            let mut decoder = Decoder::default();
            let mut last = Step::Fine;
            for bit in bits(&frame) {
                prop_assert_eq!(last, Step::Fine);
                prop_assert_eq!(decoder.field(), bit.field, "bit {}", decoder.position());
                last = decoder.push(bit.recessive);
            }
            prop_assert_eq!(last, Step::Complete);
            prop_assert_eq!(decoder.frame(), Some(frame));
        }

        /// CRC-15 has a Hamming distance of 6, but stuffing weakens it; a single flip is always found.
        #[test]
        fn one_wrong_bit_is_found(frame in any_frame(), which in 1..50_usize) {
            let mut decoder = Decoder::default();
            let outcome = bits(&frame)
                .enumerate()
                .filter(|(_, bit)| bit.field != Field::AckSlot)
                .map(|(index, bit)| (index, bit.recessive != (index == which)))
                .map(|(_, level)| decoder.push(level))
                .find(|step| *step != Step::Fine);
            prop_assert!(!matches!(outcome, Some(Step::Complete) if decoder.frame() == Some(frame)));
        }
    }
}
