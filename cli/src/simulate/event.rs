//! What the machines on the simulated bus tell.

use core::fmt;

use devicenet_core::access::{AccessEvent, StateKind};

/// What a node tells.
#[derive(Clone, Copy, Debug)]
pub(crate) enum NodeEvent {
    /// Network access.
    Access(AccessEvent),
}

impl NodeEvent {
    /// Something is wrong with the node.
    pub(crate) const fn is_problem(&self) -> bool {
        match self {
            Self::Access(event) => match event {
                AccessEvent::StateChanged { to, .. } => matches!(to, StateKind::CommFault),
                AccessEvent::Duplicate { .. }
                | AccessEvent::NotAcknowledged
                | AccessEvent::NotSent { .. }
                | AccessEvent::MacIdLocked { .. }
                | AccessEvent::BadFrame { .. }
                | AccessEvent::FramesLost { .. }
                | AccessEvent::LinkRefused(_) => true,
                AccessEvent::Challenged { .. }
                | AccessEvent::MacIdAssigned { .. }
                | AccessEvent::Identify { .. } => false,
            },
        }
    }
}

impl From<AccessEvent> for NodeEvent {
    fn from(event: AccessEvent) -> Self {
        Self::Access(event)
    }
}

impl fmt::Display for NodeEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Access(event) => event.fmt(f),
        }
    }
}
