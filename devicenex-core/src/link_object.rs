//! The link object (class 3): what the DeviceNet object is on DeviceNet.
//!
//! | Attribute of instance 1 | Type | Access |
//! |---|---|---|
//! | 1 operational address | USINT | Get, Set |
//! | 2 bit rate: 0 125, 1 250, 2 500 kbit/s, 0xFF another, or not known | USINT | Get |
//! | 3 BOI: 1 starts the node once more after bus-off | BOOL | Get, Set |
//! | 4 bus-off counter | USINT | Get; Set to 0 |
//! | 5 connection instances in use: USINT count, USINT each | ARRAY | Get |
//! | 6 Hello wait in ms, from 1; not kept over a reset | UINT | Get, Set |
//!
//! The paper keeps nothing of it but the idea that a device with an address is readdressed over its explicit connection **\[P\]**;
//! the class and the attributes are **\[D\]**. A Set of attribute 1 is answered under the old address; then the node says Hello
//! with the new one, and 127 gives the address up. Values above 127 for attribute 1, above 1 for 3, other than 0 for 4, and 0
//! for 6 are refused with 0x09. Class attribute 1 (revision) is 1.

use cip_core::code::{AttributeId, ClassId, GeneralStatus, InstanceId};
use cip_core::codec::Writer;
use cip_core::object::{AttributeRule, Effects, Failure, Object, Size, exact};
use link_core::BitRate;

use crate::access::Access;
use crate::id::OperationalAddress;

/// The object, put together for one request.
#[derive(Debug)]
pub(crate) struct LinkObject<'a> {
    access: &'a mut Access,
    /// Attribute 5.
    instances: Instances,
    new_address: Option<OperationalAddress>,
}

/// As many as there can be: 13 of the predefined set, and dynamic ones.
pub(crate) type Instances = heapless::Vec<u8, MOST_CONNECTIONS>;

impl<'a> LinkObject<'a> {
    pub(crate) const fn new(access: &'a mut Access, instances: Instances) -> Self {
        Self { access, instances, new_address: None }
    }

    /// The address that was set: to be said Hello with when the response has been sent.
    pub(crate) const fn new_address(&self) -> Option<OperationalAddress> {
        self.new_address
    }
}

impl Object for LinkObject<'_> {
    const CLASS: ClassId = ClassId::DEVICENET;

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        (instance.0 == 1).then_some(RULES)
    }

    fn get(&self, _: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        match attribute.0 {
            1 => out.u8(self.access.address().number())?,
            2 => out.u8(rate_code(self.access.bit_rate()))?,
            3 => out.u8(self.access.bus_off_interrupt().into())?,
            4 => out.u8(self.access.bus_off_counter())?,
            5 => {
                // There are less than 256.
                out.u8(u8::try_from(self.instances.len()).unwrap_or(u8::MAX))?;
                out.bytes(&self.instances)?;
            }
            _ => out.u16(self.access.hello_wait())?,
        }
        Ok(())
    }

    fn set(
        &mut self,
        _: InstanceId,
        attribute: AttributeId,
        value: &[u8],
        _: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        match attribute.0 {
            1 => {
                let [number] = exact(value)?;
                self.new_address = Some(OperationalAddress::new(number).ok_or(INVALID)?);
            }
            3 => match exact(value)? {
                [bit @ (0 | 1)] => self.access.set_bus_off_interrupt(bit == 1),
                [_] => return Err(INVALID),
            },
            4 => match exact(value)? {
                [0] => self.access.clear_bus_off_counter(),
                [_] => return Err(INVALID),
            },
            _ => match u16::from_le_bytes(exact(value)?) {
                0 => return Err(INVALID),
                millis => self.access.set_hello_wait(millis),
            },
        }
        Ok(Effects::NONE)
    }
}

const fn rate_code(rate: Option<BitRate>) -> u8 {
    match rate {
        Some(BitRate::K125) => 0,
        Some(BitRate::K250) => 1,
        Some(BitRate::K500) => 2,
        Some(_) | None => 0xFF,
    }
}

const RULES: &[AttributeRule] = &[
    AttributeRule::get_set(1, 1),
    AttributeRule::get(2, 1),
    AttributeRule::get_set(3, 1),
    AttributeRule::get_set(4, 1),
    AttributeRule::get(5, 0).sized(Size::Any),
    AttributeRule::get_set(6, 2),
];
const INVALID: Failure = Failure::new(GeneralStatus::INVALID_ATTRIBUTE_VALUE);
/// The connections that a node can have.
pub(crate) const MOST_CONNECTIONS: usize = 127;
