#![no_std]
#![no_main]
//! The same slave as in `slave`, without any part that a slave may do without.

use core::sync::atomic::AtomicU8;

use cortex_m_rt::entry;
use devicenet_core::slave::Parts;
use devicenet_firmware::{Block, Server, run};
use panic_halt as _;

#[entry]
fn main() -> ! {
    run::<PARTS>()
}

const PARTS: u16 = Parts::empty().bits();

/// The RAM of the machine without its application, as the size of a symbol.
#[used]
static MACHINE_RAM: [AtomicU8; RAM] = [const { AtomicU8::new(0) }; RAM];
const RAM: usize = size_of::<Server<PARTS>>() - size_of::<Block<PARTS>>();
