//! The NMT states of a controlled node once more: where each cause leads, and what runs through by itself.

use powerlink_core::nmt::Cause;
use powerlink_core::nmt::NmtState::{self, *};

/// The state, and the two conditions of `ReadyToOperate`.
#[derive(Clone, Debug)]
pub(super) struct States {
    pub(super) state: NmtState,
    is_enabled: bool,
    is_ready: bool,
    /// The application is always ready.
    is_automatic: bool,
}

/// One step: the state that is entered, and why.
pub(super) type Step = (NmtState, Cause);

impl States {
    pub(super) fn new(is_automatic: bool) -> Self {
        Self { state: Off, is_enabled: false, is_ready: false, is_automatic }
    }

    /// Follows a cause: every state that is entered by it, up to the one that lasts.
    pub(super) fn follow(&mut self, cause: Cause) -> Vec<Step> {
        let Some(to) = self.next(cause) else { return vec![] };
        let mut steps = vec![(to, cause)];
        let rest: &[NmtState] = match to {
            Initialising => &[ResetApplication, ResetCommunication, ResetConfiguration, NotActive],
            ResetApplication => &[ResetCommunication, ResetConfiguration, NotActive],
            ResetCommunication => &[ResetConfiguration, NotActive],
            ResetConfiguration => &[NotActive],
            _ => &[],
        };
        steps.extend(rest.iter().map(|&state| (state, Cause::Done)));
        self.settle(rest.last().copied().unwrap_or(to));
        steps
    }

    /// Is in a state from now on.
    pub(super) fn settle(&mut self, state: NmtState) {
        self.state = state;
        self.is_enabled = false;
        self.is_ready = self.is_automatic && state == PreOperational2;
    }

    fn next(&mut self, cause: Cause) -> Option<NmtState> {
        let on = !matches!(self.state, Off);
        let polled = matches!(self.state, PreOperational2 | ReadyToOperate | Operational);
        match (cause, self.state) {
            (Cause::PowerOn, Off) => Some(Initialising),
            (Cause::LocalReset | Cause::SwReset, _) if on => Some(Initialising),
            (Cause::SwitchOff, _) if on => Some(Off),
            (Cause::ResetNode, _) if on => Some(ResetApplication),
            (Cause::ResetCommunication | Cause::InternalError, _) if on => Some(ResetCommunication),
            (Cause::ResetConfiguration, _) if on => Some(ResetConfiguration),
            (Cause::Soc | Cause::Soa, NotActive | BasicEthernet) => Some(PreOperational1),
            (Cause::Preq | Cause::Pres, NotActive | BasicEthernet) => Some(PreOperational1),
            (Cause::Soc, PreOperational1) => Some(PreOperational2),
            (Cause::BasicEthernetTimeout, NotActive) => Some(BasicEthernet),
            (Cause::EnableReadyToOperate, PreOperational2) => {
                self.is_enabled = true;
                self.is_ready.then_some(ReadyToOperate)
            }
            (Cause::ApplicationReady, PreOperational2) => {
                self.is_ready = true;
                self.is_enabled.then_some(ReadyToOperate)
            }
            (Cause::StartNode, ReadyToOperate) => Some(Operational),
            (Cause::StopNode, _) if polled => Some(Stopped),
            (Cause::EnterPreOperational2, Operational | Stopped) => Some(PreOperational2),
            _ => None,
        }
    }
}
