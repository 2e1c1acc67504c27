#![no_std]
#![no_main]
//! A slave with all its parts: no formatting, no output. `scripts/bare-metal` prints its size, and demands that no panicking
//! code was linked into it.

use core::sync::atomic::AtomicU8;

use cortex_m_rt::entry;
use devicenet_core::slave::Parts;
use devicenet_firmware::{Block, Server, run};
use panic_halt as _;

#[entry]
fn main() -> ! {
    run::<PARTS>()
}

const PARTS: u16 = Parts::all().bits();

/// The RAM of the machine without its application, as the size of a symbol.
#[used]
static MACHINE_RAM: [AtomicU8; RAM] = [const { AtomicU8::new(0) }; RAM];
const RAM: usize = size_of::<Server<PARTS>>() - size_of::<Block<PARTS>>();
