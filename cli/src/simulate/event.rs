//! What the nodes on the simulated bus tell, and what is told of them.

use std::rc::Rc;

use devicenet_core::MacId;
use devicenet_core::access::{AccessEvent, StateKind};
use devicenet_core::master::{self, IoInstance, MasterEvent, Replacement, ScannerStatus, SlaveState};
use devicenet_core::slave::{IoKind, IoMode, SlaveEvent};
use devicenet_core::tool::{self, ToolEvent};

use devicenex_core::OperationalAddress;
use devicenex_core::access as nex;
use devicenex_core::device::DeviceEvent;
use devicenex_core::manager::{DeviceState, ManagerEvent, PlannedEvent};
use devicenex_core::message::ConnectionInstance;

use crate::scenario::{Do, Output};

/// What a node tells, or what is told of it.
#[derive(Clone, Debug)]
pub(crate) enum NodeEvent {
    /// Network access.
    Access(AccessEvent),
    /// Network access of a DeviceNeX node.
    NexAccess(nex::AccessEvent),
    /// The operational address of a DeviceNeX node is another one; other events say why.
    Address(OperationalAddress),
    /// A DeviceNeX device; new outputs are told by `DeviceOutput`.
    Device(DeviceEvent),
    /// A network manager.
    Manager(Box<ManagerEvent>),
    /// A DeviceNeX device has other outputs.
    DeviceOutput { connection: ConnectionInstance, data: Rc<[u8]> },
    /// A slave; new outputs are told by `Output`.
    Slave(SlaveEvent),
    /// A slave has other outputs.
    Output { connection: IoKind, data: Rc<[u8]> },
    /// A master; new inputs are told by `Input`.
    Master(MasterEvent),
    /// A master has other input data of a slave.
    Input { slave: MacId, connection: IoInstance, data: Rc<[u8]> },
    /// The status of a scanner itself has changed.
    ScannerStatus(ScannerStatus),
    /// A tool.
    Tool(ToolEvent),
    /// An action of the scenario that cannot be seen on the bus, or has no effect.
    Action(Do, Effect),
}

/// What comes of an action.
#[derive(Clone, Debug)]
pub(crate) enum Effect {
    /// What it says.
    AtOnce,
    /// The node has no power: what was set waits for it.
    AtPowerUp,
    /// Nothing, and why.
    None(String),
}

impl NodeEvent {
    /// What it is in the words of a trace.
    pub(crate) fn words(&self) -> String {
        match self {
            Self::Access(event) => event.to_string(),
            Self::NexAccess(event) => event.to_string(),
            Self::Address(address) => format!("OA {address}"),
            Self::Device(event) => event.to_string(),
            Self::Manager(event) => event.to_string(),
            Self::DeviceOutput { connection, data } => format!("{connection}: output data {}", hex(data)),
            Self::Slave(event) => event.to_string(),
            Self::Master(event) => event.to_string(),
            Self::ScannerStatus(status) => format!("scanner status {status}"),
            Self::Tool(event) => event.to_string(),
            Self::Output { connection, data } => format!("{connection}: output data {}", hex(data)),
            Self::Input { slave, connection, data } => {
                format!("slave {slave}: {connection}: input data {}", hex(data))
            }
            Self::Action(action, effect) => words_of_action(action, effect),
        }
    }

    /// False for what the frames beside it tell, and for what happens all the time.
    pub(crate) fn is_news(&self) -> bool {
        match self {
            Self::Slave(event) => is_news_of_slave(event),
            Self::Device(event) => is_news_of_device(event),
            Self::Manager(event) => is_news_of_manager(event),
            Self::Master(event) => is_news_of_master(event),
            // The change of the controller's mode tells the bit rate.
            Self::NexAccess(nex::AccessEvent::BitRateLocked(_))
            | Self::Address(_)
            | Self::DeviceOutput { .. }
            | Self::Output { .. }
            | Self::Input { .. } => false,
            Self::Access(_)
            | Self::NexAccess(_)
            | Self::ScannerStatus(_)
            | Self::Tool(_)
            | Self::Action(..) => true,
        }
    }

    /// Whether it tells that something is wrong.
    pub(crate) fn is_problem(&self) -> bool {
        match self {
            Self::Access(event) => is_problem_of_access(event),
            Self::NexAccess(event) => is_problem_of_nex_access(event),
            Self::Slave(event) => match event {
                SlaveEvent::Mode(_, mode) => matches!(mode, IoMode::Fault),
                SlaveEvent::Io { to, .. } => matches!(to, cip_core::connection::IoState::TimedOut),
                SlaveEvent::NotAcknowledged
                | SlaveEvent::ResponseAbandoned { .. }
                | SlaveEvent::NotSent { .. }
                | SlaveEvent::Ignored { .. } => true,
                _ => false,
            },
            Self::Master(event) => match event {
                MasterEvent::Slave { event: master::SlaveEvent::StateChanged { to, cause, .. }, .. } => {
                    matches!(to, SlaveState::Waiting)
                        && !matches!(
                            cause,
                            master::Cause::MasterOnLine
                                | master::Cause::CheckHeard
                                | master::Cause::Commanded
                        )
                }
                MasterEvent::Slave {
                    event:
                        master::SlaveEvent::RequestFailed(_)
                        | master::SlaveEvent::Differs(_)
                        | master::SlaveEvent::Refused { .. },
                    ..
                }
                | MasterEvent::EventsLost { .. } => true,
                MasterEvent::Replacement(what) => {
                    !matches!(what, Replacement::Assigned(_) | Replacement::WouldAssign(_))
                }
                _ => false,
            },
            Self::Tool(event) => match event {
                ToolEvent::StateChanged { cause, .. } => {
                    matches!(cause, tool::Cause::OwnedByAnother | tool::Cause::OffLine)
                }
                ToolEvent::NotRecovered { .. }
                | ToolEvent::BadFrame
                | ToolEvent::Collision
                | ToolEvent::EventsLost(_) => true,
                _ => false,
            },
            Self::Action(_, effect) => matches!(effect, Effect::None(_)),
            Self::Device(event) => is_problem_of_device(event),
            Self::Manager(event) => is_problem_of_manager(event),
            Self::Address(_)
            | Self::DeviceOutput { .. }
            | Self::ScannerStatus(_)
            | Self::Output { .. }
            | Self::Input { .. } => false,
        }
    }
}

/// The responses beside them tell the others.
const fn is_news_of_slave(event: &SlaveEvent) -> bool {
    !matches!(
        event,
        SlaveEvent::Received(_)
            | SlaveEvent::Explicit { .. }
            | SlaveEvent::Allocation { .. }
            | SlaveEvent::Changed { .. }
            | SlaveEvent::Effect(_)
            | SlaveEvent::NetworkStatus(_)
    )
}

/// The responses beside them tell the others.
const fn is_news_of_device(event: &DeviceEvent) -> bool {
    !matches!(event, DeviceEvent::Explicit { .. } | DeviceEvent::Changed { .. } | DeviceEvent::Effect(_))
}

/// The states of a planned device say less than its other events.
fn is_news_of_manager(event: &ManagerEvent) -> bool {
    match event {
        ManagerEvent::Planned(_, PlannedEvent::StateChanged { to, .. }) => match to {
            DeviceState::Running | DeviceState::Retrying => true,
            DeviceState::Idle
            | DeviceState::Probing
            | DeviceState::Missing
            | DeviceState::Found
            | DeviceState::Assigned
            | DeviceState::Joining
            | DeviceState::Connecting
            | DeviceState::Lost
            | DeviceState::Conflict => false,
        },
        _ => true,
    }
}

fn is_problem_of_manager(event: &ManagerEvent) -> bool {
    match event {
        ManagerEvent::Planned(_, event) => match event {
            PlannedEvent::StateChanged { to, .. } => *to == DeviceState::Retrying,
            PlannedEvent::NotAddressed(_)
            | PlannedEvent::Refused { .. }
            | PlannedEvent::Differs { .. }
            | PlannedEvent::TimedOut(_)
            | PlannedEvent::Lost(_)
            | PlannedEvent::NoSpare
            | PlannedEvent::Conflict(_)
            | PlannedEvent::Read(_, Err(_)) => true,
            PlannedEvent::Learned(_)
            | PlannedEvent::Found(_)
            | PlannedEvent::Addressed(_)
            | PlannedEvent::Connected { .. }
            | PlannedEvent::Replaced { .. }
            | PlannedEvent::Challenged(_)
            | PlannedEvent::Read(_, Ok(_)) => false,
        },
        ManagerEvent::SecondManager { .. }
        | ManagerEvent::Rejoins(_)
        | ManagerEvent::Misplaced { .. }
        | ManagerEvent::Readdressed { result: Err(_), .. }
        | ManagerEvent::RequestFailed(..)
        | ManagerEvent::BadFrame(_) => true,
        ManagerEvent::Node(_)
        | ManagerEvent::Started
        | ManagerEvent::Stopped
        | ManagerEvent::Unknown { .. }
        | ManagerEvent::Spare(_)
        | ManagerEvent::StandbyLeft(_)
        | ManagerEvent::Readdressed { result: Ok(()), .. }
        | ManagerEvent::Response(_) => false,
    }
}

const fn is_problem_of_device(event: &DeviceEvent) -> bool {
    match event {
        DeviceEvent::Mode(_, mode) => matches!(mode, IoMode::Fault),
        DeviceEvent::Io { to, .. } => matches!(to, cip_core::connection::IoState::TimedOut),
        DeviceEvent::Refused { .. }
        | DeviceEvent::NotAcknowledged(_)
        | DeviceEvent::ResponseAbandoned { .. }
        | DeviceEvent::NotSent { .. }
        | DeviceEvent::Ignored { .. } => true,
        _ => false,
    }
}

const fn is_news_of_master(event: &MasterEvent) -> bool {
    !matches!(
        event,
        MasterEvent::ScanDone { .. }
            | MasterEvent::Slave {
                event: master::SlaveEvent::Input(_)
                    | master::SlaveEvent::Heartbeat(_)
                    | master::SlaveEvent::Shutdown(_),
                ..
            }
    )
}

const fn is_problem_of_access(event: &AccessEvent) -> bool {
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

const fn is_problem_of_nex_access(event: &nex::AccessEvent) -> bool {
    match event {
        nex::AccessEvent::StateChanged { to, .. } => {
            matches!(to, nex::StateKind::BusOff | nex::StateKind::Faulted)
        }
        nex::AccessEvent::AddressTaken { .. }
        | nex::AccessEvent::OwnIdentity(_)
        | nex::AccessEvent::RoamRefused { .. }
        | nex::AccessEvent::NotAcknowledged
        | nex::AccessEvent::NotSent { .. }
        | nex::AccessEvent::BadFrame(_)
        | nex::AccessEvent::FramesLost { .. }
        | nex::AccessEvent::LinkRefused(_) => true,
        nex::AccessEvent::BitRateLocked(_)
        | nex::AccessEvent::AddressAssigned { .. }
        | nex::AccessEvent::Defended { .. } => false,
    }
}

impl From<nex::AccessEvent> for NodeEvent {
    fn from(event: nex::AccessEvent) -> Self {
        Self::NexAccess(event)
    }
}

impl From<AccessEvent> for NodeEvent {
    fn from(event: AccessEvent) -> Self {
        Self::Access(event)
    }
}

/// What is told of an action, in words.
fn words_of_action(action: &Do, effect: &Effect) -> String {
    let name = action.name();
    if let Effect::None(why) = effect {
        return format!("the action {name} has no effect: {why}");
    }
    let later = if matches!(effect, Effect::AtPowerUp) { ", which is read at power-up" } else { "" };
    match action {
        Do::SetMac(mac) => format!("MAC ID switch set to {mac}{later}"),
        Do::SetOa(oa) if oa.is_none() => "gives up its OA".to_owned(),
        Do::SetOa(oa) => format!("OA set to {oa}"),
        Do::Readdress(from, to) => format!("readdress OA {from} as {to}"),
        Do::SetInput(data) => format!("input data {}{later}", hex(data)),
        Do::SetOutput(Output::Slave(mac, data)) => format!("output data for {mac}: {}", hex(data)),
        Do::SetOutput(Output::StrobeBit(mac, bit)) => format!("strobe bit for {mac}: {}", u8::from(*bit)),
        Do::SetOutput(Output::Multicast(data)) => {
            format!("output data for the multicast poll: {}", hex(data))
        }
        Do::Recover(device, mac) => format!("recover {device} as MAC ID {mac}"),
        Do::Identify(device) => format!("identify {device}"),
        Do::GoRun => "to run mode".to_owned(),
        Do::GoIdle => "to idle mode".to_owned(),
        Do::Claim | Do::Release => format!("{name} the offline connection set"),
        Do::Who => "ask who is faulted".to_owned(),
        _ => name.to_owned(),
    }
}

fn hex(data: &[u8]) -> String {
    let bytes: Vec<String> = data.iter().map(|byte| format!("{byte:02X}")).collect();
    if bytes.is_empty() { "none".to_owned() } else { bytes.join(" ") }
}
