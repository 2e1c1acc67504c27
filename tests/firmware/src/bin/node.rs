#![no_std]
#![no_main]
//! test
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use panic_semihosting as _;
#[entry]
fn main() -> ! {
    hprintln!("hello {}", core::mem::size_of::<link_core::Frame>());
    debug::exit(debug::EXIT_SUCCESS);
    loop {}
}
