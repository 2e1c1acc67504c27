//! The IDs that a path to an object consists of.

use super::{Epath, LogicalKind, PathForm, Segment, SegmentError, Width};
use crate::code::{AttributeId, ClassId, InstanceId};
use crate::codec::{Full, ParseError, Writer};

/// Class, instance, attribute, member and connection point of a path, as far as it names them.
///
/// ```
/// use cip_core::code::{AttributeId, ClassId, InstanceId};
/// use cip_core::codec::Writer;
/// use cip_core::epath::{LogicalPath, PathForm};
///
/// let path = LogicalPath::object(ClassId::ASSEMBLY, InstanceId(101)).with_attribute(AttributeId(3));
/// let mut buffer = [0; 8];
/// let mut out = Writer::new(&mut buffer);
/// path.emit(PathForm::Packed, &mut out)?;
/// assert_eq!(out.written(), [0x20, 0x04, 0x24, 0x65, 0x30, 0x03]);
/// # Ok::<(), cip_core::codec::Full>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LogicalPath {
    /// The class.
    pub class: Option<ClassId>,
    /// The instance.
    pub instance: Option<InstanceId>,
    /// The attribute.
    pub attribute: Option<AttributeId>,
    /// The member of the attribute.
    pub member: Option<u32>,
    /// The connection point.
    pub connection_point: Option<u32>,
}

/// The path cannot be written with a whole number of 16-bit words: an odd number of its IDs exceeds 255 and no other
/// ID is left to widen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
#[error("the packed path has an odd number of bytes and cannot be counted in words")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Unpackable;

impl LogicalPath {
    /// The path to an object.
    pub const fn object(class: ClassId, instance: InstanceId) -> Self {
        Self {
            class: Some(class),
            instance: Some(instance),
            attribute: None,
            member: None,
            connection_point: None,
        }
    }

    /// The same with an attribute.
    pub const fn with_attribute(self, attribute: AttributeId) -> Self {
        Self { attribute: Some(attribute), ..self }
    }

    /// Writes each ID in the smallest segment that holds it: class, instance, attribute, member, connection point.
    pub fn emit(&self, form: PathForm, out: &mut Writer<'_>) -> Result<(), Full> {
        self.ids()
            .into_iter()
            .flatten()
            .try_for_each(|(kind, value)| full(Segment::logical(kind, value).emit(form, out)))
    }

    /// The number of bytes that [`emit`](Self::emit) writes in the packed form.
    pub fn packed_len(&self) -> usize {
        self.ids().into_iter().flatten().fold(0, |len: usize, (_, value)| {
            len.saturating_add(match Width::of(value) {
                Width::Bits8 => 2,
                Width::Bits16 => 3,
                Width::Bits32 => 5,
            })
        })
    }

    /// Writes a packed path of whole words: if the smallest segments make an odd number of bytes, the last ID of one
    /// byte takes a 16-bit segment.
    pub fn emit_words(&self, out: &mut Writer<'_>) -> Result<Result<(), Unpackable>, Full> {
        let ids = self.ids();
        let odd = !self.packed_len().is_multiple_of(2);
        let widened =
            ids.iter().rposition(|id| id.is_some_and(|(_, value)| Width::of(value) == Width::Bits8));
        if odd && widened.is_none() {
            return Ok(Err(Unpackable));
        }
        for (index, id) in ids.into_iter().enumerate() {
            let Some((kind, value)) = id else { continue };
            let width = if odd && widened == Some(index) { Width::Bits16 } else { Width::of(value) };
            full(Segment::Logical { kind, width, value }.emit(PathForm::Packed, out))?;
        }
        Ok(Ok(()))
    }

    pub(super) fn of(path: Epath<'_>) -> Result<Self, ParseError> {
        let mut logical = Self::default();
        let mut offset = 0;
        let mut segments = path.segments();
        while let Some(segment) = segments.next() {
            if let Segment::Logical { kind, value, .. } = segment? {
                logical.set(kind, value, offset)?;
            }
            offset = segments.reader.offset();
        }
        Ok(logical)
    }

    fn set(&mut self, kind: LogicalKind, value: u32, offset: usize) -> Result<(), ParseError> {
        let narrow = || u16::try_from(value).map_err(|_| ParseError::value(kind.name(), offset, value));
        match kind {
            LogicalKind::Class => self.class = Some(ClassId(narrow()?)),
            LogicalKind::Instance => self.instance = Some(InstanceId(narrow()?)),
            LogicalKind::Attribute => self.attribute = Some(AttributeId(narrow()?)),
            LogicalKind::Member => self.member = Some(value),
            LogicalKind::ConnectionPoint => self.connection_point = Some(value),
            LogicalKind::Service => {}
        }
        Ok(())
    }

    fn ids(&self) -> [Option<(LogicalKind, u32)>; 5] {
        [
            self.class.map(|id| (LogicalKind::Class, id.0.into())),
            self.instance.map(|id| (LogicalKind::Instance, id.0.into())),
            self.attribute.map(|id| (LogicalKind::Attribute, id.0.into())),
            self.member.map(|id| (LogicalKind::Member, id)),
            self.connection_point.map(|id| (LogicalKind::ConnectionPoint, id)),
        ]
    }
}

/// The segments of a path are as wide as their IDs: there is nothing that does not fit but the buffer.
fn full(result: Result<(), SegmentError>) -> Result<(), Full> {
    result.map_err(|error| match error {
        SegmentError::Full(full) => full,
        SegmentError::Unfit { .. } => Full,
    })
}
