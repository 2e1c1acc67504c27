#![no_std]
#![no_main]
//! The smallest firmware around the passive decoder, for a data logger without a computer: no formatting, no output. As with
//! the other, `scripts/bare-metal` demands that no panicking code was linked into it.

use core::hint::black_box;

use cortex_m_rt::entry;
use devicenet_core::monitor::{MonitorConfig, SizedMonitor};
use link_core::{Frame, Id, Instant, StandardId};
use panic_halt as _;

#[entry]
fn main() -> ! {
    let mut monitor = SizedMonitor::<4, 64>::new(MonitorConfig::default());
    loop {
        let id = Id::Standard(StandardId::new(black_box(0)).unwrap_or(StandardId::MAX));
        let data = black_box([0_u8; 8]);
        if let Some(frame) = Frame::new(id, data.get(..black_box(8)).unwrap_or_default()) {
            let reading = monitor.observe(Instant::from_nanos(black_box(0)), black_box(0), &frame);
            black_box(reading.kind);
        }
    }
}
