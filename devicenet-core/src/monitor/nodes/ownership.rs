//! Who owns the predefined connection set of a node.

use cip_core::code::InstanceId;
use cip_core::message::AllocationChoice;
use cip_core::monitor::{Connection, ConnectionState};

use super::Node;
use crate::id::MacId;
use crate::monitor::Predefined;

/// Who owns a predefined connection set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(in crate::monitor) struct Allocation {
    pub(in crate::monitor) choice: AllocationChoice,
    /// `None`: not allocated.
    pub(in crate::monitor) master: Option<MacId>,
}

/// The explicit connection that the I/O connections were allocated through, if it is one that UCMM has opened. As long as
/// it is open they can stay in Configuring.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(in crate::monitor) struct Parent {
    pub(in crate::monitor) client: MacId,
    pub(in crate::monitor) instance: Option<InstanceId>,
}

impl Node {
    /// The master that owns the connection set, as an allocation has told or else as the traffic suggests.
    pub(in crate::monitor) fn owner(&self) -> Option<MacId> {
        self.allocation.map_or(self.client, |_| self.told_owner())
    }

    /// The master that owns the connection set, if an allocation has told.
    pub(in crate::monitor) fn told_owner(&self) -> Option<MacId> {
        let master = self.allocation.and_then(|allocation| allocation.master);
        master.filter(|_| self.is_held())
    }

    /// The ownership lasts as long as a connection of the set: it lapses when the last has ended or timed out, and a slave
    /// that goes on shows that it has not.
    fn is_held(&self) -> bool {
        let holds = |connection: &Connection| {
            matches!(connection.state, ConnectionState::Established | ConnectionState::DeferredDelete)
        };
        self.connections.iter().any(holds)
            || !self.live_choice().difference(AllocationChoice::ACK_SUPPRESSION).is_empty()
    }

    /// It has answered `client` on its explicit connection, which it does for the owner only.
    pub(in crate::monitor) fn answers_owner(&mut self, client: MacId) {
        self.client = Some(client);
        if let Some(allocation) = &mut self.allocation
            && allocation.master.is_some()
        {
            allocation.master = Some(client);
        }
    }

    /// The multicast group that its multicast poll connection belongs to.
    pub(in crate::monitor) fn multicast_group(&self) -> Option<MacId> {
        self.group.or(self.owner())
    }

    /// No allocation was seen, and the slave produces by change of state or cyclic and was never heard to answer a poll: what its
    /// master sends it without data are no polls.
    pub(in crate::monitor) fn seems_to_produce_only(&self) -> bool {
        self.allocation.is_none()
            && self.peek(Predefined::CosCyclic).produced.heard
            && !self.peek(Predefined::Poll).answers
    }

    /// The choice, if an allocation is known to exist.
    pub(in crate::monitor) fn choice(&self) -> Option<AllocationChoice> {
        self.allocation.filter(|allocation| allocation.master.is_some()).map(|allocation| allocation.choice)
    }

    /// The bits of the choice whose connections still exist.
    pub(in crate::monitor) fn live_choice(&self) -> AllocationChoice {
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
}
