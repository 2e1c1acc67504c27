#![no_std]
#![no_main]
//! The smallest firmware around a node's network access: no formatting, no output. `scripts/bare-metal` prints its size, and demands
//! that no panicking code was linked into it.

use core::hint::black_box;
use core::sync::atomic::AtomicU8;

use cortex_m_rt::entry;
use devicenet_core::MacId;
use devicenet_core::access::{Access, Config};
use devicenet_core::message::{DeviceIdentity, PortNumber};
use devicenet_firmware::drive;
use panic_halt as _;

/// The RAM of the machine, as the size of a symbol.
#[used]
static MACHINE_RAM: [AtomicU8; size_of::<Access>()] = [const { AtomicU8::new(0) }; size_of::<Access>()];

#[entry]
fn main() -> ! {
    let device = DeviceIdentity { vendor: black_box(0x1234).into(), serial: black_box(0x0000_2345) };
    drive(&mut Access::new(Config::new(device, PortNumber::ZERO, MacId::DEFAULT)))
}
