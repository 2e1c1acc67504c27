//! The passive decoder: what every frame on the bus means.
//!
//! A [`Monitor`] is shown the frames of a bus or of a recording, one after the other, and says of each what it is,
//! who has sent it, what it asks or answers, and what is wrong with it. A frame of DeviceNet rarely tells all of that by
//! itself: a response does not repeat what it answers, I/O carries nothing but data, and the meaning of an identifier
//! can depend on an exchange long before. So the monitor keeps in mind:
//!
//! | What | From |
//! |---|---|
//! | allocation choice and owner of each slave | Allocate, Release, allocation information, on the unconnected port and on explicit connections |
//! | explicit connections of UCMM, with their identifiers and body format | Open, Close |
//! | I/O connections with identifiers of their own | Create, Set of attributes 4 and 5 of the Connection object |
//! | sizes, expected packet rates, paths, watchdog actions of connections | Get and Set of attributes of the Connection object; sizes also from [`set_io_sizes`](SizedMonitor::set_io_sizes) |
//! | connection states | the above, and watchdogs by the time stamps of the frames |
//! | who a node is, and where it stands on its way to the network | duplicate MAC ID checks, Identity object, offline connection set |
//! | requests, commands and fragments that wait for their answer | the frames themselves |
//!
//! A recording can start in the middle. What cannot be known without the frames before is decoded as far as it goes
//! and marked [`assumed`](Reading::assumed); it is never a [`Problem`].
//!
//! Storage is fixed: see [`SizedMonitor`] for its two sizes. What does not fit is counted in [`Lost`] and noted at the
//! frame.
//!
//! # The words
//!
//! `Display` of a [`Reading`] is one line:
//!
//! | Frames | Words |
//! |---|---|
//! | requests | `1 -> 10  Get_Attribute_Single Identity 1 Vendor ID` |
//! | | `1 -> 10  Set_Attribute_Single Connection 2 EPR 75 ms` |
//! | | `1 -> 10  Allocate explicit + poll, master 1` |
//! | responses | `10 -> 1  Get_Attribute_Single: Vendor 4660`, `10 -> 1  Release: ok` |
//! | error responses | `10 -> 1  Get_Attribute_Single: error 0x16 Object does not exist` |
//! | fragments | `10 -> 1  first fragment 0  8E 0F 57 45 41 54`, `10 -> 1  last fragment 2 completes Get_Attribute_Single: ..` |
//! | | `1 -> 10  acknowledge of fragment 0` |
//! | I/O | `poll 10 <- 1  03`, `poll 10 -> 1  03 6B 00`: the slave first, the arrow shows where the data go |
//! | | `bit-strobe * <- 1  00 04 00 00 00 00 00 00` |
//! | network access | `dup MAC 10 request  vendor 4660 serial 0x00002345` |
//! | broadcasts | `heartbeat 3  operational, configuration 0x0000` |
//! | offline connection set | `offline Who  all nodes, delay by byte 2` |
//!
//! Services for several attributes, or for a member of one, stand with what they name: `Get_Attribute_List: Vendor 4660,
//! Product name "ab"`; requests and responses inside of a Multiple_Service_Packet as they would alone, with `; ` between. A MAC ID that is not known is `?`. After the words stand, if there are any, a note and `assumed`
//! in parentheses, and after ` ! ` the problem.
//!
//! # Example
//!
//! ```
//! use devicenet_core::Identifier;
//! use devicenet_core::monitor::{Kind, Monitor, MonitorConfig};
//! use link_core::Instant;
//!
//! let mut monitor = Monitor::new(MonitorConfig::default());
//! let mut show = |n, id, data: &[u8]| {
//!     let frame = Identifier::new(id).and_then(|id| id.frame(data)).unwrap();
//!     monitor.observe(Instant::from_millis(n), n, &frame).to_string()
//! };
//! assert_eq!(show(1, 0x456, &[0x01, 0x4B, 3, 1, 3, 1]), "1 -> 10  Allocate explicit + poll, master 1");
//! assert_eq!(show(2, 0x453, &[0x01, 0xCB, 0]), "10 -> 1  Allocate: body format 8/8");
//! assert_eq!(show(3, 0x454, &[0x01, 0x10, 5, 2, 9, 75, 0]), "1 -> 10  Set_Attribute_Single Connection 2 EPR 75 ms");
//! assert_eq!(show(4, 0x453, &[0x01, 0x90, 80, 0]), "10 -> 1  Set_Attribute_Single: EPR 80 ms (75 ms requested)");
//! assert_eq!(show(5, 0x455, &[0x03]), "poll 10 <- 1  03");
//! assert_eq!(show(6, 0x3CA, &[]), "poll 10 -> 1");
//! ```

mod bodies;
mod broadcast;
mod connections;
mod created;
mod dup_mac;
mod dynamic;
mod explicit;
mod io;
#[cfg(feature = "serde")]
mod json;
mod kind;
mod learn;
mod nodes;
mod offline;
mod pairing;
mod problem;
mod reading;
mod records;
mod requests;
mod responses;
mod state;
#[cfg(test)]
mod tests;
mod text;
mod ucmm;
mod unconnected;
mod volley;

pub use cip_core::monitor::{Answered, ConnectionState, Frag, FragmentationGuess};
pub use connections::{ConnectionName, ConnectionRecord, DynamicConnection, Predefined};
pub use kind::Kind;
pub use nodes::{AccessState, NAME_CAPACITY, NodeRecord, Roles};
pub use problem::Problem;
pub use reading::{Detail, Fields, Message, Note, Reading};
pub(crate) use records::{Records, Rhythm, Told};
pub use state::Lost;
pub use text::{ValueText, Words};

use cip_core::monitor::{Flaw, Flow, Slots};
use link_core::{Frame, Instant};

use io::Lane;
use state::State;

use crate::id::{Identifier, MacId, Purpose};
use crate::message::ExplicitHeader;

/// A monitor for a whole network: 32 messages in progress of up to 512 bytes, 32 connections opened by UCMM. About 102
/// kilobytes.
pub type Monitor = SizedMonitor<32, 512>;

/// What a monitor cannot learn from the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub struct MonitorConfig {
    /// Take the message of an I/O connection whose size is unknown for fragmented, when a frame of eight bytes that
    /// begins with 0 is followed by its continuation on the same identifier. On by default; everything decoded by it is
    /// marked assumed.
    pub fragmentation: FragmentationGuess,
}

/// The passive decoder. `N` is the number of messages that can be in progress at a time and also the number of
/// connections opened by UCMM; `B` is the longest message in bytes. [`Monitor`] has sizes for a computer.
///
/// [`observe`](Self::observe) takes bounded time: it looks at one slave, at `N` connections, and for a bit-strobe
/// command or a check of a MAC ID at all 64 nodes.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct SizedMonitor<const N: usize, const B: usize> {
    config: MonitorConfig,
    state: State<N>,
    slots: Slots<N, B>,
}

impl<const N: usize, const B: usize> SizedMonitor<N, B> {
    /// A monitor that has seen nothing.
    #[must_use]
    pub const fn new(config: MonitorConfig) -> Self {
        Self { config, state: State::new(), slots: Slots::new() }
    }

    /// Tells the sizes of an I/O connection in bytes, as the slave counts them: what it consumes and what it produces.
    /// Nothing on the bus says whether I/O is fragmented; a size above 8 does. Sizes that are read on the bus replace
    /// these.
    pub fn set_io_sizes(
        &mut self,
        slave: MacId,
        connection: Predefined,
        consumed: Option<u16>,
        produced: Option<u16>,
    ) {
        let connection = self.state.node(slave).connection(connection);
        connection.consumed.size = consumed.or(connection.consumed.size);
        connection.produced.size = produced.or(connection.produced.size);
    }

    /// Reads frame number `n`, which was on the bus at `at`.
    pub fn observe(&mut self, at: Instant, n: u64, frame: &Frame) -> Reading<'_> {
        self.observe_with_records(at, n, frame).0
    }

    /// The same, with what was learned of the nodes.
    #[inline]
    pub(crate) fn observe_with_records(
        &mut self,
        at: Instant,
        n: u64,
        frame: &Frame,
    ) -> (Reading<'_>, Records<'_>) {
        let Self { config, state, slots } = self;
        let identifier = Identifier::of_frame(frame);
        let mut reading = Reading::new(at, n, frame, identifier);
        state.now = state.now.max(at);
        let Some(identifier) = identifier else {
            let is_remote = frame.is_remote();
            reading.flag(if is_remote { Problem::RemoteFrame } else { Problem::ExtendedIdentifier });
            return (reading, state.records());
        };
        if usize::from(frame.dlc()) > Frame::MAX_DATA {
            reading.flag(Flaw::DataLengthCode { dlc: frame.dlc() });
        }
        let message = dispatch(state, slots, &mut reading, identifier, *config);
        reading.message = message;
        state.count(&reading);
        // Words of a response that answers several requests in one.
        if let Some(request) = reading.request {
            let parts = state.packets.of(request.n);
            reading.fields.explicit.answers_parts(parts);
            if let Some(message) = &mut reading.message {
                message.fields.explicit.answers_parts(parts);
            }
        }
        (reading, state.records())
    }

    /// What was learned of the nodes.
    pub(crate) fn records(&self) -> Records<'_> {
        self.state.records()
    }

    /// What is known of every node that was heard or addressed.
    pub fn nodes(&self) -> impl Iterator<Item = NodeRecord> {
        self.nodes_at(self.state.now)
    }

    /// The same as of a moment after the last frame: who has checked its MAC ID twice is on line a second later, heard or not.
    pub fn nodes_at(&self, now: Instant) -> impl Iterator<Item = NodeRecord> {
        let now = now.max(self.state.now);
        self.state.settled().filter_map(move |(mac, node)| NodeRecord::of(mac, &node, now))
    }

    /// What is known of a node, if it was heard or addressed.
    #[must_use]
    pub fn node(&self, mac: MacId) -> Option<NodeRecord> {
        let (_, node) = self.state.nodes().find(|&(other, _)| other == mac)?;
        NodeRecord::of(mac, node, self.state.now)
    }

    /// What is known of every connection: those of the predefined set by slave, then those opened by UCMM.
    pub fn connections(&self) -> impl Iterator<Item = ConnectionRecord> {
        let predefined = self.state.settled().flat_map(|(mac, node)| {
            let owner = node.owner();
            Predefined::ALL.into_iter().filter_map(move |which| {
                let name = ConnectionName::Predefined(which);
                ConnectionRecord::of(name, mac, owner, node.peek(which))
            })
        });
        let dynamic = self.state.dynamics.iter().flatten().filter_map(|held| {
            let mut connection = held.connection;
            connection.settle(self.state.now, !held.is_io, false);
            let name = ConnectionName::Dynamic { instance: held.instance, group: held.group };
            ConnectionRecord::of(name, held.server, Some(held.client), &connection)
        });
        predefined.chain(dynamic)
    }

    /// What did not fit into the storage so far.
    #[must_use]
    pub fn lost(&self) -> Lost {
        Lost { evicted_messages: self.slots.evicted, ..self.state.lost }
    }
}

/// Hands the frame to the family that its identifier belongs to.
fn dispatch<'s, const N: usize, const B: usize>(
    state: &mut State<N>,
    slots: &'s mut Slots<N, B>,
    reading: &mut Reading<'_>,
    identifier: Identifier,
    config: MonitorConfig,
) -> Option<Message<'s>> {
    let purpose = identifier.purpose();
    let Some(mac) = identifier.mac_id() else {
        match purpose {
            Purpose::Reserved => {
                reading.kind = Kind::Reserved;
                reading.flag(Problem::ReservedIdentifier);
            }
            Purpose::Invalid => {
                reading.kind = Kind::Invalid;
                reading.flag(Problem::InvalidIdentifier);
            }
            _ => offline::observe(state, reading, purpose),
        }
        return None;
    };
    if purpose == Purpose::DuplicateMacCheck {
        dup_mac::observe(state, reading, mac);
        return None;
    }
    if state.group2_dynamics != 0
        && reading.group == Some(2)
        && let Some((header, route)) = dynamic::group2(state, reading, identifier)
    {
        let message = explicit::observe(state, slots, reading, header, &route);
        take_part(state, reading);
        return message;
    }
    if reading.group == Some(2)
        && let Some(ends) = created::find(state, identifier)
    {
        let message = created::observe(state, slots, reading, ends, config.fragmentation);
        take_part(state, reading);
        return message;
    }
    let message = match purpose {
        Purpose::Dynamic => dynamic::observe(state, slots, reading, identifier, config.fragmentation),
        Purpose::ExplicitRequest
        | Purpose::ExplicitResponse
        | Purpose::Group2UnconnectedRequest
        | Purpose::UnconnectedRequest
        | Purpose::UnconnectedResponse => explicit_family(state, slots, reading, identifier, mac, purpose),
        Purpose::BitStrobeCommand => {
            volley::strobe(state, reading, mac);
            None
        }
        Purpose::MulticastPollCommand => {
            volley::poll(state, slots, reading, identifier, mac, config.fragmentation)
        }
        _ => {
            let (which, flow) = io_connection(purpose);
            io::observe(
                state,
                slots,
                reading,
                Lane { identifier, slave: mac, which, flow },
                config.fragmentation,
            )
        }
    };
    take_part(state, reading);
    message
}

/// The messages that begin with a header.
fn explicit_family<'s, const N: usize, const B: usize>(
    state: &mut State<N>,
    slots: &'s mut Slots<N, B>,
    reading: &mut Reading<'_>,
    identifier: Identifier,
    mac: MacId,
    purpose: Purpose,
) -> Option<Message<'s>> {
    let frame = reading.frame;
    let Some(&byte) = frame.data().first() else {
        let (kind, is_source) = match purpose {
            Purpose::ExplicitRequest => (Kind::ExplicitRequest, false),
            Purpose::ExplicitResponse => (Kind::ExplicitResponse, true),
            Purpose::Group2UnconnectedRequest => (Kind::Group2UnconnectedRequest, false),
            Purpose::UnconnectedRequest => (Kind::UnconnectedRequest, true),
            _ => (Kind::UnconnectedResponse, true),
        };
        reading.kind = kind;
        *(if is_source { &mut reading.src } else { &mut reading.dst }) = Some(mac);
        reading.flag(Flaw::TooShort { at_least: 2, found: 0 });
        return None;
    };
    let header = ExplicitHeader::from(byte);
    let is_ucmm = purpose == Purpose::UnconnectedResponse;
    if (is_ucmm || purpose == Purpose::ExplicitResponse)
        && let Some(kind) = broadcast::recognise(header, frame.data(), mac, is_ucmm)
    {
        broadcast::observe(state, reading, header, mac, kind);
        return None;
    }
    match purpose {
        Purpose::Group2UnconnectedRequest => unconnected::observe(state, reading, header, mac),
        Purpose::UnconnectedRequest => ucmm::request(state, reading, header, mac),
        Purpose::UnconnectedResponse => ucmm::response(state, reading, header, mac),
        _ => {
            let flow = if purpose == Purpose::ExplicitRequest { Flow::Consumed } else { Flow::Produced };
            let route = explicit::predefined(identifier, mac, flow, header);
            return explicit::observe(state, slots, reading, header, &route);
        }
    }
    None
}

fn io_connection(purpose: Purpose) -> (Predefined, Flow) {
    match purpose {
        Purpose::MulticastPollResponse => (Predefined::MulticastPoll, Flow::Produced),
        Purpose::ChangeOfState => (Predefined::CosCyclic, Flow::Produced),
        Purpose::ChangeOfStateAcknowledge => (Predefined::CosCyclic, Flow::Consumed),
        Purpose::BitStrobeResponse => (Predefined::BitStrobe, Flow::Produced),
        Purpose::PollCommand => (Predefined::Poll, Flow::Consumed),
        _ => (Predefined::Poll, Flow::Produced),
    }
}

/// A node that sends anything but a check or its farewell is on line.
fn take_part<const N: usize>(state: &mut State<N>, reading: &Reading<'_>) {
    if let Some(source) = reading.src.filter(|_| reading.kind != Kind::Shutdown) {
        state.node(source).takes_part(reading.at);
    }
}
