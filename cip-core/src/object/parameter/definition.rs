//! What a parameter is: the part that never changes.

use super::emit_short_string;
use super::limits::{Number, ZERO, emit_or, highest, lowest};
use crate::code::{AttributeId, GeneralStatus};
use crate::codec::{Full, Writer};
use crate::data_type::DataType;
use crate::object::failure::wrong_length;
use crate::object::{Failure, Size};

/// One parameter: a stub (attributes 1-6), or a full one with texts, limits and scaling.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameter {
    data_type: DataType,
    size: Option<u8>,
    link_path: &'static [u8],
    descriptor: ParameterDescriptor,
    names: &'static [&'static [u8]],
    full: Option<&'static FullParameter>,
}

/// The attributes 7-24 of a full parameter. Texts are in ISO 8859-1; limits are as the value is on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FullParameter {
    /// Attribute 7, up to 16 characters.
    pub name: &'static [u8],
    /// Attribute 8, up to 4 characters.
    pub units: &'static [u8],
    /// Attribute 9, up to 64 characters.
    pub help: &'static [u8],
    /// Attribute 10. Empty: the lowest value of the type.
    pub minimum: &'static [u8],
    /// Attribute 11. Empty: the highest value of the type.
    pub maximum: &'static [u8],
    /// Attribute 12. Empty: zero.
    pub default: &'static [u8],
    /// Attributes 13-16 and 21.
    pub scaling: Scaling,
    /// Attributes 17-20.
    pub links: ScalingLinks,
    /// Attributes 22-24.
    pub international: Option<International>,
}

/// How a tool shows a value (attributes 13-16 and 21): (value + offset) x multiplier x base / (divisor x
/// 10^precision).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Scaling {
    /// Attribute 13.
    pub multiplier: u16,
    /// Attribute 14.
    pub divisor: u16,
    /// Attribute 15.
    pub base: u16,
    /// Attribute 16.
    pub offset: i16,
    /// Attribute 21: digits behind the point.
    pub precision: u8,
}

/// The parameters whose values take the place of the scaling constants (attributes 17-20); 0: none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ScalingLinks {
    /// Attribute 17.
    pub multiplier: u16,
    /// Attribute 18.
    pub divisor: u16,
    /// Attribute 19.
    pub base: u16,
    /// Attribute 20.
    pub offset: u16,
}

/// The texts in several languages (attributes 22-24), each a complete STRINGI.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct International {
    /// Attribute 22.
    pub name: &'static [u8],
    /// Attribute 23.
    pub units: &'static [u8],
    /// Attribute 24.
    pub help: &'static [u8],
}

bitflags::bitflags! {
    /// Attribute 4.
    ///
    /// | Bit | Meaning |
    /// |---|---|
    /// | 0 | the link path can be set |
    /// | 1 | values have names (Get_Enum_String) |
    /// | 2 | the value is scaled |
    /// | 3 | other parameters scale it |
    /// | 4 | read only |
    /// | 5 | monitor: the value changes by itself |
    /// | 6 | scaling with extended precision |
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct ParameterDescriptor: u16 {
        /// The link path can be set.
        const SETTABLE_PATH = 0x0001;
        /// Values have names.
        const NAMED_VALUES = 0x0002;
        /// The value is scaled.
        const SCALING = 0x0004;
        /// Other parameters scale it.
        const SCALING_LINKS = 0x0008;
        /// The value cannot be set.
        const READ_ONLY = 0x0010;
        /// The value changes by itself.
        const MONITOR = 0x0020;
        /// Scaling with extended precision: attribute 21 counts.
        const EXTENDED_PRECISION = 0x0040;
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for ParameterDescriptor {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=u16:#06x}", self.bits());
    }
}

impl Scaling {
    /// The value as it is.
    pub const NONE: Self = Self { multiplier: 1, divisor: 1, base: 1, offset: 0, precision: 0 };
}

impl FullParameter {
    /// A parameter without limits and scaling, whose default is zero.
    pub const fn new(name: &'static [u8], units: &'static [u8], help: &'static [u8]) -> Self {
        Self {
            name,
            units,
            help,
            minimum: &[],
            maximum: &[],
            default: &[],
            scaling: Scaling::NONE,
            links: ScalingLinks { multiplier: 0, divisor: 0, base: 0, offset: 0 },
            international: None,
        }
    }
}

impl Parameter {
    /// A stub that can be read and set. `link_path` is the packed path to the attribute that has the same value, or
    /// empty.
    pub const fn new(data_type: DataType, link_path: &'static [u8]) -> Self {
        Self {
            data_type,
            size: None,
            link_path,
            descriptor: ParameterDescriptor::empty(),
            names: &[],
            full: None,
        }
    }

    /// The same for values of up to `size` bytes, for types of no fixed size.
    #[must_use]
    pub const fn sized(self, size: u8) -> Self {
        Self { size: Some(size), ..self }
    }

    /// The same, which cannot be set.
    #[must_use]
    pub const fn read_only(self) -> Self {
        self.with(ParameterDescriptor::READ_ONLY)
    }

    /// The same, which cannot be set and changes by itself.
    #[must_use]
    pub const fn monitor(self) -> Self {
        self.with(ParameterDescriptor::READ_ONLY).with(ParameterDescriptor::MONITOR)
    }

    /// The same with names for the values 0, 1, 2 and so on.
    #[must_use]
    pub const fn named_values(self, names: &'static [&'static [u8]]) -> Self {
        Self { names, ..self }.with(ParameterDescriptor::NAMED_VALUES)
    }

    /// A full parameter.
    #[must_use]
    pub const fn full(self, full: &'static FullParameter) -> Self {
        Self { full: Some(full), ..self }
    }

    /// The data type.
    pub const fn data_type(&self) -> DataType {
        self.data_type
    }

    /// Attribute 4, as it follows from the definition.
    pub fn descriptor(&self) -> ParameterDescriptor {
        let Some(full) = self.full else { return self.descriptor };
        let scaled = full.scaling != Scaling::NONE;
        let linked = full.links != ScalingLinks::default();
        let mut descriptor = self.descriptor;
        descriptor.set(ParameterDescriptor::SCALING, scaled || linked);
        descriptor.set(ParameterDescriptor::SCALING_LINKS, linked);
        descriptor.set(ParameterDescriptor::EXTENDED_PRECISION, full.scaling.precision != 0);
        descriptor
    }

    /// True unless a text is too long, a limit has another size than the value or is beyond the other, the default is
    /// beyond a limit, or the size of a type that has none is not told: for a test of the application.
    pub fn is_valid(&self) -> bool {
        let texts = self.names.iter().chain([&self.link_path]).all(|text| text.len() <= 0xFF);
        let sized = self.data_type.size().is_some() || self.size.is_some();
        texts && sized && self.full.is_none_or(|full| full.is_valid(self.data_type))
    }

    pub(super) const fn is_read_only(&self) -> bool {
        self.descriptor.contains(ParameterDescriptor::READ_ONLY)
    }

    pub(super) const fn is_full(&self) -> bool {
        self.full.is_some()
    }

    pub(super) const fn names(&self) -> &'static [&'static [u8]] {
        self.names
    }

    pub(super) fn attribute_count(&self) -> usize {
        match self.full {
            None => 6,
            Some(FullParameter { international: None, .. }) => 21,
            Some(FullParameter { international: Some(_), .. }) => 24,
        }
    }

    /// Writes an attribute other than the value.
    pub(super) fn emit(&self, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Full> {
        match attribute.0 {
            2 => out.u8(u8::try_from(self.link_path.len()).map_err(|_| Full)?),
            3 => out.bytes(self.link_path),
            4 => out.u16(self.descriptor().bits()),
            5 => out.u8(self.data_type.code().0),
            6 => out.u8(self.size()),
            _ => self.full.map_or(Ok(()), |full| full.emit(self.data_type, attribute, out)),
        }
    }

    /// Judges a value: its length, then whether it is within the limits.
    pub(super) fn check(&self, value: &[u8]) -> Result<(), Failure> {
        match self.data_type.size() {
            Some(size) if size != value.len() => return Err(wrong_length(value.len(), size)),
            Some(_) => {}
            None if self.data_type == DataType::ShortString => Size::ShortString.check(value)?,
            None => {}
        }
        if value.len() > usize::from(self.size()) {
            return Err(GeneralStatus::TOO_MUCH_DATA.into());
        }
        let no_boolean = self.data_type == DataType::Bool && !matches!(value, [0 | 1]);
        if no_boolean || !self.full.is_none_or(|full| full.allows(self.data_type, value)) {
            return Err(GeneralStatus::INVALID_ATTRIBUTE_VALUE.into());
        }
        Ok(())
    }

    /// Attribute 6.
    fn size(&self) -> u8 {
        let of_type = self.data_type.size().and_then(|size| u8::try_from(size).ok());
        of_type.or(self.size).unwrap_or(0)
    }

    const fn with(self, bit: ParameterDescriptor) -> Self {
        Self { descriptor: self.descriptor.union(bit), ..self }
    }
}

impl FullParameter {
    fn emit(&self, data_type: DataType, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Full> {
        match attribute.0 {
            7 => emit_short_string(self.name, out),
            8 => emit_short_string(self.units, out),
            9 => emit_short_string(self.help, out),
            10 => emit_or(self.minimum, lowest(data_type), data_type, out),
            11 => emit_or(self.maximum, highest(data_type), data_type, out),
            12 => emit_or(self.default, ZERO, data_type, out),
            13 => out.u16(self.scaling.multiplier),
            14 => out.u16(self.scaling.divisor),
            15 => out.u16(self.scaling.base),
            16 => out.i16(self.scaling.offset),
            17 => out.u16(self.links.multiplier),
            18 => out.u16(self.links.divisor),
            19 => out.u16(self.links.base),
            20 => out.u16(self.links.offset),
            21 => out.u8(self.scaling.precision),
            other => self.international.map_or(Ok(()), |texts| {
                out.bytes(match other {
                    22 => texts.name,
                    23 => texts.units,
                    _ => texts.help,
                })
            }),
        }
    }

    /// True if the value is a number within the limits, or no number.
    fn allows(&self, data_type: DataType, value: &[u8]) -> bool {
        let Some(value) = Number::of(data_type, value) else { return true };
        let above = Number::of(data_type, self.minimum).is_none_or(|minimum| minimum <= value);
        let below = Number::of(data_type, self.maximum).is_none_or(|maximum| value <= maximum);
        above && below
    }

    fn is_valid(&self, data_type: DataType) -> bool {
        let texts = self.name.len() <= 16 && self.units.len() <= 4 && self.help.len() <= 64;
        let limits = [self.minimum, self.maximum, self.default];
        let sized = limits
            .iter()
            .all(|limit| limit.is_empty() || data_type.size().is_none_or(|size| limit.len() == size));
        let within = |limit: &[u8]| limit.is_empty() || self.allows(data_type, limit);
        texts && sized && limits.into_iter().all(within)
    }
}
