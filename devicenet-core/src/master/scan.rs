//! The scan as time and frames move it on.

use core::time::Duration;

use super::board::View;
use super::cycle::{Cycle, Position};
use super::machine::{Master, Timer};
use crate::counter::count_wide;

impl<const SLAVES: usize, const MESSAGE: usize> Master<SLAVES, MESSAGE> {
    /// Moves the scan on where it waits for nothing.
    pub(super) fn scan(&mut self) {
        self.follow_slaves();
        if !self.on_line {
            return;
        }
        if !self.lanes.carries_command() {
            self.skip_idle();
        }
        let ratio = self.config.background_ratio;
        if self.cycle.position == Position::Stopped {
            if !Cycle::is_needed(View::new(&self.board, &self.slots)) {
                return;
            }
            self.cycle.begin(View::new(&self.board, &self.slots), ratio);
        } else if self.cycle.is_over() {
            self.end_scan();
            if !Cycle::is_needed(View::new(&self.board, &self.slots)) {
                return self.cycle.stop();
            }
            self.cycle.begin(View::new(&self.board, &self.slots), ratio);
        } else {
            return;
        }
        if self.cycle.position == Position::Pause {
            // Nobody is due in this scan.
            self.pause();
        }
    }

    /// All commands are out.
    pub(super) fn pause(&mut self) {
        let delay = self.config.interscan_delay;
        if delay.is_zero() && self.cycle.sent_commands() {
            self.cycle.delay_over = true;
        } else {
            self.timers.set_after(Timer::Interscan, delay.max(SHORTEST_EMPTY_SCAN));
        }
        self.timers.set_after(Timer::ResponseWait, self.config.response_wait);
        self.give_way();
    }

    /// A frame was on the bus, or is handed out, or was destroyed: another one may follow. An interscan delay that is long
    /// enough for several is enough.
    pub(super) fn give_way(&mut self) {
        if self.cycle.position != Position::Pause {
            return;
        }
        if self.config.interscan_delay >= ANSWERED {
            self.cycle.quiet = true;
            return;
        }
        self.cycle.quiet = false;
        let is_talking = self.cycle.unanswered != 0 || self.lanes.carries_explicit();
        let waits = is_talking || self.cycle.disturbed != 0;
        self.timers.set_after(Timer::Quiet, if waits { ANSWERED } else { QUIET });
    }

    fn end_scan(&mut self) {
        count_wide(&mut self.counters.scans);
        for timer in [Timer::Interscan, Timer::ResponseWait, Timer::Quiet] {
            self.timers.clear(timer);
        }
        let mut missing = 0_u8;
        for slave in self.cycle.missing() {
            if let Some(slot) = self.board.get_mut(&mut self.slots, slave) {
                count_wide(&mut slot.counters.missed);
                missing = missing.saturating_add(1);
            }
        }
        self.scan_done = Some(missing);
    }
}

/// Between two scans in which nobody is polled.
const SHORTEST_EMPTY_SCAN: Duration = Duration::from_millis(1);
/// The bus is quiet when nobody has begun to send for so long: four bits at 125 kbit/s, one more than the intermission.
const QUIET: Duration = Duration::from_micros(32);
/// The longest frame at 125 kbit/s, and some time for the reaction of the one who answers.
const ANSWERED: Duration = Duration::from_millis(2);
