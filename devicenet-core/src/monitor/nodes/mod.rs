//! What is known of a node.

mod access;
mod ownership;
mod record;

use cip_core::code::{DeviceType, VendorId};
use cip_core::message::AllocationChoice;
use cip_core::monitor::{Connection, ConnectionState, Seen, Side, Traffic};
use link_core::Instant;

use super::connections::Predefined;
use super::explicit::Channel;
use super::pairing::Waiting;
use crate::id::MacId;
use crate::message::{DeviceIdentity, PortNumber};

pub use access::AccessState;
pub(super) use ownership::{Allocation, Parent};
pub use record::{NAME_CAPACITY, NodeRecord, Roles};

/// A command to many slaves, and who has answered it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Volley {
    pub(super) seen: Seen,
    pub(super) answered: u64,
    /// It has a length which the slaves may ignore.
    pub(super) excused: bool,
}

/// What Identity object and duplicate MAC ID check have told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Identity {
    /// The physical port: a device with two can have two MAC IDs.
    pub(super) port: Option<PortNumber>,
    pub(super) vendor: Option<VendorId>,
    pub(super) serial: Option<u32>,
    pub(super) device_type: Option<DeviceType>,
    pub(super) product: Option<u16>,
    pub(super) revision: Option<(u8, u8)>,
}

/// All that is known of a MAC ID.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Node {
    pub(super) access: AccessState,
    pub(super) access_since: Instant,
    pub(super) roles: Roles,
    pub(super) identity: Identity,
    pub(super) name: heapless::Vec<u8, NAME_CAPACITY>,
    /// `None`: no Allocate, Release or allocation information was seen.
    pub(super) allocation: Option<Allocation>,
    /// `None`: the explicit connection of the predefined set.
    pub(super) parent: Option<Parent>,
    pub(super) connections: [Connection; 5],
    /// Who was answered on the explicit connection: the owner as long as no allocation was seen.
    pub(super) client: Option<MacId>,
    /// The multicast group, from attribute 5 of instance 5 or by its answers; `None`: the owner's MAC ID.
    pub(super) group: Option<MacId>,
    /// The explicit connection of the predefined set.
    pub(super) explicit: Channel,
    /// Requests on the Group 2 Only unconnected port.
    pub(super) port: Waiting<4>,
    /// UCMM requests to this node.
    pub(super) ucmm: Waiting<4>,
    /// The duplicate MAC ID check request that a response answers.
    pub(super) check: Option<Seen>,
    /// It takes part after a single check: if the second follows, by Quick Connect.
    pub(super) half_checked: bool,
    /// The device that has sent it, if it is not the one known by this MAC ID.
    pub(super) rival: Option<DeviceIdentity>,
    /// As a master: its bit-strobe command.
    pub(super) strobe: Option<Volley>,
    /// As a multicast group: its poll command.
    pub(super) multicast: Option<Volley>,
    /// As a multicast group: its poll commands as a stream of data.
    pub(super) multicast_side: Side,
    pub(super) heartbeat: Option<Instant>,
    pub(super) heartbeat_interval: Option<u8>,
    pub(super) traffic: Traffic,
}

impl Node {
    pub(super) const NEW: Self = Self {
        access: AccessState::Unknown,
        access_since: Instant::ZERO,
        roles: Roles::empty(),
        identity: Identity {
            port: None,
            vendor: None,
            serial: None,
            device_type: None,
            product: None,
            revision: None,
        },
        name: heapless::Vec::new(),
        allocation: None,
        parent: None,
        client: None,
        group: None,
        connections: [Connection::NEW; 5],
        explicit: Channel::NEW,
        port: Waiting::new(),
        ucmm: Waiting::new(),
        check: None,
        half_checked: false,
        rival: None,
        strobe: None,
        multicast: None,
        multicast_side: Side::NEW,
        heartbeat: None,
        heartbeat_interval: None,
        traffic: Traffic::NONE,
    };

    pub(super) fn connection(&mut self, which: Predefined) -> &mut Connection {
        let [explicit, poll, strobe, cos, multicast] = &mut self.connections;
        match which {
            Predefined::Explicit => explicit,
            Predefined::Poll => poll,
            Predefined::BitStrobe => strobe,
            Predefined::CosCyclic => cos,
            Predefined::MulticastPoll => multicast,
        }
    }

    pub(super) const fn peek(&self, which: Predefined) -> &Connection {
        let [explicit, poll, strobe, cos, multicast] = &self.connections;
        match which {
            Predefined::Explicit => explicit,
            Predefined::Poll => poll,
            Predefined::BitStrobe => strobe,
            Predefined::CosCyclic => cos,
            Predefined::MulticastPoll => multicast,
        }
    }

    /// Keeps as much of a product name as there is room for.
    pub(super) fn set_name(&mut self, name: &[u8]) {
        self.name.clear();
        self.name.extend(name.iter().copied().take(NAME_CAPACITY));
    }

    /// Lets the watchdogs of the predefined set expire. `is_open` says whether an explicit connection of UCMM exists.
    pub(super) fn settle(&mut self, now: Instant, is_open: impl FnOnce(Parent) -> bool) {
        let suppressed =
            self.choice().is_some_and(|choice| choice.contains(AllocationChoice::ACK_SUPPRESSION));
        let [explicit, poll, strobe, changes, multicast] = &mut self.connections;
        for connection in [&mut *poll, &mut *strobe, &mut *multicast] {
            connection.settle(now, false, false);
        }
        if !suppressed {
            // Only acknowledges restart its watchdog; without them it has none.
            changes.settle(now, false, false);
        }
        let io = [poll, strobe, changes, multicast];
        let io_alive = io.iter().any(|connection| connection.is_alive());
        explicit.settle(now, true, io_alive);
        let configuring = |connection: &&mut Connection| connection.state == ConnectionState::Configuring;
        if !io.iter().any(configuring) {
            return;
        }
        let is_configured = match self.parent {
            None => !matches!(explicit.state, ConnectionState::NonExistent | ConnectionState::TimedOut),
            Some(parent) => is_open(parent),
        };
        if !is_configured {
            // Nobody is left to configure them.
            io.into_iter().filter(configuring).for_each(Connection::lapse);
        }
    }

    /// This device is known by the MAC ID.
    pub(super) fn is(&self, device: DeviceIdentity) -> bool {
        self.identity.vendor == Some(device.vendor) && self.identity.serial == Some(device.serial)
    }

    /// The device has gone to another MAC ID. It could be a twin that has: then this one goes on, and its connections with it.
    pub(super) fn leaves(&mut self, at: Instant) {
        self.identity = Identity::default();
        self.name.clear();
        self.heartbeat = None;
        self.connections.iter_mut().for_each(Connection::lapse);
        self.goes_off_line(at);
    }

    /// The node has left the network or restarted: its connections are gone.
    pub(super) fn drop_connections(&mut self, at: Instant) {
        for connection in &mut self.connections {
            connection.end(at);
        }
        self.allocation = Some(Allocation { choice: AllocationChoice::empty(), master: None });
        self.parent = None;
        self.group = None;
        self.explicit = Channel::NEW;
        self.port = Waiting::new();
        self.ucmm = Waiting::new();
    }
}
