//! PDO: objects in the process data of PReq and PRes.

use link_core::codec::Writer;

use crate::NodeId;
use crate::dictionary::{Entry, ObjectAddress, ObjectSet};
use crate::ethernet::MAX_PROCESS_DATA;
use crate::wire::{AbortCode, PdoVersion};

/// An object in process data, as it stands in a mapping object.
///
/// | Bits | Content |
/// |---|---|
/// | 15-0 | index |
/// | 23-16 | sub-index |
/// | 31-24 | reserved |
/// | 47-32 | offset, in bits |
/// | 63-48 | length, in bits |
///
/// ```
/// use powerlink_core::dictionary::ObjectAddress;
/// use powerlink_core::pdo::MappingEntry;
///
/// // What openPOWERLINK's managing node writes to 0x1600/1 of its demo.
/// let entry = MappingEntry::of(u64::from_le_bytes([0x00, 0x62, 0x01, 0x00, 0x00, 0x00, 0x08, 0x00]));
/// assert_eq!(entry, MappingEntry { object: ObjectAddress::new(0x6200, 1), offset: 0, length: 8 });
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct MappingEntry {
    /// The object.
    pub object: ObjectAddress,
    /// Where it begins, in bits.
    pub offset: u16,
    /// How long it is, in bits.
    pub length: u16,
}

impl MappingEntry {
    /// Reads the number of a mapping object.
    #[must_use]
    pub const fn of(number: u64) -> Self {
        let [i0, i1, sub, _, o0, o1, l0, l1] = number.to_le_bytes();
        Self {
            object: ObjectAddress::new(u16::from_le_bytes([i0, i1]), sub),
            offset: u16::from_le_bytes([o0, o1]),
            length: u16::from_le_bytes([l0, l1]),
        }
    }

    /// The number of a mapping object.
    #[must_use]
    pub const fn number(self) -> u64 {
        let ([i0, i1], sub) = (self.object.index.to_le_bytes(), self.object.sub);
        let ([o0, o1], [l0, l1]) = (self.offset.to_le_bytes(), self.length.to_le_bytes());
        u64::from_le_bytes([i0, i1, sub, 0, o0, o1, l0, l1])
    }
}

/// An entry as it is kept: in whole bytes.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Place {
    object: ObjectAddress,
    start: u16,
    len: u16,
    /// While it is in use: the line of an object that takes some values only, else [`ANY_VALUE`].
    line: u16,
}

impl Place {
    /// No object.
    const EMPTY: Self = Self { object: ObjectAddress::new(0, 0), start: 0, len: 0, line: ANY_VALUE };

    /// The place of an entry, if that begins and ends with a byte.
    const fn of(entry: MappingEntry) -> Option<Self> {
        let MappingEntry { object, offset, length } = entry;
        if (offset | length) & 0x07 != 0 {
            return None;
        }
        Some(Self { object, start: offset >> 3, len: length >> 3, line: ANY_VALUE })
    }

    /// As it was written.
    const fn entry(self) -> MappingEntry {
        MappingEntry { object: self.object, offset: self.start << 3, length: self.len << 3 }
    }

    #[inline]
    fn range(self) -> core::ops::Range<usize> {
        let start = usize::from(self.start);
        start..start.saturating_add(self.len.into())
    }
}

/// An object that a PDO could not carry: the first one, if there are several.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PdoFault {
    /// The object.
    pub object: ObjectAddress,
    /// Why.
    pub code: AbortCode,
}

/// What is in the process data of one direction, or of one other node: a communication object (0x1400, 0x1800) and a
/// mapping object (0x1600, 0x1A00).
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Mapping {
    /// Whose process data: nobody's own number for PReq and PRes of the node itself, else that of another node.
    pub node: NodeId,
    /// Its version.
    pub version: PdoVersion,
    entries: [Place; MAX_MAPPED],
    /// The entries that count: sub-index 0.
    count: u8,
    /// One of those takes some values only.
    is_limited: bool,
    /// The bytes that they need.
    len: u16,
}

impl Mapping {
    /// Nothing is mapped.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            node: NodeId::NONE,
            version: PdoVersion(0),
            entries: [Place::EMPTY; MAX_MAPPED],
            count: 0,
            is_limited: false,
            len: 0,
        }
    }

    /// A mapping of the manufacturer.
    ///
    /// # Errors
    /// Why an entry cannot be mapped.
    pub fn with<O: ObjectSet>(
        entries: &[MappingEntry],
        transmit: bool,
        limit: usize,
    ) -> Result<Self, AbortCode> {
        let mut mapping = Self::new();
        if entries.len() > MAX_MAPPED {
            return Err(AbortCode::PDO_LENGTH);
        }
        for (slot, &entry) in mapping.entries.iter_mut().zip(entries) {
            *slot = Place::of(entry).ok_or(AbortCode::NOT_MAPPABLE)?;
        }
        let count = u8::try_from(entries.len()).map_err(|_| AbortCode::PDO_LENGTH)?;
        mapping.activate::<O>(count, transmit, limit)?;
        Ok(mapping)
    }

    /// Sub-index 0.
    #[must_use]
    pub const fn count(&self) -> u8 {
        self.count
    }

    /// The bytes of process data that it needs.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len.into()
    }

    /// The same, as Size has it.
    pub(crate) const fn size(&self) -> u16 {
        self.len
    }

    /// Whether nothing is mapped.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The entries that count.
    pub fn entries(&self) -> impl Iterator<Item = MappingEntry> {
        self.in_use().unwrap_or_default().iter().map(|place| place.entry())
    }

    /// One entry, whether it counts or not: sub-indices 1 and up.
    #[must_use]
    pub fn entry(&self, sub: u8) -> Option<MappingEntry> {
        self.entries.get(usize::from(sub.checked_sub(1)?)).map(|place| place.entry())
    }

    /// Writes an entry, sub-indices 1 and up.
    ///
    /// # Errors
    /// While the mapping is in use, where there is no such entry, and for one that is not of whole bytes.
    pub fn set_entry(&mut self, sub: u8, entry: MappingEntry) -> Result<(), AbortCode> {
        if self.count != 0 {
            return Err(AbortCode::UNSUPPORTED_ACCESS);
        }
        let slot = sub.checked_sub(1).and_then(|index| self.entries.get_mut(usize::from(index)));
        *slot.ok_or(AbortCode::NO_SUB_INDEX)? = Place::of(entry).ok_or(AbortCode::NOT_MAPPABLE)?;
        Ok(())
    }

    /// Writes sub-index 0: 0 takes the mapping out of use, a number puts so many entries into use.
    ///
    /// # Errors
    /// Why an entry cannot be mapped; the mapping stays out of use.
    pub fn activate<O: ObjectSet>(
        &mut self,
        count: u8,
        transmit: bool,
        limit: usize,
    ) -> Result<(), AbortCode> {
        (self.count, self.len) = (0, 0);
        if usize::from(count) > MAX_MAPPED {
            return Err(AbortCode::VALUE_TOO_HIGH);
        }
        let (mut len, mut is_limited) = (0, false);
        for place in self.entries.iter_mut().take(count.into()) {
            place.line = check::<O>(*place, transmit)?;
            is_limited |= place.line != ANY_VALUE;
            len = place.range().end.max(len);
        }
        if len > limit.min(MAX_PROCESS_DATA) {
            return Err(AbortCode::PDO_LENGTH);
        }
        self.len = u16::try_from(len).map_err(|_| AbortCode::PDO_LENGTH)?;
        (self.count, self.is_limited) = (count, is_limited);
        Ok(())
    }

    /// Whether something is mapped of the process data that a node sends; `NONE` is the PReq.
    #[must_use]
    pub const fn is_of(&self, node: NodeId) -> bool {
        self.count != 0 && self.node.0 == node.0
    }

    /// Whether process data of this version fit: the main version counts, the sub version may differ.
    #[must_use]
    pub const fn fits(&self, version: PdoVersion) -> bool {
        self.version.main() == version.main()
    }

    /// Gives the objects what is in `data`. One that does not take its value keeps its own, and the others take theirs.
    ///
    /// # Errors
    /// The object that did not take its value.
    pub fn unpack<O: ObjectSet>(&self, data: &[u8], objects: &mut O) -> Result<(), PdoFault> {
        let Some(places) = self.in_use() else { return Ok(()) };
        if self.is_limited {
            return give_checked(places, data, objects);
        }
        let mut rest = places.iter();
        while let Some(place) = rest.next() {
            if let Some(value) = data.get(place.range())
                && let Err(code) = objects.write(place.object, value)
            {
                // The first is told.
                let _ = give_checked(rest.as_slice(), data, objects);
                return Err(PdoFault { object: place.object, code });
            }
        }
        Ok(())
    }

    /// Takes the values of the objects into `data`. Where one cannot be read is what was there.
    ///
    /// # Errors
    /// The object that could not be read.
    pub fn pack<O: ObjectSet>(&self, objects: &O, data: &mut [u8]) -> Result<(), PdoFault> {
        let mut result = Ok(());
        for place in self.in_use().unwrap_or_default() {
            let Some(value) = data.get_mut(place.range()) else { continue };
            let mut out = Writer::new(value);
            let read = objects.read(place.object, &mut out);
            // Half a value is none.
            let whole = if out.remaining() == 0 { Ok(()) } else { Err(AbortCode::LENGTH) };
            if let Err(code) = read.and(whole) {
                result = result.and(Err(PdoFault { object: place.object, code }));
            }
        }
        result
    }

    fn in_use(&self) -> Option<&[Place]> {
        self.entries.get(..self.count.into())
    }
}

impl Default for Mapping {
    fn default() -> Self {
        Self::new()
    }
}

/// The mappings of a node: PReq and other nodes' PRes, and its own PRes.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Mappings {
    /// 0x1600 and up. One of node 0 is for PReq.
    pub receive: [Mapping; RECEIVE_CHANNELS],
    /// 0x1A00.
    pub transmit: Mapping,
}

impl Mappings {
    /// Nothing is mapped.
    #[must_use]
    pub const fn new() -> Self {
        Self { receive: [const { Mapping::new() }; RECEIVE_CHANNELS], transmit: Mapping::new() }
    }

    /// The channel that takes the process data of a node; `NONE` is the PReq.
    #[inline]
    pub fn channel_of(&self, node: NodeId) -> Option<(u8, &Mapping)> {
        (0..).zip(&self.receive).find(|(_, mapping)| mapping.is_of(node))
    }

    /// The bytes of PReq that are mapped.
    pub(crate) fn poll_size(&self) -> u16 {
        self.channel_of(NodeId::NONE).map_or(0, |(_, mapping)| mapping.size())
    }

    /// Puts the entries of a receive channel into use, or out of it. A frame is taken by one channel. The limit is that of PReq.
    ///
    /// # Errors
    /// Where there is no such channel, another one takes the frames of that node, or an entry cannot be mapped.
    pub fn activate_receive<O: ObjectSet>(
        &mut self,
        channel: usize,
        count: u8,
        limit: usize,
    ) -> Result<(), AbortCode> {
        let node = self.receive.get(channel).ok_or(AbortCode::NO_OBJECT)?.node;
        let others = self.receive.iter().enumerate().filter(|&(other, _)| other != channel);
        if count > 0 && others.clone().any(|(_, mapping)| mapping.is_of(node)) {
            return Err(AbortCode::PARAMETER_INCOMPATIBLE);
        }
        let limit = if node == NodeId::NONE { limit } else { MAX_PROCESS_DATA };
        self.receive.get_mut(channel).ok_or(AbortCode::NO_OBJECT)?.activate::<O>(count, false, limit)
    }
}

impl Default for Mappings {
    fn default() -> Self {
        Self::new()
    }
}

/// The same where an object takes some values only, or another one did not take its own.
#[inline(never)]
fn give_checked<O: ObjectSet>(places: &[Place], data: &[u8], objects: &mut O) -> Result<(), PdoFault> {
    let mut result = Ok(());
    for place in places {
        let Some(value) = data.get(place.range()) else { continue };
        let line = O::ENTRIES.get(usize::from(place.line));
        let checked = line.map_or(Ok(()), |line| line.check_write(value));
        if let Err(code) = checked.and_then(|()| objects.write(place.object, value)) {
            result = result.and(Err(PdoFault { object: place.object, code }));
        }
    }
    result
}

/// Whether an object may be mapped so: what is received is written to it, what is sent is read of it. Returns its line if it takes
/// some values only.
fn check<O: ObjectSet>(place: Place, transmit: bool) -> Result<u16, AbortCode> {
    let line = Entry::find(O::ENTRIES, place.object)?;
    let is_whole = line.object_type.fixed_len() == Some(place.len.into());
    let is_accessible = if transmit { line.access.is_readable() } else { line.access.is_writable() };
    if !(line.mappable.allows(transmit) && is_whole && is_accessible) {
        return Err(AbortCode::NOT_MAPPABLE);
    }
    if transmit || line.takes_any_value() {
        return Ok(ANY_VALUE);
    }
    let at = O::ENTRIES.iter().position(|other| core::ptr::eq(other, line));
    at.and_then(|at| u16::try_from(at).ok()).ok_or(AbortCode::NOT_MAPPABLE)
}

/// Entries of one mapping.
pub const MAX_MAPPED: usize = 32;
/// No line: the object takes any value of its length. An object set has fewer lines.
const ANY_VALUE: u16 = u16::MAX;
/// PReq, and the PRes of so many other nodes less one.
pub const RECEIVE_CHANNELS: usize = 3;
