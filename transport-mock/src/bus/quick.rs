//! The cheap path: a frame that nothing can go wrong with takes two steps, its beginning and its end.

use link_core::wire::{INTERMISSION_BITS, bits};
use link_core::{Frame, Instant, TxOutcome};

use super::attempt::{Sender, SenderOutcome};
use super::counters::ErrorState;
use super::engine::{JOINING_RUN, SUSPEND_BITS};
use super::phase::Phase;
use super::segment::Activity;
use super::{Bus, after, span};
use crate::NodeId;
use crate::record::Interest;

impl Bus {
    /// Who wins arbitration among those that begin at `at`, and whether its first place is its own.
    pub(super) fn contest(&self, index: usize, at: Instant) -> Option<(usize, Frame, bool)> {
        let mut best: Option<(u32, usize, &Frame)> = None;
        let mut unique = true;
        for &node in &self.segments[index].waiting {
            let station = &self.stations[node];
            if station.suspend_until > at || !station.has_joined() {
                continue;
            }
            let Some(mail) = station.queue.head(at) else { continue };
            match best {
                Some((key, ..)) if mail.key > key => {}
                Some((key, ..)) if mail.key == key => unique = false,
                Some(_) | None => {
                    best = Some((mail.key, node, &mail.frame));
                    unique = true;
                }
            }
        }
        best.map(|(_, node, frame)| (node, *frame, unique))
    }

    /// The end of a frame on the cheap path.
    pub(super) fn finish_quick(&mut self, index: usize) {
        let Activity::Quick { start, end, bit, sender, frame } = self.segments[index].activity else {
            return;
        };
        if self.interest.contains(Interest::LOSERS) {
            self.record_contenders(index, start, sender, &frame);
        } else if !self.interest.is_empty() {
            let attempt = &mut self.segments[index].attempt;
            attempt.senders.push(Sender { node: NodeId::new(sender), frame, outcome: SenderOutcome::Sent });
        }
        let segment = &mut self.segments[index];
        segment.activity = Activity::Quiet;
        segment.last_sender = Some(sender);
        segment.free_at = after(end, u64::from(INTERMISSION_BITS) * bit);
        let attempt = &mut segment.attempt;
        attempt.frame = Some(frame);
        (attempt.sent, attempt.settled) = (true, end);
        if self.interest.contains(Interest::RECEIVERS) {
            attempt.receivers.copy_from(&segment.joined);
            attempt.receivers.remove(sender);
        }

        self.stations[sender].queue.send(start);
        let token = self.stations[sender].queue.take_sent().map(|mail| mail.token);
        if self.stations[sender].queue.is_empty() {
            self.segments[index].waiting.retain(|&node| node != sender);
        }
        // Out of the way while the stations are told.
        let acceptance = std::mem::replace(&mut self.acceptance, super::Acceptance::new());
        let joined = std::mem::take(&mut self.segments[index].joined);
        acceptance.for_each(&frame, &joined, sender, |node| {
            if node != sender {
                self.deliver(node, &frame);
            } else if let Some(token) = token {
                self.done(sender, token, TxOutcome::Sent);
            }
        });
        self.acceptance = acceptance;
        self.segments[index].joined = joined;
        self.close_attempt(index, end);
        self.settle_counters(index, sender, bit, end);
        self.break_joining(index, start, end, bit);
        self.plan(index);
    }

    /// The counters after a frame that all have received.
    fn settle_counters(&mut self, index: usize, sender: usize, bit: u64, end: Instant) {
        // In the order of the nodes, as on the exact path.
        let mut blamed = std::mem::take(&mut self.segments[index].blamed);
        let mut before = true;
        blamed.retain(|&node| {
            if before && node >= sender {
                before = false;
                self.settle_sender(sender, bit, end);
            }
            let station = &mut self.stations[node];
            if node != sender && station.has_joined() && !station.mode.listen_only {
                station.engine.counters.received();
                self.report_counters(node, end);
            }
            self.stations[node].engine.counters.rec > 0
        });
        self.segments[index].blamed = blamed;
        if before {
            self.settle_sender(sender, bit, end);
        }
    }

    fn settle_sender(&mut self, sender: usize, bit: u64, end: Instant) {
        let station = &mut self.stations[sender];
        station.engine.counters.sent();
        if station.engine.counters.state() == ErrorState::Passive {
            let bits = INTERMISSION_BITS + u32::from(SUSPEND_BITS);
            station.suspend_until = after(end, u64::from(bits) * bit);
        }
        self.report_counters(sender, end);
    }

    /// A frame interrupts the recessive run that joining stations count.
    fn break_joining(&mut self, index: usize, start: Instant, end: Instant, bit: u64) {
        // ACK delimiter and end of frame are eight recessive bits, and the intermission follows.
        let recessive_since = Instant::from_nanos(end.as_nanos().saturating_sub(8 * bit));
        for &node in &self.segments[index].joining {
            let station = &mut self.stations[node];
            let Phase::Joining { left, .. } = station.engine.phase else { continue };
            let sequences = span(station.heard_from, start) / (u64::from(JOINING_RUN) * station.bit());
            let left = left - u16::try_from(sequences).unwrap_or(u16::MAX).min(left);
            station.engine.phase = Phase::Joining { left: left.max(1), run: 0 };
            station.heard_from = station.heard_from.max(recessive_since);
        }
    }

    /// Who began together with the winner of a frame on the cheap path, and in which bit they lost.
    fn record_contenders(&mut self, index: usize, start: Instant, winner: usize, frame: &Frame) {
        let segment = &mut self.segments[index];
        for &node in &segment.waiting {
            let station = &self.stations[node];
            if station.suspend_until > start || !station.has_joined() {
                continue;
            }
            let Some(mail) = station.queue.head(start) else { continue };
            let outcome = if node == winner {
                SenderOutcome::Sent
            } else {
                SenderOutcome::LostArbitration { bit: first_difference(&mail.frame, frame) }
            };
            segment.attempt.senders.push(Sender { node: NodeId::new(node), frame: mail.frame, outcome });
        }
        segment.attempt.senders.sort_unstable_by_key(|sender| sender.node);
    }
}

/// The first bit in which two frames differ.
fn first_difference(one: &Frame, other: &Frame) -> u32 {
    let equal =
        bits(one).zip(bits(other)).take_while(|(one, other)| one.recessive == other.recessive).count();
    u32::try_from(equal).unwrap_or(u32::MAX)
}
