//! The classic CAN frame.

use core::fmt;

use embedded_can_types::{ExtendedId, Id, StandardId};

/// A classic CAN data or remote frame with an 11 or 29 bit identifier.
///
/// | part | values |
/// |---|---|
/// | identifier | [`Id::Standard`] 0 to 0x7FF, [`Id::Extended`] 0 to 0x1FFF_FFFF |
/// | remote | a remote frame has a DLC, and no data |
/// | DLC | 0 to 15; 9 to 15 mean 8 bytes (ISO 11898-1), and are kept because they are on the wire |
/// | data | 0 to 8 bytes |
///
/// Two frames are equal when they are the same bits on the wire.
///
/// With feature `serde` it is serialised as `{"id":1327,"extended":false,"remote":false,"dlc":2,"data":[0,52]}`.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(into = "Parts", try_from = "Parts"))]
pub struct Frame {
    id: Id,
    remote: bool,
    dlc: u8,
    data: [u8; Frame::MAX_DATA],
}

impl Frame {
    /// The most data bytes of a classic frame.
    pub const MAX_DATA: usize = 8;
    /// The greatest data length code.
    pub const MAX_DLC: u8 = 15;

    /// A data frame; `None` for more than eight bytes.
    #[must_use]
    pub fn new(id: impl Into<Id>, bytes: &[u8]) -> Option<Self> {
        let mut data = [0; Self::MAX_DATA];
        let room = data.get_mut(..bytes.len())?;
        room.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
        Some(Self { id: id.into(), remote: false, dlc: u8::try_from(bytes.len()).ok()?, data })
    }

    /// A data frame without data, to which they are [appended](Self::append).
    #[must_use]
    pub fn empty(id: impl Into<Id>) -> Self {
        Self { id: id.into(), remote: false, dlc: 0, data: [0; Self::MAX_DATA] }
    }

    /// Appends to the data of a data frame; `None`, and the frame is as it was, if there is no room for all of these.
    ///
    /// ```
    /// use link_core::{Frame, frame::standard_id};
    ///
    /// let mut frame = Frame::empty(standard_id(0x42B));
    /// assert_eq!((frame.append(&[0x80]), frame.append(&[1, 2])), (Some(()), Some(())));
    /// assert_eq!(frame.append(&[0; 6]), None);
    /// assert_eq!(frame.data(), [0x80, 1, 2]);
    /// ```
    pub fn append(&mut self, bytes: &[u8]) -> Option<()> {
        if self.remote {
            return None;
        }
        let start = usize::from(self.dlc);
        let end = start.checked_add(bytes.len())?;
        let room = self.data.get_mut(start..end)?;
        room.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
        self.dlc = u8::try_from(end).ok()?;
        Some(())
    }

    /// A data frame with the first `len` of these bytes; `None` for more than eight. It costs no copy of unknown length.
    #[must_use]
    pub fn first_of(id: impl Into<Id>, data: [u8; Self::MAX_DATA], len: usize) -> Option<Self> {
        let dlc = u8::try_from(len).ok()?;
        let unused = Self::MAX_DATA.checked_sub(len)?.saturating_mul(8);
        // Bytes that are not data are zero.
        let used = u64::MAX.checked_shr(u32::try_from(unused).ok()?).unwrap_or(0);
        let data = (u64::from_le_bytes(data) & used).to_le_bytes();
        Some(Self { id: id.into(), remote: false, dlc, data })
    }

    /// A remote frame that asks for `dlc` bytes; `None` above [`MAX_DLC`](Self::MAX_DLC).
    #[must_use]
    pub fn remote(id: impl Into<Id>, dlc: u8) -> Option<Self> {
        (dlc <= Self::MAX_DLC).then(|| Self { id: id.into(), remote: true, dlc, data: [0; Self::MAX_DATA] })
    }

    /// An eight-byte data frame whose data length code is 8 to 15; `None` for another code.
    #[must_use]
    pub fn with_dlc(id: impl Into<Id>, dlc: u8, data: [u8; Self::MAX_DATA]) -> Option<Self> {
        (8..=Self::MAX_DLC).contains(&dlc).then(|| Self { id: id.into(), remote: false, dlc, data })
    }

    /// The identifier.
    #[must_use]
    pub const fn id(&self) -> Id {
        self.id
    }

    /// The bits of the identifier, 11 or 29 of them.
    #[must_use]
    pub fn raw_id(&self) -> u32 {
        match self.id {
            Id::Standard(id) => u32::from(id.as_raw()),
            Id::Extended(id) => id.as_raw(),
        }
    }

    /// The 11-bit identifier of a data frame: `None` for a remote frame or 29 bits, which DeviceNet never uses.
    #[must_use]
    pub fn standard_data_id(&self) -> Option<StandardId> {
        match self.id {
            Id::Standard(id) if !self.remote => Some(id),
            Id::Standard(_) | Id::Extended(_) => None,
        }
    }

    /// Whether the identifier has 29 bits.
    #[must_use]
    pub const fn is_extended(&self) -> bool {
        matches!(self.id, Id::Extended(_))
    }

    /// Whether it is a remote frame.
    #[must_use]
    pub const fn is_remote(&self) -> bool {
        self.remote
    }

    /// The data length code as it is on the wire, 0 to 15.
    #[must_use]
    pub const fn dlc(&self) -> u8 {
        self.dlc
    }

    /// The data: at most eight bytes, none in a remote frame.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        let len = if self.remote { 0 } else { usize::from(self.dlc).min(Self::MAX_DATA) };
        self.data.get(..len).unwrap_or_default()
    }

    /// The data as they are on the wire, right-aligned, and how many bits they are.
    pub(crate) fn data_bits(&self) -> (u64, u32) {
        let len = self.data().len();
        // Bytes that are not data are zero, and shifted out.
        let bits = u32::try_from(len).map_or(0, |len| len.saturating_mul(8));
        (u64::from_be_bytes(self.data).checked_shr(64_u32.saturating_sub(bits)).unwrap_or(0), bits)
    }

    /// The order in which frames win arbitration: the smaller key wins.
    ///
    /// It is the arbitration field as sent, 32 bits: base identifier, RTR or SRR, IDE, identifier extension, RTR. So
    /// at equal 11 bits a standard data frame beats a standard remote frame, which beats an extended frame.
    #[must_use]
    pub fn arbitration_key(&self) -> u32 {
        let remote = u32::from(self.remote);
        match self.id {
            Id::Standard(id) => u32::from(id.as_raw()) << 21 | remote << 20,
            Id::Extended(id) => {
                let (base, extension) = (id.as_raw() >> 18, id.as_raw() & 0x3_FFFF);
                base << 21 | 1 << 20 | 1 << 19 | extension << 1 | remote
            }
        }
    }

    /// The exact number of bits on the wire, stuff bits included, from start of frame to the end of frame. The three
    /// bits of intermission that separate it from the next frame are not counted.
    #[must_use]
    pub fn bit_len(&self) -> u32 {
        crate::wire::bit_len(self)
    }

    /// Converts from any frame that implements the `embedded_can` trait; `None` if it is not a classic frame: more than
    /// eight bytes, a DLC above 15, or fewer bytes than its DLC says.
    #[must_use]
    pub fn from_can(frame: &impl embedded_can_types::Frame) -> Option<Self> {
        let dlc = u8::try_from(frame.dlc()).ok()?;
        if frame.is_remote_frame() {
            return Self::remote(frame.id(), dlc);
        }
        let data = frame.data();
        if data.len() > Self::MAX_DATA {
            return None;
        }
        match dlc {
            0..=8 => Self::new(frame.id(), data.get(..usize::from(dlc))?),
            _ => Self::with_dlc(frame.id(), dlc, data.try_into().ok()?),
        }
    }

    /// Converts to any frame that implements the `embedded_can` trait; `None` if that type refuses it. The trait knows no
    /// DLC above 8 in a data frame: such a frame is sent with a DLC of 8.
    #[must_use]
    pub fn to_can<F: embedded_can_types::Frame>(&self) -> Option<F> {
        if self.remote { F::new_remote(self.id, usize::from(self.dlc)) } else { F::new(self.id, self.data()) }
    }
}

impl embedded_can_types::Frame for Frame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        Self::new(id, data)
    }

    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        Self::remote(id, u8::try_from(dlc).ok()?)
    }

    fn is_extended(&self) -> bool {
        self.is_extended()
    }

    fn is_remote_frame(&self) -> bool {
        self.is_remote()
    }

    fn id(&self) -> Id {
        self.id
    }

    fn dlc(&self) -> usize {
        usize::from(self.dlc).min(Self::MAX_DATA)
    }

    fn data(&self) -> &[u8] {
        self.data()
    }
}

/// `52F [7] 00 34 12 45 23 00 00`, `1FFE4433 [8] remote`: identifier, data length code and data, as candump shows them.
impl fmt::Display for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.id {
            Id::Standard(id) => write!(f, "{:03X} [{}]", id.as_raw(), self.dlc)?,
            Id::Extended(id) => write!(f, "{:08X} [{}]", id.as_raw(), self.dlc)?,
        }
        if self.remote {
            return f.write_str(" remote");
        }
        self.data().iter().try_for_each(|byte| write!(f, " {byte:02X}"))
    }
}

impl fmt::Debug for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Frame({self})")
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Frame {
    fn format(&self, f: defmt::Formatter<'_>) {
        match self.id {
            Id::Standard(id) => defmt::write!(f, "{=u16:03X} [{=u8}]", id.as_raw(), self.dlc),
            Id::Extended(id) => defmt::write!(f, "{=u32:08X} [{=u8}]", id.as_raw(), self.dlc),
        }
        if self.remote {
            defmt::write!(f, " remote");
        } else {
            defmt::write!(f, " {=[u8]:02X}", self.data());
        }
    }
}

/// A frame as it is serialised. One that cannot be on the wire is refused.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Parts {
    id: u32,
    extended: bool,
    remote: bool,
    dlc: u8,
    data: heapless::Vec<u8, { Frame::MAX_DATA }>,
}

#[cfg(feature = "serde")]
impl From<Frame> for Parts {
    fn from(frame: Frame) -> Self {
        Self {
            id: frame.raw_id(),
            extended: frame.is_extended(),
            remote: frame.remote,
            dlc: frame.dlc,
            data: heapless::Vec::from_slice(frame.data()).unwrap_or_default(),
        }
    }
}

#[cfg(feature = "serde")]
impl TryFrom<Parts> for Frame {
    type Error = &'static str;

    fn try_from(parts: Parts) -> Result<Self, Self::Error> {
        let id = if parts.extended {
            ExtendedId::new(parts.id).map(Id::from)
        } else {
            u16::try_from(parts.id).ok().and_then(StandardId::new).map(Id::from)
        };
        let id = id.ok_or("the identifier does not fit into 11 bits, or 29 of an extended frame")?;
        let frame = match (parts.remote, parts.dlc, parts.data.as_slice()) {
            (true, dlc, []) => Self::remote(id, dlc),
            (true, ..) => return Err("a remote frame has no data"),
            (false, dlc @ 0..=8, data) if usize::from(dlc) == data.len() => Self::new(id, data),
            (false, 0..=8, _) => None,
            (false, dlc, data) => data.try_into().ok().and_then(|data| Self::with_dlc(id, dlc, data)),
        };
        frame.ok_or("the data length code does not fit the data")
    }
}

/// Builds an identifier from a number that the caller knows to be in range, such as a constant of a layout; a number
/// out of range is cut to 11 bits.
#[must_use]
pub const fn standard_id(raw: u16) -> StandardId {
    match StandardId::new(raw & 0x7FF) {
        Some(id) => id,
        None => StandardId::MAX,
    }
}

/// The same for 29 bits.
#[must_use]
pub const fn extended_id(raw: u32) -> ExtendedId {
    match ExtendedId::new(raw & 0x1FFF_FFFF) {
        Some(id) => id,
        None => ExtendedId::MAX,
    }
}

#[cfg(test)]
mod tests;
