#![no_std]
#![no_main]
//! A node gets on line on a bus of two, in virtual time, on a Cortex-M4 in QEMU; then the RAM of each machine.
//!
//! The other node is not simulated but for what a controller needs of it: it acknowledges each frame after a millisecond.

use core::time::Duration;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use devicenet_core::MacId;
use devicenet_core::access::{Access, Config};
use devicenet_core::message::{DeviceIdentity, PortNumber};
use devicenet_core::monitor::{Monitor, SizedMonitor};
use link_core::{Action, Input, Instant, LinkEvent, Machine, TxOutcome};
use panic_semihosting as _;

#[entry]
fn main() -> ! {
    let on_line_at = get_on_line();
    hprintln!("{:<24} {:>6} bytes of RAM", "Access", size_of::<Access>());
    hprintln!("{:<24} {:>6} bytes of RAM", "SizedMonitor<4, 64>", size_of::<SizedMonitor<4, 64>>());
    hprintln!("{:<24} {:>6} bytes of RAM", "Monitor", size_of::<Monitor>());
    let expected = Instant::from_millis(2_002);
    debug::exit(if on_line_at == Some(expected) { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    loop {}
}

/// When the node was on line.
fn get_on_line() -> Option<Instant> {
    // A fictitious vendor.
    let device = DeviceIdentity { vendor: 0x1234.into(), serial: 0x0000_2345 };
    let mut access = Access::new(Config::new(device, PortNumber::ZERO, MacId::DEFAULT));
    let mut now = Instant::ZERO;
    let mut input = Input::Link(LinkEvent::Up);
    loop {
        let mut sending = None;
        for action in access.handle(now, input) {
            match action {
                Action::Transmit(token, frame) => {
                    hprintln!("{:.3}  {}", now, frame);
                    sending = Some(token);
                }
                Action::Event(event) => hprintln!("{:.3}  {}", now, event),
                Action::Withdraw(_) | Action::Link(_) => {}
            }
        }
        if access.is_online() {
            return Some(now);
        }
        (now, input) = match sending {
            Some(token) => (now + Duration::from_millis(1), Input::TxDone(token, TxOutcome::Sent)),
            None => (access.deadline()?.at, Input::Tick),
        };
    }
}
