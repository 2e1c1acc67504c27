//! The objects of the application.

use link_core::codec::Writer;

use super::{Entry, ObjectAddress};
use crate::wire::AbortCode;

/// The objects 0x2000 to 0x9FFF, which the application adds to those of the node: those of the vendor and those of a device
/// profile. Process data are objects that may be mapped.
///
/// A set has its lines as a constant, and reads and writes values by address. What it is asked has been checked against the
/// line: the object exists, the access is allowed, the length and the range are right.
///
/// ```
/// use link_core::codec::Writer;
/// use powerlink_core::dictionary::{Access, Entry, Mappable, ObjectAddress, ObjectSet, ObjectType};
/// use powerlink_core::wire::AbortCode;
///
/// /// Eight digital inputs and eight digital outputs, after CiA 401.
/// #[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
/// struct DigitalIo {
///     inputs: u8,
///     outputs: u8,
/// }
///
/// impl ObjectSet for DigitalIo {
///     const ENTRIES: &'static [Entry] = &[
///         Entry::new(0x6000, 1, "inputs", ObjectType::Unsigned(1), Access::ReadOnly).mapped(Mappable::Transmit),
///         Entry::new(0x6200, 1, "outputs", ObjectType::Unsigned(1), Access::ReadWrite).mapped(Mappable::Receive),
///     ];
///
///     fn read(&self, at: ObjectAddress, out: &mut Writer<'_>) -> Result<(), AbortCode> {
///         let value = if at.index == 0x6000 { self.inputs } else { self.outputs };
///         out.u8(value).map_err(|_| AbortCode::OUT_OF_MEMORY)
///     }
///
///     fn write(&mut self, _: ObjectAddress, data: &[u8]) -> Result<(), AbortCode> {
///         self.outputs = data.first().copied().ok_or(AbortCode::LENGTH)?;
///         Ok(())
///     }
///
///     fn restore(&mut self) {
///         self.outputs = 0;
///     }
/// }
/// ```
pub trait ObjectSet {
    /// What there is, in the order of index and sub-index.
    const ENTRIES: &'static [Entry];

    /// Writes the value of an object to `out`.
    ///
    /// # Errors
    /// Why it cannot be read now. A PRes that lacks a value says that its data are not valid.
    fn read(&self, at: ObjectAddress, out: &mut Writer<'_>) -> Result<(), AbortCode>;

    /// Takes a value from SDO or from a PDO.
    ///
    /// # Errors
    /// Why it cannot be taken. Of a PDO the sender does not hear it, but the application does.
    fn write(&mut self, at: ObjectAddress, data: &[u8]) -> Result<(), AbortCode>;

    /// Power-on values: the node is reset.
    fn restore(&mut self);
}

/// An application without objects.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NoObjects;

impl ObjectSet for NoObjects {
    const ENTRIES: &'static [Entry] = &[];

    fn read(&self, _: ObjectAddress, _: &mut Writer<'_>) -> Result<(), AbortCode> {
        Err(AbortCode::NO_OBJECT)
    }

    fn write(&mut self, _: ObjectAddress, _: &[u8]) -> Result<(), AbortCode> {
        Err(AbortCode::NO_OBJECT)
    }

    fn restore(&mut self) {}
}
