#![no_std]
#![no_main]
//! The smallest firmware around a Group 2 Only server: two bytes in, one byte out, by poll, explicit messages of up to 32
//! bytes. No formatting, no output. `scripts/bare-metal` prints its size, and demands that no panicking code was linked
//! into it. Everything that a CAN controller would give comes through `black_box`, so that the compiler cannot know it.

use core::hint::black_box;

use cip_core::code::{DeviceType, VendorId};
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use cip_core::message::AllocationChoice;
use cip_core::object::Identity;
use cortex_m_rt::entry;
use devicenet_core::MacId;
use devicenet_core::slave::{Application, Config, Group2OnlyServer, IoKind};
use link_core::{Action, Frame, Id, Input, Instant, LinkEvent, Machine, StandardId, TxOutcome, TxToken};
use panic_halt as _;

#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct Block {
    device: DeviceIdentity,
    inputs: [u8; 2],
    outputs: [u8; 1],
}

impl Application for Block {
    const IO: AllocationChoice = AllocationChoice::POLL;
    type Long = ();

    fn identity(&self) -> Identity<'_> {
        Identity::new(&self.device)
    }

    fn produced(&self, _: IoKind) -> &[u8] {
        &self.inputs
    }

    fn consumed(&mut self, _: IoKind) -> &mut [u8] {
        &mut self.outputs
    }
}

#[entry]
fn main() -> ! {
    let device = DeviceIdentity {
        vendor: VendorId(black_box(0x1234)),
        device_type: DeviceType::GENERAL_PURPOSE_DISCRETE_IO,
        product_code: 1,
        revision: Revision { major: 1, minor: 1 },
        serial: black_box(0x0000_2345),
        name: ProductName::from_bytes(b"Example").unwrap_or_default(),
    };
    let config = Config::new(&device, MacId::DEFAULT);
    let block = Block { device, inputs: [0; 2], outputs: [0] };
    let Ok(mut slave) = Group2OnlyServer::<Block, 32>::new(config, block) else { loop {} };
    let mut sent = None;
    loop {
        let now = Instant::from_nanos(black_box(0));
        slave.input(now, next_input(&mut sent));
        while let Some(action) = slave.poll(now) {
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
        black_box(slave.deadline());
        black_box(slave.application().outputs);
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
