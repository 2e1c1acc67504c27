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
//! # The set is claimed
//!
//! The bus is played by hand: other nodes acknowledge each frame, and no other tool is there.
//!
//! ```
//! use devicenet_core::message::{DelayOffset, DeviceIdentity, PortNumber};
//! use devicenet_core::tool::{Config, OfflineTool, ToolState};
//! use devicenet_core::{MacId, access};
//! use link_core::{Action, Input, Instant, LinkEvent, Machine, TxOutcome};
//!
//! let device = DeviceIdentity { vendor: 0x1234.into(), serial: 0x0000_2345 };
//! let mut tool = OfflineTool::new(Config::new(access::Config::new(device, PortNumber::ZERO, MacId::try_from(5)?)));
//!
//! let mut now = Instant::ZERO;
//! let mut trace = Vec::new();
//! let mut inputs = vec![Input::Link(LinkEvent::Up)];
//! while now <= Instant::from_millis(4000) {
//!     let input = inputs.pop().unwrap_or(Input::Tick);
//!     tool.input(now, input);
//!     match (tool.access().is_online(), tool.state()) {
//!         (true, ToolState::Idle) => tool.claim(now)?,
//!         // Refused while the last question waits for answers.
//!         (_, ToolState::Owner) => _ = tool.who(now, DelayOffset::SERIAL),
//!         _ => {}
//!     }
//!     while let Some(action) = tool.poll(now) {
//!         if let Action::Transmit(token, frame) = action {
//!             trace.push(format!("{now:.1} {frame}"));
//!             inputs.push(Input::TxDone(token, TxOutcome::Sent));
//!         }
//!     }
//!     if inputs.is_empty() {
//!         now = tool.deadline().map_or(Instant::MAX, |deadline| deadline.at);
//!     }
//! }
//! assert_eq!(trace[2..], [
//!     "2.0 7EF [8] 05 4B 34 12 45 23 00 00",
//!     "3.0 7EF [8] 05 4B 34 12 45 23 00 00",
//!     "4.0 7ED [3] 3F 4B 03",
//! ]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Decisions where the literature is silent
//!
//! | Situation | What happens |
//! |---|---|
//! | two tools claim at once | whose first request was on the bus first defends it; the other gives way |
//! | two tools send at the very same moment | their frames destroy each other: each takes its own back and waits 10 to 640 ms, by its MAC ID |
//! | the owner hears an ownership response | somebody else owns the set too: the tool gives it up |
//! | a message is given back unsent by the controller | it is sent again 100 ms later: a claim needs two requests on the bus |
//! | the owner vanishes | there is nothing to notice: the next claim is not answered |
//! | a device was given a MAC ID that another node has | the other objects, the device is faulted again: [`Refusal::Taken`] |

mod command;
mod config;
mod event;
mod input;
mod machine;
mod output;
mod state;
#[cfg(test)]
mod tests;

pub use command::CommandError;
pub use config::Config;
pub use event::{Counters, Refusal, ToolEvent};
pub use machine::OfflineTool;
pub use state::{Cause, EDGES, Edge, ToolState};
