//! A frame as the bits on the wire: fields, bit stuffing, CRC-15, exact length.
//!
//! | field | 11-bit identifier | 29-bit identifier |
//! |---|---|---|
//! | start of frame | 1, dominant | 1, dominant |
//! | arbitration | identifier 11, RTR 1 | base identifier 11, SRR 1 (1), IDE 1 (1), extension 18, RTR 1 |
//! | control | IDE 1 (0), r0 1 (0), DLC 4 | r1 1 (0), r0 1 (0), DLC 4 |
//! | data | 8 times 0 to 8 | the same |
//! | CRC | 15, delimiter 1 (1) | the same |
//! | acknowledge | slot 1, delimiter 1 (1) | the same |
//! | end of frame | 7 (1) | the same |
//!
//! So 44 + 8n or 64 + 8n bits for n data bytes before stuffing; three bits of intermission follow. From start of frame
//! to the last CRC bit, five equal bits are followed by a stuff bit of the other polarity. A dominant bit is 0.
//! Source: Bosch CAN Specification 2.0 (1991), parts A 3.1 and B 3.1; ISO 11898-1.

use embedded_can_types::Id;

use crate::frame::Frame;

/// Bits from the CRC delimiter to the end of frame, which are not stuffed: delimiter, ACK slot, ACK delimiter, EOF 7.
pub const TRAILER_BITS: u32 = 10;

/// Recessive bits between a frame and whatever follows.
pub const INTERMISSION_BITS: u32 = 3;

/// The field that a bit belongs to.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Field {
    /// Start of frame.
    StartOfFrame,
    /// Identifier, SRR, IDE of an extended frame, RTR: here a sender that sees dominant for recessive has lost, and
    /// nothing is wrong. The IDE bit of a standard frame counts too: it decides against an extended frame.
    Arbitration,
    /// Reserved bits and data length code.
    Control,
    /// Data.
    Data,
    /// The 15 bits of the CRC.
    Crc,
    /// CRC delimiter.
    CrcDelimiter,
    /// ACK slot: sent recessive, and pulled dominant by every receiver without an error.
    AckSlot,
    /// ACK delimiter.
    AckDelimiter,
    /// End of frame.
    EndOfFrame,
}

/// One bit of a frame as its sender puts it on the wire.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bit {
    /// `true` is recessive (1), `false` dominant (0).
    pub recessive: bool,
    /// Inserted by bit stuffing; it belongs to the field of the bit before it.
    pub stuff: bool,
    /// Where it belongs.
    pub field: Field,
}

/// The bits of a frame, from start of frame to the end of frame, stuff bits included.
#[derive(Clone, Debug)]
pub struct Bits {
    header: Header,
    /// The next unstuffed bit.
    next: u32,
    run: u32,
    last: bool,
}

/// The bits of `frame` in the order of sending.
#[must_use]
pub fn bits(frame: &Frame) -> Bits {
    Bits { header: Header::of(frame), next: 0, run: 0, last: true }
}

/// The exact length from start of frame to the end of frame, stuff bits included.
#[must_use]
pub fn bit_len(frame: &Frame) -> u32 {
    let header = Header::of(frame);
    header.len.wrapping_add(header.stuffing()).wrapping_add(TRAILER_BITS)
}

/// CRC-15 of the low `len` bits of `value`, most significant first: polynomial 0x4599, initial value 0.
#[must_use]
pub fn crc15(value: u128, len: u32) -> u16 {
    let above = u128::MAX.checked_shl(len).unwrap_or(0);
    crc_of_message(value & !above, len)
}

/// As [`crc15`], of a `value` that has no bits above the message.
fn crc_of_message(value: u128, len: u32) -> u16 {
    // With a zero initial value, leading zeros do not change the CRC, so the bits are taken as whole bytes.
    let bytes = value.to_be_bytes();
    let used = usize::try_from(len.div_ceil(8)).unwrap_or(bytes.len()).min(bytes.len());
    let (_, message) = bytes.split_at(bytes.len().saturating_sub(used));
    // The register is kept left-aligned in 16 bits.
    let register = message.iter().fold(0_u16, |register, &byte| {
        let [high, _] = register.to_be_bytes();
        let entry = CRC_TABLE.get(usize::from(high ^ byte)).copied().unwrap_or_default();
        register << 8 ^ entry
    });
    register >> 1
}

impl Iterator for Bits {
    type Item = Bit;

    fn next(&mut self) -> Option<Bit> {
        if self.run == STUFF_RUN && self.next <= self.header.len {
            self.last = !self.last;
            self.run = 1;
            let field = self.header.field(self.next.saturating_sub(1));
            return Some(Bit { recessive: self.last, stuff: true, field });
        }
        if self.next >= self.header.len.saturating_add(TRAILER_BITS) {
            return None;
        }
        let recessive = self.header.bit(self.next);
        let field = self.header.field(self.next);
        self.next = self.next.saturating_add(1);
        self.run = if self.next > self.header.len {
            0
        } else if recessive == self.last && self.run > 0 {
            self.run.saturating_add(1)
        } else {
            1
        };
        self.last = recessive;
        Some(Bit { recessive, stuff: false, field })
    }
}

/// The bits that are stuffed, start of frame to CRC, before stuffing: at most 118.
#[derive(Clone, Debug)]
struct Header {
    /// Right-aligned, with room for the CRC.
    fields: u128,
    crc: u16,
    len: u32,
    arbitration_end: u32,
    data_start: u32,
    crc_start: u32,
}

impl Header {
    fn of(frame: &Frame) -> Self {
        // The arbitration key is the field as sent, left-aligned in 32 bits; a standard frame's ends with IDE.
        let key = u128::from(frame.arbitration_key());
        // The dominant start of frame is the zero above it. The extended frame's first reserved bit comes along.
        let (mut bits, mut len, arbitration_end) = match frame.id() {
            Id::Standard(_) => (key >> 19, 14_u32, 14),
            Id::Extended(_) => (key << 1, 34, 33),
        };
        // r0 and the DLC are five bits.
        bits = bits << 5 | u128::from(frame.dlc());
        len = len.wrapping_add(5);
        let data_start = len;
        let (data, data_len) = frame.data_bits();
        bits = bits << data_len | u128::from(data);
        let crc_start = len.wrapping_add(data_len);
        let crc = crc_of_message(bits, crc_start);
        let len = crc_start.wrapping_add(CRC_BITS);
        Self { fields: bits << CRC_BITS, crc, len, arbitration_end, data_start, crc_start }
    }

    fn bit(&self, index: u32) -> bool {
        match self.len.checked_sub(index.saturating_add(1)) {
            Some(shift) => (self.fields | u128::from(self.crc)) >> shift & 1 == 1,
            None => true,
        }
    }

    fn field(&self, index: u32) -> Field {
        if index == 0 {
            return Field::StartOfFrame;
        }
        if index < self.arbitration_end {
            return Field::Arbitration;
        }
        if index < self.data_start {
            return Field::Control;
        }
        if index < self.crc_start {
            return Field::Data;
        }
        match index.checked_sub(self.len) {
            None => Field::Crc,
            Some(0) => Field::CrcDelimiter,
            Some(1) => Field::AckSlot,
            Some(2) => Field::AckDelimiter,
            Some(_) => Field::EndOfFrame,
        }
    }

    /// How many stuff bits there are.
    fn stuffing(&self) -> u32 {
        // Pad on the left to whole nibbles with alternating bits, which need no stuffing themselves and end in a
        // recessive bit, so that the dominant start of frame begins a new run.
        let padding = self.len.next_multiple_of(4).wrapping_sub(self.len);
        let padded = self.fields | u128::from(PADDING & ((1_u8 << padding).wrapping_sub(1))) << self.len;
        let high = u64::try_from(padded >> 64).unwrap_or_default();
        let low = u64::try_from(padded & u128::from(u64::MAX)).unwrap_or_default();
        let len = self.len.wrapping_add(padding);
        let mut count = StuffCount { bits: 0, state: AFTER_RECESSIVE };
        count.take(high, len.saturating_sub(64), 0);
        count.take(low, len.min(64), CRC_NIBBLES);
        // Last, because it takes time to compute: a processor can do both at once.
        count.take(low | u64::from(self.crc), CRC_NIBBLES, 0);
        count.bits
    }
}

/// Counts stuff bits, four bits at a step.
struct StuffCount {
    bits: u32,
    /// The state of [`STUFF_TABLE`], in the high nibble.
    state: u8,
}

impl StuffCount {
    /// Goes on with the bits of `word` below `from`, down to `to`, both multiples of four.
    fn take(&mut self, word: u64, from: u32, to: u32) {
        let mut left = from;
        while left > to {
            left = left.wrapping_sub(4);
            let [nibble, ..] = (word >> left).to_le_bytes();
            let index = usize::from(self.state | nibble & 0xF);
            let step = STUFF_TABLE.get(index).copied().unwrap_or_default();
            self.bits = self.bits.wrapping_add(u32::from(step & 0xF));
            self.state = step & 0xF0;
        }
    }
}

const STUFF_RUN: u32 = 5;
const PADDING: u8 = 0b0101;
const CRC_BITS: u32 = 15;
/// Whole nibbles that hold the CRC.
const CRC_NIBBLES: u32 = 16;
/// One recessive bit was seen.
const AFTER_RECESSIVE: u8 = 5 << 4;
const CRC_POLYNOMIAL: u16 = 0x4599;
const CRC_TABLE: [u16; 256] = crc_table();
/// Indexed by state and nibble: the next state (high nibble) and the number of stuff bits inserted (low nibble). State
/// 0 to 4 is a run of 1 to 5 dominant bits, 5 to 9 one of recessive bits.
const STUFF_TABLE: [u8; 160] = stuff_table();

const fn crc_table() -> [u16; 256] {
    let mut table = [0; 256];
    let mut rest: &mut [u16] = &mut table;
    let mut byte: u16 = 0;
    while let Some((entry, tail)) = rest.split_first_mut() {
        let mut crc = byte << 8;
        let mut bit = 0_u8;
        while bit < 8 {
            crc = if crc & 0x8000 != 0 { crc << 1 ^ CRC_POLYNOMIAL << 1 } else { crc << 1 };
            bit = bit.wrapping_add(1);
        }
        *entry = crc;
        byte = byte.wrapping_add(1);
        rest = tail;
    }
    table
}

const fn stuff_table() -> [u8; 160] {
    let mut table = [0; 160];
    let mut rest: &mut [u8] = &mut table;
    let mut index: u8 = 0;
    while let Some((entry, tail)) = rest.split_first_mut() {
        let (mut state, nibble) = (index >> 4, index & 0xF);
        let mut stuffed = 0_u8;
        let mut mask = 8_u8;
        while mask > 0 {
            let first_of_polarity = if nibble & mask != 0 { 5 } else { 0 };
            let same_polarity = (state >= 5) == (nibble & mask != 0);
            state = if same_polarity { state.wrapping_add(1) } else { first_of_polarity };
            if state == 4 || state == 9 {
                // Five equal bits: the stuff bit begins a run of the other polarity.
                stuffed = stuffed.wrapping_add(1);
                state = if state == 4 { 5 } else { 0 };
            }
            mask >>= 1;
        }
        *entry = state << 4 | stuffed;
        index = index.wrapping_add(1);
        rest = tail;
    }
    table
}

#[cfg(test)]
mod tests;
