//! The loop: what comes next, and what the machines make of it.

use link_core::{Action, Frame, Input, Instant, LinkCommand, LinkEvent, Mode, TxToken};

use super::{Network, NodeId, Pending};
use crate::bus::{ErrorState, after};
use crate::change::{ChangeKind, Reaction};
use crate::record::Interest;
use crate::referee;

impl<E: 'static> Network<E> {
    /// Does the next thing, if it is due by `end`.
    pub(super) fn step(&mut self, end: Instant) -> bool {
        let deadline = self.timeline.earliest();
        let others = deadline.min(self.next_change);
        if let Some(next) = self.bus.next() {
            let first = if next.begins {
                next.at < others && next.at < end
            } else {
                next.at <= others && next.at <= end
            };
            if first {
                self.now = self.bus.advance(next, others.min(end));
                return true;
            }
        }
        if others > end || others == Instant::MAX {
            return false;
        }
        self.now = self.now.max(others);
        if self.next_change <= deadline {
            self.change_next();
        } else {
            let node = self.timeline.first();
            self.feed(node, Input::Tick);
        }
        true
    }

    /// Hands what the bus has to tell to the nodes, until nothing is left.
    pub(super) fn serve_nodes(&mut self) {
        let mut index = 0;
        // Answers to commands come behind what is there already.
        while let Some(&(node, input)) = self.bus.outbox.get(index) {
            index += 1;
            self.feed(node, input);
        }
        self.bus.outbox.clear();
    }

    pub(super) fn feed(&mut self, index: usize, input: Input) {
        let node = &mut self.nodes[index];
        if !node.runs() {
            return;
        }
        if self.interest.contains(Interest::REQUESTS)
            && let Input::TxDone(token, outcome) = input
        {
            let (at, node) = (self.now, NodeId::new(index));
            self.pending.push(Pending::Done { at, node, token, outcome });
        }
        let local = node.clock.local(self.now);
        node.slot.input(local, input);
        self.drain(index);
    }

    /// Carries out what a machine wants, and notes when it must be called next.
    pub(super) fn drain(&mut self, index: usize) {
        let node = &mut self.nodes[index];
        let local = node.clock.local(self.now);
        if node.last_call != self.now {
            node.last_call = self.now;
            node.calls = 0;
        }
        while let Some(action) = self.nodes[index].slot.poll(local) {
            self.carry_out(index, action);
            if self.called_too_often(index, "its output never ends") {
                return;
            }
        }
        let node = &self.nodes[index];
        let deadline = node.slot.deadline();
        let at = deadline.map_or(Instant::MAX, |deadline| node.clock.network(deadline.at).max(self.now));
        if let Some(deadline) = deadline
            && at == self.now
            && self.called_too_often(index, deadline.why)
        {
            return;
        }
        self.timeline.set(index, at);
    }

    /// Counts the calls of a machine at one moment. After too many, it is left alone for a while.
    pub(super) fn called_too_often(&mut self, index: usize, why: &'static str) -> bool {
        let node = &mut self.nodes[index];
        node.calls += 1;
        if node.calls <= MOST_CALLS {
            return false;
        }
        self.timeline.set(index, after(self.now, STUCK_PAUSE));
        self.violation(index, referee::STUCK, || why.to_owned());
        true
    }

    pub(super) fn carry_out(&mut self, index: usize, action: Action<E>) {
        match action {
            Action::Transmit(token, frame) => self.transmit(index, token, frame),
            Action::Withdraw(token) => self.bus.withdraw(self.now, index, token),
            Action::Link(command) => self.command_link(index, command),
            Action::Event(event) => {
                if self.interest.contains(Interest::EVENTS) {
                    self.pending.push(Pending::Event { at: self.now, node: NodeId::new(index), event });
                }
            }
        }
    }

    pub(super) fn transmit(&mut self, index: usize, token: TxToken, frame: Frame) {
        if self.interest.contains(Interest::REQUESTS) {
            let (at, node) = (self.now, NodeId::new(index));
            self.pending.push(Pending::Request { at, node, token, frame });
        }
        if self.bus.in_flight(index) >= self.nodes[index].max_in_flight {
            let most = self.nodes[index].max_in_flight;
            self.violation(index, referee::IN_FLIGHT, || format!("{frame} when {most} are in flight"));
        }
        if self.bus.has_token(index, token) {
            self.violation(index, referee::TOKEN_REUSED, || format!("token {}: {frame}", token.0));
        }
        match self.bus.error_state(index) {
            None => self.violation(index, referee::LINK_DOWN, || frame.to_string()),
            Some(ErrorState::BusOff) => self.violation(index, referee::BUS_OFF, || frame.to_string()),
            Some(ErrorState::Active | ErrorState::Passive) if self.bus.mode(index).listen_only => {
                self.violation(index, referee::LISTEN_ONLY, || frame.to_string());
            }
            Some(ErrorState::Active | ErrorState::Passive) => {}
        }
        let node = &mut self.nodes[index];
        let ready = match node.reaction {
            Reaction::Immediate => self.now,
            Reaction::Fixed(delay) => self.now + delay,
            Reaction::Uniform(least, most) => {
                let range = u64::try_from(most.saturating_sub(least).as_nanos()).unwrap_or(u64::MAX);
                after(self.now + least, node.rng.below(range.saturating_add(1)))
            }
        };
        self.bus.request(index, token, frame, ready);
    }

    pub(super) fn command_link(&mut self, index: usize, command: LinkCommand) {
        let answer = match command {
            LinkCommand::SetMode(mode) => Some(self.set_mode(index, mode)),
            LinkCommand::SetFilter(filter) => {
                self.bus.set_filter(index, filter);
                Some(LinkEvent::FilterSet)
            }
            LinkCommand::Reset => self.bus.reset(self.now, index).err().map(LinkEvent::Refused),
        };
        if let Some(event) = answer {
            self.bus.outbox.push((index, Input::Link(event)));
        }
    }

    pub(super) fn set_mode(&mut self, index: usize, mode: Mode) -> LinkEvent {
        if let Err(kind) = self.bus.set_mode(self.now, index, mode) {
            return LinkEvent::Refused(kind);
        }
        self.note_change(ChangeKind::Mode(NodeId::new(index), mode));
        LinkEvent::ModeSet(mode)
    }
}

/// Calls of one machine at one moment before it counts as stuck. A master that talks to 63 slaves at once makes a few
/// hundred.
const MOST_CALLS: u32 = 10_000;
/// How long a stuck machine is left alone, in nanoseconds.
const STUCK_PAUSE: u64 = 1_000_000;
