//! What the monitor has learned.

use cip_core::code::InstanceId;
use cip_core::monitor::packet::Packets;
use cip_core::monitor::{Connection, ConnectionState, Flow, Seen, Sent};
use link_core::Instant;

use super::connections::{DynamicConnection, Predefined};
use super::explicit::Channel;
use super::nodes::{Node, Parent, Roles};
use super::reading::{Note, Reading};
use super::records::Records;
use crate::id::{Identifier, MacId};
use crate::message::DuplicateMacCheck;

/// Everything learned, except the messages in progress.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct State<const N: usize> {
    nodes: [Node; MacId::COUNT],
    pub(super) dynamics: [Option<Dynamic>; N],
    /// How many of them use Group 2, whose identifiers belong to the predefined set otherwise.
    pub(super) group2_dynamics: usize,
    /// How many of them were made by Create.
    pub(super) created: usize,
    pub(super) offline: Offline,
    pub(super) packets: Packets,
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
    /// Dynamic connections that were given up for newer ones.
    pub connections: u64,
    /// Requests that were given up for newer ones of other clients.
    pub requests: u64,
}

/// The last messages of the offline connection set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Offline {
    pub(super) ownership: Option<Seen>,
    pub(super) who: Option<Seen>,
    pub(super) identify: Option<Seen>,
}

/// A connection opened by UCMM, or made by Create.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Dynamic {
    pub(super) client: MacId,
    pub(super) server: MacId,
    pub(super) group: u8,
    pub(super) instance: Option<InstanceId>,
    /// What the server consumes.
    pub(super) requests: Option<Identifier>,
    /// What the server produces.
    pub(super) responses: Option<Identifier>,
    /// Made by Create, for I/O: its frames have no header.
    pub(super) is_io: bool,
    pub(super) connection: Connection,
    pub(super) channel: Channel,
}

/// Where an explicit message runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Link {
    pub(super) server: MacId,
    /// Position of the dynamic connection; `None`: the predefined explicit connection.
    pub(super) dynamic: Option<usize>,
}

impl Dynamic {
    /// The direction of a frame with this identifier and header, if it is an explicit message of the connection.
    pub(super) fn flow(&self, identifier: Identifier, header: MacId) -> Option<Flow> {
        if self.is_io {
            return None;
        }
        if self.responses == Some(identifier) && header == self.client {
            return Some(Flow::Produced);
        }
        let expected = if self.group == 2 { self.client } else { self.server };
        (self.requests == Some(identifier) && header == expected).then_some(Flow::Consumed)
    }
}

impl<const N: usize> State<N> {
    pub(super) const fn new() -> Self {
        Self {
            nodes: [const { Node::NEW }; MacId::COUNT],
            dynamics: [const { None }; N],
            group2_dynamics: 0,
            created: 0,
            offline: Offline { ownership: None, who: None, identify: None },
            packets: Packets::new(),
            now: Instant::ZERO,
            lost: Lost { evicted_messages: 0, long_messages: 0, connections: 0, requests: 0 },
        }
    }

    pub(super) const fn records(&self) -> Records<'_> {
        Records { nodes: &self.nodes }
    }

    pub(super) fn node(&mut self, mac: MacId) -> &mut Node {
        node(&mut self.nodes, mac)
    }

    /// Lets the watchdogs of a node's predefined set expire.
    pub(super) fn settle(&mut self, mac: MacId, now: Instant) {
        let Self { nodes, dynamics, .. } = self;
        node(nodes, mac).settle(now, |parent| is_open(dynamics, mac, parent, now));
    }

    /// The nodes as they are now that the watchdogs have expired that must have.
    pub(super) fn settled(&self) -> impl Iterator<Item = (MacId, Node)> {
        self.nodes().map(|(mac, node)| {
            let mut node = node.clone();
            node.settle(self.now, |parent| is_open(&self.dynamics, mac, parent, self.now));
            (mac, node)
        })
    }

    pub(super) fn nodes(&self) -> impl Iterator<Item = (MacId, &Node)> {
        MacId::all().zip(&self.nodes)
    }

    pub(super) fn nodes_mut(&mut self) -> impl Iterator<Item = (MacId, &mut Node)> {
        MacId::all().zip(&mut self.nodes)
    }

    pub(super) fn channel(&mut self, link: Link) -> &mut Channel {
        match link.dynamic.and_then(|index| self.dynamics.get_mut(index)) {
            Some(Some(dynamic)) => &mut dynamic.channel,
            Some(None) | None => &mut node(&mut self.nodes, link.server).explicit,
        }
    }

    pub(super) fn connection(&mut self, link: Link) -> &mut Connection {
        match link.dynamic.and_then(|index| self.dynamics.get_mut(index)) {
            Some(Some(dynamic)) => &mut dynamic.connection,
            Some(None) | None => node(&mut self.nodes, link.server).connection(Predefined::Explicit),
        }
    }

    /// The dynamic connection of a link, if it is one.
    pub(super) fn held(&self, link: Link) -> Option<&Dynamic> {
        self.dynamics.get(link.dynamic?)?.as_ref()
    }

    /// The connection with that instance at a server.
    pub(super) fn instance(&mut self, server: MacId, instance: InstanceId) -> Option<&mut Connection> {
        if let Some(predefined) = Predefined::from_instance(instance) {
            return Some(self.node(server).connection(predefined));
        }
        self.dynamic(server, instance).map(|dynamic| &mut dynamic.connection)
    }

    /// Whether a request to a server waits for its answer that establishes an I/O connection of the predefined set.
    pub(super) fn establishes(&self, server: MacId, which: Predefined) -> bool {
        let Some((_, node)) = self.nodes().find(|&(mac, _)| mac == server) else { return false };
        let held = node.peek(which);
        let own = self.dynamics.iter().flatten().filter(|dynamic| dynamic.server == server);
        let channels = own.map(|dynamic| &dynamic.channel).chain([&node.explicit]);
        channels
            .filter_map(|channel| channel.pending)
            .any(|request| request.establishes(which.instance(), held.state))
    }

    /// The dynamic connection with that instance at a server.
    pub(super) fn dynamic(&mut self, server: MacId, instance: InstanceId) -> Option<&mut Dynamic> {
        let mut held = self.dynamics.iter_mut().flatten();
        held.find(|dynamic| dynamic.server == server && dynamic.instance == Some(instance))
    }

    /// The dynamic connection that a frame belongs to, and its direction.
    pub(super) fn find_dynamic(&self, identifier: Identifier, header: MacId) -> Option<(usize, Flow)> {
        self.dynamics.iter().enumerate().find_map(|(index, dynamic)| {
            let dynamic = dynamic.as_ref()?;
            dynamic.flow(identifier, header).map(|flow| (index, flow))
        })
    }

    /// Keeps a new dynamic connection: where the same one was, in a free place, in that of one that has ended, else in
    /// that of the one quiet for longest.
    pub(super) fn insert_dynamic(&mut self, new: Dynamic) -> Option<usize> {
        let same = self.dynamics.iter().position(|slot| {
            slot.as_ref().is_some_and(|held| {
                let same_instance = held.instance.is_some() && held.instance == new.instance;
                let same_identifier = held.requests.is_some() && held.requests == new.requests
                    || held.responses.is_some() && held.responses == new.responses;
                held.server == new.server && (same_instance || held.client == new.client && same_identifier)
            })
        });
        let free = || self.dynamics.iter().position(Option::is_none);
        let oldest = || {
            let rank = |slot: &Option<Dynamic>| {
                slot.as_ref().map(|held| {
                    (held.connection.state != ConnectionState::NonExistent, held.connection.active)
                })
            };
            self.dynamics.iter().enumerate().min_by_key(|(_, slot)| rank(slot)).map(|(index, _)| index)
        };
        let replaces = same.is_some();
        let index = same.or_else(free).or_else(oldest)?;
        let slot = self.dynamics.get_mut(index)?;
        let evicted = slot.as_ref().is_some_and(|held| held.connection.state != ConnectionState::NonExistent);
        if evicted && !replaces {
            self.lost.connections = self.lost.connections.saturating_add(1);
        }
        *slot = Some(new);
        self.count_dynamics();
        Some(index)
    }

    /// Ends the dynamic connection with that instance at a server. It keeps its record and loses its identifiers.
    pub(super) fn close_dynamic(&mut self, server: MacId, instance: InstanceId, at: Instant) {
        for dynamic in self.dynamics.iter_mut().flatten() {
            if dynamic.server == server && dynamic.instance == Some(instance) {
                dynamic.end(at);
            }
        }
        self.count_dynamics();
    }

    /// The watchdogs of all connections of a node were started anew.
    pub(super) fn reset_connections(&mut self, mac: MacId, at: Instant) {
        self.node(mac).connections.iter_mut().for_each(|connection| connection.reset(at));
        for dynamic in self.dynamics.iter_mut().flatten().filter(|dynamic| dynamic.server == mac) {
            dynamic.connection.reset(at);
        }
    }

    /// A node has restarted or left the network.
    pub(super) fn drop_connections(&mut self, mac: MacId, at: Instant) {
        self.node(mac).drop_connections(at);
        for dynamic in self.dynamics.iter_mut().flatten().filter(|dynamic| dynamic.server == mac) {
            dynamic.end(at);
        }
        self.count_dynamics();
    }

    /// A device has asked for a MAC ID, or has it. What is known of it under another one is over, unless it is another port.
    pub(super) fn moved(&mut self, to: MacId, check: &DuplicateMacCheck, at: Instant) {
        let Self { nodes, dynamics, .. } = self;
        for (mac, node) in MacId::all().zip(nodes).filter(|&(mac, _)| mac != to) {
            node.rival = node.rival.filter(|&rival| rival != check.device);
            let is_port = node.identity.port.is_none_or(|port| port == check.port);
            if is_port && node.is(check.device) {
                node.leaves(at);
                let own = dynamics.iter_mut().flatten().filter(|held| held.server == mac);
                own.for_each(|held| held.connection.lapse());
            }
        }
    }

    /// Counts the frame, for its sender.
    pub(super) fn count(&mut self, reading: &Reading<'_>) {
        if reading.note == Some(Note::NotStored) {
            self.lost.long_messages = self.lost.long_messages.saturating_add(1);
        }
        let Some(source) = reading.src else { return };
        let is_refused = reading.fields.explicit.status.is_some()
            || reading.message.is_some_and(|message| message.fields.explicit.status.is_some());
        self.node(source).traffic.count(Sent {
            at: reading.at,
            bytes: reading.frame.data().len(),
            is_problem: reading.problem.is_some(),
            is_error_response: is_refused,
            latency: reading.request.map(|request| request.latency),
        });
    }

    pub(super) fn add_role(&mut self, mac: MacId, role: Roles) {
        self.node(mac).roles |= role;
    }

    fn count_dynamics(&mut self) {
        let used = |dynamic: &&Dynamic| !dynamic.is_io && dynamic.group == 2 && dynamic.requests.is_some();
        self.created = self.dynamics.iter().flatten().filter(|dynamic| dynamic.is_io).count();
        self.group2_dynamics = self.dynamics.iter().flatten().filter(used).count();
    }
}

impl Dynamic {
    /// What a reading of one of its frames says of it.
    pub(super) fn told(&self) -> DynamicConnection {
        DynamicConnection {
            server: self.server,
            client: self.client,
            instance: self.instance,
            group: self.group,
            state: self.connection.state,
        }
    }

    fn end(&mut self, at: Instant) {
        self.connection.end(at);
        self.requests = None;
        self.responses = None;
    }
}

/// Whether the explicit connection that UCMM has opened at a server is still there.
fn is_open(dynamics: &[Option<Dynamic>], server: MacId, parent: Parent, now: Instant) -> bool {
    dynamics.iter().flatten().any(|held| {
        let mut connection = held.connection;
        connection.settle(now, true, false);
        let is_it = held.server == server && held.client == parent.client && held.instance == parent.instance;
        is_it && !held.is_io && connection.state == ConnectionState::Established
    })
}

fn node(nodes: &mut [Node; MacId::COUNT], mac: MacId) -> &mut Node {
    let [zero, others @ ..] = nodes;
    mac.index().checked_sub(1).and_then(|index| others.get_mut(index)).unwrap_or(zero)
}
