//! What the nodes on the simulated bus tell, and what is told of them.

use devicenet_core::access::{AccessEvent, StateKind};

use crate::scenario::Do;

/// What a node tells, or what is told of it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum NodeEvent {
    /// Network access.
    Access(AccessEvent),
    /// An action of the scenario that cannot be seen on the bus, or has no effect.
    Action(Do, Effect),
}

/// What comes of an action.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Effect {
    /// What it says.
    AtOnce,
    /// The node has no power: what was set waits for it.
    AtPowerUp,
    /// Nothing, and why.
    None(&'static str),
}

/// Whether an event tells that something is wrong with the node.
pub(crate) const fn is_problem(event: &AccessEvent) -> bool {
    match event {
        AccessEvent::StateChanged { to, .. } => matches!(to, StateKind::CommFault),
        AccessEvent::Duplicate { .. }
        | AccessEvent::NotAcknowledged
        | AccessEvent::NotSent { .. }
        | AccessEvent::MacIdLocked { .. }
        | AccessEvent::BadFrame { .. }
        | AccessEvent::FramesLost { .. }
        | AccessEvent::LinkRefused(_) => true,
        AccessEvent::Challenged { .. } | AccessEvent::MacIdAssigned { .. } | AccessEvent::Identify { .. } => {
            false
        }
    }
}

impl From<AccessEvent> for NodeEvent {
    fn from(event: AccessEvent) -> Self {
        Self::Access(event)
    }
}

/// What is told of an action, in words.
pub(crate) fn words_of_action(action: Do, effect: Effect) -> String {
    let name = action.name();
    match (action, effect) {
        (_, Effect::None(why)) => format!("the action {name} has no effect: {why}"),
        (Do::SetMac(mac), Effect::AtOnce) => format!("MAC ID switch set to {mac}"),
        (Do::SetMac(mac), Effect::AtPowerUp) => {
            format!("MAC ID switch set to {mac}, which is read at power-up")
        }
        (_, Effect::AtOnce | Effect::AtPowerUp) => name.to_owned(),
    }
}
