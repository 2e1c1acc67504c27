//! A CAN peripheral for a port: whatever the chip would give comes through `black_box`, so that the compiler cannot know it.

use core::convert::Infallible;
use core::hint::black_box;
use core::ops::ControlFlow;

use embedded_can::nb::Can;
use embedded_can::{ErrorKind, Id};
use link_core::embedded::Driver;
use link_core::frame::standard_id;
use link_core::{Frame, Instant, LinkCommand, LinkEvent, Machine, Port, drive};

/// The peripheral, of which nothing is kept.
#[derive(Debug)]
pub struct Chip;

impl Can for Chip {
    type Frame = Frame;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, ErrorKind> {
        black_box(frame);
        black_box(Ok(None))
    }

    fn receive(&mut self) -> nb::Result<Frame, ErrorKind> {
        if let Some(error) = black_box(None) {
            return Err(error);
        }
        let data = black_box([0_u8; 8]);
        Frame::new(standard_id(black_box(0)), data.get(..black_box(8)).unwrap_or_default())
            .ok_or(nb::Error::WouldBlock)
    }
}

impl Driver for Chip {
    fn now(&mut self) -> Instant {
        Instant::from_nanos(black_box(0))
    }

    fn sent(&mut self) -> Option<(Id, bool)> {
        black_box(None)
    }

    fn abort(&mut self, frame: &Frame) -> bool {
        black_box(frame);
        black_box(true)
    }

    fn event(&mut self) -> Option<LinkEvent> {
        black_box(Some(LinkEvent::Up))
    }

    fn command(&mut self, command: &LinkCommand) -> bool {
        black_box(command);
        black_box(true)
    }

    fn idle(&mut self, until: Option<Instant>) {
        black_box(until);
    }
}

/// Runs a machine on a port, for ever unless that fails.
pub fn run_loop<M: Machine>(machine: &mut M, port: &mut impl Port) -> ! {
    let _ = drive(machine, port, |_, _, event| {
        black_box(&event);
        ControlFlow::<Infallible>::Continue(())
    });
    loop {}
}
