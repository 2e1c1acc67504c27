#![no_std]
#![no_main]
//! The smallest firmware around a node's network access: no formatting, no output. `scripts/bare-metal` prints its size, and demands
//! that no panicking code was linked into it. Everything that a CAN controller would give comes through `black_box`, so
//! that the compiler cannot know it.

use core::hint::black_box;

use cortex_m_rt::entry;
use devicenet_core::MacId;
use devicenet_core::access::{Access, Config};
use devicenet_core::message::{DeviceIdentity, PortNumber};
use link_core::{Action, Frame, Id, Input, Instant, LinkEvent, Machine, StandardId, TxOutcome, TxToken};
use panic_halt as _;

#[entry]
fn main() -> ! {
    let device = DeviceIdentity { vendor: black_box(0x1234).into(), serial: black_box(0x0000_2345) };
    let mut access = Access::new(Config::new(device, PortNumber::ZERO, MacId::DEFAULT));
    let mut sent = None;
    loop {
        let now = Instant::from_nanos(black_box(0));
        access.input(now, next_input(&mut sent));
        while let Some(action) = access.poll(now) {
            match action {
                Action::Transmit(token, frame) => {
                    black_box(frame);
                    sent = Some(token);
                }
                Action::Withdraw(token) => {
                    black_box(token);
                }
                Action::Link(command) => {
                    black_box(command);
                }
                Action::Event(event) => {
                    black_box(event);
                }
            }
        }
        black_box(access.deadline());
    }
}

fn next_input(sent: &mut Option<TxToken>) -> Input {
    if let Some(token) = sent.take() {
        return Input::TxDone(token, if black_box(true) { TxOutcome::Sent } else { TxOutcome::Dropped });
    }
    if black_box(false) {
        return Input::Link(black_box(LinkEvent::Up));
    }
    let id = Id::Standard(StandardId::new(black_box(0)).unwrap_or(StandardId::MAX));
    let data = black_box([0_u8; 8]);
    match Frame::new(id, data.get(..black_box(8)).unwrap_or_default()) {
        Some(frame) => Input::Frame(frame),
        None => Input::Tick,
    }
}
