//! What goes wrong, how it is counted, and how the managing node is told.
//!
//! [`ErrorCounters`] are the objects 0x1C0A to 0x1C10, [`Signalling`] the bits EN, EA, EC and ER and the errors in a
//! StatusResponse.

mod counter;
mod signalling;
mod symptom;

pub use counter::{ErrorCounter, ErrorCounters};
pub use signalling::Signalling;
pub use symptom::Symptom;
