//! The cycle of a controlled node (DLL_CS): what must come when, and what did not.
//!
//! ```text
//!            SoC             PReq            SoA
//! WaitSoc --------> WaitPreq ------> WaitSoa ------> WaitSoc
//!                      |                                ^
//!                      +------------- SoA --------------+
//!                            LOSS_PREQ if one was due
//! ```
//!
//! A stopped node is not polled: from SoC it goes to `WaitSoa`. [`CYCLE_EDGES`] has every transition with what it finds
//! missing; [`error`](crate::error) counts it.

mod edges;
mod machine;
mod state;
#[cfg(test)]
mod tests;

pub use edges::CYCLE_EDGES;
pub use machine::{Cycle, PollWithoutSoc, Supervision};
pub use state::{CycleEdge, CycleEvent, CycleMode, CycleState, Losses};
