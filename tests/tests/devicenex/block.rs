//! The device behind the nodes of these tests.

use cip_core::code::{DeviceType, VendorId};
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use cip_core::object::Identity;
use devicenex_core::access::Role;
use devicenex_core::device::{Application, Config, Device};
use devicenex_core::message::{ConnectionInstance, PortByte};

/// Two bytes in, two bytes out.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Block {
    identity: DeviceIdentity,
    pub(crate) inputs: [u8; 2],
    pub(crate) outputs: [u8; 2],
}

pub(crate) type Node = Device<Block, 64, 4>;

pub(crate) fn identity(serial: u32) -> DeviceIdentity {
    identity_of(7, serial)
}

/// The vendor is fictitious.
pub(crate) fn identity_of(product_code: u16, serial: u32) -> DeviceIdentity {
    DeviceIdentity {
        vendor: VendorId(0x1234),
        device_type: DeviceType::GENERAL_PURPOSE_DISCRETE_IO,
        product_code,
        revision: Revision::new(1, 1).unwrap(),
        serial,
        name: ProductName::new("Example Block").unwrap(),
    }
}

/// A device without power.
pub(crate) fn node(serial: u32) -> Node {
    node_of(identity(serial), [0x34, 0x12])
}

/// A device without power that produces these inputs.
pub(crate) fn node_of(identity: DeviceIdentity, inputs: [u8; 2]) -> Node {
    let config = Config::new(&identity, PortByte::ZERO, Role::Device);
    Device::new(config, Block { identity, inputs, outputs: [0; 2] }).unwrap()
}

impl Application for Block {
    type Long = ();

    fn identity(&self) -> Identity<'_> {
        Identity::new(&self.identity)
    }

    fn produced(&self, _: ConnectionInstance) -> &[u8] {
        &self.inputs
    }

    fn consumed(&mut self, _: ConnectionInstance) -> &mut [u8] {
        &mut self.outputs
    }
}
