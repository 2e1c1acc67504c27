//! The external nodes, through which clients of the server come onto the bus.

use core::time::Duration;
use std::collections::BTreeMap;

use link_core::{Instant, LinkEvent, TxOutcome};
use transport_mock::nodes::{External, ExternalEvent};
use transport_mock::{Network, NodeId};

use super::event::NodeEvent;
use super::sight::{Observer, index};
use super::socketcand::{ClientId, Complaint, MOST_CLIENTS, Outgoing, Server};
use crate::recording::controller;
use crate::scenario::{Role, Scenario};
use crate::text;

/// The machine of an external node. Each frame knows whose it is.
pub(super) type Outside = External<ClientId>;

/// The machine of an external node, which restarts by itself after bus-off.
pub(super) fn outside() -> Outside {
    // One client does not use up what there is. Those that have gone may leave frames, and many that come and go would fill
    // the memory without a limit.
    External::new().with_restart(RESTART).with_capacity(MOST_CLIENTS * MOST_WAITING)
}

/// The external nodes, in the order of the server's channels.
pub(super) struct Doors {
    doors: Vec<Door>,
    /// Frames that were not sent since the last time, by door and client.
    lost: BTreeMap<(usize, ClientId), u64>,
    /// When something was last told in the trace.
    told: Option<Instant>,
}

struct Door {
    id: NodeId,
    /// Frames that wait to be sent, of each client that has some.
    waiting: BTreeMap<ClientId, usize>,
    is_bus_off: bool,
}

impl Doors {
    pub(super) fn of(scenario: &Scenario, network: &Network<NodeEvent>) -> Self {
        let external = network.nodes().filter(|id| scenario.nodes[id.index()].role == Role::External);
        let door = |id| Door { id, waiting: BTreeMap::new(), is_bus_off: false };
        Self { doors: external.map(door).collect(), lost: BTreeMap::new(), told: None }
    }

    /// Frames of clients go to the bus.
    pub(super) fn take_in(
        &mut self,
        network: &mut Network<NodeEvent>,
        server: &mut Server,
        outgoing: Vec<Outgoing>,
    ) {
        for Outgoing { client, channel, frame } in outgoing {
            let door = &mut self.doors[channel];
            let own = door.waiting.get(&client).copied().unwrap_or(0);
            let inject = |outside: &mut Outside, now| outside.inject(now, client, frame);
            if own < MOST_WAITING && network.command(door.id, inject).is_some_and(|taken| taken.is_ok()) {
                door.waiting.insert(client, own + 1);
            } else {
                server.lost(network.now(), client, controller::CONTROLLER, "too many frames wait to be sent");
                *self.lost.entry((channel, client)).or_default() += 1;
            }
        }
    }

    /// What was on the bus goes to clients, and what they cannot be told into the trace.
    pub(super) fn hand_out(
        &mut self,
        network: &mut Network<NodeEvent>,
        server: &mut Server,
        observer: &mut Observer<'_>,
    ) {
        for (channel, door) in self.doors.iter_mut().enumerate() {
            while let Some((at, event)) =
                network.command(door.id, |outside: &mut Outside, _| outside.take()).flatten()
            {
                match event {
                    ExternalEvent::Received(frame) => server.frame(at, channel, &frame, None),
                    ExternalEvent::Done { owner, frame, outcome } => {
                        door.leave(owner);
                        match outcome {
                            TxOutcome::Sent => server.frame(at, channel, &frame, Some(owner)),
                            TxOutcome::Dropped | TxOutcome::Withdrawn | TxOutcome::Unknown => {
                                server.lost(at, owner, controller::TX_TIMEOUT, "the frame was not sent");
                                *self.lost.entry((channel, owner)).or_default() += 1;
                            }
                        }
                    }
                    ExternalEvent::Link(event) => {
                        if let LinkEvent::Overrun { lost } = event {
                            let words = format!("overrun, clients miss {}", lost.max(1));
                            observer.trouble(network.now(), Some(index(door.id)), words);
                        }
                        if let Some(class) = door.class(event) {
                            server.bus_error(at, channel, class);
                        }
                    }
                }
            }
        }
        self.announce(network, server, observer);
    }

    /// Tells in the trace what was kept back.
    pub(super) fn conclude(
        &mut self,
        network: &Network<NodeEvent>,
        server: &mut Server,
        observer: &mut Observer<'_>,
    ) {
        self.told = None;
        self.announce(network, server, observer);
    }

    /// What goes wrong without end is told now and then, with how often.
    fn announce(&mut self, network: &Network<NodeEvent>, server: &mut Server, observer: &mut Observer<'_>) {
        let now = network.now();
        if self.told.is_some_and(|told| now < told + SILENCE) {
            return;
        }
        let node = |channel: usize| index(self.doors[channel].id);
        let (lost, complaints) = (core::mem::take(&mut self.lost), server.complaints());
        if !lost.is_empty() || !complaints.is_empty() {
            self.told = Some(now);
        }
        for ((channel, client), count) in lost {
            let words = format!("{} of {client} not sent", text::count(count, "frame"));
            observer.trouble(network.now(), Some(node(channel)), words);
        }
        for (client, Complaint { channel, words, more }) in complaints {
            let and_more = if more == 0 { String::new() } else { format!(", and {more} more") };
            let words = format!("{client}: {words}{and_more}");
            observer.trouble(network.now(), channel.map(node), words);
        }
    }
}

impl Door {
    /// A frame of a client no longer waits.
    fn leave(&mut self, client: ClientId) {
        if let Some(own) = self.waiting.get_mut(&client) {
            *own -= 1;
            if *own == 0 {
                self.waiting.remove(&client);
            }
        }
    }

    /// The error frame that a SocketCAN interface gives.
    fn class(&mut self, event: LinkEvent) -> Option<u32> {
        match event {
            LinkEvent::BusOff => {
                self.is_bus_off = true;
                Some(controller::BUS_OFF)
            }
            LinkEvent::Up => core::mem::take(&mut self.is_bus_off).then_some(controller::RESTARTED),
            LinkEvent::Down => {
                self.is_bus_off = false;
                None
            }
            LinkEvent::BusError(_) => Some(controller::BUS_ERROR),
            LinkEvent::ErrorWarning
            | LinkEvent::ErrorPassive
            | LinkEvent::ErrorActive
            | LinkEvent::Overrun { .. } => Some(controller::CONTROLLER),
            LinkEvent::Counters { .. }
            | LinkEvent::ModeSet(_)
            | LinkEvent::FilterSet
            | LinkEvent::Refused(_) => None,
        }
    }
}

/// Frames of one client that wait at one external node.
const MOST_WAITING: usize = 1024;
/// Between two times at which the trace tells what went wrong with clients.
const SILENCE: Duration = Duration::from_millis(100);
/// From bus-off to the restart, as `restart-ms` of an interface.
const RESTART: Duration = Duration::from_millis(100);

#[cfg(test)]
mod tests;
