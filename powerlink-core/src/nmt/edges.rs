//! The transition table.

use super::{Cause, Edge, NmtState};

/// Every transition. Debug builds check each step against it. What is not listed is ignored in that state, without any change.
///
/// | Name | From | Cause | To |
/// |---|---|---|---|
/// | GT1 | Off | power on | Initialising |
/// | GT2 | Initialising | local reset | Initialising |
/// | GT2 | ResetApplication | local reset | Initialising |
/// | GT2 | ResetCommunication | local reset | Initialising |
/// | GT2 | ResetConfiguration | local reset | Initialising |
/// | GT2 | NotActive | local reset | Initialising |
/// | GT2 | PreOperational1 | local reset | Initialising |
/// | GT2 | PreOperational2 | local reset | Initialising |
/// | GT2 | ReadyToOperate | local reset | Initialising |
/// | GT2 | Operational | local reset | Initialising |
/// | GT2 | Stopped | local reset | Initialising |
/// | GT2 | BasicEthernet | local reset | Initialising |
/// | GT3 | Initialising | switch off | Off |
/// | GT3 | ResetApplication | switch off | Off |
/// | GT3 | ResetCommunication | switch off | Off |
/// | GT3 | ResetConfiguration | switch off | Off |
/// | GT3 | NotActive | switch off | Off |
/// | GT3 | PreOperational1 | switch off | Off |
/// | GT3 | PreOperational2 | switch off | Off |
/// | GT3 | ReadyToOperate | switch off | Off |
/// | GT3 | Operational | switch off | Off |
/// | GT3 | Stopped | switch off | Off |
/// | GT3 | BasicEthernet | switch off | Off |
/// | GT4 | ResetCommunication | NMTResetNode | ResetApplication |
/// | GT4 | ResetConfiguration | NMTResetNode | ResetApplication |
/// | GT4 | NotActive | NMTResetNode | ResetApplication |
/// | GT4 | PreOperational1 | NMTResetNode | ResetApplication |
/// | GT4 | PreOperational2 | NMTResetNode | ResetApplication |
/// | GT4 | ReadyToOperate | NMTResetNode | ResetApplication |
/// | GT4 | Operational | NMTResetNode | ResetApplication |
/// | GT4 | Stopped | NMTResetNode | ResetApplication |
/// | GT4 | BasicEthernet | NMTResetNode | ResetApplication |
/// | GT5 | ResetConfiguration | NMTResetCommunication | ResetCommunication |
/// | GT5 | NotActive | NMTResetCommunication | ResetCommunication |
/// | GT5 | PreOperational1 | NMTResetCommunication | ResetCommunication |
/// | GT5 | PreOperational2 | NMTResetCommunication | ResetCommunication |
/// | GT5 | ReadyToOperate | NMTResetCommunication | ResetCommunication |
/// | GT5 | Operational | NMTResetCommunication | ResetCommunication |
/// | GT5 | Stopped | NMTResetCommunication | ResetCommunication |
/// | GT5 | BasicEthernet | NMTResetCommunication | ResetCommunication |
/// | GT6 | NotActive | internal communication error | ResetCommunication |
/// | GT6 | PreOperational1 | internal communication error | ResetCommunication |
/// | GT6 | PreOperational2 | internal communication error | ResetCommunication |
/// | GT6 | ReadyToOperate | internal communication error | ResetCommunication |
/// | GT6 | Operational | internal communication error | ResetCommunication |
/// | GT6 | Stopped | internal communication error | ResetCommunication |
/// | GT6 | BasicEthernet | internal communication error | ResetCommunication |
/// | GT7 | NotActive | NMTResetConfiguration | ResetConfiguration |
/// | GT7 | PreOperational1 | NMTResetConfiguration | ResetConfiguration |
/// | GT7 | PreOperational2 | NMTResetConfiguration | ResetConfiguration |
/// | GT7 | ReadyToOperate | NMTResetConfiguration | ResetConfiguration |
/// | GT7 | Operational | NMTResetConfiguration | ResetConfiguration |
/// | GT7 | Stopped | NMTResetConfiguration | ResetConfiguration |
/// | GT7 | BasicEthernet | NMTResetConfiguration | ResetConfiguration |
/// | GT8 | Initialising | NMTSwReset | Initialising |
/// | GT8 | ResetApplication | NMTSwReset | Initialising |
/// | GT8 | ResetCommunication | NMTSwReset | Initialising |
/// | GT8 | ResetConfiguration | NMTSwReset | Initialising |
/// | GT8 | NotActive | NMTSwReset | Initialising |
/// | GT8 | PreOperational1 | NMTSwReset | Initialising |
/// | GT8 | PreOperational2 | NMTSwReset | Initialising |
/// | GT8 | ReadyToOperate | NMTSwReset | Initialising |
/// | GT8 | Operational | NMTSwReset | Initialising |
/// | GT8 | Stopped | NMTSwReset | Initialising |
/// | GT8 | BasicEthernet | NMTSwReset | Initialising |
/// | GT10 | Initialising | done | ResetApplication |
/// | GT11 | ResetApplication | done | ResetCommunication |
/// | GT12 | ResetCommunication | done | ResetConfiguration |
/// | CT1 | ResetConfiguration | done | NotActive |
/// | CT2 | NotActive | SoA | PreOperational1 |
/// | CT2 | NotActive | SoC | PreOperational1 |
/// | CT2 | NotActive | PReq | PreOperational1 |
/// | CT2 | NotActive | PRes | PreOperational1 |
/// | CT3 | NotActive | basic Ethernet timeout | BasicEthernet |
/// | CT4 | PreOperational1 | SoC | PreOperational2 |
/// | CT5 | PreOperational2 | NMTEnableReadyToOperate | PreOperational2 |
/// | CT5 | PreOperational2 | application ready | PreOperational2 |
/// | CT6 | PreOperational2 | NMTEnableReadyToOperate | ReadyToOperate |
/// | CT6 | PreOperational2 | application ready | ReadyToOperate |
/// | CT7 | ReadyToOperate | NMTStartNode | Operational |
/// | CT8 | PreOperational2 | NMTStopNode | Stopped |
/// | CT8 | ReadyToOperate | NMTStopNode | Stopped |
/// | CT8 | Operational | NMTStopNode | Stopped |
/// | CT9 | Operational | NMTEnterPreOperational2 | PreOperational2 |
/// | CT10 | Stopped | NMTEnterPreOperational2 | PreOperational2 |
/// | CT11 | PreOperational2 | cycle error | PreOperational1 |
/// | CT11 | ReadyToOperate | cycle error | PreOperational1 |
/// | CT11 | Operational | cycle error | PreOperational1 |
/// | CT11 | Stopped | cycle error | PreOperational1 |
/// | CT12 | BasicEthernet | SoC | PreOperational1 |
/// | CT12 | BasicEthernet | PReq | PreOperational1 |
/// | CT12 | BasicEthernet | PRes | PreOperational1 |
/// | CT12 | BasicEthernet | SoA | PreOperational1 |
///
/// CT2 and CT12 consume their frame: a request in the very SoA is not answered, and the SoC of CT2 does not lead on by CT4.
/// CT2 by a PReq or PRes is a node's choice
/// ([`poll_ends_not_active`](crate::node::Options::poll_ends_not_active)): one that does not choose it tells the machine of none.
/// CT5 takes note of the first of two conditions, CT6 is the second. GT1, GT2 and GT8 begin the error signalling anew.
/// Sources: EPSG DS 301, the state machine of controlled nodes, as openPOWERLINK 2.7.2 (`nmtk.c`) has it.
pub const EDGES: &[Edge] = {
    use NmtState::*;
    &[
        edge("GT1", Off, Cause::PowerOn, Initialising),
        edge("GT2", Initialising, Cause::LocalReset, Initialising),
        edge("GT2", ResetApplication, Cause::LocalReset, Initialising),
        edge("GT2", ResetCommunication, Cause::LocalReset, Initialising),
        edge("GT2", ResetConfiguration, Cause::LocalReset, Initialising),
        edge("GT2", NotActive, Cause::LocalReset, Initialising),
        edge("GT2", PreOperational1, Cause::LocalReset, Initialising),
        edge("GT2", PreOperational2, Cause::LocalReset, Initialising),
        edge("GT2", ReadyToOperate, Cause::LocalReset, Initialising),
        edge("GT2", Operational, Cause::LocalReset, Initialising),
        edge("GT2", Stopped, Cause::LocalReset, Initialising),
        edge("GT2", BasicEthernet, Cause::LocalReset, Initialising),
        edge("GT3", Initialising, Cause::SwitchOff, Off),
        edge("GT3", ResetApplication, Cause::SwitchOff, Off),
        edge("GT3", ResetCommunication, Cause::SwitchOff, Off),
        edge("GT3", ResetConfiguration, Cause::SwitchOff, Off),
        edge("GT3", NotActive, Cause::SwitchOff, Off),
        edge("GT3", PreOperational1, Cause::SwitchOff, Off),
        edge("GT3", PreOperational2, Cause::SwitchOff, Off),
        edge("GT3", ReadyToOperate, Cause::SwitchOff, Off),
        edge("GT3", Operational, Cause::SwitchOff, Off),
        edge("GT3", Stopped, Cause::SwitchOff, Off),
        edge("GT3", BasicEthernet, Cause::SwitchOff, Off),
        edge("GT4", ResetCommunication, Cause::ResetNode, ResetApplication),
        edge("GT4", ResetConfiguration, Cause::ResetNode, ResetApplication),
        edge("GT4", NotActive, Cause::ResetNode, ResetApplication),
        edge("GT4", PreOperational1, Cause::ResetNode, ResetApplication),
        edge("GT4", PreOperational2, Cause::ResetNode, ResetApplication),
        edge("GT4", ReadyToOperate, Cause::ResetNode, ResetApplication),
        edge("GT4", Operational, Cause::ResetNode, ResetApplication),
        edge("GT4", Stopped, Cause::ResetNode, ResetApplication),
        edge("GT4", BasicEthernet, Cause::ResetNode, ResetApplication),
        edge("GT5", ResetConfiguration, Cause::ResetCommunication, ResetCommunication),
        edge("GT5", NotActive, Cause::ResetCommunication, ResetCommunication),
        edge("GT5", PreOperational1, Cause::ResetCommunication, ResetCommunication),
        edge("GT5", PreOperational2, Cause::ResetCommunication, ResetCommunication),
        edge("GT5", ReadyToOperate, Cause::ResetCommunication, ResetCommunication),
        edge("GT5", Operational, Cause::ResetCommunication, ResetCommunication),
        edge("GT5", Stopped, Cause::ResetCommunication, ResetCommunication),
        edge("GT5", BasicEthernet, Cause::ResetCommunication, ResetCommunication),
        edge("GT6", NotActive, Cause::InternalError, ResetCommunication),
        edge("GT6", PreOperational1, Cause::InternalError, ResetCommunication),
        edge("GT6", PreOperational2, Cause::InternalError, ResetCommunication),
        edge("GT6", ReadyToOperate, Cause::InternalError, ResetCommunication),
        edge("GT6", Operational, Cause::InternalError, ResetCommunication),
        edge("GT6", Stopped, Cause::InternalError, ResetCommunication),
        edge("GT6", BasicEthernet, Cause::InternalError, ResetCommunication),
        edge("GT7", NotActive, Cause::ResetConfiguration, ResetConfiguration),
        edge("GT7", PreOperational1, Cause::ResetConfiguration, ResetConfiguration),
        edge("GT7", PreOperational2, Cause::ResetConfiguration, ResetConfiguration),
        edge("GT7", ReadyToOperate, Cause::ResetConfiguration, ResetConfiguration),
        edge("GT7", Operational, Cause::ResetConfiguration, ResetConfiguration),
        edge("GT7", Stopped, Cause::ResetConfiguration, ResetConfiguration),
        edge("GT7", BasicEthernet, Cause::ResetConfiguration, ResetConfiguration),
        edge("GT8", Initialising, Cause::SwReset, Initialising),
        edge("GT8", ResetApplication, Cause::SwReset, Initialising),
        edge("GT8", ResetCommunication, Cause::SwReset, Initialising),
        edge("GT8", ResetConfiguration, Cause::SwReset, Initialising),
        edge("GT8", NotActive, Cause::SwReset, Initialising),
        edge("GT8", PreOperational1, Cause::SwReset, Initialising),
        edge("GT8", PreOperational2, Cause::SwReset, Initialising),
        edge("GT8", ReadyToOperate, Cause::SwReset, Initialising),
        edge("GT8", Operational, Cause::SwReset, Initialising),
        edge("GT8", Stopped, Cause::SwReset, Initialising),
        edge("GT8", BasicEthernet, Cause::SwReset, Initialising),
        edge("GT10", Initialising, Cause::Done, ResetApplication),
        edge("GT11", ResetApplication, Cause::Done, ResetCommunication),
        edge("GT12", ResetCommunication, Cause::Done, ResetConfiguration),
        edge("CT1", ResetConfiguration, Cause::Done, NotActive),
        edge("CT2", NotActive, Cause::Soa, PreOperational1),
        edge("CT2", NotActive, Cause::Soc, PreOperational1),
        edge("CT2", NotActive, Cause::Preq, PreOperational1),
        edge("CT2", NotActive, Cause::Pres, PreOperational1),
        edge("CT3", NotActive, Cause::BasicEthernetTimeout, BasicEthernet),
        edge("CT4", PreOperational1, Cause::Soc, PreOperational2),
        edge("CT5", PreOperational2, Cause::EnableReadyToOperate, PreOperational2),
        edge("CT5", PreOperational2, Cause::ApplicationReady, PreOperational2),
        edge("CT6", PreOperational2, Cause::EnableReadyToOperate, ReadyToOperate),
        edge("CT6", PreOperational2, Cause::ApplicationReady, ReadyToOperate),
        edge("CT7", ReadyToOperate, Cause::StartNode, Operational),
        edge("CT8", PreOperational2, Cause::StopNode, Stopped),
        edge("CT8", ReadyToOperate, Cause::StopNode, Stopped),
        edge("CT8", Operational, Cause::StopNode, Stopped),
        edge("CT9", Operational, Cause::EnterPreOperational2, PreOperational2),
        edge("CT10", Stopped, Cause::EnterPreOperational2, PreOperational2),
        edge("CT11", PreOperational2, Cause::CycleError, PreOperational1),
        edge("CT11", ReadyToOperate, Cause::CycleError, PreOperational1),
        edge("CT11", Operational, Cause::CycleError, PreOperational1),
        edge("CT11", Stopped, Cause::CycleError, PreOperational1),
        edge("CT12", BasicEthernet, Cause::Soc, PreOperational1),
        edge("CT12", BasicEthernet, Cause::Preq, PreOperational1),
        edge("CT12", BasicEthernet, Cause::Pres, PreOperational1),
        edge("CT12", BasicEthernet, Cause::Soa, PreOperational1),
    ]
};

const fn edge(name: &'static str, from: NmtState, cause: Cause, to: NmtState) -> Edge {
    Edge { name, from, cause, to }
}
