//! The loop that a driver runs around a machine. Everything that a CAN controller and
//! a clock would give comes through `black_box`, so that the compiler cannot know it.

use core::hint::black_box;

use link_core::ethernet::{self, MAX_FRAME};
use link_core::{
    Action, ExtendedId, Frame, Id, Input, Instant, LinkEvent, Machine, StandardId, TxOutcome, TxToken,
};

/// Feeds a machine and carries out what it asks for, for ever. All frames have identifiers of 11 bits.
pub fn drive<M: Machine>(machine: &mut M) -> ! {
    run(machine, standard)
}

/// The same with identifiers of both lengths, and remote frames.
pub fn drive_extended<M: Machine>(machine: &mut M) -> ! {
    run(machine, |data| {
        let extended = ExtendedId::new(black_box(0)).unwrap_or(ExtendedId::MAX);
        match black_box(0) {
            0 => Frame::new(Id::Extended(extended), data),
            1 => Frame::remote(Id::Extended(extended), 8),
            _ => standard(data),
        }
    })
}

/// The same for an Ethernet controller.
pub fn drive_ethernet<M: ethernet::Machine>(machine: &mut M) -> ! {
    let (mut received, mut buffer) = ([0; MAX_FRAME], [0; MAX_FRAME]);
    loop {
        let now = Instant::from_nanos(black_box(0));
        let frame = black_box(&mut received).get(..black_box(60)).unwrap_or_default();
        let input = match black_box(0) {
            0 => ethernet::Input::Tick,
            1 => ethernet::Input::Link(black_box(ethernet::LinkEvent::Up)),
            _ => ethernet::Input::Frame(frame),
        };
        machine.input(now, input);
        while let Some(action) = machine.poll(now, &mut buffer) {
            match &action {
                ethernet::Action::Transmit(frame) => {
                    black_box(frame);
                }
                ethernet::Action::Event(event) => {
                    black_box(event);
                }
            }
        }
        black_box(machine.deadline().map(|deadline| deadline.at));
    }
}

fn run<M: Machine>(machine: &mut M, frame: impl Fn(&[u8]) -> Option<Frame>) -> ! {
    let mut sent = None;
    loop {
        let now = Instant::from_nanos(black_box(0));
        machine.input(now, next_input(&mut sent, &frame));
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

fn next_input(sent: &mut Option<TxToken>, frame: impl Fn(&[u8]) -> Option<Frame>) -> Input {
    if let Some(token) = sent.take() {
        return Input::TxDone(token, if black_box(true) { TxOutcome::Sent } else { TxOutcome::Dropped });
    }
    if black_box(false) {
        return Input::Link(black_box(LinkEvent::Up));
    }
    let data = black_box([0_u8; 8]);
    match frame(data.get(..black_box(8)).unwrap_or_default()) {
        Some(frame) => Input::Frame(frame),
        None => Input::Tick,
    }
}

fn standard(data: &[u8]) -> Option<Frame> {
    Frame::new(Id::Standard(StandardId::new(black_box(0)).unwrap_or(StandardId::MAX)), data)
}
