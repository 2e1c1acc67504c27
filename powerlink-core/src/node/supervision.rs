//! What does not come, or not in time: the cycle, its timer and the error counters.

use core::time::Duration;

use link_core::Instant;

use super::machine::{ControlledNode, Timer};
use crate::cycle::{CycleEvent, CycleMode, Losses, Supervision};
use crate::dictionary::ObjectSet;
use crate::error::Symptom;
use crate::nmt::{Cause, NmtState};

impl<O: ObjectSet, const PRES: usize, const SDO: usize> ControlledNode<O, PRES, SDO> {
    /// MC toggles when a multiplexed cycle is over: a node that is polled in one cycle of many was to be polled in it.
    pub(super) fn multiplexed_cycle(&mut self, toggle: bool) -> Option<Cause> {
        if core::mem::replace(&mut self.poll.multiplexed_cycle, toggle) == toggle {
            return None;
        }
        let was_polled = core::mem::take(&mut self.poll.in_multiplexed_cycle);
        let is_due = self.active.multiplexed_cycles > 0 && self.is_started();
        if was_polled || !is_due { None } else { self.losses(Losses::PREQ) }
    }

    /// Whether process data are exchanged, so that a PReq is due.
    pub(super) const fn is_started(&self) -> bool {
        matches!(self.nmt.state(), NmtState::ReadyToOperate | NmtState::Operational)
    }

    /// The distance of two SoCs against the cycle length.
    pub(super) fn jitter(&mut self) -> Option<Cause> {
        // As for the loss of SoC: the cycle length may be unknown yet.
        if self.nmt.state() == NmtState::PreOperational2 {
            return None;
        }
        let (expected, range) = (self.timers.at(Timer::Soc)?, self.dictionary.values.jitter_range);
        let tolerance = Duration::from_nanos(self.active.loss_of_soc_tolerance.into());
        let (now, expected) = (self.timers.now(), expected.saturating_sub(tolerance));
        let jitter = now.saturating_since(expected).max(expected.saturating_since(now));
        if jitter <= Duration::from_nanos(range.into()) {
            return None;
        }
        if self.dictionary.counters.symptom(Symptom::SocJitter) {
            self.react(Symptom::SocJitter)
        } else {
            None
        }
    }

    pub(super) fn supervise_soc(&mut self) {
        let (length, tolerance) = (self.active.cycle_length, self.active.loss_of_soc_tolerance);
        if length == 0 || tolerance == 0 || !self.nmt.state().is_cyclic() {
            return self.timers.clear(Timer::Soc);
        }
        let nanos = u64::from(length).saturating_mul(NANOS_PER_MICRO).saturating_add(tolerance.into());
        self.timers.set_after(Timer::Soc, Duration::from_nanos(nanos));
    }

    /// The SoC is overdue since `due`. The next one is expected a cycle later, and so on: a node that is called late has missed
    /// all that were due by `now`. They are counted in one step, as far as the threshold: however late it is, the work is the
    /// same.
    pub(super) fn soc_timeout(&mut self, due: Instant, now: Instant) {
        let cycle = u64::from(self.active.cycle_length).saturating_mul(NANOS_PER_MICRO);
        let late = now.as_nanos().saturating_sub(due.as_nanos());
        let more = late.checked_div(cycle).unwrap_or(0);
        let next = cycle.saturating_mul(more.saturating_add(1));
        self.timers.set(Timer::Soc, due.saturating_add_nanos(next));
        // In `PreOperational2` the cycle length may be unknown yet.
        if self.nmt.state() == NmtState::PreOperational2 {
            return;
        }
        let mut cause = self.cycle_event(CycleEvent::SocTimeout);
        if cause.is_none() && more > 0 {
            cause = self.lost_socs(u32::try_from(more).unwrap_or(u32::MAX));
        }
        match cause {
            // A poll that came at this very moment is answered first.
            Some(cause) if self.poll.is_due => self.poll.then = self.poll.then.or(Some(cause)),
            Some(cause) => {
                self.cause(cause);
            }
            None => {}
        }
    }

    /// Tells the cycle what happened, and counts what is missing. Returns what that leads to.
    pub(super) fn cycle_event(&mut self, event: CycleEvent) -> Option<Cause> {
        let state = self.nmt.state();
        let mode = if state == NmtState::Stopped { CycleMode::Stopped } else { CycleMode::Polled };
        let supervision = Supervision {
            is_timed: state != NmtState::PreOperational2 && self.timers.at(Timer::Soc).is_some(),
            is_preq_due: self.active.multiplexed_cycles == 0 && self.is_started(),
        };
        let losses = self.cycle.apply(mode, event, supervision);
        if losses.is_empty() { None } else { self.losses(losses) }
    }

    /// Further SoCs behind one whose time is over: that is all that they change.
    fn lost_socs(&mut self, count: u32) -> Option<Cause> {
        let is_reached = self.dictionary.counters.symptoms(Symptom::LossOfSoc, count);
        if is_reached { self.react(Symptom::LossOfSoc) } else { None }
    }

    fn losses(&mut self, losses: Losses) -> Option<Cause> {
        let symptoms = [
            (Losses::SOC, Symptom::LossOfSoc),
            (Losses::SOA, Symptom::LossOfSoa),
            (Losses::PREQ, Symptom::LossOfPreq),
        ];
        let mut cause = None;
        for (loss, symptom) in symptoms {
            if losses.contains(loss) && self.dictionary.counters.symptom(symptom) {
                cause = self.react(symptom).or(cause);
            }
        }
        cause
    }

    /// A threshold was reached. What is only counted is no error.
    fn react(&mut self, symptom: Symptom) -> Option<Cause> {
        let options = &self.config.options;
        let reacts = match symptom {
            Symptom::LossOfSoc | Symptom::LossOfPreq | Symptom::Crc => true,
            Symptom::LossOfSoa => options.reacts_to_loss_of_soa,
            Symptom::SocJitter => options.reacts_to_jitter,
            Symptom::Collision => options.reacts_to_collisions,
            Symptom::LossOfLink => false,
        };
        if !reacts {
            return None;
        }
        self.error(symptom.code());
        Some(Cause::CycleError)
    }

    pub(super) fn symptom(&mut self, symptom: Symptom) {
        let is_reached = self.dictionary.counters.symptom(symptom);
        if is_reached && let Some(cause) = self.react(symptom) {
            self.cause(cause);
        }
    }
}

const NANOS_PER_MICRO: u64 = 1000;
