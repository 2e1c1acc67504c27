//! Reading numbers and words out of one line.

use link_core::{ExtendedId, Id, Instant, StandardId};

use super::error::Fault;

/// A place in a line.
#[derive(Clone, Copy)]
pub(super) struct Scanner<'a> {
    line: &'a [u8],
    at: usize,
}

impl<'a> Scanner<'a> {
    pub(super) fn new(line: &'a [u8]) -> Self {
        Self { line, at: 0 }
    }

    pub(super) fn fault(&self, expected: &'static str) -> Fault {
        Fault { at: self.at, expected }
    }

    #[inline]
    pub(super) fn peek(&self) -> Option<u8> {
        self.line.get(self.at).copied()
    }

    #[inline]
    pub(super) fn eat(&mut self, byte: u8) -> bool {
        let found = self.peek() == Some(byte);
        self.at += usize::from(found);
        found
    }

    /// Goes on by a byte, if there is one.
    pub(super) fn skip(&mut self) {
        self.at += usize::from(self.at < self.line.len());
    }

    #[inline]
    pub(super) fn expect(&mut self, byte: u8, expected: &'static str) -> Result<(), Fault> {
        if self.eat(byte) { Ok(()) } else { Err(self.fault(expected)) }
    }

    #[inline]
    pub(super) fn skip_blanks(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t')) {
            self.at += 1;
        }
    }

    /// The bytes up to the next blank; empty at the end of the line.
    #[inline]
    pub(super) fn word(&mut self) -> &'a [u8] {
        let start = self.at;
        while !matches!(self.peek(), None | Some(b' ' | b'\t')) {
            self.at += 1;
        }
        &self.line[start..self.at]
    }

    /// The word after blanks, without moving on.
    pub(super) fn peek_word(&self) -> &'a [u8] {
        let mut ahead = *self;
        ahead.skip_blanks();
        ahead.word()
    }

    pub(super) fn rest(&self) -> &'a [u8] {
        &self.line[self.at..]
    }

    /// Decimal digits; `None` if there is none, or they exceed 64 bits.
    #[inline]
    pub(super) fn decimal(&mut self) -> Option<u64> {
        let start = self.at;
        let mut value = 0u64;
        while let Some(digit @ b'0'..=b'9') = self.peek() {
            value = value.checked_mul(10)?.checked_add(u64::from(digit - b'0'))?;
            self.at += 1;
        }
        (self.at > start).then_some(value)
    }

    /// Seconds with any number of decimals (those after the ninth are dropped), and how many there are.
    #[inline]
    pub(super) fn seconds(&mut self) -> Result<(Instant, u8), Fault> {
        let before = *self;
        let bad = || before.fault("a time in seconds");
        let seconds = self.decimal().ok_or_else(bad)?;
        let (mut fraction, mut digits) = (0u64, 0u8);
        if self.eat(b'.') {
            while let Some(digit @ b'0'..=b'9') = self.peek() {
                if digits < 9 {
                    fraction = fraction * 10 + u64::from(digit - b'0');
                    digits += 1;
                }
                self.at += 1;
            }
        }
        let nanos = fraction * POWERS_OF_TEN[usize::from(9 - digits)];
        let total = seconds.checked_mul(1_000_000_000).and_then(|s| s.checked_add(nanos)).ok_or_else(bad)?;
        Ok((Instant::from_nanos(total), digits))
    }

    /// An identifier as can-utils write it, up to something that is not a hexadecimal digit.
    #[inline]
    pub(super) fn can_id(&mut self) -> Result<CanId, Fault> {
        let start = *self;
        let mut value = 0u32;
        while let Some(digit) = self.peek().and_then(hex) {
            value = value << 4 | u32::from(digit);
            self.at += 1;
            if self.at - start.at > 8 {
                return Err(start.fault("an identifier of at most 8 hexadecimal digits"));
            }
        }
        match self.at - start.at {
            0 => Err(start.fault("an identifier in hexadecimal")),
            1..=3 => {
                let id = u16::try_from(value).ok().and_then(StandardId::new);
                let id = id.ok_or_else(|| start.fault("an 11-bit identifier, 000 to 7FF"))?;
                Ok(CanId::Frame { id: Id::Standard(id), remote: false })
            }
            _ if value & ERROR_FLAG != 0 => Ok(CanId::Error { class: value & ID_MASK }),
            _ => CanId::extended(value).ok_or_else(|| start.fault("an identifier")),
        }
    }

    /// A byte in hexadecimal: two digits, or none consumed.
    #[inline]
    pub(super) fn hex_byte(&mut self) -> Option<u8> {
        let (high, low) = (*self.line.get(self.at)?, *self.line.get(self.at + 1)?);
        let (high, low) = (HEX[usize::from(high)], HEX[usize::from(low)]);
        if (high | low) > 0xF {
            return None;
        }
        self.at += 2;
        Some(high << 4 | low)
    }

    /// One hexadecimal digit.
    #[inline]
    pub(super) fn hex_digit(&mut self) -> Option<u8> {
        let digit = hex(self.peek()?)?;
        self.at += 1;
        Some(digit)
    }
}

/// The sum of times that are distances from line to line.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Sum {
    at: Instant,
    /// The most decimals of any of them, which are what the sum has.
    digits: u8,
}

impl Sum {
    /// Adds a distance, and gives the moment with its decimals; `None` when that is more than 584 years away.
    pub(super) fn add(&mut self, (distance, digits): (Instant, u8)) -> Option<(Instant, u8)> {
        self.at = Instant::from_nanos(self.at.as_nanos().checked_add(distance.as_nanos())?);
        self.digits = self.digits.max(digits);
        Some((self.at, self.digits))
    }

    /// What [`add`](Self::add) wants.
    pub(super) const LIMIT: &str = "a distance that ends within 584 years";

    /// The sum so far.
    pub(super) fn at(self) -> Instant {
        self.at
    }
}

/// What the identifier field of SocketCAN says.
#[derive(Clone, Copy)]
pub(super) enum CanId {
    Frame { id: Id, remote: bool },
    Error { class: u32 },
}

impl CanId {
    /// From the 32 bits of `can_id`, as in a pcap file.
    pub(super) fn from_bits(bits: u32) -> Option<Self> {
        if bits & ERROR_FLAG != 0 {
            return Some(Self::Error { class: bits & ID_MASK });
        }
        if bits & EXTENDED_FLAG != 0 {
            return Self::extended(bits);
        }
        let id = StandardId::new(u16::try_from(bits & ID_MASK).ok()?)?;
        Some(Self::Frame { id: Id::Standard(id), remote: bits & REMOTE_FLAG != 0 })
    }

    fn extended(bits: u32) -> Option<Self> {
        let id = ExtendedId::new(bits & ID_MASK)?;
        Some(Self::Frame { id: Id::Extended(id), remote: bits & REMOTE_FLAG != 0 })
    }
}

/// Flags of `can_id` (linux/can.h).
pub(super) const EXTENDED_FLAG: u32 = 0x8000_0000;
pub(super) const REMOTE_FLAG: u32 = 0x4000_0000;
pub(super) const ERROR_FLAG: u32 = 0x2000_0000;
const ID_MASK: u32 = 0x1FFF_FFFF;

/// The value of a hexadecimal digit.
#[inline]
pub(super) fn hex(digit: u8) -> Option<u8> {
    let value = HEX[usize::from(digit)];
    (value <= 0xF).then_some(value)
}

static HEX: [u8; 256] = {
    let mut table = [0xFF; 256];
    let mut value = 0;
    while value < 16 {
        table[b"0123456789ABCDEF"[value] as usize] = value as u8;
        table[b"0123456789abcdef"[value] as usize] = value as u8;
        value += 1;
    }
    table
};

const POWERS_OF_TEN: [u64; 10] =
    [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000, 1_000_000_000];
