//! Network access: finding the bit rate, saying Hello, getting an address, and keeping it.
//!
//! A device listens until it knows the bit rate, says Hello twice without an address, and stands by. A network manager
//! finds it, and gives it an address by ROAM; it says Hello twice more, with that address, and is on line **\[P\]**. Whoever
//! has the address already answers, and the newcomer starts anew without one: nobody is ever sent off the bus for it.
//!
//! ```text
//! listen only    bit rate found          DetectingBitRate -> Hello1
//! t = 0 s        Hello, OA 127           wait 1 s
//! t = 1 s        Hello, OA 127           Hello1 -> Hello2, wait 1 s
//! t = 2 s                                Hello2 -> Standby
//! ...            ROAM to OA 67           Standby -> Hello1
//! t = 0 s        Hello, OA 67            wait 1 s
//! t = 1 s        Hello, OA 67            Hello1 -> Hello2, wait 1 s
//! t = 2 s                                Hello2 -> Online
//! ```
//!
//! The waits begin when the controller reports that the Hello was *on the bus*. Nothing is sent at a bit rate that was not
//! confirmed: by valid frames for a device, by its owner for a network manager.
//!
//! [`Access`] is that machine, for devices, network managers and everything else with an address. It is a
//! [`Machine`](link_core::Machine) of its own and part of larger ones. What it may do from one state to the next is the
//! table [`EDGES`]; [`Config`] has all times and choices.
//!
//! # Decisions where the paper is silent
//!
//! | Situation | What happens |
//! |---|---|
//! | two nodes join with one address | the one with the lower identity (vendor, product, revision, serial number) keeps it, and says Hello once more; the other starts anew without one |
//! | a node on line hears a Hello response with its address | it starts anew without one: two segments were joined |
//! | segments are joined, and all are silent | a node on line tells its address from time to time by a Hello response ([`Config::announcement`]) |
//! | a Hello with the own address and the own identity | counted and told, nothing else: an echo, or a cloned serial number |
//! | a Mini-who or ROAM while the device still says Hello | discarded, refused: it asks again; [`Config::early_roam`] |
//! | several Mini-whos, or Hello requests, before the answer was handed to the controller | one answer serves all |
//! | bus-off | off the bus until a reset; with BOI once back, bit rate detection included |
//! | the link goes down and up again | bit rate detection, then Hello with the old address ([`Config::keep_address`]) |
//! | the bit rate cannot be set | the node is faulted, or takes the rate of the link: [`ModeRefused`] |
//! | a frame and the end of a wait at the same moment | the frame counts first; a wait that ended before it counts before it |

mod command;
mod config;
mod event;
mod input;
mod machine;
mod output;
mod state;
#[cfg(test)]
mod tests;

pub use config::{Config, ModeRefused, Role};
pub use event::{AccessEvent, Counters, Outgoing, RoamRefusal};
pub use machine::Access;
pub use state::{Cause, EDGES, Edge, Fault, HelloNumber, HelloStage, Restart, State, StateKind};
