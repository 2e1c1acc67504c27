//! What is known of a node.

use core::fmt;
use core::time::Duration;

use cip_core::code::{DeviceType, VendorId};
use cip_core::message::AllocationChoice;
use link_core::Instant;

use super::connection::{Connection, Side};
use super::connections::{ConnectionState, Predefined};
use super::dup_mac::SECOND_CHECK_WITHIN;
use super::explicit::Channel;
use super::pairing::{Seen, Waiting};
use crate::id::MacId;
use crate::message::DeviceIdentity;

bitflags::bitflags! {
    /// What a node was seen to be.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    pub struct Roles: u8 {
        /// It answers on the predefined connection set.
        const SLAVE = 0x01;
        /// It uses the predefined connection set of others.
        const MASTER = 0x02;
        /// It opens connections by UCMM.
        const UCMM_CLIENT = 0x04;
        /// It answers UCMM requests.
        const UCMM_SERVER = 0x08;
        /// It uses the offline connection set.
        const TOOL = 0x10;
    }
}

impl fmt::Display for Roles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for (role, name) in ROLES {
            if self.contains(role) {
                f.write_str(separator)?;
                f.write_str(name)?;
                separator = ", ";
            }
        }
        Ok(())
    }
}

/// Where a node stands on its way to the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AccessState {
    /// Nothing was heard of it.
    Unknown,
    /// It has sent its first duplicate MAC ID check request.
    FirstCheck,
    /// It has sent its second.
    SecondCheck,
    /// It takes part: it has sent something else, or nobody has objected for a second after the second check.
    OnLine,
    /// Two devices claim the MAC ID, and none of them has it yet.
    SuspectedDuplicate,
    /// It has told on the offline connection set that it has a communication fault.
    Faulted,
    /// It has said that it goes off line: Device Shutdown.
    OffLine,
}

impl AccessState {
    /// The name, the same for programs and for people.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::FirstCheck => "first_check",
            Self::SecondCheck => "second_check",
            Self::OnLine => "online",
            Self::SuspectedDuplicate => "suspected_duplicate",
            Self::Faulted => "comm_fault",
            Self::OffLine => "offline",
        }
    }
}

impl fmt::Display for AccessState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Who owns a predefined connection set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Allocation {
    pub(super) choice: AllocationChoice,
    /// `None`: not allocated.
    pub(super) master: Option<MacId>,
}

/// A command to many slaves, and who has answered it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Volley {
    pub(super) seen: Seen,
    pub(super) answered: u64,
}

/// What Identity object and duplicate MAC ID check have told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Identity {
    pub(super) vendor: Option<VendorId>,
    pub(super) serial: Option<u32>,
    pub(super) device_type: Option<DeviceType>,
    pub(super) product: Option<u16>,
    pub(super) revision: Option<(u8, u8)>,
}

/// The counters of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Counters {
    pub(super) frames: u64,
    pub(super) bytes: u64,
    pub(super) responses: u64,
    pub(super) error_responses: u64,
    pub(super) problems: u64,
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
    pub(super) counters: Counters,
    pub(super) last_latency: Option<Duration>,
    pub(super) first_seen: Option<Instant>,
    pub(super) last_seen: Instant,
}

impl Node {
    pub(super) const NEW: Self = Self {
        access: AccessState::Unknown,
        access_since: Instant::ZERO,
        roles: Roles::empty(),
        identity: Identity { vendor: None, serial: None, device_type: None, product: None, revision: None },
        name: heapless::Vec::new(),
        allocation: None,
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
        counters: Counters { frames: 0, bytes: 0, responses: 0, error_responses: 0, problems: 0 },
        last_latency: None,
        first_seen: None,
        last_seen: Instant::ZERO,
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

    /// The master that owns the connection set, as an allocation has told or else as the traffic suggests.
    pub(super) fn owner(&self) -> Option<MacId> {
        self.allocation.map_or(self.client, |allocation| allocation.master)
    }

    /// The master that owns the connection set, if an allocation has told.
    pub(super) fn told_owner(&self) -> Option<MacId> {
        self.allocation.and_then(|allocation| allocation.master)
    }

    /// It has answered `client` on its explicit connection, which it does for the owner only.
    pub(super) fn answers_owner(&mut self, client: MacId) {
        self.client = Some(client);
        if let Some(allocation) = &mut self.allocation
            && allocation.master.is_some()
        {
            allocation.master = Some(client);
        }
    }

    /// The multicast group that its multicast poll connection belongs to.
    pub(super) fn multicast_group(&self) -> Option<MacId> {
        self.group.or(self.owner())
    }

    /// The choice, if an allocation is known to exist.
    pub(super) fn choice(&self) -> Option<AllocationChoice> {
        self.allocation.filter(|allocation| allocation.master.is_some()).map(|allocation| allocation.choice)
    }

    /// The bits of the choice whose connections still exist.
    pub(super) fn live_choice(&self) -> AllocationChoice {
        let [explicit, poll, strobe, changes, multicast] = &self.connections;
        let gone = |connection: &Connection| {
            matches!(connection.state, ConnectionState::NonExistent | ConnectionState::TimedOut)
        };
        let choice = self.choice().unwrap_or_default();
        let mut live = choice;
        live.set(AllocationChoice::EXPLICIT, choice.contains(AllocationChoice::EXPLICIT) && !gone(explicit));
        live.set(AllocationChoice::POLL, choice.contains(AllocationChoice::POLL) && !gone(poll));
        live.set(
            AllocationChoice::BIT_STROBE,
            choice.contains(AllocationChoice::BIT_STROBE) && !gone(strobe),
        );
        let of_multicast = choice.contains(AllocationChoice::MULTICAST_POLL) && !gone(multicast);
        live.set(AllocationChoice::MULTICAST_POLL, of_multicast);
        if gone(changes) {
            live.remove(
                AllocationChoice::CHANGE_OF_STATE
                    | AllocationChoice::CYCLIC
                    | AllocationChoice::ACK_SUPPRESSION,
            );
        }
        live
    }

    /// Keeps as much of a product name as there is room for.
    pub(super) fn set_name(&mut self, name: &[u8]) {
        self.name.clear();
        self.name.extend(name.iter().copied().take(NAME_CAPACITY));
    }

    /// Lets the watchdogs of the predefined set expire.
    pub(super) fn settle(&mut self, now: Instant) {
        let [explicit, io @ ..] = &mut self.connections;
        for connection in io.iter_mut() {
            connection.settle(now, false, false);
        }
        let io_alive = io.iter().any(Connection::is_alive);
        explicit.settle(now, true, io_alive);
    }

    /// The node is there: it has sent something other than a check.
    pub(super) fn takes_part(&mut self, at: Instant) {
        let is_new = match self.access {
            AccessState::Unknown | AccessState::FirstCheck | AccessState::SecondCheck => true,
            AccessState::OffLine => true,
            // A newcomer would have checked a second time by now: the owner has kept its MAC ID.
            AccessState::SuspectedDuplicate => at.saturating_since(self.access_since) > SECOND_CHECK_WITHIN,
            AccessState::OnLine | AccessState::Faulted => false,
        };
        if is_new {
            if self.access == AccessState::SuspectedDuplicate {
                self.check = None;
            }
            self.half_checked = self.access == AccessState::FirstCheck;
            self.access = AccessState::OnLine;
            self.access_since = at;
        }
    }

    /// The node has left the network or restarted: its connections are gone.
    pub(super) fn drop_connections(&mut self, at: Instant) {
        for connection in &mut self.connections {
            connection.end(at);
        }
        self.allocation = Some(Allocation { choice: AllocationChoice::empty(), master: None });
        self.group = None;
        self.explicit = Channel::NEW;
        self.port = Waiting::new();
        self.ucmm = Waiting::new();
    }

    /// The access state at `now`: a second after the second check the node is on line.
    pub(super) fn access_at(&self, now: Instant) -> AccessState {
        let waited = now.saturating_since(self.access_since);
        match self.access {
            AccessState::SecondCheck if waited >= CHECK_TIME => AccessState::OnLine,
            state => state,
        }
    }
}

/// What is known of a node: a copy for a summary.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct NodeRecord {
    /// The MAC ID.
    pub mac: MacId,
    /// What it was seen to be.
    pub roles: Roles,
    /// Its access to the network at the time of the last frame observed.
    pub access: AccessState,
    /// Vendor, from a duplicate MAC ID check or the Identity object.
    pub vendor: Option<VendorId>,
    /// Serial number, from the same.
    pub serial: Option<u32>,
    /// Identity object, attribute 2.
    pub device_type: Option<DeviceType>,
    /// Identity object, attribute 3.
    pub product: Option<u16>,
    /// Identity object, attribute 4: major, minor.
    pub revision: Option<(u8, u8)>,
    /// Identity object, attribute 7: ISO 8859-1 characters.
    pub product_name: heapless::Vec<u8, NAME_CAPACITY>,
    /// The allocation choice, if an allocation was seen.
    pub choice: Option<AllocationChoice>,
    /// The master that owns its predefined connection set: of the allocation, or else the one that it answers.
    pub master: Option<MacId>,
    /// Frames that it has sent.
    pub frames: u64,
    /// Data bytes that it has sent.
    pub bytes: u64,
    /// Responses, I/O included, whose request was seen.
    pub responses: u64,
    /// Error responses that it has sent.
    pub error_responses: u64,
    /// Problems of frames that it has sent.
    pub problems: u64,
    /// Response time of its last response.
    pub last_latency: Option<Duration>,
    /// When it was first heard.
    pub first_seen: Option<Instant>,
    /// When it was last heard.
    pub last_seen: Option<Instant>,
}

impl NodeRecord {
    pub(super) fn of(mac: MacId, node: &Node, now: Instant) -> Option<Self> {
        let known = node.first_seen.is_some() || !node.roles.is_empty() || node.allocation.is_some();
        known.then(|| Self {
            mac,
            roles: node.roles,
            access: node.access_at(now),
            vendor: node.identity.vendor,
            serial: node.identity.serial,
            device_type: node.identity.device_type,
            product: node.identity.product,
            revision: node.identity.revision,
            product_name: node.name.clone(),
            choice: node.choice(),
            master: node.owner(),
            frames: node.counters.frames,
            bytes: node.counters.bytes,
            responses: node.counters.responses,
            error_responses: node.counters.error_responses,
            problems: node.counters.problems,
            last_latency: node.last_latency,
            first_seen: node.first_seen,
            last_seen: node.first_seen.map(|_| node.last_seen),
        })
    }
}

/// The longest product name that is kept.
pub const NAME_CAPACITY: usize = 32;
/// The wait after each duplicate MAC ID check request.
pub(super) const CHECK_TIME: Duration = Duration::from_secs(1);
const ROLES: [(Roles, &str); 5] = [
    (Roles::SLAVE, "slave"),
    (Roles::MASTER, "master"),
    (Roles::UCMM_CLIENT, "UCMM client"),
    (Roles::UCMM_SERVER, "UCMM server"),
    (Roles::TOOL, "tool"),
];
