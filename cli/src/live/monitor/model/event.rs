//! What happens, one line each.

use core::fmt;

use devicenet_core::MacId;
use devicenet_core::doctor::Change;
use devicenet_core::monitor::{AccessState, ConnectionName, ConnectionState};
use link_core::Instant;

use super::link::LinkState;

/// Something that has happened on the bus.
#[derive(Clone, Debug)]
pub(in crate::live::monitor) struct Event {
    pub(in crate::live::monitor) at: Instant,
    pub(in crate::live::monitor) what: Happening,
}

/// What it was.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(in crate::live::monitor) enum Happening {
    /// The interface, or its controller.
    Link(LinkState),
    /// A node on its way to the network.
    Access { mac: MacId, from: AccessState, to: AccessState },
    /// A connection.
    Connection {
        server: MacId,
        client: Option<MacId>,
        name: ConnectionName,
        from: ConnectionState,
        to: ConnectionState,
    },
    /// Something is wrong, is worse, or is over.
    Finding(Change),
    /// The interface received frames that nobody read; 0 where it does not count them.
    Lost(u32),
}

impl Happening {
    /// For programs.
    pub(in crate::live::monitor) const fn name(&self) -> &'static str {
        match self {
            Self::Link(_) => "link",
            Self::Access { .. } => "access",
            Self::Connection { .. } => "connection",
            Self::Finding(_) => "finding",
            Self::Lost(_) => "lost",
        }
    }

    /// The node that it is about.
    pub(in crate::live::monitor) const fn mac(&self) -> Option<MacId> {
        match self {
            Self::Access { mac, .. } | Self::Connection { server: mac, .. } => Some(*mac),
            Self::Finding(change) => change.finding.node,
            Self::Link(_) | Self::Lost(_) => None,
        }
    }
}

impl fmt::Display for Happening {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Link(state) => state.fmt(f),
            Self::Access { from, to, .. } => write!(f, "{} -> {}", words(*from), words(*to)),
            Self::Connection { name, from, to, client, .. } => {
                write!(f, "{name}: {from} -> {to}")?;
                match client {
                    Some(client) => write!(f, ", client {client}"),
                    None => Ok(()),
                }
            }
            Self::Finding(change) => change.fmt(f),
            Self::Lost(0) => f.write_str("frames were lost"),
            Self::Lost(1) => f.write_str("1 frame was lost"),
            Self::Lost(lost) => write!(f, "{lost} frames were lost"),
        }
    }
}

/// An access state for people.
pub(in crate::live::monitor) const fn words(state: AccessState) -> &'static str {
    match state {
        AccessState::Unknown => "not heard",
        AccessState::FirstCheck => "1st check",
        AccessState::SecondCheck => "2nd check",
        AccessState::OnLine => "online",
        AccessState::SuspectedDuplicate => "duplicate?",
        AccessState::Faulted => "comm fault",
        AccessState::OffLine => "offline",
    }
}
