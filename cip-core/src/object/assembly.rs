//! The Assembly object (class 0x04).

use super::{AttributeRule, Effect, Effects, Failure, Object, Size};
use crate::code::{AttributeId, ClassId, GeneralStatus, InstanceId};
use crate::codec::{Full, Writer};

/// The assemblies of an application: blocks of data that I/O connections and explicit messages carry.
///
/// Instances 1-99 are for device profiles, 100-199 and 768-1279 for the vendor, 200-767 are open.
///
/// ```
/// use cip_core::code::{GeneralStatus, InstanceId};
/// use cip_core::object::{Assemblies, Assembly, Failure};
///
/// #[derive(Default)]
/// struct Valves {
///     sensors: [u8; 2],
///     coils: [u8; 1],
/// }
///
/// impl Assemblies for Valves {
///     const ASSEMBLIES: &'static [Assembly] = &[Assembly::input(100, 2), Assembly::output(150, 1)];
///
///     fn data(&self, instance: InstanceId) -> &[u8] {
///         if instance.0 == 100 { &self.sensors } else { &self.coils }
///     }
///
///     fn write(&mut self, _: InstanceId, data: &[u8]) -> Result<(), Failure> {
///         self.coils = data.try_into().map_err(|_| GeneralStatus::NOT_ENOUGH_DATA)?;
///         Ok(())
///     }
/// }
/// ```
pub trait Assemblies {
    /// All assemblies.
    const ASSEMBLIES: &'static [Assembly];

    /// The data of an assembly of the table: as many bytes as it says.
    fn data(&self, instance: InstanceId) -> &[u8];

    /// Judges data before they are written; by default, all are good. 0x09 is the status of a value out of range.
    fn check(&self, _instance: InstanceId, _data: &[u8]) -> Result<(), Failure> {
        Ok(())
    }

    /// Takes over the data of an output or configuration assembly: checked, and as many bytes as the table says.
    /// Storage can fail (0x19), or the device be in a state that forbids it (0x10).
    fn write(&mut self, instance: InstanceId, data: &[u8]) -> Result<(), Failure>;

    /// What the table says of an instance.
    fn assembly(&self, instance: InstanceId) -> Option<&'static Assembly> {
        Self::ASSEMBLIES.iter().find(|assembly| assembly.instance == instance)
    }
}

/// One assembly: its instance, its size, and who writes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Assembly {
    /// The instance.
    pub instance: InstanceId,
    /// The size in bytes.
    pub size: u16,
    /// Who writes it.
    pub kind: AssemblyKind,
    members: &'static [Member],
    rules: [AttributeRule; 4],
}

/// Who writes the data of an assembly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AssemblyKind {
    /// The device; the network reads it.
    Input,
    /// The network, by the I/O connection that owns it, or by explicit messages while none does.
    Output,
    /// The network, by explicit messages.
    Configuration,
}

/// A member of an assembly (attribute 2).
///
/// | Bytes | Content |
/// |---|---|
/// | 0-1 | size in bits |
/// | 2-3 | length of the path in bytes |
/// | 4.. | packed path to the member's value; without one the bits are padding |
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Member {
    /// The size in bits.
    pub bits: u16,
    /// The packed path to the value.
    pub path: &'static [u8],
}

/// The Assembly object over the assemblies of an application.
///
/// | Attribute | Value | Access |
/// |---|---|---|
/// | 1 | number of members, UINT | Get, if there are members |
/// | 2 | member list, [`Member`] each | Get, if there are members |
/// | 3 | data | Get; Set of output and configuration assemblies |
/// | 4 | size in bytes, UINT | Get |
///
/// A Set of an input assembly is 0x0E, of another length 0x13 or 0x15, and of an output assembly that an I/O
/// connection owns 0x0C. Class attributes: 1 revision (2), 2 highest instance, 3 number of instances. Source: CIP
/// Vol. 1, chapter 5; product manuals.
///
/// ```
/// # use cip_core::code::InstanceId;
/// # use cip_core::codec::Writer;
/// # use cip_core::object::{Assemblies, Assembly, Failure};
/// # struct Valves;
/// # impl Assemblies for Valves {
/// #     const ASSEMBLIES: &'static [Assembly] = &[Assembly::input(100, 2), Assembly::output(150, 1)];
/// #     fn data(&self, _: InstanceId) -> &[u8] { &[0x34, 0x12] }
/// #     fn write(&mut self, _: InstanceId, _: &[u8]) -> Result<(), Failure> { Ok(()) }
/// # }
/// use cip_core::code::{ClassId, ServiceCode};
/// use cip_core::object::{AssemblyObject, Call, FailureOptions, respond};
///
/// let mut valves = Valves;
/// let owned = [InstanceId(150)];
/// let mut objects = (AssemblyObject { assemblies: &mut valves, owned_by_io: &owned },);
/// let set = Call::new(ServiceCode::SET_ATTRIBUTE_SINGLE, ClassId::ASSEMBLY, InstanceId(150), &[3, 0xFF]);
/// let mut buffer = [0; 8];
/// let mut out = Writer::new(&mut buffer);
/// assert!(respond(&mut objects, &set, FailureOptions::default(), &mut out).is_err());
/// assert_eq!(out.written(), [0x94, 0x0C, 0xFF]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct AssemblyObject<'a, A> {
    /// The assemblies.
    pub assemblies: A,
    /// The output assemblies that an I/O connection owns at the time of the request.
    pub owned_by_io: &'a [InstanceId],
}

impl Assembly {
    /// Data of the device, of `size` bytes.
    pub const fn input(instance: u16, size: u16) -> Self {
        Self::new(instance, size, AssemblyKind::Input)
    }

    /// Data for the device, of `size` bytes.
    pub const fn output(instance: u16, size: u16) -> Self {
        Self::new(instance, size, AssemblyKind::Output)
    }

    /// Settings of the device, of `size` bytes.
    pub const fn configuration(instance: u16, size: u16) -> Self {
        Self::new(instance, size, AssemblyKind::Configuration)
    }

    /// The same with attributes 1 and 2.
    #[must_use]
    pub const fn with_members(self, members: &'static [Member]) -> Self {
        Self { members, ..self }
    }

    /// The members; none if the assembly does not tell.
    pub const fn members(&self) -> &'static [Member] {
        self.members
    }

    const fn new(instance: u16, size: u16, kind: AssemblyKind) -> Self {
        let data = match kind {
            AssemblyKind::Input => AttributeRule::get(3, size),
            AssemblyKind::Output | AssemblyKind::Configuration => AttributeRule::get_set(3, size),
        };
        let member_list = AttributeRule::get(2, 0).sized(Size::Any);
        let rules = [data, AttributeRule::get(4, 2), AttributeRule::get(1, 2), member_list];
        Self { instance: InstanceId(instance), size, kind, members: &[], rules }
    }

    fn rules(&self) -> &[AttributeRule] {
        let count = if self.members.is_empty() { 2 } else { 4 };
        self.rules.get(..count).unwrap_or_default()
    }
}

impl Member {
    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u16(self.bits)?;
        out.u16(u16::try_from(self.path.len()).map_err(|_| Full)?)?;
        out.bytes(self.path)
    }
}

impl<A: Assemblies> Assemblies for &mut A {
    const ASSEMBLIES: &'static [Assembly] = A::ASSEMBLIES;

    fn data(&self, instance: InstanceId) -> &[u8] {
        (**self).data(instance)
    }

    fn check(&self, instance: InstanceId, data: &[u8]) -> Result<(), Failure> {
        (**self).check(instance, data)
    }

    fn write(&mut self, instance: InstanceId, data: &[u8]) -> Result<(), Failure> {
        (**self).write(instance, data)
    }
}

impl<A: Assemblies> Object for AssemblyObject<'_, A> {
    const CLASS: ClassId = ClassId::ASSEMBLY;
    const REVISION: u16 = 2;

    fn class_attributes(&self) -> &'static [AttributeRule] {
        const { &[AttributeRule::get(1, 2), AttributeRule::get(2, 2), AttributeRule::get(3, 2)] }
    }

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        self.assemblies.assembly(instance).map(Assembly::rules)
    }

    /// An input assembly is one that cannot be set, not one without the service.
    fn has_set(&self, instance: InstanceId) -> bool {
        !instance.is_class()
    }

    fn next_instance(&self, instance: InstanceId) -> Option<InstanceId> {
        A::ASSEMBLIES.iter().map(|assembly| assembly.instance).filter(|&next| next > instance).min()
    }

    fn get(&self, instance: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        let Some(assembly) = self.assemblies.assembly(instance) else {
            let count = u16::try_from(A::ASSEMBLIES.len()).unwrap_or(u16::MAX);
            let highest = const { highest(A::ASSEMBLIES) };
            return Ok(out.u16(if attribute.0 == 2 { highest } else { count })?);
        };
        match attribute.0 {
            1 => out.u16(u16::try_from(assembly.members.len()).map_err(|_| Full)?),
            2 => assembly.members.iter().try_for_each(|member| member.emit(out)),
            3 => out.bytes(self.assemblies.data(instance)),
            _ => out.u16(assembly.size),
        }?;
        Ok(())
    }

    fn set(
        &mut self,
        instance: InstanceId,
        _: AttributeId,
        value: &[u8],
        _: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        self.assemblies.check(instance, value)?;
        if self.owned_by_io.contains(&instance) {
            return Err(GeneralStatus::OBJECT_STATE_CONFLICT.into());
        }
        self.assemblies.write(instance, value)?;
        Ok(Effect::ASSEMBLY_DATA.into())
    }
}

/// The highest instance, found when the program is compiled.
const fn highest(mut assemblies: &[Assembly]) -> u16 {
    let mut highest = 0;
    while let [Assembly { instance: InstanceId(instance), .. }, rest @ ..] = assemblies {
        highest = if *instance > highest { *instance } else { highest };
        assemblies = rest;
    }
    highest
}
