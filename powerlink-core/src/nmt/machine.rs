//! The NMT state machine of a controlled node.

use super::edges::EDGES;
use super::{Cause, Edge, NmtState};

/// The NMT state machine of a controlled node: a state, and what is known on the way to `ReadyToOperate`.
///
/// It knows neither frames nor time: its owner tells it what happened, and does what follows from the transition.
///
/// ```
/// use powerlink_core::nmt::{Cause, Nmt, NmtState};
///
/// let mut nmt = Nmt::new();
/// nmt.apply(Cause::PowerOn);
/// while nmt.state().is_initialisation() {
///     nmt.apply(Cause::Done);
/// }
/// assert_eq!(nmt.state(), NmtState::NotActive);
/// let edge = nmt.apply(Cause::Soa).expect("it leaves NotActive");
/// assert_eq!(edge.to_string(), "| CT2 | NotActive | SoA | PreOperational1 |");
/// assert_eq!(nmt.apply(Cause::StartNode), None, "ignored there");
/// ```
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Nmt {
    state: NmtState,
    /// NMTEnableReadyToOperate was received.
    is_enabled: bool,
    /// The application said that it is ready.
    is_ready: bool,
}

impl Nmt {
    /// A node without power.
    #[must_use]
    pub const fn new() -> Self {
        Self { state: NmtState::Off, is_enabled: false, is_ready: false }
    }

    /// The state.
    #[must_use]
    pub const fn state(&self) -> NmtState {
        self.state
    }

    /// Follows what happened; `None` if it changes nothing in this state.
    pub fn apply(&mut self, cause: Cause) -> Option<&'static Edge> {
        let to = self.next(cause)?;
        let edge = EDGES.iter().find(|edge| (edge.from, edge.cause, edge.to) == (self.state, cause, to));
        debug_assert!(edge.is_some(), "{} -> {to} by {cause} is not in the table", self.state);
        #[cfg(test)]
        super::tests::record(self.state, cause, to);
        let stays = to == self.state && cause != Cause::LocalReset && cause != Cause::SwReset;
        if !stays {
            (self.is_enabled, self.is_ready) = (false, false);
        }
        self.state = to;
        edge
    }

    /// Where a cause leads; CT5 leads to the state itself, and takes its note.
    fn next(&mut self, cause: Cause) -> Option<NmtState> {
        use NmtState::*;
        let state = self.state;
        Some(match cause {
            Cause::PowerOn if state == Off => Initialising,
            Cause::LocalReset | Cause::SwReset if state.is_powered() => Initialising,
            Cause::SwitchOff if state.is_powered() => Off,
            Cause::Done => match state {
                Initialising => ResetApplication,
                ResetApplication => ResetCommunication,
                ResetCommunication => ResetConfiguration,
                ResetConfiguration => NotActive,
                Off | NotActive | PreOperational1 | PreOperational2 | ReadyToOperate | Operational
                | Stopped | BasicEthernet => return None,
            },
            Cause::ResetNode
                if state.is_communicating() || matches!(state, ResetCommunication | ResetConfiguration) =>
            {
                ResetApplication
            }
            Cause::ResetCommunication if state.is_communicating() || state == ResetConfiguration => {
                ResetCommunication
            }
            Cause::ResetConfiguration if state.is_communicating() => ResetConfiguration,
            Cause::InternalError if state.is_communicating() => ResetCommunication,
            Cause::EnableReadyToOperate if state == PreOperational2 => {
                self.is_enabled = true;
                self.ready_to_operate()
            }
            Cause::ApplicationReady if state == PreOperational2 => {
                self.is_ready = true;
                self.ready_to_operate()
            }
            Cause::StartNode if state == ReadyToOperate => Operational,
            Cause::StopNode if state.answers_poll() => Stopped,
            Cause::EnterPreOperational2 if matches!(state, Operational | Stopped) => PreOperational2,
            Cause::CycleError if state.is_cyclic() => PreOperational1,
            Cause::Soc if state == PreOperational1 => PreOperational2,
            Cause::Soc | Cause::Soa if matches!(state, NotActive | BasicEthernet) => PreOperational1,
            Cause::Preq | Cause::Pres if matches!(state, NotActive | BasicEthernet) => PreOperational1,
            Cause::BasicEthernetTimeout if state == NotActive => BasicEthernet,
            _ => return None,
        })
    }

    /// Both conditions of CT6, or only the first.
    const fn ready_to_operate(&self) -> NmtState {
        if self.is_enabled && self.is_ready { NmtState::ReadyToOperate } else { NmtState::PreOperational2 }
    }
}

impl Default for Nmt {
    fn default() -> Self {
        Self::new()
    }
}
