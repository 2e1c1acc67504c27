//! What is done to the network from outside.

use link_core::{Instant, LinkEvent, Mode};

use super::{Network, NodeId, OwnedChange, Pending};
use crate::change::{Change, ChangeKind};
use crate::record::Interest;

impl<E: 'static> Network<E> {
    pub(super) fn change_next(&mut self) {
        let Some((_, change)) = self.changes.pop_first() else { return };
        self.next_change = self.changes.first_key_value().map_or(Instant::MAX, |((at, _), _)| *at);
        self.apply(change);
        self.serve_nodes();
    }

    /// Does something now.
    pub fn apply(&mut self, change: Change<E>) {
        let now = self.now;
        match change {
            Change::Cut(node) => {
                if self.exists(node) && std::mem::replace(&mut self.nodes[node.index()].plugged, false) {
                    self.note_change(ChangeKind::Cut(node));
                    self.bus.detach(now, node.index());
                }
            }
            Change::Plug(node) => {
                if self.exists(node) && !std::mem::replace(&mut self.nodes[node.index()].plugged, true) {
                    self.note_change(ChangeKind::Plug(node));
                    if self.nodes[node.index()].powered {
                        self.bus.attach(now, node.index());
                    }
                }
            }
            Change::PowerOff(node) => self.power_off(node),
            Change::PowerOn(node) => self.power_on(node),
            Change::PowerCycle(node) => {
                self.power_off(node);
                self.power_on(node);
            }
            Change::SetBitRate(node, bit_rate) => self.change_mode(node, |mode| mode.bit_rate = bit_rate),
            Change::SetListenOnly(node, on) => self.change_mode(node, |mode| mode.listen_only = on),
            Change::SetClock(node, ppm) => {
                if self.exists(node) {
                    self.note_change(ChangeKind::Clock(node, ppm));
                    self.nodes[node.index()].clock.set(now, ppm);
                    self.bus.set_clock(now, node.index(), ppm);
                    if self.nodes[node.index()].runs() {
                        self.drain(node.index());
                    }
                }
            }
            Change::SetReaction(node, reaction) => {
                if self.exists(node) {
                    self.note_change(ChangeKind::Reaction(node, reaction));
                    self.nodes[node.index()].reaction = reaction;
                }
            }
            Change::FaultOn(id, fault) => {
                self.note_change(ChangeKind::FaultOn(id, fault));
                self.bus.fault_on(now, id, fault);
            }
            Change::FaultOff(id) => {
                self.note_change(ChangeKind::FaultOff(id));
                self.bus.fault_off(id);
            }
            Change::Split(apart) => {
                self.bus.split(now, &apart);
                self.pend_change(OwnedChange::Split(apart));
            }
            Change::Join => {
                self.note_change(ChangeKind::Join);
                self.bus.join(now);
                if let Some(producers) = &mut self.producers {
                    producers.join();
                }
            }
            Change::Call(call) => call(self),
        }
    }

    pub(super) fn power_on(&mut self, node: NodeId) {
        if !self.exists(node) || std::mem::replace(&mut self.nodes[node.index()].powered, true) {
            return;
        }
        self.note_change(ChangeKind::PowerOn(node));
        let index = node.index();
        if !self.nodes[index].own_power {
            self.nodes[index].slot.power_up();
        }
        self.bus.reset_mode(index);
        if self.nodes[index].plugged {
            self.bus.attach(self.now, index);
        } else {
            self.drain(index);
        }
    }

    pub(super) fn power_off(&mut self, node: NodeId) {
        if !self.exists(node) || !std::mem::replace(&mut self.nodes[node.index()].powered, false) {
            return;
        }
        self.note_change(ChangeKind::PowerOff(node));
        if self.nodes[node.index()].own_power {
            self.bus.detach(self.now, node.index());
        } else {
            self.bus.power_off(self.now, node.index());
            self.timeline.set(node.index(), Instant::MAX);
        }
        if let Some(producers) = &mut self.producers {
            producers.forget(node);
        }
    }

    pub(super) fn change_mode(&mut self, node: NodeId, change: impl Fn(&mut Mode)) {
        if !self.exists(node) {
            return;
        }
        let mut mode = self.bus.mode(node.index());
        change(&mut mode);
        if matches!(self.set_mode(node.index(), mode), LinkEvent::ModeSet(_)) {
            self.bus.turn_switch(node.index(), change);
        }
    }

    pub(super) fn exists(&self, node: NodeId) -> bool {
        node.index() < self.nodes.len()
    }

    pub(super) fn note_change(&mut self, change: ChangeKind<'static>) {
        self.pend_change(OwnedChange::Plain(change));
    }

    pub(super) fn pend_change(&mut self, change: OwnedChange) {
        if self.interest.contains(Interest::CHANGES) {
            self.pending.push(Pending::Change { at: self.now, change });
        }
    }
}
