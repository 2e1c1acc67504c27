//! The master: a scanner that brings its slaves up, exchanges I/O data with them, and brings them back when they were
//! lost.
//!
//! [`Master`] is one machine for a whole network: network access, up to 63 slaves, the scan, and an explicit client. Its
//! scan list is made of [`ScanEntry`]s.
//!
//! | File | Subject |
//! |---|---|
//! | `contact`, `bring_up` | from the first contact to established connections |
//! | `cycle`, `output` | the scan, and the order in which frames leave |
//! | `receive` | I/O data, responses, heartbeats |
//! | `replacement` | automatic device replacement |
//! | `node` | the master as a node of its own |
//! | `talk` | explicit requests of the application |
//!
//! # Decisions where the literature is silent
//!
//! | Situation | What happens |
//! |---|---|
//! | both doors are open: unconnected port and UCMM | the unconnected port is used ([`FirstContact`]) |
//! | a slave restarts while it runs | it falls silent and is lost after four expected packet rates; its check, heard while the master waits for it, ends the back-off |
//! | a slave does not know attributes 7 and 8 | it is believed to have the sizes of the scan list; a wrong length shows at run time |
//! | a command was given back unsent by the controller | it is not repeated; the next scan has the next |
//! | new output data while a fragmented message is sent | they go with the next message: none is torn |
//! | a slave times out | it is contacted at once, then after pauses that double |
//! | the master was restarted and finds its own old connections | it releases them, and allocates again |

mod bring_up;
mod command;
mod config;
mod contact;
mod cycle;
mod event;
mod machine;
mod node;
mod output;
mod receive;
mod replacement;
mod scan_list;
mod slot;
mod state;
mod status;
mod talk;
#[cfg(test)]
mod tests;
mod writes;

pub use command::CommandError;
pub use config::{Config, FirstContact};
pub use event::{Counters, MasterEvent, SlaveCounters, SlaveEvent};
pub use machine::Master;
pub use replacement::{Replacement, ReplacementMode};
pub use scan_list::{
    BitStrobeConnection, ElectronicKey, IoInstance, PollConnection, ScanEntry, ScanListError, ScanRate,
    StateChangeConnection,
};
pub use state::{Cause, EDGES, Edge, SlaveState};
pub use status::ScannerStatus;
pub use writes::AttributeWrite;
