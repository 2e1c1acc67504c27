//! The device under test on its host, whose clock may be set back, and which may come late to look at it.

use core::time::Duration;

use devicenet_core::slave::{Application, Event, Slave};
use link_core::{Action, Deadline, Input, Instant, Machine};

use crate::device::Data;

/// A slave, whatever its application is.
pub(crate) trait Device: Machine<Event = Event> {
    fn set_inputs(&mut self, now: Instant, inputs: &[u8]);
    /// Of poll.
    fn outputs(&self) -> &[u8];
    /// What the network status indicator shows.
    fn lamp(&self) -> String;
    /// Events that were lost, and answers to transmissions that nobody had asked for.
    fn lost(&self) -> (u16, u16);
    fn boxed(&self) -> Box<dyn Device>;
}

impl<A: Application + Data + Clone + 'static, const DYNAMIC: usize> Device for Slave<A, 64, DYNAMIC> {
    fn set_inputs(&mut self, now: Instant, inputs: &[u8]) {
        self.application_mut().set_inputs(inputs);
        self.inputs_changed(now);
    }

    fn outputs(&self) -> &[u8] {
        self.application().outputs()
    }

    fn lamp(&self) -> String {
        self.network_status().to_string()
    }

    fn lost(&self) -> (u16, u16) {
        let counters = self.counters();
        (counters.events_lost, counters.stray_tx_done)
    }

    fn boxed(&self) -> Box<dyn Device> {
        Box::new(self.clone())
    }
}

pub(crate) struct Host {
    pub(crate) device: Box<dyn Device>,
    /// How far its clock was set back.
    pub(crate) behind: Duration,
    /// It looks at frames, and not at deadlines.
    pub(crate) late: bool,
}

impl Host {
    pub(crate) fn new(device: impl Device + 'static) -> Self {
        Self { device: Box::new(device), behind: Duration::ZERO, late: false }
    }

    /// What its clock shows.
    fn local(&self, now: Instant) -> Instant {
        now.saturating_sub(self.behind)
    }

    pub(crate) fn set_inputs(&mut self, now: Instant, inputs: &[u8]) {
        let now = self.local(now);
        self.device.set_inputs(now, inputs);
    }
}

impl Clone for Host {
    fn clone(&self) -> Self {
        Self { device: self.device.boxed(), behind: self.behind, late: self.late }
    }
}

impl Machine for Host {
    type Event = Event;

    fn input(&mut self, now: Instant, input: Input) {
        let now = self.local(now);
        self.device.input(now, input);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<Event>> {
        let now = self.local(now);
        self.device.poll(now)
    }

    fn deadline(&self) -> Option<Deadline> {
        let deadline = self.device.deadline().filter(|_| !self.late)?;
        Some(Deadline { at: deadline.at + self.behind, ..deadline })
    }

    fn max_in_flight(&self) -> usize {
        self.device.max_in_flight()
    }
}
