//! The Parameter object (class 0x0F).

mod definition;
mod limits;

pub use definition::{FullParameter, International, Parameter, ParameterDescriptor, Scaling, ScalingLinks};

use super::{
    AttributeRule, Call, Effect, Effects, Failure, Object, Size, attributes_all, class_attribute, exact,
};
use crate::code::{AttributeId, ClassId, GeneralStatus, InstanceId, ServiceCode};
use crate::codec::{Full, Writer};

/// The parameters of an application: a public interface to its settings, with all that a tool needs to show them.
///
/// Parameters are instances 1, 2, 3 and so on, in the order of the table.
///
/// ```
/// use cip_core::code::InstanceId;
/// use cip_core::codec::Writer;
/// use cip_core::data_type::DataType;
/// use cip_core::object::{Failure, FullParameter, Parameter, Parameters, exact};
///
/// struct Drive {
///     speed: u16,
///     direction: u8,
/// }
///
/// impl Parameters for Drive {
///     const PARAMETERS: &'static [Parameter] = &[
///         Parameter::new(DataType::Uint, &[]).full(&FullParameter {
///             minimum: &[10, 0],
///             maximum: &3000_u16.to_le_bytes(),
///             default: &1500_u16.to_le_bytes(),
///             ..FullParameter::new(b"Speed", b"rpm", b"Speed of the shaft")
///         }),
///         Parameter::new(DataType::Usint, &[0x20, 0x64, 0x24, 0x01, 0x30, 0x64]).named_values(&[b"Left", b"Right"]),
///     ];
///
///     fn value(&self, parameter: InstanceId, out: &mut Writer<'_>) -> Result<(), Failure> {
///         Ok(if parameter.0 == 1 { out.u16(self.speed)? } else { out.u8(self.direction)? })
///     }
///
///     fn set_value(&mut self, parameter: InstanceId, value: &[u8]) -> Result<(), Failure> {
///         match parameter.0 {
///             1 => self.speed = u16::from_le_bytes(exact(value)?),
///             _ => [self.direction] = exact(value)?,
///         }
///         Ok(())
///     }
/// }
/// assert!(Drive::PARAMETERS.iter().all(Parameter::is_valid));
/// ```
pub trait Parameters {
    /// All parameters.
    const PARAMETERS: &'static [Parameter];

    /// Writes the value of a parameter of the table.
    fn value(&self, parameter: InstanceId, out: &mut Writer<'_>) -> Result<(), Failure>;

    /// Sets a parameter of the table. The value has the right length and is within the limits of a full parameter;
    /// 0x09 is the status of one that is wrong for another reason.
    fn set_value(&mut self, parameter: InstanceId, value: &[u8]) -> Result<(), Failure>;

    /// What the table says of an instance.
    fn parameter(&self, parameter: InstanceId) -> Option<&'static Parameter> {
        Self::PARAMETERS.get(usize::from(parameter.0).checked_sub(1)?)
    }
}

/// The Parameter object over the parameters of an application.
///
/// | Attribute | Value | Access |
/// |---|---|---|
/// | 1 | value, of the type of attribute 5 | Get; Set unless it is read-only |
/// | 2 | length of the link path in bytes, USINT | Get |
/// | 3 | link path, packed EPATH | Get |
/// | 4 | [`ParameterDescriptor`], WORD | Get |
/// | 5 | code of the data type, USINT | Get |
/// | 6 | size of the value in bytes, USINT | Get |
/// | 7-9 | name, units, help, SHORT_STRING | Get, full parameters |
/// | 10-12 | minimum, maximum, default, of the type of attribute 5 | Get, full parameters |
/// | 13-16 | scaling multiplier, divisor, base (UINT), offset (INT) | Get, full parameters |
/// | 17-20 | links to the parameters that scale, UINT | Get, full parameters |
/// | 21 | decimal precision, USINT | Get, full parameters |
/// | 22-24 | international name, units, help, STRINGI | Get, if there |
///
/// | Class attribute | Value |
/// |---|---|
/// | 1 | revision, 1 |
/// | 2 | highest instance: the number of parameters |
/// | 8 | [`ParameterClassDescriptor`] |
/// | 9 | configuration assembly, 0: none |
/// | 10 | native language, 1: English |
///
/// | Service | Of | Answer |
/// |---|---|---|
/// | 0x01 Get_Attributes_All | instance | its attributes in order |
/// | 0x05 Reset, 0x15 Restore, 0x16 Save | class | no data, and [`Effect::PARAMETERS_RESET`] and so on; see [`ParameterStorage`] |
/// | 0x0E, 0x10 | instance; 0x0E class | |
/// | 0x4B Get_Enum_String | instance with named values | USINT index; the name, SHORT_STRING; 0x20 beyond the last |
///
/// The link path tells where the value is also found; it cannot be set. Source: CIP Vol. 1, chapter 5; product manuals.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ParameterObject<P> {
    /// The parameters.
    pub parameters: P,
    /// What the class can do with all values together. Default: nothing.
    pub storage: ParameterStorage,
    /// Class attribute 9. Default: 0, none.
    pub configuration_assembly: InstanceId,
    /// Class attribute 10. Default: 1, English.
    pub native_language: u8,
}

bitflags::bitflags! {
    /// What the Parameter class can do with all values together.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct ParameterStorage: u8 {
        /// The service Reset: default values.
        const RESET = 0x01;
        /// The service Restore: values that were saved.
        const RESTORE = 0x02;
        /// The service Save: bit 2 of the class descriptor.
        const SAVE = 0x04;
        /// Values are kept without power: bit 3 of the class descriptor.
        const NON_VOLATILE = 0x08;
    }

    /// Class attribute 8.
    ///
    /// | Bit | Meaning |
    /// |---|---|
    /// | 0 | there are instances |
    /// | 1 | all parameters are full ones |
    /// | 2 | values are stored by the service Save |
    /// | 3 | values are kept without power |
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct ParameterClassDescriptor: u16 {
        /// There are instances.
        const INSTANCES = 0x0001;
        /// All parameters are full ones.
        const FULL = 0x0002;
        /// Values are stored by the service Save.
        const SAVE = 0x0004;
        /// Values are kept without power.
        const NON_VOLATILE = 0x0008;
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for ParameterStorage {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=u8:#04x}", self.bits());
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for ParameterClassDescriptor {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=u16:#06x}", self.bits());
    }
}

impl<P: Parameters> ParameterObject<P> {
    /// An object that neither stores nor resets values, in English.
    pub const fn new(parameters: P) -> Self {
        Self {
            parameters,
            storage: ParameterStorage::empty(),
            configuration_assembly: InstanceId(0),
            native_language: 1,
        }
    }

    /// Class attribute 8.
    pub fn descriptor(&self) -> ParameterClassDescriptor {
        let full = P::PARAMETERS.iter().all(Parameter::is_full);
        [
            (true, ParameterClassDescriptor::INSTANCES),
            (full, ParameterClassDescriptor::FULL),
            (self.storage.contains(ParameterStorage::SAVE), ParameterClassDescriptor::SAVE),
            (self.storage.contains(ParameterStorage::NON_VOLATILE), ParameterClassDescriptor::NON_VOLATILE),
        ]
        .into_iter()
        .filter_map(|(set, bit)| set.then_some(bit))
        .collect()
    }

    fn get_class(&self, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        match attribute.0 {
            8 => out.u16(self.descriptor().bits()),
            9 => out.u16(self.configuration_assembly.0),
            10 => out.u8(self.native_language),
            _ => return class_attribute(self, attribute, out),
        }?;
        Ok(())
    }

    fn store(&self, call: &Call<'_>, offer: ParameterStorage, effect: Effect) -> Result<Effects, Failure> {
        if !self.storage.contains(offer) {
            return Err(GeneralStatus::SERVICE_NOT_SUPPORTED.into());
        }
        call.no_data()?;
        Ok(effect.into())
    }
}

/// The name of a value, for Get_Enum_String.
fn enum_string(parameter: &Parameter, data: &[u8], out: &mut Writer<'_>) -> Result<Effects, Failure> {
    if parameter.names().is_empty() {
        return Err(GeneralStatus::SERVICE_NOT_SUPPORTED.into());
    }
    let [index] = exact(data)?;
    let name = parameter.names().get(usize::from(index));
    emit_short_string(name.ok_or(Failure::new(GeneralStatus::INVALID_PARAMETER))?, out)?;
    Ok(Effects::NONE)
}

impl<P: Parameters> Object for ParameterObject<P> {
    const CLASS: ClassId = ClassId::PARAMETER;

    fn class_attributes(&self) -> &'static [AttributeRule] {
        const {
            &[
                AttributeRule::get(1, 2),
                AttributeRule::get(2, 2),
                AttributeRule::get(8, 2),
                AttributeRule::get(9, 2),
                AttributeRule::get(10, 1),
            ]
        }
    }

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        let parameter = self.parameters.parameter(instance)?;
        let rules = if parameter.is_read_only() { READ_ONLY } else { SETTABLE };
        rules.get(..parameter.attribute_count())
    }

    fn next_instance(&self, instance: InstanceId) -> Option<InstanceId> {
        let next = InstanceId(instance.0.checked_add(1)?);
        self.parameters.parameter(next).map(|_| next)
    }

    fn get(&self, instance: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        match self.parameters.parameter(instance) {
            None => self.get_class(attribute, out),
            Some(_) if attribute.0 == 1 => self.parameters.value(instance, out),
            Some(parameter) => Ok(parameter.emit(attribute, out)?),
        }
    }

    fn set(
        &mut self,
        instance: InstanceId,
        _: AttributeId,
        value: &[u8],
        _: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        if let Some(parameter) = self.parameters.parameter(instance) {
            parameter.check(value)?;
        }
        self.parameters.set_value(instance, value)?;
        Ok(Effect::PARAMETER_VALUE.into())
    }

    fn service(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<Effects, Failure> {
        let Some(parameter) = self.parameters.parameter(call.instance) else {
            return match call.service {
                ServiceCode::RESET => self.store(call, ParameterStorage::RESET, Effect::PARAMETERS_RESET),
                ServiceCode::RESTORE => {
                    self.store(call, ParameterStorage::RESTORE, Effect::PARAMETERS_RESTORE)
                }
                ServiceCode::SAVE => self.store(call, ParameterStorage::SAVE, Effect::PARAMETERS_SAVE),
                _ => Err(GeneralStatus::SERVICE_NOT_SUPPORTED.into()),
            };
        };
        match call.service {
            ServiceCode::GET_ATTRIBUTES_ALL => attributes_all(self, call, out),
            GET_ENUM_STRING => enum_string(parameter, call.data, out),
            _ => Err(GeneralStatus::SERVICE_NOT_SUPPORTED.into()),
        }
    }
}

fn emit_short_string(text: &[u8], out: &mut Writer<'_>) -> Result<(), Full> {
    out.u8(u8::try_from(text.len()).map_err(|_| Full)?)?;
    out.bytes(text)
}

/// All attributes of a parameter. Those of its data type have the size that the parameter says.
const fn rules(value: AttributeRule) -> [AttributeRule; 24] {
    let short_string = Size::ShortString;
    [
        value.sized(Size::Any),
        AttributeRule::get(2, 1),
        AttributeRule::get(3, 0).sized(Size::Any),
        AttributeRule::get(4, 2),
        AttributeRule::get(5, 1),
        AttributeRule::get(6, 1),
        AttributeRule::get(7, 0).sized(short_string),
        AttributeRule::get(8, 0).sized(short_string),
        AttributeRule::get(9, 0).sized(short_string),
        AttributeRule::get(10, 0).sized(Size::Any),
        AttributeRule::get(11, 0).sized(Size::Any),
        AttributeRule::get(12, 0).sized(Size::Any),
        AttributeRule::get(13, 2),
        AttributeRule::get(14, 2),
        AttributeRule::get(15, 2),
        AttributeRule::get(16, 2),
        AttributeRule::get(17, 2),
        AttributeRule::get(18, 2),
        AttributeRule::get(19, 2),
        AttributeRule::get(20, 2),
        AttributeRule::get(21, 1),
        AttributeRule::get(22, 0).sized(Size::Any),
        AttributeRule::get(23, 0).sized(Size::Any),
        AttributeRule::get(24, 0).sized(Size::Any),
    ]
}

static SETTABLE_RULES: [AttributeRule; 24] = rules(AttributeRule::get_set(1, 0));
static READ_ONLY_RULES: [AttributeRule; 24] = rules(AttributeRule::get(1, 0));
const SETTABLE: &[AttributeRule] = &SETTABLE_RULES;
const READ_ONLY: &[AttributeRule] = &READ_ONLY_RULES;
const GET_ENUM_STRING: ServiceCode = ServiceCode(0x4B);
