//! Listening before talking: who is there, and whose.

use std::collections::BTreeMap;

use devicenet_core::MacId;
use devicenet_core::monitor::{Kind, Monitor, MonitorConfig, NodeRecord};
use link_core::machine::Deadline;
use link_core::{Input, Instant, LinkEvent, Port as _};

use super::port::{LivePort, PortError};
use crate::exit::Failure;

/// What was heard.
pub(super) struct Heard {
    monitor: Box<Monitor>,
    /// Frames.
    pub(super) frames: u64,
    /// Errors on the bus.
    pub(super) errors: u64,
    /// Who is polled, strobed, or otherwise sent I/O, and when last.
    polled: BTreeMap<MacId, Instant>,
    is_up: bool,
}

impl Heard {
    pub(super) fn new() -> Self {
        let monitor = Box::new(Monitor::new(MonitorConfig::default()));
        Self { monitor, frames: 0, errors: 0, polled: BTreeMap::new(), is_up: false }
    }

    /// Takes note of an input.
    pub(super) fn note(&mut self, at: Instant, input: Input) {
        match input {
            Input::Frame(frame) => {
                self.frames += 1;
                let reading = self.monitor.observe(at, self.frames, &frame);
                if let (Kind::PollCommand | Kind::CosCyclic, Some(slave)) = (reading.kind, reading.dst) {
                    self.polled.insert(slave, at);
                }
            }
            Input::Link(LinkEvent::BusError(_)) => self.errors += 1,
            Input::Link(LinkEvent::Up) => self.is_up = true,
            Input::Link(LinkEvent::Down) => self.is_up = false,
            Input::Link(_) | Input::TxDone(..) | Input::Tick => {}
        }
    }

    /// Listens until a moment, or for as long as there is something to hear.
    pub(super) fn listen(&mut self, port: &mut LivePort, until: Instant) -> Result<(), Failure> {
        let deadline = Some(Deadline { at: until, why: "listening" }).filter(|_| until < Instant::MAX);
        loop {
            match port.wait(deadline) {
                Ok((_, Input::Tick)) | Err(PortError::Over) => return Ok(()),
                Ok((at, input)) => self.note(at, input),
                Err(PortError::Failed(failure)) => return Err(failure),
            }
        }
    }

    pub(super) const fn is_up(&self) -> bool {
        self.is_up
    }

    pub(super) fn node(&self, mac: MacId) -> Option<NodeRecord> {
        self.monitor.node(mac)
    }

    /// Every node that has sent something, in the order of the MAC IDs.
    pub(super) fn nodes(&self) -> impl Iterator<Item = NodeRecord> {
        self.monitor.nodes().filter(|node| node.first_seen.is_some())
    }

    /// Another master that has the node, or `None` in its place if it is not known who sends it its data.
    pub(super) fn master_of(&self, mac: MacId) -> Option<Option<MacId>> {
        let master = self.node(mac).and_then(|node| node.master);
        if master.is_some() || self.polled.contains_key(&mac) { Some(master) } else { None }
    }
}
