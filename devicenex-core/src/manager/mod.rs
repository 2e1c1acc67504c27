//! The network manager: it finds devices, gives them addresses, makes their connections, and replaces what is lost.
//!
//! [`Manager`] is one machine for a whole network (paper section 5): a node of its own with an address that it was given
//! beforehand, and a database of [`PlannedDevice`]s: who shall be where, with which connections, and who may stand in.
//!
//! ```text
//! t = 0 s     Mini-who                                   who has no address?
//!             Hello, OA 127                     <---     I, and this is who I am
//!             ROAM to OA 67                     --->     you are 67
//! t = 0 s     Hello, OA 67                      <---     and once more a second later
//! t = 2 s     Connection request, instance 7    --->     the producers first,
//!             Connection response               <---
//!             Connection request, instance 13   --->     then those that consume,
//!             Set_Attribute_Single              --->     each told the producer's connection ID
//!             ...                                        data are heard, states are asked for
//! ```
//!
//! All devices are brought up at once, each as far as it is; what is known of one is its [`DeviceState`], and what leads from
//! one to the next the table [`EDGES`]. Every step is a [`ManagerEvent`].
//!
//! # A device gets its address and a connection
//!
//! The bus is played by hand: a device stands by, and answers as it would.
//!
//! ```
//! use cip_core::code::{DeviceType, VendorId};
//! use cip_core::identity::{DeviceIdentity, ProductName, Revision};
//! use devicenex_core::OperationalAddress;
//! use devicenex_core::id::Direction;
//! use devicenex_core::manager::{Config, IdentityPattern, Manager, ManagerEvent, PlannedConnection, PlannedDevice};
//! use devicenex_core::message::{self, Hello, MiniWho, PortByte, Roam};
//! use link_core::{Action, BitRate, ExtendedId, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, TxOutcome};
//!
//! // A fictitious vendor. Use the one that ODVA assigned to you.
//! let own = DeviceIdentity {
//!     vendor: VendorId(0x03E7),
//!     device_type: DeviceType::COMMUNICATIONS_ADAPTER,
//!     product_code: 1,
//!     revision: Revision::new(1, 1).ok_or("revision")?,
//!     serial: 0x2345,
//!     name: ProductName::new("Example Manager").ok_or("name")?,
//! };
//! let address = OperationalAddress::try_from(67)?;
//! let config = Config::new(own, OperationalAddress::try_from(1)?, BitRate::K500);
//! // Up to eight devices, each with up to four connections.
//! let mut manager = Manager::<8, 4>::new(config);
//!
//! // Address 67 is for any device of that product; it produces every 100 ms, to whoever consumes.
//! let device = message::DeviceIdentity { vendor: VendorId(0x03E7), product_code: 42, major_revision: 1, serial: 7 };
//! let mut plan = PlannedDevice::new(address, IdentityPattern::product_of(device));
//! plan.connections.push(PlannedConnection::producer(100)).map_err(|_| "room for four")?;
//! manager.add_device(Instant::ZERO, plan)?;
//!
//! let mut now = Instant::ZERO;
//! let mut said = Vec::new();
//! let mut inputs = vec![Input::Link(LinkEvent::Up)];
//! let hello = |source| Hello { source, direction: Direction::Request, device, port: PortByte::ZERO }.frame();
//! while !said.iter().any(|line: &String| line.ends_with("-> Running: connected")) {
//!     let input = if inputs.is_empty() { Input::Tick } else { inputs.remove(0) };
//!     for action in manager.handle(now, input) {
//!         match action {
//!             Action::Transmit(token, frame) => {
//!                 inputs.push(Input::TxDone(token, TxOutcome::Sent));
//!                 // The device.
//!                 if MiniWho::of_frame(&frame).is_some() {
//!                     inputs.extend(hello(OperationalAddress::NONE).map(Input::Frame));
//!                 } else if Roam::of_frame(&frame).is_some() {
//!                     inputs.extend(hello(address).map(Input::Frame));
//!                 } else if frame.data().starts_with(&[0x4B, 0xC0, 0x07]) {
//!                     let response = ExtendedId::new(0x1D03_8601).ok_or("29 bits")?;
//!                     inputs.extend(Frame::new(response, &[0x4B, 0xC0, 0, 100, 0]).map(Input::Frame));
//!                 }
//!             }
//!             Action::Link(LinkCommand::SetMode(mode)) => inputs.push(Input::Link(LinkEvent::ModeSet(mode))),
//!             Action::Event(ManagerEvent::Planned(address, event)) => said.push(format!("{now:.1} {address} {event}")),
//!             Action::Event(_) | Action::Link(_) | Action::Withdraw(_) => {}
//!         }
//!     }
//!     if inputs.is_empty() {
//!         now = manager.deadline().map_or(now, |deadline| deadline.at);
//!     }
//! }
//! assert_eq!(said, [
//!     "2.0 67 Idle -> Probing: started",
//!     "2.5 67 Probing -> Missing: no response",
//!     "2.5 67 Missing -> Found: Hello without address",
//!     "2.5 67 found: vendor 999, product 42, revision 1, serial 0x00000007",
//!     "2.5 67 Found -> Assigned: ROAM sent",
//!     "2.5 67 Assigned -> Joining: Hello request",
//!     "4.5 67 Joining -> Connecting: wait over",
//!     "4.5 67 on line: vendor 999, product 42, revision 1, serial 0x00000007",
//!     "4.5 67 connection 7 established, 100 ms, produces on 00860007",
//!     "4.5 67 Connecting -> Running: connected",
//! ]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What it keeps to
//!
//! | Rule | How |
//! |---|---|
//! | it sets the bit rate, and says Hello twice **\[P\]** | it is a [`Device`](crate::device::Device) in the role of a network manager, and answers about itself like any |
//! | Mini-who as long as a device is missing **\[P\]** | every [`mini_who_interval`](Config::mini_who_interval), and at once when one is lost |
//! | a device that obeys no ROAM yet gets none **\[D\]** | one that answers a Mini-who stands by; one that joins is waited for |
//! | one unanswered request is no loss **\[D\]** | [`connect_tries`](Config::connect_tries), then a spare is looked for |
//! | a network that runs is not disturbed **\[D\]** | whoever has a planned address is asked who it is, its connections are read, and made only where they are not as planned |
//! | consumers with an EPR of 0 are not touched when their producer is replaced **\[P\]** | the spare produces with the address of the lost device, so with the same connection ID; if that differs, they are told |
//! | one manager works **\[D\]** | whoever sees the Mini-who or ROAM of another before it has sent its own leaves the work; of two that work the one with the lower half serial number goes on; when the other works again says [`takeover_after`](Config::takeover_after) |
//! | few frames in flight **\[D\]** | one of addresses, one request, and those of its own node |
//!
//! What a device produces by itself is heard, and missed after four packet rates; every other connection is asked for its state,
//! one each [`poll_interval`](Config::poll_interval) **\[D\]**. After that follow a time-out, [`DeviceState::Retrying`], and
//! [`DeviceState::Lost`].
//!
//! | File | Subject |
//! |---|---|
//! | `database`, `config` | what it is told |
//! | `discover`, `address`, `standing` | Hellos, Mini-whos, ROAMs: who is there, and who gets which address |
//! | `connect`, `answer`, `adopt`, `watch` | connections: made, found and compared with the plan, and what becomes of them |
//! | `talk` | requests of the application, planned reads, new addresses for devices that have one |
//! | `machine`, `timer`, `slot`, `made`, `lanes`, `output` | what is kept of each device and connection, and the order in which frames leave |
//! | `node`, `rejoin` | the manager as a node of its own; what it does when another has its address |
//!
//! # Decisions where the paper is silent
//!
//! | Situation | What happens |
//! |---|---|
//! | the manager begins, and devices run already | each planned address is asked for its identity without a connection; only those that nobody answers for are looked for |
//! | a dynamic connection after a restart of the manager | its number is not known any more: those of the device are listed, and the one that is as planned is taken; another one is made only if there is none |
//! | a connection that is there already differs from the plan | told, and what can be set is set; a dynamic one whose producer or trigger differs is deleted, and made anew |
//! | a device does not take its address | after [`roam_tries`](Config::roam_tries) told, and passed over for [`retry_wait`](Config::retry_wait): another that fits is taken, spares too as soon as it shows that it is still there |
//! | a device answers a Mini-who while the manager waits for its second Hello | it stands by: it gets its address at once |
//! | several places fit a device | that which it had, that which is for it alone, the first of the database; as a spare last |
//! | the device itself was never seen, but its spare | the spare waits [`spare_wait`](Config::spare_wait), then it may |
//! | several spares answer | the first on the bus: that of the lowest low half of a serial number |
//! | nobody can stand in | told once; Mini-whos go on, and the lost device gets its address too, if it comes back first |
//! | a device says Hello without an address though it had one | it was restarted, and gets its address back before any spare |
//! | a device is on line with an address that is not planned, and missing at another | it is readdressed, when its Hello response shows that it is on line ([`Config::readdress`]) |
//! | somebody else has a planned address | told once, and looked at again after [`retry_wait`](Config::retry_wait), then more rarely; the planned device waits. One that is missing at another address is told that one |
//! | an unknown device with an address falls silent | it is told again when it comes back, once it has left out three announcements ([`access::Config::announcement`](crate::access::Config::announcement)) |
//! | the explicit connection of the predefined set belongs to another client | a dynamic one is asked for |
//! | a connection is refused | told, and asked for again after [`retry_wait`](Config::retry_wait); the others are made |
//! | another node has the address of the manager | it gives it up, waits [`rejoin_after`](Config::rejoin_after), and says Hello with it once more; if it is still taken with the next one that is not planned, and goes on from there. It takes what another manager gives it meanwhile, and leaves the work to that |
//! | there are two managers | the one that has not asked yet is the second, and leaves the work; of two that have, the one with the lower half serial number goes on |
//! | the other manager falls silent | nothing, or [`Config::takeover_after`] |
//! | learning | a device without an address gets the lowest one that is free; one that has an address keeps it. Connections are the application's business |

mod address;
mod adopt;
mod answer;
mod command;
mod config;
mod connect;
mod database;
mod discover;
mod event;
mod lanes;
mod machine;
mod made;
mod node;
mod output;
mod rejoin;
mod slot;
mod standing;
mod state;
mod talk;
#[cfg(test)]
mod tests;
mod timer;
mod watch;

pub use command::DeviceView;
pub use config::Config;
pub use database::{
    Attribute, DatabaseError, IdentityPattern, PlannedConnection, PlannedDevice, READS, SPARES, Source,
};
pub use event::{Counters, Difference, ManagerEvent, PlannedEvent, RequestFailure, Value};
pub use machine::Manager;
pub use state::{Cause, DeviceState, EDGES, Edge};
pub use talk::RequestError;
