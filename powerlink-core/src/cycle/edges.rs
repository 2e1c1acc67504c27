//! The transition table of the cycle.

use super::{CycleEdge, CycleEvent, CycleMode, CycleState, Losses};

/// Every transition. Debug builds check each step against it. What is not listed is ignored in that state.
///
/// | Mode | From | Event | Missing | To |
/// |---|---|---|---|---|
/// | polled | NonCyclic | SoC |  | WaitPreq |
/// | polled | WaitSoc | SoC |  | WaitPreq |
/// | polled | WaitSoc | PReq | SoC | WaitSoc |
/// | polled | WaitSoc | PReq | SoC | WaitSoa |
/// | polled | WaitSoc | PRes | SoC | WaitSoc |
/// | polled | WaitSoc | PRes | SoC | WaitSoa |
/// | polled | WaitSoc | SoA | SoC | WaitSoc |
/// | polled | WaitSoc | ASnd |  | WaitSoc |
/// | polled | WaitSoc | SoC timeout | SoC | WaitSoc |
/// | polled | WaitPreq | PReq |  | WaitSoa |
/// | polled | WaitPreq | SoA | PReq | WaitSoc |
/// | polled | WaitPreq | SoA |  | WaitSoc |
/// | polled | WaitPreq | SoC | SoA | WaitPreq |
/// | polled | WaitPreq | ASnd | SoA | WaitPreq |
/// | polled | WaitPreq | PRes |  | WaitPreq |
/// | polled | WaitPreq | SoC timeout | SoC, SoA | WaitSoc |
/// | polled | WaitSoa | SoA |  | WaitSoc |
/// | polled | WaitSoa | PReq | SoC, SoA | WaitSoc |
/// | polled | WaitSoa | SoC | SoA | WaitPreq |
/// | polled | WaitSoa | ASnd | SoA | WaitSoa |
/// | polled | WaitSoa | PRes |  | WaitSoa |
/// | polled | WaitSoa | SoC timeout | SoC, SoA | WaitSoc |
/// | stopped | NonCyclic | SoC |  | WaitSoa |
/// | stopped | WaitSoc | SoC |  | WaitSoa |
/// | stopped | WaitSoc | SoA | SoC | WaitSoc |
/// | stopped | WaitSoc | PReq | SoC | WaitSoc |
/// | stopped | WaitSoc | SoC timeout | SoC | WaitSoc |
/// | stopped | WaitPreq | PReq |  | WaitSoa |
/// | stopped | WaitPreq | SoA |  | WaitSoc |
/// | stopped | WaitPreq | SoC | SoA | WaitPreq |
/// | stopped | WaitPreq | ASnd | SoA | WaitPreq |
/// | stopped | WaitPreq | SoC timeout | SoC, SoA | WaitSoc |
/// | stopped | WaitSoa | SoA |  | WaitSoc |
/// | stopped | WaitSoa | SoC | SoA | WaitSoa |
/// | stopped | WaitSoa | ASnd | SoA | WaitSoa |
/// | stopped | WaitSoa | SoC timeout | SoC, SoA | WaitSoc |
///
/// Two rows for a PReq or PRes in `WaitSoc`: the specification stays, openPOWERLINK waits for SoA;
/// [`PollWithoutSoc`](super::PollWithoutSoc) chooses. Two rows for a SoA in `WaitPreq`: a PReq was due, or not.
///
/// Sources: EPSG DS 301, DLL_CS state machine; for the stopped node openPOWERLINK 2.7.2 (`dllkstatemachine.c`).
pub const CYCLE_EDGES: &[CycleEdge] = {
    use CycleMode::*;
    use CycleState::*;
    &[
        edge(Polled, NonCyclic, CycleEvent::Soc, Losses::empty(), WaitPreq),
        edge(Polled, WaitSoc, CycleEvent::Soc, Losses::empty(), WaitPreq),
        edge(Polled, WaitSoc, CycleEvent::Preq, Losses::SOC, WaitSoc),
        edge(Polled, WaitSoc, CycleEvent::Preq, Losses::SOC, WaitSoa),
        edge(Polled, WaitSoc, CycleEvent::Pres, Losses::SOC, WaitSoc),
        edge(Polled, WaitSoc, CycleEvent::Pres, Losses::SOC, WaitSoa),
        edge(Polled, WaitSoc, CycleEvent::Soa, Losses::SOC, WaitSoc),
        edge(Polled, WaitSoc, CycleEvent::Asnd, Losses::empty(), WaitSoc),
        edge(Polled, WaitSoc, CycleEvent::SocTimeout, Losses::SOC, WaitSoc),
        edge(Polled, WaitPreq, CycleEvent::Preq, Losses::empty(), WaitSoa),
        edge(Polled, WaitPreq, CycleEvent::Soa, Losses::PREQ, WaitSoc),
        edge(Polled, WaitPreq, CycleEvent::Soa, Losses::empty(), WaitSoc),
        edge(Polled, WaitPreq, CycleEvent::Soc, Losses::SOA, WaitPreq),
        edge(Polled, WaitPreq, CycleEvent::Asnd, Losses::SOA, WaitPreq),
        edge(Polled, WaitPreq, CycleEvent::Pres, Losses::empty(), WaitPreq),
        edge(Polled, WaitPreq, CycleEvent::SocTimeout, SOC_AND_SOA, WaitSoc),
        edge(Polled, WaitSoa, CycleEvent::Soa, Losses::empty(), WaitSoc),
        edge(Polled, WaitSoa, CycleEvent::Preq, SOC_AND_SOA, WaitSoc),
        edge(Polled, WaitSoa, CycleEvent::Soc, Losses::SOA, WaitPreq),
        edge(Polled, WaitSoa, CycleEvent::Asnd, Losses::SOA, WaitSoa),
        edge(Polled, WaitSoa, CycleEvent::Pres, Losses::empty(), WaitSoa),
        edge(Polled, WaitSoa, CycleEvent::SocTimeout, SOC_AND_SOA, WaitSoc),
        edge(Stopped, NonCyclic, CycleEvent::Soc, Losses::empty(), WaitSoa),
        edge(Stopped, WaitSoc, CycleEvent::Soc, Losses::empty(), WaitSoa),
        edge(Stopped, WaitSoc, CycleEvent::Soa, Losses::SOC, WaitSoc),
        edge(Stopped, WaitSoc, CycleEvent::Preq, Losses::SOC, WaitSoc),
        edge(Stopped, WaitSoc, CycleEvent::SocTimeout, Losses::SOC, WaitSoc),
        edge(Stopped, WaitPreq, CycleEvent::Preq, Losses::empty(), WaitSoa),
        edge(Stopped, WaitPreq, CycleEvent::Soa, Losses::empty(), WaitSoc),
        edge(Stopped, WaitPreq, CycleEvent::Soc, Losses::SOA, WaitPreq),
        edge(Stopped, WaitPreq, CycleEvent::Asnd, Losses::SOA, WaitPreq),
        edge(Stopped, WaitPreq, CycleEvent::SocTimeout, SOC_AND_SOA, WaitSoc),
        edge(Stopped, WaitSoa, CycleEvent::Soa, Losses::empty(), WaitSoc),
        edge(Stopped, WaitSoa, CycleEvent::Soc, Losses::SOA, WaitSoa),
        edge(Stopped, WaitSoa, CycleEvent::Asnd, Losses::SOA, WaitSoa),
        edge(Stopped, WaitSoa, CycleEvent::SocTimeout, SOC_AND_SOA, WaitSoc),
    ]
};

const SOC_AND_SOA: Losses = Losses::SOC.union(Losses::SOA);

const fn edge(
    mode: CycleMode,
    from: CycleState,
    event: CycleEvent,
    losses: Losses,
    to: CycleState,
) -> CycleEdge {
    CycleEdge { mode, from, event, losses, to }
}
