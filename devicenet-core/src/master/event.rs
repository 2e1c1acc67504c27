//! What the master tells the application, and what it counts.

use core::fmt;

use cip_core::code::{AdditionalCode, GeneralStatus};
use cip_core::message::Response;

use super::difference::Difference;
use super::replacement::Replacement;
use super::scan_list::IoInstance;
use super::state::{Cause, SlaveState};
use super::status::ScannerStatus;
use crate::access::{AccessEvent, NetworkStatus};
use crate::client::Failure;
use crate::id::MacId;
use crate::message::{Heartbeat, Shutdown};
use crate::slave;

/// What the master tells the application.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MasterEvent {
    /// About the master's own network access.
    Access(AccessEvent),
    /// About the master as a node that answers others.
    Node(slave::SlaveEvent),
    /// The network status indicator shows something else.
    NetworkStatus(NetworkStatus),
    /// About a slave.
    Slave {
        /// Which.
        mac_id: MacId,
        /// What.
        event: SlaveEvent,
    },
    /// A scan is over: every command was sent, and every response is there or was given up.
    ScanDone {
        /// Responses that were missing.
        missing: u8,
    },
    /// A look at MAC ID 63 for a replacement of a missing slave.
    Replacement(Replacement),
    /// Events were lost, because they were not fetched between inputs.
    EventsLost {
        /// How many.
        count: u16,
    },
}

/// What the master tells about a slave.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SlaveEvent {
    /// It is in another state.
    StateChanged {
        /// Before.
        from: SlaveState,
        /// Now.
        to: SlaveState,
        /// Why.
        cause: Cause,
    },
    /// Its scanner status changed.
    Status(ScannerStatus),
    /// It is not as the scan list says; its attempt ends.
    Differs(Difference),
    /// It answered with an error that ends its attempt.
    Refused {
        /// Why.
        status: GeneralStatus,
        /// More about it.
        additional: AdditionalCode,
    },
    /// New input data: [`Master::input_data`](super::Master::input_data).
    Input(IoInstance),
    /// A response to [`Master::request`](super::Master::request): [`Master::response`](super::Master::response).
    Response,
    /// No response to [`Master::request`](super::Master::request).
    RequestFailed(Failure),
    /// Its heartbeat.
    Heartbeat(Heartbeat),
    /// It goes off line on purpose.
    Shutdown(Shutdown),
}

/// What is counted for a slave. All counters saturate.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SlaveCounters {
    /// I/O commands sent: poll, bit-strobe, multicast poll.
    pub commands: u32,
    /// I/O messages received.
    pub received: u32,
    /// Scans in which its response was missing.
    pub missed: u32,
    /// Times that it was lost while it ran.
    pub timeouts: u16,
    /// Times that its I/O was established.
    pub established: u16,
    /// Attempts to bring it up that failed.
    pub attempts_failed: u16,
    /// I/O messages dropped for a missing or repeated fragment.
    pub fragment_errors: u16,
    /// I/O messages dropped for their length.
    pub length_errors: u16,
    /// Explicit frames that were of no use: late, repeated, malformed.
    pub explicit_ignored: u16,
    /// Explicit requests that got no response.
    pub explicit_failed: u16,
    /// Heartbeats.
    pub heartbeats: u32,
}

/// What is counted for the master as a whole. All counters saturate.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Counters {
    /// Scans.
    pub scans: u32,
    /// Frames of other nodes that the master has nothing to do with.
    pub unrelated: u32,
    /// I/O messages of slaves that do not run, or of a connection that they were not asked for.
    pub unexpected: u32,
    /// Frames that the controller gave back unsent.
    pub not_sent: u32,
    /// Errors on the bus while a request to an unconnected port was in flight: it was taken back, and sent again later.
    pub collisions: u16,
    /// Answers of the port that no frame was waiting for.
    pub stray_tx_done: u16,
    /// Commands to the controller that were refused.
    pub refused: u16,
    /// Events that were not fetched in time.
    pub events_lost: u16,
}

impl fmt::Display for MasterEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Access(event) => fmt::Display::fmt(event, f),
            Self::Node(event) => fmt::Display::fmt(event, f),
            Self::NetworkStatus(status) => fmt::Display::fmt(&slave::SlaveEvent::NetworkStatus(*status), f),
            Self::Slave { mac_id, event } => write!(f, "slave {mac_id}: {event}"),
            Self::ScanDone { missing: 0 } => f.write_str("scan done"),
            Self::ScanDone { missing } => write!(f, "scan done, {missing} missing"),
            Self::Replacement(replacement) => write!(f, "replacement: {replacement}"),
            Self::EventsLost { count } => write!(f, "{count} events lost"),
        }
    }
}

impl fmt::Display for Replacement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::WouldAssign(slave) => write!(f, "the device at MAC ID 63 would become slave {slave}"),
            Self::Assigned(slave) => write!(f, "the device at MAC ID 63 becomes slave {slave}"),
            Self::NoMatch => f.write_str("the device at MAC ID 63 is none that is missing"),
            Self::SeveralMissing => f.write_str("several slaves of its kind are missing"),
            Self::SeveralCandidates => f.write_str("several devices were heard at MAC ID 63"),
            Self::Refused => f.write_str("the device at MAC ID 63 does not let its MAC ID be set"),
        }
    }
}

impl fmt::Display for SlaveEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StateChanged { from, to, cause } => write!(f, "{from} -> {to}: {cause}"),
            Self::Status(status) => write!(f, "status {status}"),
            Self::Differs(difference) => write!(f, "not as expected: {difference}"),
            Self::Refused { status, additional } => {
                let response = Response::Error { status: *status, additional: *additional };
                write!(f, "refused: {response}")
            }
            Self::Input(instance) => write!(f, "{instance} input"),
            Self::Response => f.write_str("response"),
            Self::RequestFailed(failure) => write!(f, "request failed: {failure}"),
            Self::Heartbeat(heartbeat) => write!(f, "heartbeat: {}", heartbeat.state),
            Self::Shutdown(shutdown) => write!(f, "shutdown: {}", shutdown.code),
        }
    }
}
