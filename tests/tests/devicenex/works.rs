//! A network manager with its devices on the simulated bus.

use std::time::Duration;

use devicenex_core::device::DeviceEvent;
use devicenex_core::manager::{
    Config, DeviceState, IdentityPattern, Manager, ManagerEvent, PlannedConnection, PlannedDevice,
    PlannedEvent, Source,
};
use devicenex_core::{Identifier, message};
use link_core::{BitRate, Frame, Instant};
use transport_mock::record::Outcome;
use transport_mock::{BusConfig, Network, NodeConfig, NodeId, Record};

use super::block::{Node, identity_of, node_of};
use super::plant::oa;

/// Room for a full network.
pub(crate) type Chief = Manager<126, 4>;

/// What any node of the network tells.
#[derive(Clone, Debug)]
pub(crate) enum Told {
    Chief(ManagerEvent),
    Block,
}

impl From<ManagerEvent> for Told {
    fn from(event: ManagerEvent) -> Self {
        Self::Chief(event)
    }
}

impl From<DeviceEvent> for Told {
    fn from(_: DeviceEvent) -> Self {
        Self::Block
    }
}

/// The same as Hello tells it.
pub(crate) fn who(product_code: u16, serial: u32) -> message::DeviceIdentity {
    (&identity_of(product_code, serial)).into()
}

pub(crate) struct Works {
    pub(crate) network: Network<Told>,
    rate: BitRate,
    /// What was on the bus, with the begin and the end.
    pub(crate) frames: Vec<(Instant, Instant, Frame)>,
    pub(crate) spoilt: Vec<Instant>,
    /// What managers told.
    pub(crate) told: Vec<(Instant, NodeId, ManagerEvent)>,
}

impl Works {
    pub(crate) fn at(rate: BitRate) -> Self {
        Self {
            network: Network::new(BusConfig::new(rate, 1)),
            rate,
            frames: Vec::new(),
            spoilt: Vec::new(),
            told: Vec::new(),
        }
    }

    pub(crate) fn config(&self, serial: u32, address: u8) -> Config {
        Config::new(identity_of(1, serial), oa(address), self.rate)
    }

    pub(crate) fn manager(
        &mut self,
        power_up: u64,
        config: Config,
        plan: impl IntoIterator<Item = PlannedDevice<4>>,
    ) -> NodeId {
        let mut chief = Chief::new(config);
        for planned in plan {
            chief.add_device(Instant::ZERO, planned).unwrap();
        }
        let mut node = NodeConfig::named("manager");
        node.power_up = Some(Instant::from_millis(power_up));
        node.bit_rate = Some(self.rate);
        self.network.add(node, chief)
    }

    /// A device whose controller is at the wrong rate at power-up.
    pub(crate) fn device(&mut self, name: &str, product_code: u16, serial: u32, power_up: u64) -> NodeId {
        let [low, high, ..] = serial.to_le_bytes();
        let mut node = NodeConfig::named(name);
        node.power_up = Some(Instant::from_millis(power_up));
        node.bit_rate = Some(BitRate::M1);
        node.listen_only = true;
        self.network.add(node, node_of(identity_of(product_code, serial), [low, high]))
    }

    pub(crate) fn run(&mut self, until: Instant) {
        let Self { network, frames, spoilt, told, .. } = self;
        network.run_until(until, &mut |record: &Record<'_, Told>| match record {
            Record::Frame(frame) if frame.outcome == Outcome::Ok => {
                frames.push((frame.start, frame.end, *frame.frame));
            }
            Record::Frame(frame) => spoilt.push(frame.end),
            Record::Event { at, node, event: Told::Chief(event) } => {
                told.push((*at, *node, event.clone()));
            }
            _ => {}
        });
    }

    pub(crate) fn run_ms(&mut self, until: u64) {
        self.run(Instant::from_millis(until));
    }

    /// Goes on until it is so; when that was.
    #[track_caller]
    pub(crate) fn run_till(&mut self, most: Duration, is_so: impl Fn(&Self) -> bool) -> Instant {
        let end = self.network.now() + most;
        while !is_so(self) {
            assert!(self.network.now() < end, "not within {most:?}");
            let next = self.network.now() + Duration::from_millis(1);
            self.run(next);
        }
        self.network.now()
    }

    pub(crate) fn chief(&self, node: NodeId) -> &Chief {
        self.network.machine(node).unwrap()
    }

    pub(crate) fn block(&self, node: NodeId) -> &Node {
        self.network.machine(node).unwrap()
    }

    pub(crate) fn state(&self, manager: NodeId, address: u8) -> DeviceState {
        self.chief(manager).device(oa(address)).unwrap().state
    }

    /// What a manager told about a planned device.
    pub(crate) fn about(&self, manager: NodeId, address: u8) -> Vec<&PlannedEvent> {
        let about = |event| match event {
            &(_, node, ManagerEvent::Planned(at, ref event)) if node == manager && at == oa(address) => {
                Some(event)
            }
            _ => None,
        };
        self.told.iter().filter_map(about).collect()
    }

    /// Frames with that identifier, as candump shows it.
    pub(crate) fn count(&self, identifier: &str, since: Instant) -> usize {
        let is = |(begin, _, frame): &&(Instant, Instant, Frame)| {
            *begin >= since && Identifier::of_frame(frame).to_string() == identifier
        };
        self.frames.iter().filter(is).count()
    }

    /// How many frames from `since` on are of a manager: to another address, or Mini-who and ROAM.
    pub(crate) fn of_manager(&self, address: u8, since: Instant) -> Vec<String> {
        use devicenex_core::id::Layout;
        let is = |frame: &Frame| match Identifier::of_frame(frame).layout() {
            Layout::Hello { source, .. } => frame.is_remote() || source == oa(address),
            Layout::Roam { .. } => true,
            Layout::Connection { route, .. }
            | Layout::Connectionless { route, .. }
            | Layout::Explicit { route, .. } => route.source == oa(address),
            Layout::Implicit { .. } | Layout::Standard { .. } | Layout::Reserved(_) => false,
        };
        let of = self.frames.iter().filter(|(begin, _, frame)| *begin >= since && is(frame));
        of.map(|(_, _, frame)| frame.to_string()).collect()
    }
}

/// The plant of the paper, section 5: B2 or B1 at 67 produces, A at 5 and C at 109 consume.
pub(crate) fn plant_of_the_paper(consumer_rate: u16) -> Vec<PlannedDevice<4>> {
    let mut input = PlannedDevice::new(oa(67), IdentityPattern::exact(who(2, 0xB2)));
    input.spares.push(IdentityPattern::exact(who(2, 0xB1))).unwrap();
    input.connections.push(PlannedConnection::producer(100)).unwrap();
    let consumer = |address, product_code, serial| {
        let mut consumer = PlannedDevice::new(oa(address), IdentityPattern::exact(who(product_code, serial)));
        let source = Source { address: oa(67), connection: 0 };
        consumer.connections.push(PlannedConnection::consumer(source, consumer_rate)).unwrap();
        consumer
    };
    vec![consumer(5, 3, 0xA), input, consumer(109, 4, 0xC)]
}
