//! The nodes that speak DeviceNeX.

use devicenex_core::OperationalAddress;
use devicenex_core::access::{Access, Config, Role};
use devicenex_core::message::PortByte;
use link_core::{Action, BitRate, Deadline, Input, Instant, Machine};

use crate::scenario::{DeviceNode, ManagerNode, NexNode};
use crate::simulate::event::NodeEvent;

/// A DeviceNeX node of a scenario, which tells its address whenever that changes.
#[derive(Clone, Debug)]
pub(in crate::simulate) struct NexMachine {
    access: Access,
    /// The address that was told.
    told: OperationalAddress,
}

impl NexMachine {
    /// A device that has an address at the start says Hello with it once it knows the bit rate.
    pub(in crate::simulate) fn device(node: &DeviceNode) -> Self {
        let mut access = Access::new(access_config(&node.node, Role::Device));
        access.set_address(Instant::ZERO, node.node.oa);
        Self { told: access.address(), access }
    }

    pub(in crate::simulate) fn manager(node: &ManagerNode, bit_rate: BitRate) -> Self {
        let address = node.node.oa;
        let access = Access::new(access_config(&node.node, Role::NetworkManager { address, bit_rate }));
        Self { told: access.address(), access }
    }

    pub(in crate::simulate) fn reset(&mut self, now: Instant) {
        self.access.reset(now);
    }
}

impl Machine for NexMachine {
    type Event = NodeEvent;

    fn input(&mut self, now: Instant, input: Input) {
        self.access.input(now, input);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<NodeEvent>> {
        if self.told != self.access.address() {
            self.told = self.access.address();
            return Some(Action::Event(NodeEvent::Address(self.told)));
        }
        Some(match self.access.poll(now)? {
            Action::Event(event) => Action::Event(event.into()),
            Action::Transmit(token, frame) => Action::Transmit(token, frame),
            Action::Withdraw(token) => Action::Withdraw(token),
            Action::Link(command) => Action::Link(command),
        })
    }

    fn deadline(&self) -> Option<Deadline> {
        self.access.deadline()
    }

    fn max_in_flight(&self) -> usize {
        self.access.max_in_flight()
    }
}

fn access_config(node: &NexNode, role: Role) -> Config {
    Config {
        hello_wait: node.hello_wait,
        announcement: node.announcement,
        bus_off_interrupt: node.boi,
        ..Config::new(node.on_the_wire(), PortByte(node.port), role)
    }
}
