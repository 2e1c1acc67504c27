#![no_std]
#![no_main]
//! The loop of a driver around a machine that does nothing: what the other firmwares have besides their machines.

use cortex_m_rt::entry;
use devicenet_firmware::drive;
use link_core::{Action, Deadline, Input, Instant, Machine};
use panic_halt as _;

struct Idle;

impl Machine for Idle {
    type Event = ();

    fn input(&mut self, _: Instant, _: Input) {}

    fn poll(&mut self, _: Instant) -> Option<Action<()>> {
        None
    }

    fn deadline(&self) -> Option<Deadline> {
        None
    }

    fn max_in_flight(&self) -> usize {
        0
    }
}

#[entry]
fn main() -> ! {
    drive(&mut Idle)
}
