//! StatusResponse: what went wrong.

use core::fmt;

use heapless::Vec;
use link_core::codec::{Full, ParseError, Reader, Wire, Writer};

use super::{AsyncRequest, ErrorCode, Flags, NetTime, NmtStateCode};

/// StatusResponse, an ASnd. The whole frame has at least 72 bytes; a managing node drops a shorter one, and resets the node.
///
/// | Offset | Content |
/// |---|---|
/// | 18 | flags: EN, EC |
/// | 19 | PR, RS |
/// | 20 | NMT state |
/// | 21-23 | reserved |
/// | 24-31 | static error bit field: error register (0x1001), reserved, six bytes of the device |
/// | 32.. | at least two [`ErrorEntry`], the unused ones all zero |
///
/// It ends in a list: more entries may follow.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct StatusResponse {
    /// EN and EC.
    pub flags: Flags,
    /// What waits for the asynchronous slot.
    pub request: AsyncRequest,
    /// The sender's state.
    pub state: NmtStateCode,
    /// The first byte is the error register.
    pub static_errors: [u8; 8],
    /// As many as the frame has, the zero ones included. Fewer than two are written as two.
    pub entries: Vec<ErrorEntry, MAX_ENTRIES>,
}

impl StatusResponse {
    /// The entries up to the first that is a terminator.
    pub fn errors(&self) -> impl Iterator<Item = &ErrorEntry> {
        self.entries.iter().take_while(|entry| !entry.kind.is_terminator())
    }
}

/// An entry of a StatusResponse and of the error history.
///
/// | Byte | Content |
/// |---|---|
/// | 0-1 | [`EntryType`] |
/// | 2-3 | error code |
/// | 4-11 | NetTime |
/// | 12-19 | additional information |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ErrorEntry {
    /// What kind of entry it is.
    pub kind: EntryType,
    /// What went wrong.
    pub code: ErrorCode,
    /// When.
    pub time: NetTime,
    /// As the code says.
    pub additional: u64,
}

/// The type of an error entry.
///
/// | Bits | Meaning |
/// |---|---|
/// | 15 | status entry, else history entry |
/// | 14 | is put into the emergency queue as well |
/// | 13-12 | mode: 0 terminator, 1 error active, 2 error cleared, 3 event occurred |
/// | 11-0 | profile: 1 vendor, 2 POWERLINK, others the number of the device profile |
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
pub struct EntryType(pub u16);

impl EntryType {
    /// A history entry of POWERLINK: an event occurred.
    pub const POWERLINK_EVENT: Self = Self(0x3002);

    /// Whether it ends the list.
    #[must_use]
    pub const fn is_terminator(self) -> bool {
        self.0 & MODE == 0
    }

    /// Whether it tells that an error is over.
    #[must_use]
    pub const fn is_cleared(self) -> bool {
        self.0 & MODE == CLEARED
    }

    /// Bits 11-0.
    #[must_use]
    pub const fn profile(self) -> u16 {
        self.0 & PROFILE
    }
}

impl Wire<'_> for ErrorEntry {
    const NAME: &'static str = "error entry";

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        Ok(Self {
            kind: EntryType(reader.u16("entry type")?),
            code: ErrorCode(reader.u16("error code")?),
            time: NetTime {
                seconds: reader.u32("time stamp, seconds")?,
                nanoseconds: reader.u32("time stamp, nanoseconds")?,
            },
            additional: reader.u64("additional information")?,
        })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u16(self.kind.0)?;
        out.u16(self.code.0)?;
        out.u32(self.time.seconds)?;
        out.u32(self.time.nanoseconds)?;
        out.u64(self.additional)
    }

    fn wire_len(&self) -> usize {
        ENTRY
    }
}

impl Wire<'_> for StatusResponse {
    const NAME: &'static str = "StatusResponse";
    const TAIL: link_core::codec::Tail = link_core::codec::Tail::Open;

    fn read(reader: &mut Reader<'_>) -> Result<Self, ParseError> {
        let [flags, request, state, _, _, _] = reader.array("StatusResponse header")?;
        let static_errors = reader.array("static error bit field")?;
        let mut entries = Vec::new();
        while entries.len() < MIN_ENTRIES || reader.remaining() >= ENTRY {
            let entry = ErrorEntry::read(reader)?;
            if entries.push(entry).is_err() {
                break;
            }
        }
        Ok(Self {
            flags: Flags::from_bits_retain(flags),
            request: AsyncRequest(request),
            state: NmtStateCode(state),
            static_errors,
            entries,
        })
    }

    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.bytes(&[self.flags.bits(), self.request.0, self.state.0, 0, 0, 0])?;
        out.bytes(&self.static_errors)?;
        let padding = core::iter::repeat_n(&NO_ENTRY, MIN_ENTRIES.saturating_sub(self.entries.len()));
        self.entries.iter().chain(padding).try_for_each(|entry| entry.emit(out))
    }

    fn wire_len(&self) -> usize {
        self.entries.len().max(MIN_ENTRIES).saturating_mul(ENTRY).saturating_add(14)
    }
}

/// `StatusResponse, NMT_PRE_OPERATIONAL_1, EC=1 EN=0, PR=0 RS=0, 1 error: loss of SoC threshold`
impl fmt::Display for StatusResponse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ec = u8::from(self.flags.contains(Flags::EXCEPTION_CLEAR));
        let en = u8::from(self.flags.contains(Flags::EXCEPTION_NEW));
        write!(f, "StatusResponse, {}, EC={ec} EN={en}, {}", self.state, self.request)?;
        for entry in self.errors() {
            write!(f, ", {}", entry.code)?;
        }
        Ok(())
    }
}

/// The entries that a frame must have.
pub const MIN_ENTRIES: usize = 2;
/// The entries that are read; a frame of the longest length could have more.
pub const MAX_ENTRIES: usize = 13;

const ENTRY: usize = 20;
const NO_ENTRY: ErrorEntry = ErrorEntry {
    kind: EntryType(0),
    code: ErrorCode(0),
    time: NetTime { seconds: 0, nanoseconds: 0 },
    additional: 0,
};
const MODE: u16 = 0x3000;
const CLEARED: u16 = 0x2000;
const PROFILE: u16 = 0x0FFF;
