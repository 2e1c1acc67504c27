//! The exact path: every station, bit by bit, all in step.

use link_core::wire::INTERMISSION_BITS;
use link_core::{Frame, Instant};

use super::engine::JOINING_RUN;
use super::phase::{Effect, Phase};
use super::segment::{Activity, Segment};
use super::{Bus, after, span};

impl Bus {
    /// Begins to simulate a segment bit by bit, from the bit that begins at `at`.
    pub(super) fn enter_exact(&mut self, index: usize, at: Instant) {
        for place in 0..self.segments[index].members.len() {
            let node = self.segments[index].members[place];
            self.wake(node, at);
        }
        self.segments[index].activity = if self.segments[index].bit.is_some() {
            Activity::Exact { bit_start: at, begun: false }
        } else {
            Activity::Timed { next: at }
        };
    }

    /// Simulates a segment bit by bit from now on. What was passed over quickly is made up for: a frame from its
    /// beginning, an intermission from the end of the frame.
    pub(super) fn go_exact(&mut self, index: usize, now: Instant) {
        let segment = &self.segments[index];
        match segment.activity {
            Activity::Quick { start, .. } => {
                self.enter_exact(index, start);
                self.spoil(index);
                self.replay_exact(index, now);
            }
            Activity::Quiet if now < segment.free_at => {
                let Some(bit) = segment.bit else { return };
                let (free_at, intermission) = (segment.free_at, u64::from(INTERMISSION_BITS) * bit);
                let sender = segment.last_sender;
                self.enter_exact(index, Instant::from_nanos(free_at.as_nanos() - intermission));
                for place in 0..self.segments[index].members.len() {
                    let node = self.segments[index].members[place];
                    if self.stations[node].has_joined() {
                        self.stations[node].engine.pause(sender == Some(node));
                    }
                }
                self.replay_exact(index, now);
            }
            Activity::Quiet | Activity::Exact { .. } | Activity::Timed { .. } => {}
        }
    }

    /// The bit-level state of a station that slept, for the bit that begins at `at`.
    pub(super) fn wake(&mut self, node: usize, at: Instant) {
        let station = &mut self.stations[node];
        let bit = station.bit();
        let clock = &mut station.bit_clock;
        (clock.sampled, clock.ends_at, clock.level) = (true, at, true);
        match station.engine.phase {
            Phase::Idle => {
                let left = span(at, station.suspend_until).div_ceil(bit);
                if left > 0 {
                    station.engine.phase = Phase::Suspend { left: u8::try_from(left).unwrap_or(u8::MAX) };
                }
            }
            Phase::Joining { left, .. } => {
                let heard = span(station.heard_from, at) / bit;
                let sequences = heard / u64::from(JOINING_RUN);
                let run = u16::try_from(heard % u64::from(JOINING_RUN)).unwrap_or(0);
                let left = left - u16::try_from(sequences).unwrap_or(u16::MAX).min(left - 1);
                station.engine.phase = Phase::Joining { left, run };
            }
            Phase::Off
            | Phase::Frame
            | Phase::Flag { .. }
            | Phase::PassiveFlag { .. }
            | Phase::AfterFlag { .. }
            | Phase::Delimiter { .. }
            | Phase::Intermission { .. }
            | Phase::Suspend { .. } => {}
        }
    }

    /// Runs bits until somebody must be told something, the segment is quiet, or something else comes first.
    pub(super) fn run_exact(&mut self, index: usize, limit: Instant) {
        loop {
            let Activity::Exact { bit_start, begun } = self.segments[index].activity else { return };
            let Some(bit) = self.segments[index].bit else { return };
            if begun {
                self.finish_bits(index, bit_start, bit);
            } else {
                self.begin_bits(index, bit_start, bit);
            }
            let Activity::Exact { bit_start, begun } = self.segments[index].activity else { return };
            let next = if begun { after(bit_start, bit) } else { bit_start };
            let later = next > limit || next == limit && !begun;
            if later || self.has_news() || self.segments.len() > 1 {
                return;
            }
        }
    }

    /// Runs the bits of a frame that was taken for certain, up to now.
    pub(super) fn replay_exact(&mut self, index: usize, now: Instant) {
        while let Activity::Exact { bit_start, begun } = self.segments[index].activity
            && let Some(bit) = self.segments[index].bit
        {
            if !begun && bit_start < now {
                self.begin_bits(index, bit_start, bit);
            } else if begun && after(bit_start, bit) <= now {
                self.finish_bits(index, bit_start, bit);
            } else {
                return;
            }
        }
    }

    fn begin_bits(&mut self, index: usize, at: Instant, bit: u64) {
        if let Some(first) = self.first_to_start(index, at) {
            self.dissolve(index);
            let attempt = &self.segments[index].attempt;
            if !attempt.open || attempt.start != at {
                self.open_attempt(index, at, bit, &first);
                self.spoil(index);
            }
            for place in 0..self.segments[index].members.len() {
                let node = self.segments[index].members[place];
                self.start_if_ready(index, node, at);
            }
            self.form_groups(index);
        }
        for &node in &self.segments[index].leaders {
            self.stations[node].engine.begin_bit();
        }
        self.segments[index].activity = Activity::Exact { bit_start: at, begun: true };
    }

    fn finish_bits(&mut self, index: usize, began: Instant, bit: u64) {
        let now = after(began, bit);
        self.now = now;
        let leaders = &self.segments[index].leaders;
        let driven = leaders.iter().all(|&node| self.stations[node].engine.drives_recessive());
        let mut struck = std::mem::take(&mut self.struck);
        struck.clear();
        let overlay = self.faults.overlay(index, after(began, bit * 7 / 8), |node| struck.push(node.index()));
        let level = (driven && !overlay.dominant) != overlay.inverted;
        if !struck.is_empty() {
            self.dissolve(index);
        }
        let mut effects = std::mem::take(&mut self.effects);
        effects.clear();
        let (mut busy, mut quiet, mut eventful) = (false, true, false);
        for &node in &self.segments[index].leaders {
            let inverted = struck.iter().filter(|&&other| other == node).count() % 2 == 1;
            let station = &mut self.stations[node];
            let engine = &mut station.engine;
            let came_later = station.heard_from > began && matches!(engine.phase, Phase::Joining { .. });
            let effect = if came_later { Effect::None } else { engine.sample(level != inverted) };
            busy |= engine.phase.is_busy();
            quiet &= engine.phase.is_quiet();
            eventful |= effect != Effect::None || engine.counters != station.known;
            effects.push(effect);
        }
        if eventful {
            self.spread(index, &effects, began, now);
        }
        (self.struck, self.effects) = (struck, effects);
        let attempt = &self.segments[index].attempt;
        if attempt.open && (attempt.sent || !busy) {
            self.close_attempt(index, now);
        }
        self.segments[index].activity = Activity::Exact { bit_start: now, begun: false };
        if quiet {
            self.leave_exact(index, now);
        }
    }

    /// Carries out what a bit led to, for all members in their order.
    fn spread(&mut self, index: usize, effects: &[Effect], began: Instant, now: Instant) {
        self.update_followers(index);
        let (mut leader, mut follower) = (0, 0);
        for place in 0..self.segments[index].members.len() {
            let segment = &self.segments[index];
            let node = segment.members[place];
            let effect = match segment.followers.get(follower) {
                Some(&(who, led_by)) if who == node => {
                    follower += 1;
                    effects[led_by]
                }
                Some(_) | None => {
                    leader += 1;
                    effects[leader - 1]
                }
            };
            self.carry_out(index, node, effect, began, now);
        }
        for place in 0..self.segments[index].members.len() {
            let node = self.segments[index].members[place];
            self.report_counters(node, now);
        }
    }

    /// Finds members that are in the same state, and will stay so while they see the same bits and have nothing to
    /// send. One of them is simulated for all.
    fn form_groups(&mut self, index: usize) {
        if self.force_exact {
            return;
        }
        let Segment { members, leaders, followers, .. } = &mut self.segments[index];
        leaders.clear();
        followers.clear();
        for &node in members.iter() {
            let station = &self.stations[node];
            let leads = |&leader: &usize| station.is_like(&self.stations[leader]);
            match leaders.iter().position(leads) {
                Some(place) => followers.push((node, place)),
                None => leaders.push(node),
            }
        }
    }

    /// Every member is simulated by itself again.
    pub(super) fn dissolve(&mut self, index: usize) {
        self.update_followers(index);
        let Segment { members, leaders, followers, .. } = &mut self.segments[index];
        followers.clear();
        leaders.clear();
        leaders.extend_from_slice(members);
    }

    fn update_followers(&mut self, index: usize) {
        let Segment { leaders, followers, .. } = &self.segments[index];
        for &(node, place) in followers {
            self.stations[node].engine = self.stations[leaders[place]].engine.clone();
        }
    }

    /// Every station sleeps until the next frame begins.
    pub(super) fn leave_exact(&mut self, index: usize, now: Instant) {
        self.dissolve(index);
        for place in 0..self.segments[index].members.len() {
            let node = self.segments[index].members[place];
            let station = &mut self.stations[node];
            let bit = station.bit();
            match station.engine.phase {
                Phase::Suspend { left } => {
                    station.suspend_until = after(now, u64::from(left) * bit);
                    station.engine.phase = Phase::Idle;
                }
                Phase::Joining { run, .. } => {
                    let nanos = now.as_nanos().saturating_sub(u64::from(run) * bit);
                    station.heard_from = Instant::from_nanos(nanos);
                }
                Phase::Off
                | Phase::Idle
                | Phase::Frame
                | Phase::Flag { .. }
                | Phase::PassiveFlag { .. }
                | Phase::AfterFlag { .. }
                | Phase::Delimiter { .. }
                | Phase::Intermission { .. } => {}
            }
        }
        self.segments[index].activity = Activity::Quiet;
        self.segments[index].free_at = now;
        self.survey(index, now);
    }

    /// The frame that has priority among those that begin at `at`.
    fn first_to_start(&self, index: usize, at: Instant) -> Option<Frame> {
        self.segments[index]
            .waiting
            .iter()
            .map(|&node| &self.stations[node])
            .filter(|station| station.engine.phase == Phase::Idle)
            .filter_map(|station| station.queue.head(at))
            .min_by_key(|mail| mail.key)
            .map(|mail| mail.frame)
    }

    /// Lets a station send, if the bus is free for it and a frame waits.
    pub(super) fn start_if_ready(&mut self, index: usize, node: usize, at: Instant) {
        let station = &mut self.stations[node];
        if station.engine.phase != Phase::Idle || !station.can_send() {
            return;
        }
        if let Some(frame) = station.queue.send(at) {
            station.engine.start(&frame);
            self.attempt_sender(index, node, frame, at);
        }
    }
}
