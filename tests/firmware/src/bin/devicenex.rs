#![no_std]
#![no_main]
//! A DeviceNeX device: all connections are offered, four of them at once, explicit messages of 32 bytes with fragments. As with
//! the other, `scripts/bare-metal` prints its size, and demands that no panicking code was linked into it.

use core::hint::black_box;
use core::sync::atomic::AtomicU8;

use cip_core::code::{DeviceType, VendorId};
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use cip_core::object::Identity;
use cortex_m_rt::entry;
use devicenet_firmware::drive_extended;
use devicenex_core::access::Role;
use devicenex_core::device::{Application, Config, Device};
use devicenex_core::message::{ConnectionInstance, PortByte};
use panic_halt as _;

/// Two bytes in, one byte out.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct Block {
    device: DeviceIdentity,
    inputs: [u8; 2],
    outputs: [u8; 1],
}

impl Application for Block {
    type Long = ();

    fn identity(&self) -> Identity<'_> {
        Identity::new(&self.device)
    }

    fn produced(&self, _: ConnectionInstance) -> &[u8] {
        &self.inputs
    }

    fn consumed(&mut self, _: ConnectionInstance) -> &mut [u8] {
        &mut self.outputs
    }
}

#[entry]
fn main() -> ! {
    // A fictitious device.
    let device = DeviceIdentity {
        vendor: VendorId(black_box(0x1234)),
        device_type: DeviceType::GENERAL_PURPOSE_DISCRETE_IO,
        product_code: 1,
        revision: Revision { major: 1, minor: 1 },
        serial: black_box(0x0000_2345),
        name: ProductName::from_bytes(b"Example").unwrap_or_default(),
    };
    let config = Config::new(&device, PortByte::ZERO, Role::Device);
    let Ok(mut node) = Node::new(config, Block { device, inputs: black_box([0; 2]), outputs: [0] }) else {
        loop {}
    };
    drive_extended(&mut node)
}

type Node = Device<Block, 32, 4>;

/// The RAM of the machine without its application, as the size of a symbol.
#[used]
static MACHINE_RAM: [AtomicU8; RAM] = [const { AtomicU8::new(0) }; RAM];
const RAM: usize = size_of::<Node>() - size_of::<Block>();
