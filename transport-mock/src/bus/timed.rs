//! The exact path for stations that are not in step: wrong bit rates, and clocks beyond the tolerance of CAN.
//!
//! Each station has its own bit time, samples at 87.5 % of it, and follows the edges from recessive to dominant: hard
//! synchronisation at a start of frame, and otherwise resynchronisation by at most a jump width of 1/8 bit, once a bit
//! (Bosch CAN 2.0 section 8, ISO 11898-1). So what a station makes of another's rate is not assumed, but follows.
//!
//! ```text
//!   bit of one station:  |<------------- 7/8 ------------->S<-- 1/8 -->|
//!                        ^ expects edges here              ^ samples
//! ```

use link_core::Instant;

use super::phase::Phase;
use super::segment::Activity;
use super::{Bus, after, span};

impl Bus {
    /// The stations of a segment come out of step in the middle of a bit.
    pub(super) fn go_timed(&mut self, index: usize, bit_start: Instant, begun: bool, now: Instant) {
        for &node in &self.segments[index].members {
            let station = &mut self.stations[node];
            let bit = station.bit();
            let clock = &mut station.bit_clock;
            clock.sampled = !begun;
            clock.sample_at = after(bit_start, bit * 7 / 8).max(now);
            clock.ends_at = if begun { after(bit_start, bit).max(now) } else { bit_start };
            (clock.synchronised, clock.level) = (false, true);
        }
        self.segments[index].activity = Activity::Timed { next: bit_start.max(now) };
    }

    /// Runs until somebody must be told something, the segment is quiet, or something else comes first.
    pub(super) fn run_timed(&mut self, index: usize, limit: Instant) {
        loop {
            let Activity::Timed { next } = self.segments[index].activity else { return };
            self.now = next;
            self.sample_stations(index, next);
            self.begin_stations(index, next);
            if self.all_quiet(index, next) {
                return;
            }
            let next = self.next_timed(index);
            self.segments[index].activity = Activity::Timed { next };
            if next >= limit || self.has_news() || self.segments.len() > 1 {
                return;
            }
        }
    }

    fn next_timed(&self, index: usize) -> Instant {
        let clocks = self.segments[index].members.iter().map(|&node| &self.stations[node].bit_clock);
        clocks
            .map(|clock| if clock.sampled { clock.ends_at } else { clock.sample_at })
            .min()
            .unwrap_or(Instant::MAX)
    }

    /// The stations that sample at `now` do so.
    fn sample_stations(&mut self, index: usize, now: Instant) {
        let driven = self.driven(index);
        let mut struck = std::mem::take(&mut self.struck);
        struck.clear();
        let overlay = self.faults.overlay(index, now, |node| struck.push(node.index()));
        let level = (driven && !overlay.dominant) != overlay.inverted;
        for place in 0..self.segments[index].members.len() {
            let node = self.segments[index].members[place];
            let inverted = struck.iter().filter(|&&other| other == node).count() % 2 == 1;
            let station = &mut self.stations[node];
            let clock = &mut station.bit_clock;
            if clock.sampled || clock.sample_at > now {
                continue;
            }
            clock.sampled = true;
            clock.level = level != inverted;
            let end = clock.ends_at;
            let effect = station.engine.sample(level != inverted);
            // What is recorded happened in the bit, which is over at its end.
            self.carry_out(index, node, effect, now, end);
            self.report_counters(node, end);
        }
        self.struck = struck;
    }

    /// The stations whose bit ends at `now` begin another, and the others follow an edge that this makes.
    fn begin_stations(&mut self, index: usize, now: Instant) {
        let before = self.driven(index);
        for place in 0..self.segments[index].members.len() {
            let node = self.segments[index].members[place];
            let clock = &self.stations[node].bit_clock;
            if clock.sampled && clock.ends_at <= now {
                self.begin_station(index, node, now);
            }
        }
        if !before || self.driven(index) {
            return;
        }
        for place in 0..self.segments[index].members.len() {
            let node = self.segments[index].members[place];
            self.synchronise(node, now);
        }
    }

    fn begin_station(&mut self, index: usize, node: usize, now: Instant) {
        self.start_if_ready(index, node, now);
        let station = &mut self.stations[node];
        let bit = station.bit();
        station.engine.begin_bit();
        let clock = &mut station.bit_clock;
        clock.sampled = false;
        clock.synchronised = false;
        clock.sample_at = after(now, bit * 7 / 8);
        clock.ends_at = after(now, bit);
    }

    /// An edge from recessive to dominant at `now`.
    fn synchronise(&mut self, node: usize, now: Instant) {
        let station = &mut self.stations[node];
        let bit = station.bit();
        // A sender does not follow its own edges, nor anybody an edge after a dominant sample.
        if !station.engine.drives_recessive() {
            return;
        }
        let hard = matches!(
            station.engine.phase,
            Phase::Idle | Phase::Suspend { .. } | Phase::Joining { .. } | Phase::Intermission { seen: 2 }
        );
        let clock = &mut station.bit_clock;
        if hard {
            clock.sampled = false;
            clock.sample_at = after(now, bit * 7 / 8);
            clock.ends_at = after(now, bit);
            return;
        }
        if clock.synchronised || !clock.level {
            return;
        }
        clock.synchronised = true;
        let jump = bit / 8;
        if clock.sampled {
            // The edge of the next bit comes early: this bit is shortened.
            let early = span(now, clock.ends_at).min(jump);
            clock.ends_at = Instant::from_nanos(clock.ends_at.as_nanos() - early).max(now);
        } else {
            let began = clock.ends_at.as_nanos().saturating_sub(bit);
            let late = now.as_nanos().saturating_sub(began).min(jump);
            clock.sample_at = after(clock.sample_at, late);
            clock.ends_at = after(clock.ends_at, late);
        }
    }

    /// Goes back to the cheap path if nobody has anything unfinished.
    fn all_quiet(&mut self, index: usize, now: Instant) -> bool {
        let phases = || self.segments[index].members.iter().map(|&node| self.stations[node].engine.phase);
        let (busy, quiet) = (phases().any(Phase::is_busy), phases().all(Phase::is_quiet));
        let disturbed = self.faults.next() <= now;
        if self.segments[index].attempt.open && !busy {
            let over = self.end_of_bits(index, now);
            let over = *self.segments[index].attempt.over.get_or_insert(over);
            if over > now {
                return false;
            }
            self.close_attempt(index, over);
        } else {
            self.segments[index].attempt.over = None;
        }
        if quiet && !disturbed {
            self.leave_exact(index, now);
        }
        quiet && !disturbed
    }

    /// The end of the bits that were sampled at `now`.
    fn end_of_bits(&self, index: usize, now: Instant) -> Instant {
        let clocks = self.segments[index].members.iter().map(|&node| &self.stations[node].bit_clock);
        let ends = clocks.filter(|clock| clock.sampled && clock.sample_at == now).map(|clock| clock.ends_at);
        ends.max().unwrap_or(now)
    }

    fn driven(&self, index: usize) -> bool {
        self.segments[index].members.iter().all(|&node| self.stations[node].engine.drives_recessive())
    }
}
