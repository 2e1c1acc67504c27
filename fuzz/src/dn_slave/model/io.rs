//! What I/O connections consume and produce.

use core::time::Duration;

use devicenet_core::slave::{IoMode, Options};
use link_core::Instant;

use super::Model;
use super::connections::{CHANGE, Kind, POLLED, STROBED, State};
use crate::fragment::reference::{Io, io_fields};

/// The sending side of an I/O connection.
#[derive(Clone, Debug, Default)]
pub(in crate::dn_slave) struct Line {
    /// A message is to be sent.
    pub(super) due: bool,
    /// What is left of the message in progress.
    pub(super) fields: Vec<Vec<u8>>,
    /// A frame is with the controller; whether it still matters.
    pub(super) in_flight: Option<bool>,
    /// A withdrawal is owed.
    pub(in crate::dn_slave) withdraw: bool,
}

impl Line {
    /// A frame is to be handed out.
    pub(in crate::dn_slave) fn is_ready(&self) -> bool {
        self.in_flight.is_none() && (self.due || !self.fields.is_empty())
    }

    pub(super) fn stop(&mut self, dropped: bool) {
        self.due = false;
        self.fields.clear();
        if let Some(matters) = &mut self.in_flight
            && core::mem::take(matters)
        {
            self.withdraw = !dropped;
        }
    }
}

impl Model {
    pub(super) fn set_mode(&mut self, at: usize, mode: IoMode) {
        if self.modes[at] != mode && matches!(mode, IoMode::Idle | IoMode::Fault) {
            self.outputs[at].fill(0);
        }
        self.modes[at] = mode;
    }

    pub(super) fn stop_line(&mut self, at: usize) {
        self.lines[at].stop(false);
    }

    /// What has arrived of a message is dropped.
    pub(super) fn forget_message(&mut self, at: usize) {
        self.receivers[at].discard();
    }

    /// Poll, multicast poll, or the master's change of state or cyclic message.
    pub(super) fn command(&mut self, at: usize, field: &[u8]) {
        if self.io[at].state != State::Established {
            return;
        }
        let size = self.outputs[at].len();
        let message = if size > 8 {
            match self.receivers[at].frame(field) {
                Io::Complete(message) => message,
                Io::Stored | Io::TooLong | Io::Discarded => return,
            }
        } else {
            field.to_vec()
        };
        let shorter = self.options.contains(Options::ACCEPT_SHORTER_IO);
        match message.len() {
            0 if size > 0 => self.set_mode(at, IoMode::Idle),
            len if len == size || (shorter && len < size) => {
                self.outputs[at][..len].copy_from_slice(&message);
                self.set_mode(at, IoMode::Run);
            }
            _ => return,
        }
        self.alive(at);
        if self.kinds[at] != Kind::ConsumeOnly {
            self.lines[at].due = true;
        }
    }

    pub(super) fn strobe(&mut self, field: &[u8]) {
        if self.io[STROBED].state != State::Established {
            return;
        }
        match *field {
            [] => self.set_mode(STROBED, IoMode::Idle),
            [_, _, _, _, _, _, _, _] => {
                self.outputs[STROBED][0] = field[usize::from(self.mac / 8)] >> (self.mac % 8) & 1;
                self.set_mode(STROBED, IoMode::Run);
            }
            _ => return,
        }
        self.alive(STROBED);
        self.lines[STROBED].due = true;
    }

    pub(super) fn change_acknowledged(&mut self) {
        if self.io[CHANGE].state == State::Established && self.is_acknowledged() {
            (self.acknowledge, self.retries) = (None, 0);
            self.alive(CHANGE);
        }
    }

    fn alive(&mut self, at: usize) {
        let now = self.now;
        self.io[at].restart(now, 0);
    }

    pub(super) fn is_acknowledged(&self) -> bool {
        matches!(
            self.kinds[CHANGE],
            Kind::Change { acknowledged: true } | Kind::Cyclic { acknowledged: true }
        )
    }

    /// The application has other inputs.
    pub(in crate::dn_slave) fn inputs_changed(&mut self) {
        if self.io[CHANGE].state != State::Established || !matches!(self.kinds[CHANGE], Kind::Change { .. }) {
            return;
        }
        if self.inhibit.is_some() || self.lines[CHANGE].in_flight.is_some() {
            self.pending = true;
        } else {
            self.produce_change();
        }
    }

    /// A new message of instance 4: it replaces one that waits for its acknowledge.
    pub(super) fn produce_change(&mut self) {
        (self.pending, self.retries, self.acknowledge) = (false, 0, None);
        self.lines[CHANGE].due = true;
    }

    pub(super) fn start_trigger(&mut self) {
        self.trigger = after(self.now, self.io[CHANGE].rate);
    }

    /// Judges a frame of an I/O line.
    pub(super) fn produce(&mut self, at: usize, field: &[u8]) {
        let acknowledges_only = at == POLLED && self.held & super::POLL == 0;
        let line = &mut self.lines[at];
        assert!(line.is_ready(), "{field:02X?} of instance {}: nothing is to be sent", at + 2);
        if line.fields.is_empty() {
            line.due = false;
            line.fields = if acknowledges_only {
                vec![Vec::new()]
            } else if self.inputs[at].len() > 8 {
                io_fields(&self.inputs[at], false)
            } else {
                vec![self.inputs[at].clone()]
            };
        }
        line.in_flight = Some(true);
        assert_eq!(field, line.fields.remove(0), "what instance {} produces", at + 2);
        assert!(self.master.is_some(), "data for nobody");
    }

    /// A frame of an I/O line is with the controller no longer.
    pub(super) fn produced(&mut self, at: usize, sent: bool) {
        let line = &mut self.lines[at];
        line.withdraw = false;
        if line.in_flight.take() != Some(true) {
            return;
        }
        if sent && !line.fields.is_empty() {
            return;
        }
        line.fields.clear();
        if at != CHANGE || self.io[CHANGE].state != State::Established {
            return;
        }
        if self.retries == 0 {
            self.start_trigger();
            self.inhibit = after(self.now, self.io[CHANGE].inhibit);
        }
        if self.is_acknowledged() {
            self.acknowledge = after(self.now, self.acknowledge_time);
        }
        if self.pending && self.inhibit.is_none() {
            self.produce_change();
        }
    }
}

fn after(now: Instant, millis: u16) -> Option<Instant> {
    (millis != 0).then(|| now + Duration::from_millis(millis.into()))
}
