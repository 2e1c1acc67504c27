//! What the tool tells the application, and what it counts.

use core::fmt;

use super::state::{Cause, ToolState};
use crate::access::AccessEvent;
use crate::id::MacId;
use crate::message::{DeviceIdentity, NodeSelection, WhoResponse};

/// What the tool tells the application.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ToolEvent {
    /// About the tool's own network access.
    Access(AccessEvent),
    /// The tool is in another state.
    StateChanged {
        /// Before.
        from: ToolState,
        /// Now.
        to: ToolState,
        /// Why.
        cause: Cause,
    },
    /// Another tool asked for the set, and was told whose it is.
    Defended {
        /// The other.
        by: Option<DeviceIdentity>,
    },
    /// A faulted node answered to Who.
    Found(WhoResponse),
    /// All faulted nodes had the time to answer to Who.
    WhoDone {
        /// How many answered.
        found: u16,
    },
    /// At least one of these faulted nodes exists.
    Identified(NodeSelection),
    /// The wait for answers to Identify is over.
    IdentifyDone {
        /// Whether anybody answered. Devices need not answer when they are meant by their serial number.
        answered: bool,
    },
    /// The device checks its new MAC ID: request 1 or 2.
    Checking {
        /// The device.
        device: DeviceIdentity,
        /// The MAC ID.
        mac: MacId,
        /// Which request.
        request: u8,
    },
    /// The device is on line with its new MAC ID.
    Recovered {
        /// The device.
        device: DeviceIdentity,
        /// The MAC ID.
        mac: MacId,
    },
    /// The device did not get its new MAC ID.
    NotRecovered {
        /// The device.
        device: DeviceIdentity,
        /// The MAC ID.
        mac: MacId,
        /// Why.
        why: Refusal,
    },
    /// A frame of the offline connection set that says nothing.
    BadFrame,
    /// Another node sends with the same identifier at the same time: the tool waits a moment.
    Collision,
    /// Events were not fetched in time.
    EventsLost(u16),
}

/// Why a device has no new MAC ID.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Refusal {
    /// Nothing was heard of it: it is gone, or does not take part in the offline connection set.
    Silent,
    /// Somebody else has that MAC ID.
    Taken,
}

/// What is counted. All counters saturate.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Counters {
    /// Ownership requests of other tools that were answered.
    pub defended: u16,
    /// Answers of faulted nodes.
    pub answers: u32,
    /// Frames of the offline connection set that could not be read, or that nobody had asked for.
    pub ignored: u32,
    /// Times that a message was taken back because another node sent with its identifier.
    pub collisions: u16,
    /// Frames that the controller gave back unsent.
    pub not_sent: u16,
    /// Answers of the port that no frame was waiting for.
    pub stray_tx_done: u16,
    /// Events that were not fetched in time.
    pub events_lost: u16,
}

impl fmt::Display for ToolEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Access(event) => fmt::Display::fmt(event, f),
            Self::StateChanged { from, to, cause } => write!(f, "{from} -> {to}: {cause}"),
            Self::Defended { by: Some(device) } => write!(f, "ownership defended against {device}"),
            Self::Defended { by: None } => f.write_str("ownership defended against an unknown tool"),
            Self::Found(answer) => write!(f, "found {}", answer.device),
            Self::WhoDone { found: 1 } => f.write_str("Who: 1 answer"),
            Self::WhoDone { found } => write!(f, "Who: {found} answers"),
            Self::Identified(_) => f.write_str("Identify: at least one node answers"),
            Self::IdentifyDone { answered: true } => f.write_str("Identify: done"),
            Self::IdentifyDone { answered: false } => f.write_str("Identify: no answer"),
            Self::Checking { device, mac, request } => {
                write!(f, "{device} checks MAC ID {mac}, request {request}")
            }
            Self::Recovered { device, mac } => write!(f, "{device} is on line with MAC ID {mac}"),
            Self::NotRecovered { device, mac, why } => write!(f, "{device} has not MAC ID {mac}: {why}"),
            Self::BadFrame => f.write_str("bad frame of the offline connection set"),
            Self::Collision => f.write_str("another node sends with the same identifier"),
            Self::EventsLost(count) => write!(f, "{count} events lost"),
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Silent => "it does not react",
            Self::Taken => "another node has it",
        })
    }
}
