//! What the doctor asks the monitor of a node: single facts, without a copy of the record.

use core::time::Duration;

use cip_core::code::{DeviceType, VendorId};
use cip_core::message::AllocationChoice;
use cip_core::monitor::{Connection, ConnectionState};
use link_core::Instant;

use super::connections::Predefined;
use super::nodes::{AccessState, Node};
use crate::id::MacId;

/// The nodes, after a frame was read.
#[derive(Clone, Copy)]
pub(crate) struct Records<'a> {
    pub(super) nodes: &'a [Node; MacId::COUNT],
}

/// What Identity object and duplicate MAC ID check have told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(crate) struct Told {
    pub(crate) vendor: Option<VendorId>,
    pub(crate) device_type: Option<DeviceType>,
    pub(crate) product: Option<u16>,
    pub(crate) revision: Option<(u8, u8)>,
    pub(crate) serial: Option<u32>,
}

/// How a slave produces by change of state or cyclic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Rhythm {
    /// The expected packet rate: so long after a message comes the next, if nothing changes.
    pub(crate) period: Duration,
    /// So long after a message comes no other.
    pub(crate) inhibit: Duration,
    /// It does not matter whether something changes.
    pub(crate) is_cyclic: bool,
}

impl<'a> Records<'a> {
    /// Where a node stands on its way to the network.
    pub(crate) fn access(self, mac: MacId, now: Instant) -> AccessState {
        self.node(mac).map_or(AccessState::Unknown, |node| node.access_at(now))
    }

    pub(crate) fn owner(self, mac: MacId) -> Option<MacId> {
        self.node(mac)?.owner()
    }

    pub(crate) fn told(self, mac: MacId) -> Told {
        self.node(mac).map_or_else(Told::default, |node| Told {
            vendor: node.identity.vendor,
            device_type: node.identity.device_type,
            product: node.identity.product,
            revision: node.identity.revision,
            serial: node.identity.serial,
        })
    }

    /// How long the peers of a connection wait for each other.
    pub(crate) fn patience(self, mac: MacId, which: Predefined) -> Option<Duration> {
        self.connection(mac, which)?.time_out()
    }

    /// How a slave produces by change of state or cyclic; `None` as long as its expected packet rate is not known, or 0.
    pub(crate) fn rhythm(self, mac: MacId) -> Option<Rhythm> {
        let node = self.node(mac)?;
        let connection = node.peek(Predefined::CosCyclic);
        let milliseconds = |value: u16| Duration::from_millis(value.into());
        Some(Rhythm {
            period: connection.epr.filter(|&epr| epr != 0).map(milliseconds)?,
            inhibit: connection.inhibit.map_or(Duration::ZERO, milliseconds),
            is_cyclic: node.choice().is_some_and(|choice| {
                choice.contains(AllocationChoice::CYCLIC)
                    && !choice.contains(AllocationChoice::CHANGE_OF_STATE)
            }),
        })
    }

    /// The command of frame `n` wants an answer: the allocation says so, or one before was answered.
    pub(crate) fn awaits(self, mac: MacId, which: Predefined, n: u64) -> bool {
        self.connection(mac, which).is_some_and(|held| {
            held.waiting.is_some_and(|waiting| waiting.n == n)
                && (held.answers || self.is_allocation_told(mac))
        })
    }

    /// Allocate, Release or allocation information of a slave was seen. Otherwise its I/O is only assumed to be what it seems.
    pub(crate) fn is_allocation_told(self, mac: MacId) -> bool {
        self.node(mac).is_some_and(|node| node.allocation.is_some())
    }

    /// The bit-strobe or multicast poll command of `sender`, or to its group, wants an answer of this node.
    pub(crate) fn is_addressed(self, mac: MacId, which: Predefined, sender: MacId) -> bool {
        let Some(node) = self.node(mac) else { return false };
        let addressed = if which == Predefined::BitStrobe { node.owner() } else { node.multicast_group() };
        addressed.is_none_or(|addressed| addressed == sender) && node.peek(which).is_alive()
    }

    /// Since when the watchdog of a connection must have expired, and whether it has been touched since it was established.
    pub(crate) fn overdue(self, mac: MacId, which: Predefined, now: Instant) -> Option<Instant> {
        let connection = self.connection(mac, which)?;
        let is_over = match connection.state {
            ConnectionState::Established => {
                connection.watchdog().is_some_and(|time| now.saturating_since(connection.active) > time)
            }
            ConnectionState::TimedOut => true,
            ConnectionState::Unknown
            | ConnectionState::NonExistent
            | ConnectionState::Configuring
            | ConnectionState::WaitingForConnectionId
            | ConnectionState::DeferredDelete => false,
        };
        is_over.then_some(connection.active)
    }

    fn connection(self, mac: MacId, which: Predefined) -> Option<&'a Connection> {
        let node = self.nodes.get(mac.index())?;
        Some(node.peek(which))
    }

    fn node(self, mac: MacId) -> Option<&'a Node> {
        self.nodes.get(mac.index())
    }
}
