//! The master: a scanner that brings its slaves up, exchanges I/O data with them, and brings them back when they were
//! lost.
//!
//! [`Master`] is one machine for a whole network: network access, up to 63 slaves, the scan, and an explicit client. Its
//! scan list is made of [`ScanEntry`]s.
//!
//! # A slave is polled
//!
//! A scan list of one slave, and a bus that is played by hand: the slave answers each request as its device would.
//!
//! ```
//! use cip_core::code::DeviceType;
//! use cip_core::identity::{DeviceIdentity, ProductName, Revision};
//! use devicenet_core::master::{Config, ElectronicKey, IoInstance, Master, PollConnection, ScanEntry};
//! use devicenet_core::{Identifier, MacId};
//! use link_core::{Action, Input, Instant, LinkEvent, Machine, TxOutcome};
//!
//! // A fictitious vendor: the identity is never defaulted.
//! let device = DeviceIdentity {
//!     vendor: 0x1234.into(),
//!     device_type: DeviceType::COMMUNICATIONS_ADAPTER,
//!     product_code: 1,
//!     revision: Revision { major: 1, minor: 1 },
//!     serial: 0x0000_2345,
//!     name: ProductName::new("Example Master").expect("fourteen characters"),
//! };
//! // Up to eight slaves, and messages of up to 64 bytes.
//! let mut master = Master::<8, 64>::new(Config::new(device, MacId::try_from(4)?));
//!
//! let slave = MacId::try_from(63)?;
//! master.add_slave(Instant::ZERO, ScanEntry {
//!     key: ElectronicKey { vendor: Some(0x03E7.into()), ..ElectronicKey::default() },
//!     poll: Some(PollConnection { produce: 2, consume: 1, expected_packet_rate: 75 }),
//!     ..ScanEntry::explicit_only(slave)
//! })?;
//! master.set_run(true);
//! master.set_output(slave, &[0x03])?;
//!
//! /// What the slave says to a request of the master.
//! fn answer(data: &[u8]) -> Option<Vec<u8>> {
//!     let value: &[u8] = match *data.get(1..)? {
//!         [0x4B, ..] => &[0],                       // Allocate: the body format
//!         [0x0E, 1, 1, 1] => &[0xE7, 0x03],         // its vendor
//!         [0x0E, 1, 1, _] => &[1, 0],               // device type, product code
//!         [0x0E, 5, 2, 7] => &[2, 0],               // it produces two bytes
//!         [0x0E, 5, 2, 8] => &[1, 0],               // and consumes one
//!         [0x10, 5, 2, 9, ..] => &[80, 0],          // expected packet rate: 80 ms will do
//!         _ => &[],
//!     };
//!     Some([&[data[0], data[1] | 0x80], value].concat())
//! }
//!
//! let mut now = Instant::ZERO;
//! let mut commands = Vec::new();
//! let mut inputs = vec![Input::Link(LinkEvent::Up)];
//! while master.input_data(slave, IoInstance::Poll).is_none() {
//!     let input = if inputs.is_empty() { Input::Tick } else { inputs.remove(0) };
//!     for action in master.handle(now, input) {
//!         let Action::Transmit(token, frame) = action else { continue };
//!         inputs.push(Input::TxDone(token, TxOutcome::Sent));
//!         let id = Identifier::of_frame(&frame);
//!         if id == Some(Identifier::poll_command(slave)) {
//!             commands.push(frame.data().to_vec());
//!             inputs.extend(Identifier::poll_response(slave).frame(&[0x34, 0x12]).map(Input::Frame));
//!         } else if id != Some(Identifier::duplicate_mac_check(MacId::try_from(4)?)) {
//!             let response = answer(frame.data()).and_then(|data| Identifier::explicit_response(slave).frame(&data));
//!             inputs.extend(response.map(Input::Frame));
//!         }
//!     }
//!     if inputs.is_empty() {
//!         now = master.deadline().map_or(now, |deadline| deadline.at);
//!     }
//! }
//! assert_eq!(commands, [[0x03]]);
//! assert_eq!(master.input_data(slave, IoInstance::Poll), Some(&[0x34, 0x12][..]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What it keeps to
//!
//! | Rule | How |
//! |---|---|
//! | no outputs to a device that the key does not match, or that does not run | they are taken back from the controller if they wait there when the slave is lost |
//! | no input data of a slave that does not run | [`Master::input_data`] is `None`, late frames are counted |
//! | a message is sent and received whole or not at all | data that change meanwhile go with the next message |
//! | few frames in flight | those of the node that it is, and one of each lane: answers, scan, explicit |
//! | an attempt that failed is repeated | after pauses that double, up to [`Config::retry_at_most`] |
//!
//! The states of a slave and what leads from one to the next are the table [`EDGES`]; what a slave and the scanner itself
//! show are [`ScannerStatus`] codes.
//!
//! | File | Subject |
//! |---|---|
//! | `door`, `contact`, `bring_up` | from the first contact to established connections |
//! | `board`, `slot`, `presence` | what is kept of each slave, and known of all |
//! | `cycle`, `scan` | the scan: which command comes next, and when |
//! | `lanes`, `output`, `sent` | the order in which frames leave, and what became of them |
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
//! | a slave restarts while it is contacted | the attempt ends with its check, and the next begins a second later |
//! | a slave restarts while it is configured | the attempt ends when nobody objects to its check for a second, and the next begins |
//! | a slave restarts while it runs | it falls silent and is lost after four expected packet rates; or, if they are long or 0, when nobody objects to its check for a second |
//! | a check of a slave is heard while the master waits for it | it is contacted a second later, and pauses begin small again |
//! | a slave answers the Allocate of another master with success | it is given up at once, and asked for again after pauses |
//! | two masters ask one slave in the same bit | each takes its request back and asks 10 to 640 ms later, by its MAC ID |
//! | somebody else polls a slave that runs | the slave is asked, by an Allocate, whose it is |
//! | a slave does not know attributes 7 and 8 | it is believed to have the sizes of the scan list; a wrong length shows at run time |
//! | a slave answers the packet rate with 0, or without a value | the rate of the scan list is supervised |
//! | a command was given back unsent by the controller | it is not repeated; the next scan has the next. Output data outside of the scan are, 10 ms later |
//! | new output data while a fragmented message is sent | they go with the next message: none is torn |
//! | one of a slave's connections has wrong or idle data, others are well | the slave's status is that of the first that is not |
//! | a slave times out | it is contacted at once, then after pauses that double |
//! | the master was restarted and finds its own old connections | it releases them, and allocates again |
//! | a request of the application is not answered | the connection is made anew; the request is repeated if the connection was gone, or if it may be tried more than once |
//! | a tool gives the master the MAC ID of one of its slaves | that slave stays off line, with status 71 |

mod board;
mod bring_up;
mod command;
mod config;
mod contact;
mod cycle;
mod device;
mod difference;
mod door;
mod event;
mod lanes;
mod machine;
mod node;
mod output;
mod presence;
mod receive;
mod replacement;
mod scan;
mod scan_list;
mod sent;
mod set;
mod slot;
mod state;
mod status;
mod talk;
#[cfg(test)]
mod tests;
mod writes;

pub use command::CommandError;
pub use config::{Config, FirstContact};
pub use device::ConnectionError;
pub use difference::{Difference, Property};
pub use event::{Counters, MasterEvent, SlaveCounters, SlaveEvent};
pub use machine::Master;
pub use replacement::{Replacement, ReplacementMode};
pub use scan_list::{
    BitStrobeConnection, ChangeOfStateConnection, ElectronicKey, IoInstance, PollConnection, ScanEntry,
    ScanListError, ScanRate,
};
pub use state::{Cause, EDGES, Edge, SlaveState};
pub use status::ScannerStatus;
pub use writes::AttributeWrite;
