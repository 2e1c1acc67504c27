//! The passive decoder: what every frame on the bus means.
//!
//! A [`Monitor`] is shown the frames of a bus or of a recording, one after the other, and says of each what it is, who has
//! sent it, what it asks or answers, and what is wrong with it. An identifier of DeviceNeX tells its class and its sender;
//! what it does not tell comes from the frames before:
//!
//! | What | From |
//! |---|---|
//! | who a node is, and where it stands on its way to the network | Hello, ROAM, Identity object |
//! | connections: instance, group, Message IDs of both ends, expected packet rate, body format | connection requests and responses |
//! | who consumes what | attribute 5 of the Connection object, read or set |
//! | sizes, rates, paths, watchdog actions | Get and Set of attributes of the Connection object; sizes also from [`set_io_sizes`](SizedMonitor::set_io_sizes) |
//! | connection states | the above, and watchdogs by the time stamps of the frames |
//! | requests, commands and fragments that wait for their answer | the frames themselves |
//!
//! A recording can start in the middle. What cannot be known without the frames before is decoded as far as it goes and
//! marked [`assumed`](Reading::assumed); it is never a [`Problem`].
//!
//! Whether a device takes the address that a ROAM brings, it does not say. The monitor sees it all the same: the Hello with
//! that address [answers](Reading::request) the ROAM; a device that goes on without an address, or gets a second ROAM, has
//! not taken the first ([`Problem::RoamWithoutEffect`]).
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
//! | network access | `Hello 1 OA 127  vendor 291, product 1110, revision 2, serial 0x11223344`, `Mini-who of 1`, `ROAM to OA 67  vendor 291, ..` |
//! | connections | `1 -> 67  Connect multicast, producing, 29 bits, EPR 500 ms, Auto reset, Message ID 0` |
//! | | `67 -> 1  Connect: multicast, producing, 29 bits, EPR 500 ms, Message ID 2, body format 8/8` |
//! | | `67 -> 1  Connect: error 0x20 Invalid parameter` |
//! | requests and responses | as in DeviceNet: `1 -> 67  Set_Attribute_Single Connection 13 EPR 75 ms`; without a connection `1 -> 67  connectionless Get_Attribute_Single Identity 1 Vendor ID` |
//! | fragments | `67 -> 1  first fragment 0  01 8E 0F 57 45 41 54 48`, `67 -> 1  last fragment 1 completes connectionless Get_Attribute_Single: ..`, `1 -> 67  acknowledge of fragment 0` |
//! | implicit messages | `multicast 67 -> *  03 6B`, `polled 67 <- 1  03`: who has the connection first, the arrow shows where the data go |
//!
//! An address that is not known is `?`. After the words stand, if there are any, a note and `assumed` in parentheses, and
//! after ` ! ` the problem.
//!
//! # Example
//!
//! ```
//! use devicenex_core::monitor::{Monitor, MonitorConfig};
//! use link_core::frame::extended_id;
//! use link_core::{Frame, Instant};
//!
//! let mut monitor = Monitor::new(MonitorConfig::default());
//! let mut show = |n, id, data: &[u8]| {
//!     let frame = Frame::new(extended_id(id), data).unwrap();
//!     monitor.observe(Instant::from_millis(n), n, &frame).to_string()
//! };
//! assert_eq!(
//!     show(1, 0x1FFE_4433, &[0x22, 0x11, 0x23, 0x01, 0x56, 0x04, 0x02, 0x00]),
//!     "Hello 1 OA 127  vendor 291, product 1110, revision 2, serial 0x11223344"
//! );
//! assert_eq!(
//!     show(2, 0x1D86_0209, &[0x4B, 0xC0, 0x07, 0x00, 0xF4, 0x01, 0x02]),
//!     "1 -> 67  Connect multicast, producing, 29 bits, EPR 500 ms, Auto reset, Message ID 0"
//! );
//! assert_eq!(
//!     show(3, 0x1D03_8609, &[0x4B, 0xC2, 0x00, 0xF4, 0x01]),
//!     "67 -> 1  Connect: multicast, producing, 29 bits, EPR 500 ms, Message ID 2, body format 8/8"
//! );
//! assert_eq!(show(4, 0x0286_0007, &[0x03, 0x6B]), "multicast 67 -> *  03 6B");
//! ```

mod connect;
mod connections;
mod explicit;
mod hello;
mod implicit;
#[cfg(feature = "serde")]
mod json;
mod kind;
mod learn;
mod nodes;
mod problem;
mod reading;
mod state;
mod talk;
#[cfg(test)]
mod tests;
mod text;
mod vocabulary;

pub use cip_core::monitor::text::ValueText;
pub use cip_core::monitor::{Answered, ConnectionState, Flaw, Frag, FragmentationGuess};
pub use connections::{ConnectionName, ConnectionRecord};
pub use kind::Kind;
pub use nodes::{AccessState, NAME_CAPACITY, NodeRecord, Roles};
pub use problem::Problem;
pub use reading::{Detail, Fields, Message, Note, OnConnection, Reading, Stage};
pub use state::Lost;
pub use text::Words;

use cip_core::code::InstanceId;
use cip_core::monitor::Slots;
use link_core::{Frame, Instant};

use connections::Held;
use state::State;
use talk::Port;

use crate::id::{Identifier, Layout, OperationalAddress};

/// A monitor for a whole network: 128 connections, 128 devices without an address, 128 messages in progress of up to 512
/// bytes. About 185 kilobytes.
pub type Monitor = SizedMonitor<128, 512>;

/// What a monitor cannot learn from the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub struct MonitorConfig {
    /// Take the message of an implicit connection whose size is unknown for fragmented, when a frame of eight bytes that
    /// begins with 0 is followed by its continuation on the same identifier. On by default; everything decoded by it is
    /// marked assumed.
    pub fragmentation: FragmentationGuess,
}

/// The passive decoder. `N` is the number of messages that can be in progress at a time, and also the number of
/// connections, of devices without an address, and of pairs of nodes that exchange explicit messages; `B` is the longest
/// message in bytes. [`Monitor`] has sizes for a computer.
///
/// [`observe`](Self::observe) takes bounded time: it looks at `N` connections, and for a Hello or Mini-who at all nodes.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct SizedMonitor<const N: usize, const B: usize> {
    config: MonitorConfig,
    state: State<N>,
    slots: Slots<N, B>,
}

impl<const N: usize, const B: usize> SizedMonitor<N, B> {
    /// A monitor that has seen nothing.
    #[must_use]
    pub fn new(config: MonitorConfig) -> Self {
        Self { config, state: State::new(), slots: Slots::new() }
    }

    /// Tells the sizes of an implicit connection in bytes: what its server consumes and what it produces. Nothing on the bus
    /// says whether I/O is fragmented; a size above 8 does. Sizes that are read on the bus replace these.
    pub fn set_io_sizes(
        &mut self,
        server: OperationalAddress,
        instance: InstanceId,
        consumed: Option<u16>,
        produced: Option<u16>,
    ) {
        if self.state.instance(server, instance).is_none() {
            let name = ConnectionName::Instance(instance);
            self.state.insert(Held::unknown(server, name, self.state.now));
        }
        let Some(held) = self.state.instance(server, instance) else { return };
        held.connection.consumed.size = consumed.or(held.connection.consumed.size);
        held.connection.produced.size = produced.or(held.connection.produced.size);
    }

    /// Reads frame number `n`, which was on the bus at `at`.
    pub fn observe(&mut self, at: Instant, n: u64, frame: &Frame) -> Reading<'_> {
        let Self { config, state, slots } = self;
        let mut reading = Reading::new(at, n, frame);
        state.now = state.now.max(at);
        if usize::from(frame.dlc()) > Frame::MAX_DATA {
            reading.flag(Flaw::DataLengthCode { dlc: frame.dlc() });
        }
        reading.message = dispatch(state, slots, &mut reading, *config);
        state.count(&reading);
        // Words of a response that answers several requests in one.
        if let Some(request) = reading.request {
            let parts = state.packets.of(request.n);
            reading.fields.explicit.answers_parts(parts);
            if let Some(message) = &mut reading.message {
                message.fields.explicit.answers_parts(parts);
            }
        }
        reading
    }

    /// What is known of every node that was heard: those with an address, then the devices without one.
    pub fn nodes(&self) -> impl Iterator<Item = NodeRecord> {
        self.state.nodes().filter_map(|node| NodeRecord::of(node, self.state.now))
    }

    /// What is known of the node of an address, if it was heard.
    #[must_use]
    pub fn node(&self, address: OperationalAddress) -> Option<NodeRecord> {
        let node = self.state.nodes().find(|node| node.address == address && !address.is_none())?;
        NodeRecord::of(node, self.state.now)
    }

    /// What is known of every connection.
    pub fn connections(&self) -> impl Iterator<Item = ConnectionRecord> {
        self.state.connections.iter().flatten().filter_map(|held| {
            let mut held = *held;
            held.settle(self.state.now);
            held.record()
        })
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
    config: MonitorConfig,
) -> Option<Message<'s>> {
    let is_access = matches!(reading.layout, Layout::Hello { .. } | Layout::Roam { .. });
    if reading.frame.is_remote() && !is_access {
        reading.flag(Problem::RemoteFrame);
        return None;
    }
    let message = match reading.layout {
        Layout::Hello { source, direction, serial_low } => {
            hello::observe(state, reading, source, direction, serial_low);
            return None;
        }
        Layout::Roam { destination, serial_low } => {
            hello::roam(state, reading, destination, serial_low);
            return None;
        }
        Layout::Connection { route, transaction } => {
            connect::observe(state, reading, route, transaction);
            None
        }
        Layout::Connectionless { route, framing } => {
            explicit::observe(state, slots, reading, Port::Connectionless, route, framing)
        }
        Layout::Explicit { route, framing, .. } => {
            explicit::observe(state, slots, reading, Port::Explicit, route, framing)
        }
        Layout::Implicit { source, acknowledge: true, instance, .. } => {
            implicit::acknowledge(state, reading, source, instance);
            None
        }
        Layout::Implicit { source, .. } | Layout::Standard { source, .. } => {
            implicit::observe(state, slots, reading, source, config.fragmentation)
        }
        Layout::Reserved(identifier) => {
            reserved(reading, identifier);
            None
        }
    };
    // A node that sends anything but a Hello is on line.
    if let Some(node) = reading.src.and_then(|source| state.node(source)) {
        node.takes_part(reading.at);
    }
    message
}

fn reserved(reading: &mut Reading<'_>, identifier: Identifier) {
    match identifier.id() {
        // Group 3 Message ID 3 and beyond: what uses them is DeviceNet or something else.
        link_core::Id::Standard(_) => reading.flag(Problem::StandardIdentifier),
        link_core::Id::Extended(_) => {
            reading.kind = Kind::Reserved;
            reading.flag(Problem::ReservedIdentifier);
        }
    }
}
