//! A device.

use std::collections::BTreeMap;

use cip_core::code::ClassId;
use cip_core::connection::IoState;
use devicenex_core::OperationalAddress;
use devicenex_core::access::{Access, Role};
use devicenex_core::device::{Config, Device, DeviceEvent};
use devicenex_core::message::{ConnectionInstance, PortByte};
use link_core::{Action, Deadline, Input, Instant, Machine};

use super::access_config;
use super::application::{Block, connection_of_assembly};
use crate::scenario::DeviceNode;
use crate::simulate::event::NodeEvent;

/// A DeviceNeX device of a scenario, which tells its address and its outputs whenever they change.
#[derive(Clone, Debug)]
pub(crate) struct DeviceMachine {
    device: Box<Device<Block, MESSAGE, CONNECTIONS>>,
    /// What is at the sensors does not depend on power.
    kept: Vec<u8>,
    /// The address that was told.
    address: OperationalAddress,
    /// The outputs that were told.
    told: BTreeMap<u16, Vec<u8>>,
    /// Connections whose outputs are to be looked at.
    due: Vec<ConnectionInstance>,
    /// Frames that passed its filter, since power-up.
    received: u64,
}

impl DeviceMachine {
    pub(in crate::simulate) fn new(node: &DeviceNode) -> Self {
        Self::with(node, node.input.clone())
    }

    /// As it starts after `self` has lost its power.
    pub(in crate::simulate) fn restarted(&self, node: &DeviceNode) -> Self {
        Self::with(node, self.kept.clone())
    }

    #[expect(clippy::expect_used, reason = "the sizes were checked with the scenario")]
    fn with(node: &DeviceNode, input: Vec<u8>) -> Self {
        let mut block = Block::new(node);
        block.input.clone_from(&input);
        let mut config = Config::new(&node.node.device, PortByte(node.node.port), Role::Device);
        config.access = access_config(&node.node, Role::Device);
        let mut device = Box::new(Device::new(config, block).expect("a device of a scenario"));
        // A device that has an address at the start says Hello with it once it knows the bit rate.
        device.set_address(Instant::ZERO, node.node.oa);
        Self {
            address: device.access().address(),
            device,
            kept: input,
            told: BTreeMap::new(),
            due: Vec::new(),
            received: 0,
        }
    }

    pub(crate) const fn access(&self) -> &Access {
        self.device.access()
    }

    /// Frames that passed the filter that it asked for, since power-up.
    pub(crate) const fn received(&self) -> u64 {
        self.received
    }

    pub(in crate::simulate) fn reset(&mut self, now: Instant) {
        self.device.reset(now);
    }

    /// Takes another address, or none, as by a Set of its link object.
    pub(in crate::simulate) fn set_address(&mut self, now: Instant, address: OperationalAddress) {
        self.device.set_address(now, address);
    }

    pub(crate) fn set_input(&mut self, now: Instant, data: &[u8]) {
        self.keep_input(data);
        if self.device.application().input != data {
            self.device.application_mut().input = data.to_vec();
            self.device.inputs_changed(now);
        }
    }

    pub(in crate::simulate) fn keep_input(&mut self, data: &[u8]) {
        self.kept = data.to_vec();
    }

    /// What is told; `None` tells nothing new.
    fn follow(&mut self, event: DeviceEvent) -> Option<NodeEvent> {
        match event {
            DeviceEvent::Access(event) => return Some(NodeEvent::NexAccess(event)),
            DeviceEvent::Received(connection) => {
                self.due.push(connection);
                return None;
            }
            DeviceEvent::Mode(connection, _) => self.due.push(connection),
            DeviceEvent::Io { connection, to, .. } => {
                self.device.application_mut().own(connection, to == IoState::Established);
            }
            DeviceEvent::Changed { class: ClassId::ASSEMBLY, instance, .. } => {
                self.due.extend(connection_of_assembly(instance));
            }
            _ => {}
        }
        Some(NodeEvent::Device(event))
    }

    /// Outputs that have changed.
    fn output(&mut self) -> Option<NodeEvent> {
        while let Some(connection) = self.due.pop() {
            let output = self.device.application().output(connection);
            let told = self.told.entry(connection.number().0).or_insert_with(|| vec![0; output.len()]);
            if output != told.as_slice() {
                told.clear();
                told.extend_from_slice(output);
                return Some(NodeEvent::DeviceOutput { connection, data: told.as_slice().into() });
            }
        }
        None
    }
}

impl Machine for DeviceMachine {
    type Event = NodeEvent;

    fn input(&mut self, now: Instant, input: Input) {
        self.received += u64::from(matches!(input, Input::Frame(_)));
        self.device.input(now, input);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<NodeEvent>> {
        loop {
            if self.address != self.access().address() {
                self.address = self.access().address();
                return Some(Action::Event(NodeEvent::Address(self.address)));
            }
            if let Some(event) = self.output() {
                return Some(Action::Event(event));
            }
            let action = self.device.poll(now)?.map_event(|event| self.follow(event));
            if let Some(action) = action.transpose() {
                return Some(action);
            }
        }
    }

    fn deadline(&self) -> Option<Deadline> {
        self.device.deadline()
    }

    fn max_in_flight(&self) -> usize {
        self.device.max_in_flight()
    }
}

/// Of explicit messages.
const MESSAGE: usize = 512;
const CONNECTIONS: usize = 8;
