//! What a DeviceNeX device or manager has.

use std::collections::BTreeMap;

use devicenex_core::access::{AccessEvent, StateKind};
use devicenex_core::device::DeviceEvent;
use devicenex_core::manager::{DeviceState, ManagerEvent, PlannedEvent};

use super::{Happening, explicit_state, io_state, mode_name};
use crate::scenario::{ConnectionStateName, DeviceStateName, EventName, ModeName, NexConnection, Role, What};
use crate::simulate::event::NodeEvent;

/// Connections, data, and what a manager knows of its planned devices.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub(super) struct NexExchange {
    is_some: bool,
    /// Device: the states of its connections, by instance.
    connections: BTreeMap<u16, ConnectionStateName>,
    /// Device: what the data mean that it consumes, by instance.
    modes: BTreeMap<u16, ModeName>,
    /// Device: what it produces.
    input: Vec<u8>,
    /// Device: what it has consumed, by instance.
    outputs: BTreeMap<u16, Vec<u8>>,
    /// Manager: its planned devices, by operational address.
    devices: BTreeMap<u8, DeviceStateName>,
}

impl NexExchange {
    /// Of a node without power.
    pub(super) fn of(role: &Role) -> Self {
        let mut exchange = Self { is_some: true, ..Self::default() };
        match role {
            Role::Device(device) => exchange.input.clone_from(&device.input),
            Role::Manager(manager) => {
                let planned = manager.planned.iter();
                exchange.devices =
                    planned.map(|planned| (planned.oa.number(), DeviceStateName::Idle)).collect();
            }
            _ => exchange.is_some = false,
        }
        exchange
    }

    /// Whether the node is of DeviceNeX.
    pub(super) const fn is_some(&self) -> bool {
        self.is_some
    }

    /// Of the same node when it has lost its power: what is at its sensors does not depend on it.
    pub(super) fn without_power(&self, role: &Role) -> Self {
        Self { input: self.input.clone(), ..Self::of(role) }
    }

    pub(super) fn set_input(&mut self, data: &[u8]) {
        self.input = data.to_vec();
    }

    /// Whether it has everything that is expected.
    pub(super) fn holds(&self, what: &What) -> bool {
        let connection = what.nex_connection;
        what.connection_state.is_none_or(|state| self.connection_state(connection) == state)
            && what.mode.is_none_or(|mode| self.mode(connection) == mode)
            && what.output.as_ref().is_none_or(|output| self.output(connection) == Some(output.as_slice()))
            && what.input.as_ref().is_none_or(|input| self.input == *input)
            && what.device_state.is_none_or(|state| self.device_state(what.device) == Some(state))
    }

    /// Of it that which is asked for, in words.
    pub(super) fn show(&self, what: &What) -> Vec<String> {
        let mut words = Vec::new();
        let hex = |data: &[u8]| data.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
        let connection = what.nex_connection.map_or_else(String::new, |name| format!("{name} "));
        if what.connection_state.is_some() {
            words.push(format!("{connection}{}", self.connection_state(what.nex_connection)));
        }
        if what.mode.is_some() {
            words.push(format!("{connection}{}", self.mode(what.nex_connection)));
        }
        if what.input.is_some() {
            words.push(format!("input {}", hex(&self.input)));
        }
        if what.output.is_some() {
            let output = self.output(what.nex_connection).map_or_else(|| "none".to_owned(), hex);
            words.push(format!("{connection}output {output}"));
        }
        if what.device_state.is_some()
            && let (Some(oa), Some(state)) = (what.device, self.device_state(what.device))
        {
            words.push(format!("device {oa} {state}"));
        }
        words
    }

    /// Whether I/O runs: that of a device, or that of a manager with any of its planned devices.
    pub(super) fn has_io(&self) -> bool {
        self.has_io_in(ConnectionStateName::Established)
            || self.devices.values().any(|state| *state == DeviceStateName::Running)
    }

    /// Whether an I/O connection of a device has timed out.
    pub(super) fn has_timed_out(&self) -> bool {
        self.has_io_in(ConnectionStateName::TimedOut)
    }

    fn has_io_in(&self, state: ConnectionStateName) -> bool {
        self.connections.iter().any(|(instance, own)| *instance != EXPLICIT && *own == state)
    }

    /// Takes over what an event says, and tells what has happened by it.
    pub(super) fn follow(&mut self, event: &NodeEvent) -> Option<Happening> {
        match event {
            NodeEvent::Device(event) => self.follow_device(event),
            NodeEvent::Manager(event) => self.follow_manager(event),
            NodeEvent::DeviceOutput { connection, data } => {
                let instance = connection.number().0;
                self.outputs.insert(instance, data.to_vec());
                Some(on(EventName::OutputChanged, instance))
            }
            // All connections are gone.
            NodeEvent::NexAccess(AccessEvent::StateChanged { from: StateKind::Online, to, .. })
                if *to != StateKind::Online =>
            {
                self.connections.clear();
                None
            }
            _ => None,
        }
    }

    fn follow_device(&mut self, event: &DeviceEvent) -> Option<Happening> {
        Some(match event {
            DeviceEvent::Io { connection, to, .. } => {
                let (instance, state) = (connection.number().0, io_state(*to));
                self.connections.insert(instance, state);
                let is_late = state == ConnectionStateName::TimedOut;
                on(if is_late { EventName::TimedOut } else { EventName::ConnectionChanged }, instance)
            }
            DeviceEvent::Explicit { connection, to, .. } => {
                let instance = connection.number().0;
                self.connections.insert(instance, explicit_state(*to));
                on(EventName::ConnectionChanged, instance)
            }
            DeviceEvent::Mode(connection, mode) => {
                let instance = connection.number().0;
                self.modes.insert(instance, mode_name(*mode));
                on(EventName::ModeChanged, instance)
            }
            DeviceEvent::Refused { .. } => EventName::Refused.into(),
            DeviceEvent::Reset(_) => EventName::Reset.into(),
            DeviceEvent::Ignored { .. } => EventName::Ignored.into(),
            _ => return None,
        })
    }

    fn follow_manager(&mut self, event: &ManagerEvent) -> Option<Happening> {
        let (oa, event) = match event {
            ManagerEvent::Planned(oa, event) => (oa.number(), event),
            // It tells it of all its devices.
            ManagerEvent::Stopped => {
                self.devices.values_mut().for_each(|state| *state = DeviceStateName::Idle);
                return None;
            }
            ManagerEvent::SecondManager { .. } => return Some(EventName::SecondManager.into()),
            ManagerEvent::Rejoins(_) => return Some(EventName::Rejoins.into()),
            ManagerEvent::Unknown { .. } => return Some(EventName::Unknown.into()),
            ManagerEvent::Spare(_) => return Some(EventName::Spare.into()),
            _ => return None,
        };
        let mut connection = None;
        let event = match event {
            PlannedEvent::StateChanged { to, .. } => {
                self.devices.insert(oa, device_state(*to));
                EventName::DeviceChanged
            }
            PlannedEvent::Learned(_) => EventName::Learned,
            PlannedEvent::Found(_) => EventName::Found,
            PlannedEvent::Addressed(_) => EventName::Addressed,
            PlannedEvent::NotAddressed(_) => EventName::NotAddressed,
            PlannedEvent::Connected { instance, .. } => {
                connection = Some(instance.0);
                EventName::Connected
            }
            PlannedEvent::Refused { .. } => EventName::Refused,
            PlannedEvent::Differs { instance, .. } => {
                connection = Some(instance.0);
                EventName::Differs
            }
            PlannedEvent::TimedOut(instance) => {
                connection = Some(instance.0);
                EventName::TimedOut
            }
            PlannedEvent::Lost(_) => EventName::Lost,
            PlannedEvent::Replaced { .. } => EventName::Replaced,
            PlannedEvent::NoSpare => EventName::NoSpare,
            PlannedEvent::Conflict(_) => EventName::Conflict,
            PlannedEvent::Challenged(_) => return None,
            PlannedEvent::Read(..) => EventName::Read,
        };
        Some(Happening { device: Some(oa), nex_connection: connection, ..event.into() })
    }

    fn connection_state(&self, name: Option<NexConnection>) -> ConnectionStateName {
        let is_meant =
            |(instance, _): &(&u16, &ConnectionStateName)| name.is_some_and(|name| name.is(**instance));
        let found = self.connections.iter().find(is_meant).map(|(_, state)| *state);
        found.unwrap_or(ConnectionStateName::NonExistent)
    }

    fn mode(&self, name: Option<NexConnection>) -> ModeName {
        let is_meant = |(instance, _): &(&u16, &ModeName)| name.is_none_or(|name| name.is(**instance));
        self.modes.iter().find(is_meant).map_or(ModeName::Inactive, |(_, mode)| *mode)
    }

    fn output(&self, name: Option<NexConnection>) -> Option<&[u8]> {
        let is_meant = |(instance, _): &(&u16, &Vec<u8>)| name.is_none_or(|name| name.is(**instance));
        self.outputs.iter().find(is_meant).map(|(_, data)| data.as_slice())
    }

    fn device_state(&self, oa: Option<u8>) -> Option<DeviceStateName> {
        self.devices.get(&oa?).copied()
    }
}

fn on(event: EventName, instance: u16) -> Happening {
    Happening { nex_connection: Some(instance), ..event.into() }
}

pub(in crate::simulate) const fn device_state(state: DeviceState) -> DeviceStateName {
    match state {
        DeviceState::Idle => DeviceStateName::Idle,
        DeviceState::Probing => DeviceStateName::Probing,
        DeviceState::Missing => DeviceStateName::Missing,
        DeviceState::Found => DeviceStateName::Found,
        DeviceState::Assigned => DeviceStateName::Assigned,
        DeviceState::Joining => DeviceStateName::Joining,
        DeviceState::Connecting => DeviceStateName::Connecting,
        DeviceState::Running => DeviceStateName::Running,
        DeviceState::Retrying => DeviceStateName::Retrying,
        DeviceState::Lost => DeviceStateName::Lost,
        DeviceState::Conflict => DeviceStateName::Conflict,
    }
}

const EXPLICIT: u16 = 1;
