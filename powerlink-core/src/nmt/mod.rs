//! NMT, network management: the life of a controlled node.
//!
//! ```text
//!              GT1, GT2, GT8
//! Off ----> Initialising --GT10--> ResetApplication --GT11--> ResetCommunication --GT12--> ResetConfiguration
//!                                        ^ GT4                      ^ GT5, GT6                   ^ GT7  |
//!                                        +------- NMT resets from every state below -------------+      | CT1
//!                                                                                                       v
//!  BasicEthernet <---- CT3: nobody is heard ------------------------------------------------------- NotActive
//!       |                                                                                               |
//!       +--- CT12: a POWERLINK frame ---> PreOperational1 <----------- CT2: SoA or SoC -----------------+
//!                                           |         ^
//!                                  CT4: SoC v         | CT11: an error threshold, from each state below
//!                                         PreOperational2 <--------- CT10 ----------+
//!                                           |         ^                             |
//!             CT6: enabled, and the         v         | CT9                         |
//!             application is ready  ReadyToOperate    |         CT8               Stopped
//!                                           |         |   from PreOperational2,     ^
//!                              CT7: start   v         |   ReadyToOperate and        |
//!                                         Operational-+-- Operational --------------+
//! ```
//!
//! [`Nmt`] is the machine, [`EDGES`] its table. A controlled node leaves the initialisation by itself, and everything else
//! because of what the managing node sends or fails to send.

mod edges;
mod machine;
mod state;
#[cfg(test)]
mod tests;

pub use edges::EDGES;
pub use machine::Nmt;
pub use state::{Cause, Edge, NmtState};
