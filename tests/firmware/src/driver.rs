//! The loop that a driver runs around a machine. Everything that a CAN controller and
//! a clock would give comes through `black_box`, so that the compiler cannot know it.

use core::hint::black_box;

use link_core::{Action, Frame, Id, Input, Instant, LinkEvent, Machine, StandardId, TxOutcome, TxToken};

/// Feeds a machine and carries out what it asks for, for ever.
pub fn drive<M: Machine>(machine: &mut M) -> ! {
    let mut sent = None;
    loop {
        let now = Instant::from_nanos(black_box(0));
        machine.input(now, next_input(&mut sent));
        while let Some(action) = machine.poll(now) {
            match &action {
                Action::Transmit(token, frame) => {
                    black_box(frame);
                    sent = Some(*token);
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
        // Why it is so is for people.
        black_box(machine.deadline().map(|deadline| deadline.at));
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
