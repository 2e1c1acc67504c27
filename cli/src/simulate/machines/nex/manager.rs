//! A network manager.

use cip_core::connection::TransportClassTrigger;
use devicenex_core::OperationalAddress;
use devicenex_core::access::{Access, Role};
use devicenex_core::device::DeviceEvent;
use devicenex_core::id::MessageId;
use devicenex_core::manager::{
    Attribute, Config, IdentityPattern, Manager, ManagerEvent, PlannedConnection, PlannedDevice,
    RequestError, Source,
};
use link_core::{Action, BitRate, Deadline, Input, Instant, Machine};

use super::access_config;
use crate::scenario::{ManagerNode, NexConnection, Pattern, Planned, PlannedIo};
use crate::simulate::event::NodeEvent;

/// A network manager of a scenario, which tells its address whenever that changes.
#[derive(Clone, Debug)]
pub(crate) struct ManagerMachine {
    manager: Box<Manager<DEVICES, CONNECTIONS>>,
    /// The address that was told.
    address: OperationalAddress,
}

impl ManagerMachine {
    #[expect(clippy::expect_used, reason = "the database was checked with the scenario")]
    pub(in crate::simulate) fn new(node: &ManagerNode, bit_rate: BitRate) -> Self {
        let mut config = Config::new(node.node.device.clone(), node.node.oa, bit_rate);
        let role = Role::NetworkManager { address: node.node.oa, bit_rate };
        config.node.access = access_config(&node.node, role);
        config = Config {
            mini_who_interval: node.mini_who,
            idle_mini_who_interval: node.idle_mini_who,
            hello_wait: node.node.hello_wait,
            roam_tries: node.roam_tries,
            connect_tries: node.connect_tries,
            spare_wait: node.spare_wait,
            learning: node.learning,
            takeover_after: node.takeover_after,
            rejoin_after: node.rejoin_after,
            ..config
        };
        let mut manager = Box::new(Manager::new(config));
        for planned in &node.planned {
            manager.add_device(Instant::ZERO, plan(planned)).expect("an entry of a scenario");
        }
        Self { address: manager.access().address(), manager }
    }

    pub(crate) const fn access(&self) -> &Access {
        self.manager.access()
    }

    pub(in crate::simulate) fn reset(&mut self, now: Instant) {
        self.manager.reset(now);
    }

    /// Gives a node on line another address, over its explicit connection.
    pub(in crate::simulate) fn readdress(
        &mut self,
        from: OperationalAddress,
        to: OperationalAddress,
    ) -> Result<(), RequestError> {
        self.manager.readdress(from, to)
    }
}

impl Machine for ManagerMachine {
    type Event = NodeEvent;

    fn input(&mut self, now: Instant, input: Input) {
        self.manager.input(now, input);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<NodeEvent>> {
        if self.address != self.access().address() {
            self.address = self.access().address();
            return Some(Action::Event(NodeEvent::Address(self.address)));
        }
        let action = self.manager.poll(now)?;
        Some(action.map_event(|event| match event {
            ManagerEvent::Node(DeviceEvent::Access(event)) => event.into(),
            ManagerEvent::Node(event) => NodeEvent::Device(event),
            event => NodeEvent::Manager(Box::new(event)),
        }))
    }

    fn deadline(&self) -> Option<Deadline> {
        self.manager.deadline()
    }

    fn max_in_flight(&self) -> usize {
        self.manager.max_in_flight()
    }
}

/// What does not fit was refused with the scenario.
fn plan(planned: &Planned) -> PlannedDevice<CONNECTIONS> {
    let mut plan = PlannedDevice::new(planned.oa, pattern(&planned.device));
    plan.spares.extend(planned.spares.iter().map(pattern));
    plan.connections.extend(planned.connections.iter().map(connection));
    plan.reads.extend(planned.reads.iter().map(|read| Attribute {
        class: read.class,
        instance: read.instance,
        attribute: read.attribute,
    }));
    plan
}

fn pattern(pattern: &Pattern) -> IdentityPattern {
    if pattern.any_serial {
        IdentityPattern::product_of(pattern.device)
    } else {
        IdentityPattern::exact(pattern.device)
    }
}

fn connection(io: &PlannedIo) -> PlannedConnection {
    PlannedConnection {
        instance: io.connection.predefined(),
        expected_packet_rate: io.epr,
        watchdog_action: io.watchdog,
        consumes: io.from.map(|(address, connection)| Source { address, connection }),
        trigger: trigger(io).map(TransportClassTrigger),
        message: MessageId::default(),
    }
}

/// Attribute 3, where it is not what the device has by default: without acknowledges, since many may consume.
const fn trigger(io: &PlannedIo) -> Option<u8> {
    match io.connection {
        NexConnection::ChangeOfState | NexConnection::ChangeOfState11 => Some(0x10),
        NexConnection::Cyclic | NexConnection::Cyclic11 => Some(0x00),
        NexConnection::Dynamic if io.from.is_some() => Some(0x80),
        NexConnection::Dynamic => Some(0x10),
        NexConnection::Explicit
        | NexConnection::Polled
        | NexConnection::Polled11
        | NexConnection::Broadcast
        | NexConnection::Broadcast11
        | NexConnection::Producer
        | NexConnection::Producer11
        | NexConnection::Consumer
        | NexConnection::Consumer11 => None,
    }
}

const DEVICES: usize = 126;
/// With each of them.
const CONNECTIONS: usize = 4;
