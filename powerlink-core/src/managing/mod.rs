//! A small managing node, for tests and demonstrations. **It is not a product**: it has never been near a certification, and
//! leaves out what a machine needs and a test does not.
//!
//! [`ManagingNode`] has a [`NodePlan`] for each node: who it must be, what is written to it, what its process data are. It boots
//! the network as the recorded managing nodes do:
//!
//! ```text
//! MN               Off -> NotActive -> PreOperational1 -> PreOperational2 -> ReadyToOperate -> Operational
//! on the wire             (listens)    SoA only           SoC, PReq, PRes, SoA
//!
//! each node        Absent -> Clearing -> Signalling -> Configuring -> Restarting -> Configured
//!                  IdentRequest  ER=1      ER=0          SDO       NMTResetConfiguration
//!                     ^                                              IdentRequest     |
//!                     | lost: NMTResetNode                                            v
//!                     +--------- Operational <- ReadyToOperate <- PreOperational2 <---+
//!                                     NMTStartNode   NMTEnableReadyToOperate
//! ```
//!
//! [`MN_EDGES`] and [`NODE_EDGES`] are the tables. A lost node is told NMTResetNode with the reason and brought back, while the
//! others go on.
//!
//! # The asynchronous slot
//!
//! Each cycle has one. NMT commands, NMT requests of nodes, StatusRequests, invitations, own SDO frames and IdentRequests take
//! turns, and so do the nodes for each of them.
//!
//! # Limits
//!
//! | left out | what happens |
//! |---|---|
//! | redundancy, AMNI | another managing node makes it listen until that one is quiet |
//! | an own PRes, cross traffic configuration | nodes may listen to one another by what the plan writes |
//! | the start-up options 0x1F80 | a mandatory node that is lost is restarted, and the network goes on |
//! | more than one SDO transfer at a time | nodes are configured one after another |
//! | configuration manager files, software check and update | the plan lists what is written |
//! | SDO over UDP and in PDOs, IP | not there |
//! | PRes chaining, several PReq in a cycle, several ASnd in a slot | not there |
//! | time of day | NetTime is 0 |
//! | statistics objects, an own object dictionary | [`MnCounters`] |

mod boot;
mod command;
mod config;
mod cycle;
mod error;
mod event;
#[cfg(feature = "serde")]
mod json;
mod machine;
mod receive;
mod schedule;
mod state;
mod station;
#[cfg(test)]
mod tests;
mod timing;
mod transfer;

pub use config::{Config, NodePlan, ObjectWrite};
pub use error::{ConfigError, Direction, MnError};
pub use event::{MnCounters, MnEvent};
pub use machine::ManagingNode;
pub use state::{Edge, MN_EDGES, MnCause, MnState, NODE_EDGES, NodeCause, NodePhase};
