//! Network access: getting on line with a MAC ID that nobody else uses, and staying there.
//!
//! A node sends a duplicate MAC ID check request, waits one second, sends a second one, waits another second, and is on
//! line. Whoever is on line already answers such a request for its own MAC ID, and the newcomer falls silent, for good:
//! out of a communication fault leads only a reset, a power cycle, or a new MAC ID given by a tool through the offline
//! connection set.
//!
//! ```text
//! t = 0 s   first request on the bus     SendingDupMac -> WaitingDupMac
//! t = 1 s   second request               WaitingDupMac -> SendingDupMac -> WaitingDupMac
//! t = 2 s                                WaitingDupMac -> OnLine
//! ```
//!
//! The waits begin when the controller reports that the request was *on the bus*. A node that is alone is never
//! acknowledged, so its controller repeats the first request for ever, and it does not get on line before another node
//! appears.
//!
//! [`Access`] is that machine, for slaves, masters, tools and everything else with a MAC ID. It is a
//! [`Machine`](link_core::Machine) of its own and part of larger ones. What it may do from one state to the next is the
//! table [`EDGES`]; [`Config`] has the choices that the literature leaves open.
//!
//! # Decisions where the literature is silent
//!
//! | Situation | What happens |
//! |---|---|
//! | a request arrives while the answer to an earlier one has not been handed to the controller | one answer serves both: a broadcast on the same identifier; counted in [`Counters::requests_merged`] |
//! | a request arrives while an answer is on its way | one more answer follows: the first may have been sent already |
//! | Quick Connect: a foreign request is to be answered when the own second request is due | the answer goes first |
//! | the controller reports a request as sent after its withdrawal was asked for | it changes nothing: the node has left that state |
//! | a request, or a response of a node on line, is given back unsent although nobody withdrew it | it is handed out again after the bus-off back-off, or as soon as the link is up or its mode is set |
//! | the link comes up twice | the second time changes nothing, unless a restart of the controller is being waited for |
//! | bus-off while faulted by a duplicate | the node stays faulted, and no longer hears the offline connection set |
//! | a frame is delivered although the controller is off the bus | it is discarded: it was received before, and the check begins anew anyhow |
//! | a restart of the controller is refused | the node is faulted by bus-off |
//! | the filter is refused | an event; frames are sorted by their identifier anyhow |
//! | a frame and the end of a wait at the same moment | the frame counts first; a wait that ended before it counts before it |

mod command;
mod config;
mod event;
mod extent;
mod indicator;
mod input;
mod machine;
mod offline;
mod output;
mod pending;
mod state;
#[cfg(test)]
mod tests;

pub use command::CommandError;
pub use config::{BusOffWhileChecking, Config, CounterSetMode, MacIdSource, MaskPredicate};
pub use event::{AccessEvent, Counters, Outgoing};
pub(crate) use extent::Extent;
pub use indicator::NetworkStatus;
pub use machine::Access;
pub use state::{
    Cause, CheckRequest, EDGES, Edge, Fault, OfflineNode, SecondRequest, SendStage, State, StateKind,
};
