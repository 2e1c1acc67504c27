//! What a slave or a master, a device or a manager has, as far as it can be expected: followed event by event.

mod happening;
mod nex;

use std::collections::BTreeMap;

use cip_core::connection::{ExplicitState, IoState};
use devicenet_core::master::{self, MasterEvent, ScannerStatus, SlaveState};
use devicenet_core::slave::{IoMode, SlaveEvent};

use super::event::NodeEvent;
use crate::scenario::{
    ConnectionName, ConnectionStateName, Do, EventName, ModeName, Node, Role, SlaveStateName, What,
};
pub(super) use happening::Happening;
use nex::NexExchange;
pub(super) use nex::device_state;

/// Connections, data, and what a master has of its slaves.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Exchange {
    /// Slave: the states of its connections, by instance.
    connections: BTreeMap<u8, ConnectionStateName>,
    /// Slave: what the data mean that it consumes, by instance.
    modes: BTreeMap<u8, ModeName>,
    /// Slave: what it produces.
    input: Vec<u8>,
    /// Slave: what it has consumed, by instance.
    outputs: BTreeMap<u8, Vec<u8>>,
    /// Slave: the bytes of the input that a connection sends, by instance.
    produced: BTreeMap<u8, usize>,
    /// Master: its slaves, by MAC ID.
    slaves: BTreeMap<u8, Seen>,
    /// Master: its own status.
    status: ScannerStatus,
    /// The same of DeviceNeX.
    nex: NexExchange,
}

/// A slave as its master sees it.
#[derive(Clone, PartialEq, Eq, Debug)]
struct Seen {
    state: SlaveStateName,
    status: ScannerStatus,
    /// By instance.
    inputs: BTreeMap<u8, Vec<u8>>,
}

impl Exchange {
    /// Of a node without power.
    pub(super) fn of(node: &Node) -> Self {
        let mut exchange = Self::default();
        match &node.role {
            Role::Slave(slave) => {
                exchange.input.clone_from(&slave.input);
                for (name, sizes) in [
                    (ConnectionName::Poll, slave.poll),
                    (ConnectionName::BitStrobe, slave.bit_strobe),
                    (ConnectionName::ChangeOfState, slave.change_of_state),
                    (ConnectionName::MulticastPoll, slave.multicast_poll),
                ] {
                    exchange.produced.insert(name.instance(), sizes.produce.into());
                    // What comes by change of state comes over the instance of poll.
                    let consumed = match name {
                        ConnectionName::Poll => sizes.consume.max(slave.change_of_state.consume),
                        ConnectionName::ChangeOfState => 0,
                        _ => sizes.consume,
                    };
                    if consumed > 0 {
                        exchange.outputs.insert(name.instance(), vec![0; consumed.into()]);
                    }
                }
            }
            Role::Master(master) => {
                exchange.status = ScannerStatus::INITIALISING;
                let seen = Seen {
                    state: SlaveStateName::Offline,
                    status: ScannerStatus::INITIALISING,
                    inputs: BTreeMap::new(),
                };
                let slaves = master.scan.iter().map(|slave| (slave.entry.mac_id.number(), seen.clone()));
                exchange.slaves = slaves.collect();
            }
            Role::Device(_) | Role::Manager(_) => exchange.nex = NexExchange::of(&node.role),
            Role::Access(_)
            | Role::Tool(_)
            | Role::Replay(_)
            | Role::Listener
            | Role::Babbler { .. }
            | Role::External => {}
        }
        exchange
    }

    /// Of the same node when it has lost its power: what is at its sensors does not depend on it.
    pub(super) fn without_power(&self, node: &Node) -> Self {
        Self { input: self.input.clone(), nex: self.nex.without_power(&node.role), ..Self::of(node) }
    }

    /// Whether it has everything that is expected.
    pub(super) fn holds(&self, what: &What) -> bool {
        if self.nex.is_some() {
            return self.nex.holds(what);
        }
        let connection = what.connection;
        what.connection_state.is_none_or(|state| self.connection_state(connection) == state)
            && what.mode.is_none_or(|mode| self.mode(connection) == mode)
            && what.output.as_ref().is_none_or(|output| self.output(connection) == Some(output.as_slice()))
            && what.input.as_ref().is_none_or(|input| {
                self.input(what.slave, connection).is_some_and(|found| found == input.as_slice())
            })
            && what
                .slave_state
                .is_none_or(|state| self.seen(what.slave).is_some_and(|seen| seen.state == state))
            && what.status.is_none_or(|status| {
                self.scanner_status(what.slave).is_some_and(|found| status.holds(found.0.into()))
            })
    }

    /// Of it that which is asked for, in words.
    pub(super) fn show(&self, what: &What) -> Vec<String> {
        if self.nex.is_some() {
            return self.nex.show(what);
        }
        let mut words = Vec::new();
        let named = |name: Option<ConnectionName>| name.map_or_else(String::new, |name| format!("{name} "));
        let hex = |data: Option<&[u8]>| match data {
            Some(data) => data.iter().map(|byte| format!("{byte:02x}")).collect(),
            None => "none".to_owned(),
        };
        let connection = named(what.connection);
        if what.connection_state.is_some() {
            words.push(format!("{connection}{}", self.connection_state(what.connection)));
        }
        if what.mode.is_some() {
            words.push(format!("{connection}{}", self.mode(what.connection)));
        }
        if what.input.is_some() {
            words.push(format!("{connection}input {}", hex(self.input(what.slave, what.connection))));
        }
        if what.output.is_some() {
            words.push(format!("{connection}output {}", hex(self.output(what.connection))));
        }
        if what.slave_state.is_some()
            && let (Some(mac), Some(seen)) = (what.slave, self.seen(what.slave))
        {
            words.push(format!("slave {mac} {}", seen.state));
        }
        if what.status.is_some()
            && let Some(status) = self.scanner_status(what.slave)
        {
            let of = what.slave.map_or_else(String::new, |mac| format!(" of slave {mac}"));
            words.push(format!("status {}{of}", status.0));
        }
        words
    }

    /// The state and the scanner status of each slave of a master, by MAC ID.
    pub(super) fn slaves(&self) -> impl Iterator<Item = (u8, SlaveStateName, ScannerStatus)> {
        self.slaves.iter().map(|(mac, seen)| (*mac, seen.state, seen.status))
    }

    /// Whether I/O runs: that of a slave, or that of a master with any of its slaves.
    pub(super) fn has_io(&self) -> bool {
        self.has_io_in(ConnectionStateName::Established)
            || self.slaves.values().any(|seen| seen.state == SlaveStateName::Running)
            || self.nex.has_io()
    }

    /// Whether an I/O connection of a slave has timed out.
    pub(super) fn has_timed_out(&self) -> bool {
        self.has_io_in(ConnectionStateName::TimedOut) || self.nex.has_timed_out()
    }

    fn has_io_in(&self, state: ConnectionStateName) -> bool {
        self.connections.range(2..=5).any(|(_, own)| *own == state)
    }

    /// Takes over what an event says, and tells what has happened by it.
    pub(super) fn follow(&mut self, event: &NodeEvent) -> Option<Happening> {
        match event {
            NodeEvent::Slave(event) => self.follow_slave(event),
            NodeEvent::Output { connection, data } => {
                let instance = connection.instance().0 as u8;
                self.outputs.insert(instance, data.to_vec());
                Some(Happening::on(EventName::OutputChanged, instance))
            }
            NodeEvent::Master(event) => self.follow_master(event),
            NodeEvent::Input { slave, connection, data } => {
                let instance = connection.instance().0 as u8;
                if let Some(seen) = self.slaves.get_mut(&slave.number()) {
                    seen.inputs.insert(instance, data.to_vec());
                }
                let about = Happening::of_slave(EventName::InputChanged, slave.number());
                Some(Happening { connection: Some(instance), ..about })
            }
            NodeEvent::ScannerStatus(status) => {
                self.status = *status;
                None
            }
            NodeEvent::Action(Do::SetInput(data), _) => {
                self.input.clone_from(data);
                self.nex.set_input(data);
                None
            }
            NodeEvent::Device(_)
            | NodeEvent::DeviceOutput { .. }
            | NodeEvent::Manager(_)
            | NodeEvent::NexAccess(_) => self.nex.follow(event),
            NodeEvent::Access(_) | NodeEvent::Address(_) | NodeEvent::Tool(_) | NodeEvent::Action(..) => None,
        }
    }

    fn follow_slave(&mut self, event: &SlaveEvent) -> Option<Happening> {
        Some(match event {
            SlaveEvent::Io { connection, to, .. } => {
                let instance = connection.instance().0 as u8;
                self.connections.insert(instance, io_state(*to));
                let event =
                    if *to == IoState::TimedOut { EventName::TimedOut } else { EventName::ConnectionChanged };
                Happening::on(event, instance)
            }
            SlaveEvent::Explicit { instance, to, .. } => {
                self.connections.insert(*instance, explicit_state(*to));
                Happening::on(EventName::ConnectionChanged, ConnectionName::Explicit.instance())
            }
            SlaveEvent::Mode(connection, mode) => {
                let instance = connection.instance().0 as u8;
                self.modes.insert(instance, mode_name(*mode));
                Happening::on(EventName::ModeChanged, instance)
            }
            SlaveEvent::Allocation { master: Some(_), .. } => EventName::Allocated.into(),
            SlaveEvent::Allocation { master: None, .. } => EventName::Released.into(),
            SlaveEvent::Reset(_) => EventName::Reset.into(),
            SlaveEvent::StoreMacId(_) => EventName::MacIdAssigned.into(),
            SlaveEvent::BitRateDetected(_) => EventName::BitRateDetected.into(),
            SlaveEvent::Ignored { .. } => EventName::Ignored.into(),
            _ => return None,
        })
    }

    fn follow_master(&mut self, event: &MasterEvent) -> Option<Happening> {
        Some(match event {
            MasterEvent::Slave { mac_id, event } => {
                let mac = mac_id.number();
                let seen = self.slaves.get_mut(&mac)?;
                let event = match event {
                    master::SlaveEvent::StateChanged { from, to, .. } => {
                        seen.state = slave_state(*to);
                        seen.inputs.clear();
                        match (from, to) {
                            (_, SlaveState::Running) => EventName::Established,
                            (SlaveState::Running, _) => EventName::Lost,
                            _ => EventName::SlaveChanged,
                        }
                    }
                    master::SlaveEvent::Status(status) => {
                        seen.status = *status;
                        EventName::StatusChanged
                    }
                    master::SlaveEvent::Heartbeat(_) => EventName::Heartbeat,
                    master::SlaveEvent::Shutdown(_) => EventName::Shutdown,
                    _ => return None,
                };
                Happening::of_slave(event, mac)
            }
            MasterEvent::Replacement(master::Replacement::Assigned(mac)) => {
                Happening::of_slave(EventName::Replaced, mac.number())
            }
            MasterEvent::Replacement(master::Replacement::WouldAssign(_)) => return None,
            MasterEvent::Replacement(_) => EventName::NotReplaced.into(),
            _ => return None,
        })
    }

    fn connection_state(&self, name: Option<ConnectionName>) -> ConnectionStateName {
        let state = |instance: &u8| self.connections.get(instance).copied();
        let found = match name {
            // One that a client has opened has an instance of its own.
            Some(ConnectionName::Explicit) => {
                let instances = self.connections.keys().filter(|instance| **instance == 1 || **instance > 5);
                instances.filter_map(state).max_by_key(|state| *state != ConnectionStateName::NonExistent)
            }
            Some(name) => state(&name.instance()),
            None => None,
        };
        found.unwrap_or(ConnectionStateName::NonExistent)
    }

    fn mode(&self, name: Option<ConnectionName>) -> ModeName {
        let found = match name {
            Some(name) => self.modes.get(&name.instance()),
            None => self.modes.values().next(),
        };
        found.copied().unwrap_or(ModeName::Inactive)
    }

    fn output(&self, name: Option<ConnectionName>) -> Option<&[u8]> {
        let found = match name {
            // It shares the instance of poll.
            Some(ConnectionName::ChangeOfState | ConnectionName::Cyclic) => {
                self.outputs.get(&ConnectionName::Poll.instance())
            }
            Some(name) => self.outputs.get(&name.instance()),
            None => self.outputs.values().next(),
        };
        found.map(Vec::as_slice)
    }

    fn input(&self, slave: Option<u8>, name: Option<ConnectionName>) -> Option<&[u8]> {
        if slave.is_none() {
            return match name {
                Some(name) => self.input.get(..*self.produced.get(&name.instance())?),
                None => Some(&self.input),
            };
        }
        let inputs = &self.seen(slave)?.inputs;
        let found = match name {
            Some(name) => inputs.get(&name.instance()),
            None => inputs.values().next(),
        };
        found.map(Vec::as_slice)
    }

    fn seen(&self, slave: Option<u8>) -> Option<&Seen> {
        self.slaves.get(&slave?)
    }

    fn scanner_status(&self, slave: Option<u8>) -> Option<ScannerStatus> {
        match slave {
            Some(_) => self.seen(slave).map(|seen| seen.status),
            None => Some(self.status),
        }
    }
}

pub(super) const fn io_state(state: IoState) -> ConnectionStateName {
    match state {
        IoState::NonExistent => ConnectionStateName::NonExistent,
        IoState::Configuring => ConnectionStateName::Configuring,
        IoState::Established => ConnectionStateName::Established,
        IoState::TimedOut => ConnectionStateName::TimedOut,
    }
}

pub(super) const fn explicit_state(state: ExplicitState) -> ConnectionStateName {
    match state {
        ExplicitState::NonExistent => ConnectionStateName::NonExistent,
        ExplicitState::Established => ConnectionStateName::Established,
        ExplicitState::DeferredDelete => ConnectionStateName::DeferredDelete,
    }
}

pub(super) const fn mode_name(mode: IoMode) -> ModeName {
    match mode {
        IoMode::Inactive => ModeName::Inactive,
        IoMode::Run => ModeName::Run,
        IoMode::Idle => ModeName::Idle,
        IoMode::Fault => ModeName::Fault,
    }
}

pub(super) const fn slave_state(state: SlaveState) -> SlaveStateName {
    match state {
        SlaveState::Offline => SlaveStateName::Offline,
        SlaveState::Waiting => SlaveStateName::Waiting,
        SlaveState::Contacting => SlaveStateName::Contacting,
        SlaveState::Configuring => SlaveStateName::Configuring,
        SlaveState::Running => SlaveStateName::Running,
    }
}
