#![no_std]
#![no_main]
//! The same slave as in `small`, by `link_core::drive` on a port for an `embedded_can` driver.

use core::sync::atomic::AtomicU8;

use cortex_m_rt::entry;
use devicenet_core::slave::Parts;
use devicenet_firmware::{Block, Server, ServerPort, run_on_port};
use panic_halt as _;

#[entry]
fn main() -> ! {
    run_on_port::<PARTS>()
}

const PARTS: u16 = Parts::empty().bits();

/// The RAM of the machine without its application, and of the port, as the size of a symbol.
#[used]
static MACHINE_RAM: [AtomicU8; RAM] = [const { AtomicU8::new(0) }; RAM];
const RAM: usize = size_of::<Server<PARTS>>() - size_of::<Block<PARTS>>() + size_of::<ServerPort>();
