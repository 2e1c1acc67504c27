//! A slave, with the tester as the rest of the bus.

use core::time::Duration;
use std::collections::VecDeque;

use devicenet_core::slave::{Application, Config, Slave};
use link_core::frame::standard_id;
use link_core::{Action, Frame, Input, Instant, LinkEvent, Machine, TxOutcome, TxToken};

use crate::device::Data;

pub(crate) struct Bench<A: Application, const DYNAMIC: usize> {
    pub(crate) slave: Slave<A, 64, DYNAMIC>,
    pub(crate) now: Instant,
    /// Every frame is acknowledged at once.
    pub(crate) acknowledging: bool,
    in_flight: VecDeque<TxToken>,
    /// What was sent, and when.
    pub(crate) sent: VecDeque<(Instant, Frame)>,
    pub(crate) told: Vec<String>,
}

/// The same, whatever it is a bench of.
pub(crate) trait Tester {
    fn hears(&mut self, frame: Frame);
    fn link(&mut self, event: LinkEvent);
    /// Lets time pass, with a tick at each deadline on the way.
    fn wait(&mut self, millis: u64);
    /// Lets time pass, and nobody calls the slave before its end.
    fn sleep(&mut self, millis: u64);
    /// Lets time pass, and nobody calls the slave.
    fn step(&mut self, millis: u64);
    fn step_back(&mut self, millis: u64);
    fn acknowledge(&mut self, on: bool);
    fn done(&mut self, outcome: TxOutcome);
    fn set_inputs(&mut self, inputs: &[u8]);
    fn outputs(&self) -> &[u8];
    fn indicator(&self) -> String;
    fn take_sent(&mut self) -> Option<Frame>;
    fn take_told(&mut self) -> Vec<String>;
    fn now(&self) -> Instant;
    fn lost(&self) -> (u16, u16);
}

impl<A: Application, const DYNAMIC: usize> Bench<A, DYNAMIC> {
    pub(crate) fn new(config: Config, application: A) -> Self {
        Self {
            slave: Slave::new(config, application).expect("the sizes are valid"),
            now: Instant::ZERO,
            acknowledging: true,
            in_flight: VecDeque::new(),
            sent: VecDeque::new(),
            told: Vec::new(),
        }
    }

    pub(crate) fn input(&mut self, input: Input) {
        self.slave.input(self.now, input);
        self.drain();
    }

    pub(crate) fn run_until(&mut self, until: Instant) {
        while let Some(deadline) = self.slave.deadline().filter(|deadline| deadline.at <= until) {
            self.now = self.now.max(deadline.at);
            self.input(Input::Tick);
        }
        self.now = self.now.max(until);
    }

    fn drain(&mut self) {
        while let Some(action) = self.slave.poll(self.now) {
            match action {
                Action::Transmit(token, frame) => {
                    assert!(!self.in_flight.contains(&token), "{frame}: two in flight in one conversation");
                    self.in_flight.push_back(token);
                    assert!(self.in_flight.len() <= self.slave.max_in_flight());
                    self.sent.push_back((self.now, frame));
                    if self.acknowledging {
                        self.finish(TxOutcome::Sent);
                    }
                }
                Action::Event(event) => self.told.push(event.to_string()),
                Action::Withdraw(_) => self.told.push("withdrawn".to_owned()),
                Action::Link(_) => {}
            }
        }
    }

    fn finish(&mut self, outcome: TxOutcome) {
        let token = self.in_flight.pop_front().expect("nothing is in flight");
        self.slave.input(self.now, Input::TxDone(token, outcome));
        self.drain();
    }
}

impl<A: Application + Data, const DYNAMIC: usize> Tester for Bench<A, DYNAMIC> {
    fn hears(&mut self, frame: Frame) {
        self.input(Input::Frame(frame));
    }

    fn link(&mut self, event: LinkEvent) {
        self.input(Input::Link(event));
    }

    fn wait(&mut self, millis: u64) {
        self.run_until(self.now + Duration::from_millis(millis));
    }

    fn sleep(&mut self, millis: u64) {
        self.step(millis);
        self.input(Input::Tick);
    }

    fn step(&mut self, millis: u64) {
        self.now += Duration::from_millis(millis);
    }

    fn step_back(&mut self, millis: u64) {
        self.now = self.now.saturating_sub(Duration::from_millis(millis));
    }

    fn acknowledge(&mut self, on: bool) {
        self.acknowledging = on;
    }

    fn done(&mut self, outcome: TxOutcome) {
        self.finish(outcome);
    }

    fn set_inputs(&mut self, inputs: &[u8]) {
        self.slave.application_mut().set_inputs(inputs);
        self.slave.inputs_changed(self.now);
        self.drain();
    }

    fn outputs(&self) -> &[u8] {
        self.slave.application().outputs()
    }

    fn indicator(&self) -> String {
        self.slave.network_status().to_string()
    }

    fn take_sent(&mut self) -> Option<Frame> {
        self.sent.pop_front().map(|(_, frame)| frame)
    }

    fn take_told(&mut self) -> Vec<String> {
        core::mem::take(&mut self.told)
    }

    fn now(&self) -> Instant {
        self.now
    }

    fn lost(&self) -> (u16, u16) {
        let counters = self.slave.counters();
        (counters.events_lost, counters.stray_tx_done)
    }
}

/// A frame written as `5FF: 00 E7 03`.
#[track_caller]
pub(crate) fn frame(text: &str) -> Frame {
    let (id, data) = text.split_once(':').unwrap_or_else(|| panic!("no frame: {text}"));
    let id = u16::from_str_radix(id.trim(), 16).unwrap_or_else(|_| panic!("no identifier: {text}"));
    Frame::new(standard_id(id), &bytes(data)).unwrap_or_else(|| panic!("more than eight bytes: {text}"))
}

/// Bytes in hexadecimal.
#[track_caller]
pub(crate) fn bytes(text: &str) -> Vec<u8> {
    let byte = |byte| u8::from_str_radix(byte, 16).unwrap_or_else(|_| panic!("no bytes: {text}"));
    text.split_whitespace().map(byte).collect()
}
