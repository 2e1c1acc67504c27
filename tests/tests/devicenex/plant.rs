//! A bus of DeviceNeX nodes.

use devicenex_core::access::{Access, AccessEvent, Config, Role, StateKind};
use devicenex_core::message::{DeviceIdentity, PortByte};
use devicenex_core::{Identifier, OperationalAddress};
use link_core::{BitRate, Instant};
use transport_mock::record::Outcome;
use transport_mock::{BusConfig, Network, NodeConfig, NodeId, Record};

pub(crate) struct Plant {
    pub(crate) network: Network<AccessEvent>,
    rate: BitRate,
    /// The end and the identifier of every frame that was sent.
    pub(crate) trace: Vec<(Instant, String)>,
    /// When attempts to send ended in an error.
    pub(crate) spoilt: Vec<Instant>,
}

pub(crate) fn oa(number: u8) -> OperationalAddress {
    OperationalAddress::new(number).unwrap()
}

/// The vendor is fictitious.
pub(crate) const fn device(serial: u32) -> DeviceIdentity {
    DeviceIdentity { vendor: cip_core::code::VendorId(0x1234), product_code: 7, major_revision: 1, serial }
}

impl Plant {
    pub(crate) fn new() -> Self {
        Self::at(BitRate::K250)
    }

    pub(crate) fn at(rate: BitRate) -> Self {
        Self { network: Network::new(BusConfig::new(rate, 1)), rate, trace: Vec::new(), spoilt: Vec::new() }
    }

    /// A network manager with that address.
    pub(crate) fn manager(&mut self, serial: u32, address: u8, power_up: u64) -> NodeId {
        let role = Role::NetworkManager { address: oa(address), bit_rate: self.rate };
        self.node(serial, role, power_up, self.rate)
    }

    /// A device whose controller is at the wrong rate at power-up.
    pub(crate) fn device(&mut self, serial: u32, power_up: u64) -> NodeId {
        self.node(serial, Role::Device, power_up, BitRate::M1)
    }

    fn node(&mut self, serial: u32, role: Role, power_up: u64, bit_rate: BitRate) -> NodeId {
        let mut config = NodeConfig::named(format!("{serial:X}"));
        config.power_up = Some(Instant::from_millis(power_up));
        config.bit_rate = Some(bit_rate);
        config.listen_only = role == Role::Device;
        self.network.add(config, Access::new(Config::new(device(serial), PortByte::ZERO, role)))
    }

    pub(crate) fn run(&mut self, until_millis: u64) {
        let Self { network, trace, spoilt, .. } = self;
        let end = Instant::from_millis(until_millis);
        network.run_until(end, &mut |record: &Record<'_, AccessEvent>| {
            let Record::Frame(frame) = record else { return };
            if frame.outcome == Outcome::Ok {
                trace.push((frame.end, Identifier::of_frame(frame.frame).to_string()));
            } else {
                spoilt.push(frame.end);
            }
        });
    }

    pub(crate) fn spoilt_since(&self, since: Instant) -> usize {
        self.spoilt.iter().filter(|&&at| at >= since).count()
    }

    pub(crate) fn give_address(&mut self, node: NodeId, address: u8) {
        self.network.command(node, |access: &mut Access, now| access.set_address(now, oa(address))).unwrap();
    }

    pub(crate) fn access(&self, node: NodeId) -> &Access {
        self.network.machine(node).unwrap()
    }

    pub(crate) fn kind(&self, node: NodeId) -> StateKind {
        self.access(node).state().kind()
    }
}
