#![no_std]
#![no_main]
//! The loop of a driver around a machine that does nothing: what the other firmwares have besides their machines. The compiler
//! cannot know that it does nothing.

use core::hint::black_box;

use cortex_m_rt::entry;
use devicenet_firmware::drive;
use link_core::{Action, Deadline, Frame, Input, Instant, LinkCommand, Machine, TxToken, frame::standard_id};
use panic_halt as _;

struct Idle;

impl Machine for Idle {
    type Event = u32;

    fn input(&mut self, now: Instant, input: Input) {
        black_box((now, &input));
    }

    fn poll(&mut self, _: Instant) -> Option<Action<u32>> {
        match black_box(0_u32) {
            0 => None,
            1 => Frame::new(standard_id(0), &[]).map(|frame| Action::Transmit(TxToken(0), frame)),
            2 => Some(Action::Withdraw(TxToken(0))),
            3 => Some(Action::Link(LinkCommand::Reset)),
            event => Some(Action::Event(event)),
        }
    }

    fn deadline(&self) -> Option<Deadline> {
        black_box(false).then(|| Deadline::now(Instant::ZERO))
    }

    fn max_in_flight(&self) -> usize {
        0
    }
}

#[entry]
fn main() -> ! {
    drive(&mut Idle)
}
