//! A controlled node: the machine that joins all parts.
//!
//! [`ControlledNode`] is started by [`power_on`](ControlledNode::power_on), goes through its initialisation, and listens. All
//! else is the managing node's doing: it identifies the node, reads and writes its objects, polls it, and starts it.
//! [`Config`] says who the node is, [`Options`] what the node does where the protocol leaves a choice; the objects of the
//! application are an [`ObjectSet`](crate::dictionary::ObjectSet).
//!
//! # Process data
//!
//! Inputs are taken from the objects at each SoC, so that the PRes is ready when the PReq comes. Outputs are given to the
//! objects at the PReq, and told as [`NodeEvent::ProcessData`]. In `PreOperational2` they are ignored; in `ReadyToOperate` they
//! are taken and told as not valid; in `Operational` they count if the managing node says so (RD).
//!
//! # Order
//!
//! `poll` hands out answers before all else. What a PReq leads to, such as a cycle error, comes after its PRes.

mod asynchronous;
mod command;
mod config;
mod event;
#[cfg(feature = "serde")]
mod json;
mod machine;
mod output;
mod poll;
mod receive;
mod supervision;
#[cfg(test)]
mod tests;

pub use command::NodeError;
pub use config::{Config, ConfigError, DefaultMapping, Options, Readiness, VersionCheck};
pub use event::{NodeCounters, NodeEvent};
pub use machine::ControlledNode;
