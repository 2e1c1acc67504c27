//! What follows from a bit, for the mailboxes, the node and the record.

use link_core::{Frame, Input, Instant, LinkEvent, TxOutcome, TxToken};

use super::attempt::{BusError, SenderOutcome};
use super::counters::ErrorState;
use super::phase::Effect;
use super::{Bus, Note};
use crate::NodeId;

impl Bus {
    /// Everything that waits will never be sent.
    pub(super) fn drop_all(&mut self, node: usize) {
        while let Some(mail) = self.stations[node].queue.pop() {
            self.done(node, mail.token, TxOutcome::Dropped);
        }
        self.forget_if_empty(node);
    }

    pub(super) fn forget_if_empty(&mut self, node: usize) {
        let station = &self.stations[node];
        if station.queue.is_empty() {
            self.segments[station.segment].waiting.retain(|&other| other != node);
        }
    }

    pub(super) fn done(&mut self, node: usize, token: TxToken, outcome: TxOutcome) {
        self.outbox.push((node, Input::TxDone(token, outcome)));
    }

    pub(super) fn tell(&mut self, node: usize, event: LinkEvent) {
        self.outbox.push((node, Input::Link(event)));
    }

    /// Hands a frame to a node that wants it.
    pub(super) fn deliver(&mut self, node: usize, frame: &Frame) {
        if self.faults.overruns(node, frame) {
            self.tell(node, LinkEvent::Overrun { lost: 1 });
        } else {
            self.outbox.push((node, Input::Frame(*frame)));
        }
    }

    /// What a station made of a bit that ended at `now` and began at `began`.
    pub(super) fn carry_out(
        &mut self,
        segment: usize,
        node: usize,
        effect: Effect,
        began: Instant,
        now: Instant,
    ) {
        match effect {
            Effect::None => {}
            Effect::StartOfFrame { may_join } => {
                let station = &mut self.stations[node];
                if may_join && let Some(frame) = station.queue.send(began) {
                    station.engine.join(&frame);
                    self.attempt_sender(segment, node, frame, began);
                }
            }
            Effect::Received(frame) => {
                self.segments[segment].attempt.received(node);
                if self.acceptance.accepts(node, &frame) {
                    self.deliver(node, &frame);
                }
            }
            Effect::Sent => {
                if let Some(mail) = self.stations[node].queue.take_sent() {
                    self.done(node, mail.token, TxOutcome::Sent);
                }
                self.segments[segment].attempt.outcome(node, SenderOutcome::Sent, now);
                self.forget_if_empty(node);
            }
            Effect::LostArbitration { bit } => {
                self.segments[segment].attempt.outcome(node, SenderOutcome::LostArbitration { bit }, now);
                self.gave_up(node);
            }
            Effect::Error(detected) => {
                let error = BusError {
                    at: now,
                    segment,
                    node: NodeId::new(node),
                    kind: detected.kind,
                    place: detected.place,
                    sender: detected.sender,
                    flag: detected.flag,
                };
                self.segments[segment].attempt.failed(&error);
                self.notes.push(Note::Error(error));
                self.tell(node, LinkEvent::BusError(detected.kind));
                self.gave_up(node);
            }
            Effect::Joined => self.joined(node),
        }
    }

    pub(super) fn joined(&mut self, node: usize) {
        let station = &mut self.stations[node];
        station.bus_off = false;
        if std::mem::take(&mut station.announce) {
            self.tell(node, LinkEvent::Up);
        }
    }

    /// The attempt of a sender has failed: it tries again, unless the frame was withdrawn.
    pub(super) fn gave_up(&mut self, node: usize) {
        if let Some(mail) = self.stations[node].queue.give_up() {
            self.done(node, mail.token, TxOutcome::Withdrawn);
            self.forget_if_empty(node);
        }
    }

    /// Tells the trace that the counters of a node have changed, and the node if that means anything: the counters
    /// first, and then what they mean.
    pub(super) fn report_counters(&mut self, node: usize, now: Instant) {
        let station = &mut self.stations[node];
        let (before, counters) = (station.known, station.engine.counters);
        if before == counters {
            return;
        }
        self.note_counters(now, node);
        let state = match (before.state(), counters.state()) {
            (ErrorState::Active, ErrorState::Passive) => Some(LinkEvent::ErrorPassive),
            (ErrorState::Passive, ErrorState::Active) => Some(LinkEvent::ErrorActive),
            (_, ErrorState::BusOff) => Some(LinkEvent::BusOff),
            (ErrorState::Active, ErrorState::Active)
            | (ErrorState::Passive, ErrorState::Passive)
            | (ErrorState::BusOff, ErrorState::Active | ErrorState::Passive) => None,
        };
        let left = state == Some(LinkEvent::BusOff);
        let warning = counters.warning() && !before.warning() && !left;
        if state.is_some() || warning {
            self.tell(node, LinkEvent::Counters { tec: counters.tec, rec: counters.rec });
        }
        if warning {
            self.tell(node, LinkEvent::ErrorWarning);
        }
        if let Some(state) = state {
            self.tell(node, state);
        }
        if left {
            self.stations[node].bus_off = true;
            self.drop_all(node);
        }
    }

    pub(super) fn note_counters(&mut self, at: Instant, node: usize) {
        let station = &mut self.stations[node];
        let counters = station.engine.counters;
        if station.known != counters {
            station.known = counters;
            self.notes.push(Note::Counters { at, node: NodeId::new(node), counters });
        }
    }
}
