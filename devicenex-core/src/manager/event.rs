//! What the manager tells the application, and what it counts.

use core::fmt;

use cip_core::client::Failure;
use cip_core::code::{GeneralStatus, InstanceId};
use cip_core::connection::{TransportClassTrigger, WatchdogAction};
use heapless::Vec;
use link_core::Frame;

use super::database::Attribute;
use super::state::{Cause, DeviceState};
use crate::connection::ConnectionId;
use crate::device;
use crate::id::OperationalAddress;
use crate::message::{DeviceIdentity, Hello, ParseError, Roam};

/// What happened.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum ManagerEvent {
    /// The node that the manager itself is.
    Node(device::DeviceEvent),
    /// It begins its work: every planned device is being looked for.
    Started,
    /// It does nothing any more: it is off line, or leaves the work to another manager.
    Stopped,
    /// Another node has its address. It says Hello with this one now: its own once more, or another that is free as far as
    /// it knows ([`Config::rejoin_after`](super::Config::rejoin_after)).
    Rejoins(OperationalAddress),
    /// There is another manager on the bus.
    SecondManager {
        /// The low half of its serial number, from its Mini-who; `None` if it showed by a ROAM, which does not tell.
        serial_low: Option<u16>,
        /// This one leaves the work to it.
        yields: bool,
    },
    /// Something about a planned device.
    Planned(OperationalAddress, PlannedEvent),
    /// A device that is planned nowhere. `at` is its address, if it has one.
    Unknown {
        /// Who it is.
        device: DeviceIdentity,
        /// Its address; `None` if it has none.
        at: Option<OperationalAddress>,
    },
    /// A device stands by that may stand in for one that is there.
    Spare(DeviceIdentity),
    /// A device that stood by does not answer any more.
    StandbyLeft(DeviceIdentity),
    /// A planned device has another address than the planned one.
    Misplaced {
        /// Who it is.
        device: DeviceIdentity,
        /// Where it is.
        at: OperationalAddress,
        /// Where it should be.
        planned: OperationalAddress,
    },
    /// A device was told its new address, or was not.
    Readdressed {
        /// Its old address.
        from: OperationalAddress,
        /// Its new address, with which it says Hello now.
        to: OperationalAddress,
        /// How it ended.
        result: Result<(), RequestFailure>,
    },
    /// The response to a request of the application is there: [`Manager::response`](super::Manager::response).
    Response(OperationalAddress),
    /// A request of the application came to nothing.
    RequestFailed(OperationalAddress, RequestFailure),
    /// A Hello or ROAM cannot be read, and was ignored. [`error`](ManagerEvent::error) says what is wrong with it.
    BadFrame(Frame),
}

/// What happened to a planned device, or rather to its role.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum PlannedEvent {
    /// Another state.
    StateChanged {
        /// The state that was left.
        from: DeviceState,
        /// The state that was entered.
        to: DeviceState,
        /// Why.
        cause: Cause,
    },
    /// It was added to the database.
    Learned(DeviceIdentity),
    /// A device for this address was heard, and will get it.
    Found(DeviceIdentity),
    /// A device is on line with the address.
    Addressed(DeviceIdentity),
    /// It was sent its address several times, and did not take it.
    NotAddressed(DeviceIdentity),
    /// A connection is established.
    Connected {
        /// Which.
        instance: InstanceId,
        /// On which the device produces; `None` if it only consumes.
        produces: Option<ConnectionId>,
        /// What the device keeps, in ms.
        expected_packet_rate: u16,
    },
    /// The device refuses a connection, or its configuration. It is asked again later.
    Refused {
        /// Which; `None` for a dynamic one that was not made.
        instance: Option<InstanceId>,
        /// Why; `None` if the answer cannot be read.
        status: Option<GeneralStatus>,
    },
    /// A connection that was there already is not as planned.
    Differs {
        /// Which.
        instance: InstanceId,
        /// In what.
        difference: Difference,
    },
    /// Nothing was heard on a connection for too long, or the device says that it has timed out.
    TimedOut(InstanceId),
    /// The device is gone.
    Lost(Option<DeviceIdentity>),
    /// Another device took over the address.
    Replaced {
        /// Who had it.
        was: DeviceIdentity,
        /// Who has it now.
        by: DeviceIdentity,
    },
    /// Nobody who could stand in has answered. The manager goes on looking.
    NoSpare,
    /// Somebody has the address for whom it is not planned.
    Conflict(Option<DeviceIdentity>),
    /// Another device wants the address, and is being told that it is taken.
    Challenged(DeviceIdentity),
    /// An attribute was read.
    Read(Attribute, Result<Value, RequestFailure>),
}

/// What differs from the plan in a connection that was there already. All but the first is set as planned.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Difference {
    /// The device produces on another identifier. It is left so: whoever consumes it is told that one.
    Produces {
        /// The one that follows from the plan.
        planned: ConnectionId,
        /// That of the connection.
        actual: ConnectionId,
    },
    /// It consumes what another produces.
    Consumes {
        /// What the planned producer produces on.
        planned: ConnectionId,
        /// That of the connection.
        actual: ConnectionId,
    },
    /// Attribute 3.
    Trigger {
        /// That of the plan.
        planned: TransportClassTrigger,
        /// That of the connection.
        actual: TransportClassTrigger,
    },
    /// Attribute 12.
    WatchdogAction {
        /// That of the plan.
        planned: WatchdogAction,
        /// That of the connection.
        actual: WatchdogAction,
    },
    /// Attribute 9, in ms. A device that rounds the planned one is asked to keep it, and keeps what it can.
    PacketRate {
        /// That of the plan.
        planned: u16,
        /// That of the connection.
        actual: u16,
    },
}

/// The value of an attribute, if it is not longer than that.
pub type Value = Vec<u8, VALUE>;

/// Why a request of the manager came to nothing.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RequestFailure {
    /// The device refuses it.
    #[error("refused: {0}")]
    Refused(GeneralStatus),
    /// There was no answer, or none that can be used.
    #[error(transparent)]
    Failed(#[from] Failure),
}

/// What the manager counted. Every counter stays at its maximum.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Counters {
    /// Mini-whos that were sent.
    pub mini_whos: u32,
    /// ROAMs that were sent.
    pub roams: u32,
    /// Hellos without an address that were heard.
    pub hellos: u32,
    /// Devices that were lost.
    pub lost: u16,
    /// Devices that took over the address of another one.
    pub replaced: u16,
    /// Time-outs of connections.
    pub timed_out: u16,
    /// Connection requests, and configurations, that were refused.
    pub refused: u16,
    /// Answers to nobody's question, or that came too late.
    pub ignored: u32,
    /// Hellos and ROAMs that cannot be read.
    pub bad_frames: u16,
    /// Frames that were given back unsent although nobody asked for it.
    pub not_sent: u16,
    /// Mini-whos and ROAMs of others.
    pub of_other_managers: u32,
    /// Answers to transmissions that were not under way: the port breaks the contract.
    pub stray_tx_done: u16,
    /// Events that were lost because nobody fetched them.
    pub events_lost: u16,
}

impl ManagerEvent {
    /// What is wrong with a [`BadFrame`](Self::BadFrame).
    #[must_use]
    pub fn error(&self) -> Option<ParseError> {
        let Self::BadFrame(frame) = self else { return None };
        let hello = Hello::of_frame(frame).and_then(Result::err);
        hello.or_else(|| Roam::of_frame(frame).and_then(Result::err))
    }
}

/// One line, in the words of a trace.
impl fmt::Display for ManagerEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Node(event) => fmt::Display::fmt(event, f),
            Self::Started => f.write_str("looks for all planned devices"),
            Self::Stopped => f.write_str("does nothing any more"),
            Self::Rejoins(address) => write!(f, "tries OA {address}"),
            Self::SecondManager { serial_low, yields } => {
                f.write_str("another manager")?;
                if let Some(serial_low) = serial_low {
                    write!(f, ", serial ending in 0x{serial_low:04X}")?;
                }
                f.write_str(if *yields { ": leaves the work to it" } else { ": goes on working" })
            }
            Self::Planned(address, event) => write!(f, "OA {address}: {event}"),
            Self::Unknown { device, at: None } => write!(f, "unknown device without an address: {device}"),
            Self::Unknown { device, at: Some(at) } => write!(f, "unknown device at OA {at}: {device}"),
            Self::Spare(device) => write!(f, "spare stands by: {device}"),
            Self::StandbyLeft(device) => write!(f, "no longer stands by: {device}"),
            Self::Misplaced { device, at, planned } => {
                write!(f, "at OA {at} instead of {planned}: {device}")
            }
            Self::Readdressed { from, to, result: Ok(()) } => write!(f, "OA {from} becomes {to}"),
            Self::Readdressed { from, to, result: Err(why) } => {
                write!(f, "OA {from} does not become {to}: {why}")
            }
            Self::Response(address) => write!(f, "response of OA {address}"),
            Self::RequestFailed(address, why) => write!(f, "request to OA {address} failed: {why}"),
            Self::BadFrame(frame) => {
                write!(f, "bad frame {frame}")?;
                self.error().map_or(Ok(()), |error| write!(f, ": {error}"))
            }
        }
    }
}

impl fmt::Display for PlannedEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StateChanged { from, to, cause } => write!(f, "{from} -> {to}: {cause}"),
            Self::Learned(device) => write!(f, "learned: {device}"),
            Self::Found(device) => write!(f, "found: {device}"),
            Self::Addressed(device) => write!(f, "on line: {device}"),
            Self::NotAddressed(device) => write!(f, "does not take the address: {device}"),
            Self::Connected { instance, produces, expected_packet_rate } => {
                write!(f, "connection {} established, {expected_packet_rate} ms", instance.0)?;
                produces.map_or(Ok(()), |id| write!(f, ", produces on {id}"))
            }
            Self::Refused { instance, status } => {
                match instance {
                    Some(instance) => write!(f, "connection {} refused", instance.0)?,
                    None => f.write_str("dynamic connection refused")?,
                }
                status.map_or(Ok(()), |status| write!(f, ": {status}"))
            }
            Self::Differs { instance, difference } => {
                write!(f, "connection {} is not as planned: {difference}", instance.0)
            }
            Self::TimedOut(instance) => write!(f, "connection {} timed out", instance.0),
            Self::Lost(Some(device)) => write!(f, "lost: {device}"),
            Self::Lost(None) => f.write_str("never seen: spares may come in"),
            Self::Replaced { was, by } => write!(f, "replaced: {was} by {by}"),
            Self::NoSpare => f.write_str("nobody can stand in"),
            Self::Conflict(Some(device)) => write!(f, "the address is taken by {device}"),
            Self::Conflict(None) => f.write_str("the address is taken by a device of another kind"),
            Self::Challenged(device) => write!(f, "another wants the address: {device}"),
            Self::Read(attribute, Ok(value)) => write!(f, "{attribute}: {value:02X?}"),
            Self::Read(attribute, Err(why)) => write!(f, "{attribute}: {why}"),
        }
    }
}

/// `packet rate 100 ms, planned 500 ms`
impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Produces { planned, actual } => write!(f, "produces on {actual}, planned {planned}"),
            Self::Consumes { planned, actual } => write!(f, "consumes {actual}, planned {planned}"),
            Self::Trigger { planned, actual } => {
                write!(f, "transport class and trigger 0x{:02X}, planned 0x{:02X}", actual.0, planned.0)
            }
            Self::WatchdogAction { planned, actual } => {
                write!(f, "watchdog action {actual}, planned {planned}")
            }
            Self::PacketRate { planned, actual } => {
                write!(f, "packet rate {actual} ms, planned {planned} ms")
            }
        }
    }
}

const VALUE: usize = 64;
