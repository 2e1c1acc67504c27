//! The nodes of a network: who they are, and a referee that sees all that goes in and out of each.

use std::collections::BTreeMap;

use cip_core::code::DeviceType;
use cip_core::identity::{self, ProductName, Revision};
use cip_core::object::Identity;
use devicenex_core::Access;
use devicenex_core::access::Role;
use devicenex_core::device::{self, Application, Connection, Device};
use devicenex_core::manager::{Config, Manager};
use devicenex_core::message::{ConnectionInstance, DeviceIdentity, PortByte};
use link_core::{Action, BitRate, Deadline, Frame, Input, Instant, Machine, TxOutcome};

use super::observed::Observed;
use crate::plant::{NODES, oa, own, plan};

/// A node, and what its referee knows of it.
#[derive(Clone)]
pub(super) struct Node {
    pub(super) station: Station,
    observed: Observed,
    in_flight: BTreeMap<u16, Frame>,
    /// Since the last input.
    actions: usize,
}

#[derive(Clone)]
pub(super) enum Station {
    Device(Box<Device<Block, 64, 6>>),
    Manager(Box<Manager<5, 3>>),
}

/// Two bytes in, and two bytes out for each kind of connection that the plan has consume.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Block {
    identity: identity::DeviceIdentity,
    pub(super) inputs: [u8; 2],
    /// Of the multicast connection, and of dynamic ones.
    pub(super) outputs: [[u8; 2]; 2],
    /// Of all others.
    other: [u8; 2],
}

impl Application for Block {
    type Long = ();

    fn identity(&self) -> Identity<'_> {
        Identity::new(&self.identity)
    }

    fn produced(&self, _: ConnectionInstance) -> &[u8] {
        &self.inputs
    }

    fn consumed(&mut self, connection: ConnectionInstance) -> &mut [u8] {
        match connection.number().0 {
            12 | 13 => &mut self.outputs[0],
            128..=255 => &mut self.outputs[1],
            _ => &mut self.other,
        }
    }
}

impl Node {
    /// A device that begins with an address, or with none.
    pub(super) fn device(which: DeviceIdentity, number: u8, address: u8, restarts: bool) -> Self {
        let identity = identity::DeviceIdentity {
            vendor: which.vendor,
            device_type: DeviceType::GENERAL_PURPOSE_DISCRETE_IO,
            product_code: which.product_code,
            revision: Revision { major: which.major_revision, minor: 1 },
            serial: which.serial,
            name: ProductName::new("Example Block of Sixteen Points").expect("it is short enough"),
        };
        let mut config = device::Config::new(&identity, PortByte::ZERO, Role::Device);
        config.access.bus_off_interrupt = restarts;
        let block = Block { identity, inputs: [0, number], outputs: [[0; 2]; 2], other: [0; 2] };
        let mut device = Box::new(Device::new(config, block).expect("the sizes are valid"));
        device.set_address(Instant::ZERO, oa(address));
        Self::with(Station::Device(device), Observed::device(which, address))
    }

    /// A manager that is told of the plant.
    pub(super) fn manager(serial: u32, address: u8, rate: BitRate, restarts: bool) -> Self {
        let identity = identity::DeviceIdentity { serial, ..own() };
        let mut config = Config::new(identity, oa(address), rate);
        config.node.access.bus_off_interrupt = restarts;
        config.takeover_after = TAKEOVER;
        let who = DeviceIdentity::from(&config.device);
        let mut manager = Box::new(Manager::new(config));
        for address in &NODES[..3] {
            let mut plan = plan(*address);
            // Slow, so that a run has more to do with what happens than with data.
            plan.connections.iter_mut().for_each(|connection| connection.expected_packet_rate *= 10);
            manager.add_device(Instant::ZERO, plan).expect("a good plan");
        }
        Self::with(Station::Manager(manager), Observed::manager(who, address, rate))
    }

    fn with(station: Station, observed: Observed) -> Self {
        Self { station, observed, in_flight: BTreeMap::new(), actions: 0 }
    }

    pub(super) fn access(&self) -> &Access {
        match &self.station {
            Station::Device(device) => device.access(),
            Station::Manager(manager) => manager.access(),
        }
    }

    pub(super) fn as_manager(&self) -> Option<&Manager<5, 3>> {
        match &self.station {
            Station::Manager(manager) => Some(manager),
            Station::Device(_) => None,
        }
    }

    pub(super) fn as_device(&self) -> Option<&Device<Block, 64, 6>> {
        match &self.station {
            Station::Device(device) => Some(device),
            Station::Manager(_) => None,
        }
    }

    /// Whatever is asked without a connection, nothing changes.
    fn connectionless(&mut self, now: Instant, input: Input) {
        // What is over by now is over before the request.
        self.station.input(now, Input::Tick);
        let state = |node: &Self| {
            let device = node.as_device()?;
            let connections: Vec<Connection> = device.connections().collect();
            Some((connections, device.application().clone(), device.access().address()))
        };
        let before = state(self);
        self.station.input(now, input);
        assert_eq!(before, state(self), "a request without a connection changes something");
    }
}

impl Machine for Node {
    type Event = ();

    fn input(&mut self, now: Instant, input: Input) {
        self.actions = 0;
        match input {
            Input::Frame(frame) => {
                self.observed.hears(now, &frame);
                if frame.raw_id() >> 24 == 0x1C {
                    return self.connectionless(now, input);
                }
            }
            Input::TxDone(token, outcome) => {
                let frame = self.in_flight.remove(&token.0).expect("it was in flight");
                if outcome == TxOutcome::Sent {
                    self.observed.sent(now, &frame);
                }
            }
            Input::Link(event) => self.observed.link(event),
            Input::Tick => {}
        }
        self.station.input(now, input);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<()>> {
        let Some(action) = self.station.poll(now) else {
            if let Some(device) = self.as_device() {
                self.observed.consumes(&device.application().outputs);
            }
            return None;
        };
        self.actions += 1;
        assert!(self.actions < MOST_ACTIONS, "the work of one input is bounded");
        if let Action::Transmit(token, frame) = action {
            self.observed.sends(now, &frame);
            assert!(self.in_flight.insert(token.0, frame).is_none(), "{frame}: its token is in flight");
            assert!(self.in_flight.len() <= self.max_in_flight());
        }
        Some(action)
    }

    fn deadline(&self) -> Option<Deadline> {
        match &self.station {
            Station::Device(device) => device.deadline(),
            Station::Manager(manager) => manager.deadline(),
        }
    }

    fn max_in_flight(&self) -> usize {
        match &self.station {
            Station::Device(device) => device.max_in_flight(),
            Station::Manager(manager) => manager.max_in_flight(),
        }
    }
}

impl Station {
    fn input(&mut self, now: Instant, input: Input) {
        match self {
            Self::Device(device) => device.input(now, input),
            Self::Manager(manager) => manager.input(now, input),
        }
    }

    /// What is told is told in words, too.
    fn poll(&mut self, now: Instant) -> Option<Action<()>> {
        match self {
            Self::Device(device) => Some(device.poll(now)?.map_event(|event| in_words(&event))),
            Self::Manager(manager) => Some(manager.poll(now)?.map_event(|event| in_words(&event))),
        }
    }
}

fn in_words(event: &impl ToString) {
    assert!(!event.to_string().is_empty());
}

/// For how long another manager must be silent, in ms: nobody resumes a manager by hand here.
const TAKEOVER: u32 = 25_000;
/// A manager can have something to tell of every device, and a device of every connection.
const MOST_ACTIONS: usize = 100;
