//! Who is on which segment, in which mode: what changes while frames are on the wire.

use link_core::link::LinkCommandKind;
use link_core::{Instant, LinkEvent, Mode};

use super::Bus;
use super::attempt::{Sender, SenderOutcome};
use super::counters::Counters;
use super::engine::RECOVERY_SEQUENCES;
use super::phase::Phase;
use super::segment::{Activity, Segment};
use crate::NodeId;

impl Bus {
    pub(crate) fn set_mode(&mut self, now: Instant, node: usize, mode: Mode) -> Result<(), LinkCommandKind> {
        let possible = mode.bit_rate.bit_time_nanos().is_some_and(|bit| bit > 0);
        if !possible {
            return Err(LinkCommandKind::SetMode);
        }
        self.leave(now, node);
        self.drop_all(node);
        self.stations[node].mode = mode;
        self.rejoin(now, node);
        Ok(())
    }

    /// A switch is turned: it stays where it is when the power goes.
    pub(crate) fn turn_switch(&mut self, node: usize, turn: impl FnOnce(&mut Mode)) {
        turn(&mut self.stations[node].mode_at_power_up);
    }

    /// The mode at power-up.
    pub(crate) fn reset_mode(&mut self, node: usize) {
        self.stations[node].mode = self.stations[node].mode_at_power_up;
        self.acceptance.set(node, self.stations[node].filter_at_power_up.clone());
    }

    /// Another clock. The controller restarts if its bits change; what waits stays in its mailboxes.
    pub(crate) fn set_clock(&mut self, now: Instant, node: usize, ppm: i32) {
        let station = &self.stations[node];
        if station.bit_with(ppm) == station.bit() {
            self.stations[node].clock_ppm = ppm;
            return;
        }
        self.leave(now, node);
        self.gave_up(node);
        self.stations[node].clock_ppm = ppm;
        self.rejoin(now, node);
    }

    /// Restarts a controller. [`LinkEvent::Up`] follows: at once, or after the recovery sequence if it was bus-off.
    pub(crate) fn reset(&mut self, now: Instant, node: usize) -> Result<(), LinkCommandKind> {
        if !self.stations[node].attached {
            return Err(LinkCommandKind::Reset);
        }
        self.leave(now, node);
        self.drop_all(node);
        let station = &mut self.stations[node];
        station.engine.counters = Counters::default();
        if station.bus_off {
            station.announce = true;
            station.engine.enter(Phase::Joining { left: RECOVERY_SEQUENCES, run: 0 });
        } else {
            self.tell(node, LinkEvent::Up);
        }
        self.note_counters(now, node);
        self.rejoin(now, node);
        Ok(())
    }

    /// Power or cable come: the controller starts anew.
    pub(crate) fn attach(&mut self, now: Instant, node: usize) {
        if self.stations[node].attached {
            return;
        }
        let segment = self.stations[node].segment;
        if self.segments[segment].bit != Some(self.stations[node].bit()) {
            // The others are no longer in step with all that hear them.
            self.go_exact(segment, now);
        }
        let station = &mut self.stations[node];
        station.attached = true;
        station.bus_off = false;
        station.announce = false;
        station.engine.counters = Counters::default();
        station.known = Counters::default();
        station.suspend_until = now;
        let segment = &mut self.segments[station.segment];
        if segment.members.is_empty() {
            // Nobody has watched the wire until now.
            let next_bit = Instant::from_nanos(now.as_nanos().next_multiple_of(station.bit()));
            segment.free_at = segment.free_at.max(next_bit);
        }
        let place = segment.members.partition_point(|&member| member < node);
        segment.members.insert(place, node);
        self.tell(node, LinkEvent::Up);
        self.rejoin(now, node);
    }

    /// Power goes: nobody is left to be told anything.
    pub(crate) fn power_off(&mut self, now: Instant, node: usize) {
        self.detach(now, node);
        self.outbox.retain(|&(told, _)| told != node);
    }

    /// The cable goes: the node is told, and frames that waited are answered.
    pub(crate) fn detach(&mut self, now: Instant, node: usize) {
        if !self.stations[node].attached {
            return;
        }
        self.leave(now, node);
        self.tell(node, LinkEvent::Down);
        self.drop_all(node);
        let station = &mut self.stations[node];
        station.attached = false;
        station.bus_off = false;
        station.announce = false;
        station.engine.enter(Phase::Off);
        station.engine.counters = Counters::default();
        self.note_counters(now, node);
        let segment = self.stations[node].segment;
        self.segments[segment].members.retain(|&member| member != node);
        self.survey(segment, now);
    }

    /// Moves nodes to a segment of their own. Whoever is in the middle of a frame goes on with it, on either side.
    pub(crate) fn split(&mut self, now: Instant, apart: &[NodeId]) {
        let fresh = self.segments.len();
        let apart: Vec<usize> =
            apart.iter().map(|node| node.index()).filter(|&node| node < self.stations.len()).collect();
        self.regroup(now, |node, segment| if apart.contains(&node) { fresh } else { segment });
    }

    /// Makes one segment of all.
    pub(crate) fn join(&mut self, now: Instant) {
        self.regroup(now, |_, _| 0);
    }

    /// Puts every station on the segment that `place` says, by the station and its segment of now.
    fn regroup(&mut self, now: Instant, place: impl Fn(usize, usize) -> usize) {
        for segment in 0..self.segments.len() {
            self.go_exact(segment, now);
            self.dissolve(segment);
        }
        let old = std::mem::take(&mut self.segments);
        let mut sleeping = Vec::new();
        for node in 0..self.stations.len() {
            let from = self.stations[node].segment;
            let to = place(node, from);
            while self.segments.len() <= to {
                self.segments.push(Segment::new());
            }
            self.stations[node].segment = to;
            let segment = &mut self.segments[to];
            if !self.stations[node].attached {
                continue;
            }
            segment.members.push(node);
            if old[from].activity == Activity::Quiet {
                sleeping.push(node);
            }
            segment.free_at = segment.free_at.max(old[from].free_at);
            segment.bit = segment.bit.or(old[from].bit);
            if segment.activity == Activity::Quiet && old[from].activity != Activity::Quiet {
                segment.activity = old[from].activity;
                segment.attempt = old[from].attempt.clone();
                segment.attempt.open = false;
            }
            // The attempt goes where a sender is.
            let sends =
                |sender: &Sender| sender.node.index() == node && sender.outcome == SenderOutcome::Abandoned;
            if old[from].attempt.open && old[from].attempt.senders.iter().any(sends) {
                segment.attempt = old[from].attempt.clone();
            }
        }
        // Where others are in the middle of something, everybody is simulated bit by bit.
        for node in sleeping {
            if let Some(bit_start) = self.segments[self.stations[node].segment].activity.bit_start() {
                self.wake(node, bit_start);
            }
        }
        for segment in 0..self.segments.len() {
            self.survey(segment, now);
        }
    }

    /// A station is about to change in a way that the others may see in the middle of a frame.
    pub(super) fn leave(&mut self, now: Instant, node: usize) {
        let segment = self.stations[node].segment;
        self.go_exact(segment, now);
        self.dissolve(segment);
        self.segments[segment].attempt.outcome(node, SenderOutcome::Abandoned, now);
    }

    /// A station begins to listen for a free bus, unless it is off. The recovery from bus-off begins anew.
    pub(super) fn rejoin(&mut self, now: Instant, node: usize) {
        let station = &mut self.stations[node];
        let recovering = station.bus_off && matches!(station.engine.phase, Phase::Joining { .. });
        if station.attached {
            station.engine.enter(match (station.bus_off, recovering) {
                (false, _) => Phase::Joining { left: 1, run: 0 },
                (true, true) => Phase::Joining { left: RECOVERY_SEQUENCES, run: 0 },
                (true, false) => Phase::Off,
            });
        }
        station.engine.listen_only = station.mode.listen_only;
        let bit = station.bit();
        station.heard_from = Instant::from_nanos(now.as_nanos().next_multiple_of(bit));
        station.bit_clock.sample_at = station.heard_from;
        station.bit_clock.ends_at = station.heard_from;
        station.bit_clock.sampled = true;
        let segment = station.segment;
        self.survey(segment, now);
    }
}
