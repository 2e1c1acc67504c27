//! What a recording holds.

use core::fmt;

use link_core::{Frame, Id, Instant};

/// One entry of a recording: of a CAN bus, or with another content.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct RecordedFrame<C = Content> {
    /// Its number in the recording, from 1; lines that could not be read do not count.
    pub n: u64,
    /// When: since 1970 or since the start of the recording, whichever the recording uses.
    pub at: Instant,
    /// How many decimals of a second the recording gives, 0 to 9.
    pub digits: u8,
    /// The interface or channel, where the format names one.
    pub channel: Option<ChannelId>,
    /// What was seen on the bus.
    pub content: C,
}

/// What was seen on the bus.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Content {
    /// A classic data or remote frame.
    Classic(Frame),
    /// An error that the controller reported.
    Error(ErrorFrame),
    /// A CAN FD frame; in a box, because it is rare here and five times as large.
    Fd(Box<FdFrame>),
}

/// An error frame as SocketCAN reports it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ErrorFrame {
    /// Which classes of error: a bit set, see [`Self::CLASSES`].
    pub class: u32,
    /// Details: lost arbitration bit, controller state, protocol violation and its place, transceiver, and the two
    /// error counters in the last two bytes.
    pub data: [u8; 8],
}

impl ErrorFrame {
    /// The error classes of `linux/can/error.h`, bit 0 first.
    pub const CLASSES: [&'static str; 10] = [
        "transmit timeout",
        "lost arbitration",
        "controller problem",
        "protocol violation",
        "transceiver status",
        "no acknowledgement",
        "bus-off",
        "bus error",
        "controller restarted",
        "error counters",
    ];

    /// A bus error of which no more is known: a protocol violation seen by the controller.
    pub const UNSPECIFIED: Self = Self { class: 0x88, data: [0; 8] };
}

/// `error frame: controller problem, bus-off`.
impl fmt::Display for ErrorFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("error frame")?;
        let mut separator = ": ";
        for (bit, name) in Self::CLASSES.iter().enumerate() {
            if self.class >> bit & 1 != 0 {
                write!(f, "{separator}{name}")?;
                separator = ", ";
            }
        }
        Ok(())
    }
}

/// A CAN FD frame.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct FdFrame {
    id: Id,
    /// Whether the data phase was sent at the higher bit rate (BRS).
    pub bit_rate_switch: bool,
    /// Whether the sender was error-passive (ESI).
    pub error_passive: bool,
    dlc: u8,
    data: [u8; Self::MAX_DATA],
}

impl FdFrame {
    /// The most data bytes of a CAN FD frame.
    pub const MAX_DATA: usize = 64;
    /// The lengths that a data length code of 0 to 15 stands for.
    pub const LENGTHS: [u8; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];

    /// A CAN FD frame; `None` for a length that it cannot have.
    #[must_use]
    pub fn new(id: Id, bytes: &[u8], bit_rate_switch: bool, error_passive: bool) -> Option<Self> {
        let dlc = Self::LENGTHS.iter().position(|&len| usize::from(len) == bytes.len())?;
        let mut data = [0; Self::MAX_DATA];
        data[..bytes.len()].copy_from_slice(bytes);
        Some(Self { id, bit_rate_switch, error_passive, dlc: dlc as u8, data })
    }

    /// The identifier.
    #[must_use]
    pub const fn id(&self) -> Id {
        self.id
    }

    /// The data length code, 0 to 15.
    #[must_use]
    pub const fn dlc(&self) -> u8 {
        self.dlc
    }

    /// The data.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        &self.data[..usize::from(Self::LENGTHS[usize::from(self.dlc)])]
    }
}

impl fmt::Debug for FdFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { id, bit_rate_switch, error_passive, .. } = self;
        write!(f, "FdFrame({id:?} brs {bit_rate_switch} esi {error_passive} {:02X?})", self.data())
    }
}

/// A channel of a recording: a small number that [`Channels`] gives its name.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct ChannelId(u8);

impl ChannelId {
    /// From 0, in the order in which the channels appeared.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// The names of the channels seen so far.
#[derive(Clone, Debug, Default)]
pub struct Channels {
    names: Vec<Box<str>>,
    last: u8,
}

impl Channels {
    /// A recording has at most this many.
    pub const MAX: usize = 255;
    /// The most bytes of a name; Linux allows 15, captures from elsewhere have more.
    pub const MAX_NAME: usize = 255;
    /// What [`intern`](Self::intern) wants.
    pub(super) const LIMIT: &str = "at most 255 interfaces, with names of at most 255 bytes of text";

    /// The name of a channel; empty for one of another recording.
    #[must_use]
    pub fn name(&self, channel: ChannelId) -> &str {
        self.names.get(channel.index()).map_or("", |name| name)
    }

    /// Their names, in the order in which they appeared.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &str> {
        self.names.iter().map(|name| &**name)
    }

    /// How many there are so far.
    #[must_use]
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Whether no channel has been named yet.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// The channel of that name, new or known; `None` when there are too many, or the name is too long, or not text: UTF-8 without the character NUL.
    #[inline]
    pub(super) fn intern(&mut self, name: &[u8]) -> Option<ChannelId> {
        // Nearly always the same as before.
        match self.names.get(usize::from(self.last)) {
            Some(last) if last.as_bytes() == name => Some(ChannelId(self.last)),
            _ => self.search(name),
        }
    }

    #[cold]
    fn search(&mut self, name: &[u8]) -> Option<ChannelId> {
        let known = self.names.iter().position(|other| other.as_bytes() == name);
        let index = match known {
            Some(index) => index,
            None if self.names.len() < Self::MAX && name.len() <= Self::MAX_NAME => {
                let name = core::str::from_utf8(name).ok()?;
                // It ends a name in pcapng.
                if name.contains('\0') {
                    return None;
                }
                self.names.push(name.into());
                self.names.len() - 1
            }
            None => return None,
        };
        self.last = index as u8;
        Some(ChannelId(self.last))
    }
}
