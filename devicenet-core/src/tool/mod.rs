//! The offline recovery tool: it finds nodes that are silent because of a duplicate MAC ID, and gives them another one.
//!
//! Such nodes hear one identifier only, that of the offline connection set, which one tool owns at a time:
//!
//! ```text
//! 7EF: 05 4B ..    ownership?          1 s, nobody answers
//! 7EF: 05 4B ..    ownership?          1 s, nobody answers: the set is ours
//! 7ED: 3F 4B 03    Who?                every faulted node answers, each after a delay of its own
//! 7EC: 00 .. ..    its vendor and serial number
//! 7ED: 0A 4D ..    Change_MAC_ID to 10 for that vendor and serial number
//! 457: 00 .. ..    the node checks MAC ID 10, twice, and is on line
//! ```
//!
//! [`OfflineTool`] is that sequence as a machine, one step at a time, each begun by a command and ended by an event. It is
//! a node itself and has to be on line.
//!
//! # Decisions where the literature is silent
//!
//! | Situation | What happens |
//! |---|---|
//! | two tools claim at once | whose first request was on the bus first defends it; the other gives way |
//! | two tools send at the very same moment | their frames destroy each other: each takes its own back and waits, by its serial number |
//! | the owner hears an ownership response | somebody else owns the set too: the tool gives it up |
//! | the owner vanishes | there is nothing to notice: the next claim is not answered |
//! | a device was given a MAC ID that another node has | the other objects, the device is faulted again: [`Refusal::Taken`] |

mod command;
mod config;
mod event;
mod machine;
mod state;
#[cfg(test)]
mod tests;

pub use command::CommandError;
pub use config::Config;
pub use event::{Counters, Refusal, ToolEvent};
pub use machine::OfflineTool;
pub use state::{Cause, EDGES, Edge, ToolState};
