//! What the monitor has learned.

use cip_core::code::InstanceId;
use cip_core::monitor::packet::Packets;
use cip_core::monitor::{Connection, ConnectionState, Seen, Sent};
use link_core::Instant;

use super::connections::{ConnectionName, Held};
use super::nodes::{Node, Roles};
use super::reading::{Note, Reading};
use super::talk::{Ends, Talk};
use crate::id::OperationalAddress;
use crate::message::DeviceIdentity;

/// Everything learned, except the messages in progress.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct State<const N: usize> {
    nodes: [Node; OperationalAddress::COUNT],
    /// Devices without an address.
    newcomers: [Option<Node>; N],
    pub(super) connections: [Option<Held>; N],
    talks: [Option<Talk>; N],
    pub(super) packets: Packets,
    pub(super) mini_who: Option<Seen>,
    /// The low half of the serial number of the node that has sent the first Mini-who.
    pub(super) manager: Option<u16>,
    pub(super) now: Instant,
    pub(super) lost: Lost,
}

/// What did not fit into the monitor's storage. All zero means that nothing was lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Lost {
    /// Messages in progress that were given up for newer ones.
    pub evicted_messages: u64,
    /// Messages longer than the message store.
    pub long_messages: u64,
    /// Connections that were given up for newer ones.
    pub connections: u64,
    /// Requests that were given up for newer ones.
    pub requests: u64,
    /// Devices without an address that were given up for newer ones.
    pub devices: u64,
}

impl<const N: usize> State<N> {
    pub(super) fn new() -> Self {
        let mut addresses = OperationalAddress::all();
        Self {
            nodes: core::array::from_fn(|_| Node::new(addresses.next().unwrap_or_default())),
            newcomers: [const { None }; N],
            connections: [const { None }; N],
            talks: [const { None }; N],
            packets: Packets::new(),
            mini_who: None,
            manager: None,
            now: Instant::ZERO,
            lost: Lost { evicted_messages: 0, long_messages: 0, connections: 0, requests: 0, devices: 0 },
        }
    }

    /// The node of an address; `None` for OA 127.
    pub(super) fn node(&mut self, address: OperationalAddress) -> Option<&mut Node> {
        self.nodes.get_mut(address.index())
    }

    /// Those with an address, then those without.
    pub(super) fn nodes(&self) -> impl Iterator<Item = &Node> {
        self.nodes.iter().chain(self.newcomers.iter().flatten())
    }

    pub(super) fn nodes_mut(&mut self) -> impl Iterator<Item = &mut Node> {
        self.nodes.iter_mut()
    }

    pub(super) fn newcomers(&self) -> impl Iterator<Item = &Node> {
        self.newcomers.iter().flatten()
    }

    /// The record of a device without an address: its own, a free one, or that of the one quiet for longest.
    pub(super) fn newcomer(&mut self, device: DeviceIdentity) -> Option<&mut Node> {
        let is_it = |slot: &Option<Node>| slot.as_ref().is_some_and(|node| node.device == Some(device));
        let found = self.newcomers.iter().position(is_it);
        let index = match found {
            Some(index) => index,
            None => {
                let (index, is_taken) = place(&self.newcomers, |node| (true, node.traffic.last_seen()))?;
                self.lost.devices = self.lost.devices.saturating_add(u64::from(is_taken));
                let node = Node { device: Some(device), ..Node::new(OperationalAddress::NONE) };
                *self.newcomers.get_mut(index)? = Some(node);
                index
            }
        };
        self.newcomers.get_mut(index)?.as_mut()
    }

    /// The device has an address now: its record without one is over.
    pub(super) fn take_newcomer(&mut self, device: DeviceIdentity) -> Option<Node> {
        let is_it = |slot: &&mut Option<Node>| slot.as_ref().is_some_and(|node| node.device == Some(device));
        self.newcomers.iter_mut().find(is_it)?.take()
    }

    pub(super) fn add_role(&mut self, address: OperationalAddress, role: Roles) {
        if let Some(node) = self.node(address) {
            node.roles |= role;
        }
    }

    /// The talk between two nodes; a new one takes a free place, or that of the one quiet for longest.
    pub(super) fn talk(&mut self, ends: Ends, at: Instant) -> Option<&mut Talk> {
        let is_it = |slot: &Option<Talk>| slot.as_ref().is_some_and(|talk| talk.ends == ends);
        let index = match self.talks.iter().position(is_it) {
            Some(index) => index,
            None => {
                let (index, _) = place(&self.talks, |talk| (true, talk.active))?;
                *self.talks.get_mut(index)? = Some(Talk::new(ends, at));
                index
            }
        };
        let talk = self.talks.get_mut(index)?.as_mut()?;
        talk.active = at;
        Some(talk)
    }

    pub(super) fn held(&mut self, index: usize) -> Option<&mut Held> {
        self.connections.get_mut(index)?.as_mut()
    }

    /// The connection with that instance at a server.
    pub(super) fn instance(&mut self, server: OperationalAddress, instance: InstanceId) -> Option<&mut Held> {
        let name = ConnectionName::Instance(instance);
        self.connections.iter_mut().flatten().find(|held| held.server == server && held.name == name)
    }

    /// The explicit connection between two nodes: one that is there rather than one that has ended.
    pub(super) fn explicit(&self, server: OperationalAddress, client: OperationalAddress) -> Option<usize> {
        let all = self.connections.iter().enumerate();
        let own = all.filter_map(|(index, slot)| Some((index, slot.as_ref()?))).filter(|(_, held)| {
            held.is_explicit && held.server == server && held.client.is_none_or(|other| other == client)
        });
        let (index, _) = own.max_by_key(|(_, held)| {
            (held.connection.state != ConnectionState::NonExistent, held.connection.active)
        })?;
        Some(index)
    }

    /// Keeps a new connection: where the same one was, in a free place, in that of one that has ended, else in that of the
    /// one quiet for longest.
    pub(super) fn insert(&mut self, new: Held) -> Option<usize> {
        let is_same = |slot: &Option<Held>| {
            slot.as_ref().is_some_and(|held| {
                held.server == new.server
                    && (held.name == new.name
                        || held.name == ConnectionName::Explicit
                            && new.is_explicit
                            && held.client == new.client)
            })
        };
        let (index, is_taken) = match self.connections.iter().position(is_same) {
            Some(index) => (index, false),
            None => place(&self.connections, |held| {
                (held.connection.state != ConnectionState::NonExistent, held.connection.active)
            })?,
        };
        self.lost.connections = self.lost.connections.saturating_add(u64::from(is_taken));
        *self.connections.get_mut(index)? = Some(new);
        Some(index)
    }

    /// The node has gone, or started anew: its connections are over, as far as they are its own.
    pub(super) fn lapse(&mut self, server: OperationalAddress) {
        let own = self.connections.iter_mut().flatten().filter(|held| held.server == server);
        own.for_each(|held| held.connection.lapse());
    }

    /// The same, told by a message.
    pub(super) fn drop_connections(&mut self, server: OperationalAddress, at: Instant) {
        let own = self.connections.iter_mut().flatten().filter(|held| held.server == server);
        own.for_each(|held| held.connection.end(at));
    }

    /// Counts the frame, for its sender.
    pub(super) fn count(&mut self, reading: &Reading<'_>) {
        if reading.note == Some(Note::NotStored) {
            self.lost.long_messages = self.lost.long_messages.saturating_add(1);
        }
        let Some(source) = reading.src else { return };
        let is_refused = reading.fields.explicit.status.is_some()
            || reading.message.is_some_and(|message| message.fields.explicit.status.is_some());
        let node = match reading.fields.device.filter(|_| source.is_none()) {
            Some(device) => self.newcomer(device),
            None => self.node(source),
        };
        let Some(node) = node else { return };
        node.traffic.count(Sent {
            at: reading.at,
            bytes: reading.frame.data().len(),
            is_problem: reading.problem.is_some(),
            is_error_response: is_refused,
            latency: reading.response_time(),
        });
    }
}

impl Held {
    /// What is known of it before anything but a message of it was seen.
    pub(super) fn unknown(server: OperationalAddress, name: ConnectionName, at: Instant) -> Self {
        let connection = Connection { active: at, ..Connection::NEW };
        Self { connection, ..Self::new(server, name) }
    }
}

/// A free place, else that of the lowest rank; and whether something stands there that is not over (false in the rank).
fn place<T, R: Ord>(slots: &[Option<T>], rank: impl Fn(&T) -> (bool, R)) -> Option<(usize, bool)> {
    if let Some(free) = slots.iter().position(Option::is_none) {
        return Some((free, false));
    }
    let ranked = slots.iter().enumerate().filter_map(|(index, slot)| Some((index, rank(slot.as_ref()?))));
    let (index, (is_live, _)) = ranked.min_by(|(_, one), (_, other)| one.cmp(other))?;
    Some((index, is_live))
}
