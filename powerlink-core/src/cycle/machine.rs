//! The cycle state machine of a controlled node.

use super::edges::CYCLE_EDGES;
use super::{CycleEvent, CycleMode, CycleState, Losses};

/// The cycle state machine: it notices frames that do not come.
///
/// It answers nothing: a PReq is answered in every state of the cycle.
///
/// ```
/// use powerlink_core::cycle::{Cycle, CycleEvent, CycleMode, Losses, PollWithoutSoc, Supervision};
///
/// let watched = Supervision { is_timed: true, is_preq_due: true };
/// let mut cycle = Cycle::new(PollWithoutSoc::Stay);
/// let losses = [CycleEvent::Soc, CycleEvent::Preq, CycleEvent::Soa, CycleEvent::Soc, CycleEvent::Soa]
///     .map(|event| cycle.apply(CycleMode::Polled, event, watched));
/// assert_eq!(losses, [Losses::empty(), Losses::empty(), Losses::empty(), Losses::empty(), Losses::PREQ]);
/// ```
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Cycle {
    state: CycleState,
    poll_without_soc: PollWithoutSoc,
    missing: MissingSocs,
    /// The SoA of this cycle is known to be lost.
    is_soa_lost: bool,
}

/// What a PReq or PRes in `WaitSoc` leads to: the SoC before it was lost.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum PollWithoutSoc {
    /// The node stays in `WaitSoc`, as EPSG DS 301 says.
    #[default]
    Stay,
    /// It waits for SoA, as openPOWERLINK does.
    WaitSoa,
}

/// What the node knows about the frames that are due.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Supervision {
    /// The time until the next SoC is supervised.
    pub is_timed: bool,
    /// A PReq was due in this cycle.
    pub is_preq_due: bool,
}

/// The SoCs that did not come since the last one. Order and time tell of each: it counts once.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct MissingSocs {
    /// How many order told of and time has not yet.
    ahead: u8,
    /// Order told of that of the present cycle.
    is_known: bool,
    /// Time told of one first: it goes on so.
    is_timed: bool,
}

impl MissingSocs {
    const NONE: Self = Self { ahead: 0, is_known: false, is_timed: false };

    /// One is noticed. Returns whether it is another one.
    fn notice(&mut self, event: CycleEvent) -> bool {
        if event == CycleEvent::SocTimeout {
            let is_new = self.ahead == 0;
            self.is_timed |= is_new;
            self.ahead = self.ahead.saturating_sub(1);
            return is_new;
        }
        // A cycle without SoC has a poll before its SoA: SoAs that follow each other tell of one.
        let is_new = !self.is_timed && !self.is_known && (event != CycleEvent::Soa || self.ahead == 0);
        self.is_known = true;
        self.ahead = self.ahead.saturating_add(is_new.into());
        is_new
    }
}

impl Cycle {
    /// A node outside of the cycle.
    #[must_use]
    pub const fn new(poll_without_soc: PollWithoutSoc) -> Self {
        Self {
            state: CycleState::NonCyclic,
            poll_without_soc,
            missing: MissingSocs::NONE,
            is_soa_lost: false,
        }
    }

    /// The state.
    #[must_use]
    pub const fn state(&self) -> CycleState {
        self.state
    }

    /// The NMT state has no cycle.
    pub const fn leave(&mut self) {
        *self = Self::new(self.poll_without_soc);
    }

    /// Follows what happened, and says what is missing.
    #[inline]
    pub fn apply(&mut self, mode: CycleMode, event: CycleEvent, supervision: Supervision) -> Losses {
        // A managing node waits for what follows the PReq that is due: it goes without the search for its edge.
        if (self.state, event) == (CycleState::WaitPreq, CycleEvent::Preq) {
            self.enter(mode, event, Losses::empty(), CycleState::WaitSoa);
            return Losses::empty();
        }
        self.follow(mode, event, supervision)
    }

    #[inline(never)]
    fn follow(&mut self, mode: CycleMode, event: CycleEvent, supervision: Supervision) -> Losses {
        let Some((to, losses)) = self.next(mode, event, supervision) else { return Losses::empty() };
        self.enter(mode, event, losses, to);
        self.once(event, losses, supervision)
    }

    #[inline]
    fn enter(&mut self, mode: CycleMode, event: CycleEvent, losses: Losses, to: CycleState) {
        debug_assert!(
            CYCLE_EDGES.iter().any(|edge| {
                (edge.mode, edge.from, edge.event, edge.losses, edge.to)
                    == (mode, self.state, event, losses, to)
            }),
            "{} -> {to} by {event} is not in the table",
            self.state
        );
        #[cfg(test)]
        super::tests::record((mode, self.state, event, losses, to));
        self.state = to;
    }

    fn next(
        &self,
        mode: CycleMode,
        event: CycleEvent,
        supervision: Supervision,
    ) -> Option<(CycleState, Losses)> {
        use CycleEvent::{Asnd, Preq, Pres, Soa, Soc, SocTimeout};
        use CycleState::*;
        const NOTHING: Losses = Losses::empty();
        const SOC_AND_SOA: Losses = Losses::SOC.union(Losses::SOA);
        let begun = match mode {
            CycleMode::Polled => WaitPreq,
            CycleMode::Stopped => WaitSoa,
        };
        Some(match (self.state, event, mode) {
            (NonCyclic | WaitSoc, Soc, _) => (begun, NOTHING),
            (NonCyclic, ..) => return None,
            (WaitSoc, Preq | Pres, CycleMode::Polled) => match self.poll_without_soc {
                PollWithoutSoc::Stay => (WaitSoc, Losses::SOC),
                PollWithoutSoc::WaitSoa => (WaitSoa, Losses::SOC),
            },
            (WaitSoc, Preq, CycleMode::Stopped) | (WaitSoc, Soa | SocTimeout, _) => (WaitSoc, Losses::SOC),
            (WaitSoc, Asnd, CycleMode::Polled) => (WaitSoc, NOTHING),
            (WaitPreq, Preq, _) => (WaitSoa, NOTHING),
            (WaitPreq, Soa, CycleMode::Polled) if supervision.is_preq_due => (WaitSoc, Losses::PREQ),
            (WaitPreq | WaitSoa, Soa, _) => (WaitSoc, NOTHING),
            (WaitPreq, Soc | Asnd, _) => (WaitPreq, Losses::SOA),
            (WaitPreq | WaitSoa, SocTimeout, _) => (WaitSoc, SOC_AND_SOA),
            (WaitSoa, Preq, CycleMode::Polled) => (WaitSoc, SOC_AND_SOA),
            (WaitSoa, Soc, _) => (begun, Losses::SOA),
            (WaitSoa, Asnd, _) => (WaitSoa, Losses::SOA),
            (WaitPreq | WaitSoa, Pres, CycleMode::Polled) => (self.state, NOTHING),
            (WaitSoc, Pres | Asnd, CycleMode::Stopped)
            | (WaitPreq | WaitSoa, Pres, CycleMode::Stopped)
            | (WaitSoa, Preq, CycleMode::Stopped) => return None,
        })
    }

    /// A lost SoC or SoA counts once, however often it is noticed.
    ///
    /// A SoA: until the next one, or the next cycle; several ASnd in its place, and the SoC behind them, tell the same.
    ///
    /// A SoC: order tells of one in each cycle, which ends with the SoA, and so many timeouts are about the same ones. Once time is
    /// the first to tell, order tells nothing new until a SoC comes. Where time is not supervised, the SoA ends all that.
    fn once(&mut self, event: CycleEvent, mut losses: Losses, supervision: Supervision) -> Losses {
        if losses.contains(Losses::SOA) && core::mem::replace(&mut self.is_soa_lost, true) {
            losses.remove(Losses::SOA);
        }
        if matches!(event, CycleEvent::Soc | CycleEvent::Soa | CycleEvent::SocTimeout) {
            self.is_soa_lost = false;
        }
        if losses.contains(Losses::SOC) {
            losses.set(Losses::SOC, self.missing.notice(event));
        }
        if event == CycleEvent::Soc || (event == CycleEvent::Soa && !supervision.is_timed) {
            self.missing = MissingSocs::NONE;
        }
        if event == CycleEvent::Soa {
            self.missing.is_known = false;
        }
        losses
    }
}
