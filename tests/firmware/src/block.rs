//! A Group 2 Only server: two bytes in, one byte out, by poll, explicit messages of up to 32 bytes.

use core::hint::black_box;

use cip_core::code::{DeviceType, VendorId};
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use cip_core::message::AllocationChoice;
use cip_core::object::Identity;
use devicenet_core::MacId;
use devicenet_core::slave::{Application, Config, Group2OnlyServer, InvalidSlave, IoKind, Parts, PollOnly};
use link_core::embedded::EmbeddedPort;

use crate::chip::{Chip, run_loop};
use crate::drive;

/// The slave with the parts that these bits stand for.
pub type Server<const PARTS: u16> = Group2OnlyServer<Block<PARTS>, 32>;

/// A port for it.
pub type ServerPort = EmbeddedPort<Chip, { Server::<0>::MAX_IN_FLIGHT }>;

/// Its application.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Block<const PARTS: u16> {
    inputs: [u8; 2],
    outputs: [u8; 1],
}

impl<const PARTS: u16> Application for Block<PARTS> {
    const IO: AllocationChoice = AllocationChoice::POLL;
    const PARTS: Parts = Parts::from_bits_truncate(PARTS);
    type Long = PollOnly;

    fn identity(&self) -> Identity<'_> {
        // The compiler cannot know what a device was given in the factory.
        Identity::new(black_box(&DEVICE))
    }

    fn produced(&self, _: IoKind) -> &[u8] {
        &self.inputs
    }

    fn consumed(&mut self, _: IoKind) -> &mut [u8] {
        &mut self.outputs
    }
}

/// Runs it for ever.
pub fn run<const PARTS: u16>() -> ! {
    let Ok(mut slave) = server::<PARTS>() else { loop {} };
    drive(&mut slave)
}

/// The same by the run loop of `link_core`, on a port.
pub fn run_on_port<const PARTS: u16>() -> ! {
    let Ok(mut slave) = server::<PARTS>() else { loop {} };
    run_loop(&mut slave, &mut ServerPort::new(Chip))
}

#[inline(always)]
fn server<const PARTS: u16>() -> Result<Server<PARTS>, InvalidSlave> {
    let config = Config::new(black_box(&DEVICE), MacId::DEFAULT);
    Server::new(config, Block { inputs: black_box([0; 2]), outputs: [0] })
}

/// A fictitious device.
static DEVICE: DeviceIdentity = DeviceIdentity {
    vendor: VendorId(0x1234),
    device_type: DeviceType::GENERAL_PURPOSE_DISCRETE_IO,
    product_code: 1,
    revision: Revision { major: 1, minor: 1 },
    serial: 0x0000_2345,
    name: ProductName::from_array(*b"Example"),
};
