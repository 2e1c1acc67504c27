//! The nodes of a network: who they are, and what their controllers do.

use core::time::Duration;

use devicenet_core::access;
use devicenet_core::master::{self, FirstContact, Master, PollConnection, ScanEntry};
use devicenet_core::message::PortNumber;
use devicenet_core::slave::{self, Event, Group2OnlyServer, Options, Slave};
use devicenet_core::tool::{self, OfflineTool};
use devicenet_tests::block::Block;
use devicenet_tests::line::{identity, mac as mac_id};
use link_core::{Action, Frame, Input, Instant, Machine, TxToken};

use super::{MASTERS, SLAVES, TOOL, UCMM_SLAVE};

/// A node, and its controller.
pub(super) struct Node {
    pub(super) device: Device,
    pub(super) in_flight: Vec<(TxToken, Frame)>,
    /// So many frames are not heard.
    pub(super) deaf: u8,
    /// Its controller is bus-off.
    pub(super) off: bool,
    /// When its controller takes part again.
    pub(super) returns: Option<Instant>,
}

pub(super) enum Device {
    Master(Box<Master<3, 32>>),
    Slave(Box<Group2OnlyServer<Small>>),
    /// Two of its clients can have a connection at once.
    Capable(Box<Slave<Small, 32, 2>>),
    Tool(Box<OfflineTool>),
}

/// Which of them a node is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Role {
    Master,
    Slave,
    Tool,
}

/// What the first byte chooses.
#[derive(Clone, Copy)]
pub(super) struct Plan(pub(super) u8);

/// Two bytes in, one byte out, by poll.
pub(super) type Small = Block<2, 1>;

impl Plan {
    /// Who is there, in the order of their serial numbers, which begin with 1.
    pub(super) fn nodes(self) -> Vec<(u8, Node)> {
        let third = SLAVES[0] + self.0 % 4;
        let mut nodes = vec![
            (MASTERS[0], Device::Master(self.scanner(1, MASTERS[0], FirstContact::Group2))),
            (MASTERS[1], Device::Master(self.scanner(2, MASTERS[1], self.second_contact()))),
            (SLAVES[0], Device::Slave(self.block(3, SLAVES[0]))),
            (SLAVES[1], Device::Slave(self.block(4, SLAVES[1]))),
            (third, Device::Slave(self.block(5, third))),
        ];
        if self.is_large() {
            nodes.push((UCMM_SLAVE, Device::Capable(self.capable(6))));
            nodes.push((TOOL, Device::Tool(self.tool(7))));
        }
        let node = |device| Node { device, in_flight: Vec::new(), deaf: 0, off: false, returns: None };
        nodes.into_iter().map(|(mac, device)| (mac, node(device))).collect()
    }

    /// A UCMM-capable slave and a tool are there too.
    pub(super) const fn is_large(self) -> bool {
        self.0 & 0x10 != 0
    }

    /// After bus-off on line a node comes back.
    pub(super) const fn bus_off_interrupt(self) -> bool {
        self.0 & 0x20 != 0
    }

    const fn second_contact(self) -> FirstContact {
        if self.is_large() { FirstContact::Ucmm } else { FirstContact::Group2 }
    }

    fn slaves(self) -> impl Iterator<Item = u8> {
        SLAVES.into_iter().chain(self.is_large().then_some(UCMM_SLAVE))
    }

    fn scanner(self, serial: u32, mac: u8, first_contact: FirstContact) -> Box<Master<3, 32>> {
        let mut config = master::Config::new(identity(serial), mac_id(mac));
        config.node.access.bus_off_interrupt = self.bus_off_interrupt();
        config.first_contact = first_contact;
        // Slow, so that a run has more to do with what happens than with polls.
        config.interscan_delay = Duration::from_millis(500);
        // Two masters that knock at the same moments for ever would be a network of its own.
        config.retry_after = Duration::from_millis(1000 + 300 * u64::from(serial));
        let mut master = Master::new(config);
        for slave in self.slaves() {
            let poll = PollConnection { produce: 2, consume: 1, expected_packet_rate: 1500 };
            let entry = ScanEntry { poll: Some(poll), ..ScanEntry::explicit_only(mac_id(slave)) };
            master.add_slave(Instant::ZERO, entry).expect("there is room");
        }
        Box::new(master)
    }

    fn block(self, serial: u32, mac: u8) -> Box<Group2OnlyServer<Small>> {
        let (config, block) = self.slave(serial, mac);
        Box::new(Group2OnlyServer::new(config, block).expect("its messages fit into frames"))
    }

    /// It has the unconnected port of group 2, or not.
    fn capable(self, serial: u32) -> Box<Slave<Small, 32, 2>> {
        let (mut config, block) = self.slave(serial, UCMM_SLAVE);
        config.options.set(Options::UNCONNECTED_PORT, self.0 & 0x40 == 0);
        Box::new(Slave::new(config, block).expect("its messages fit into frames"))
    }

    fn slave(self, serial: u32, mac: u8) -> (slave::Config, Small) {
        let device = identity(serial);
        let mut config = slave::Config::new(&device, mac_id(mac));
        config.access.bus_off_interrupt = self.bus_off_interrupt();
        (config, Block::new(device, [0, mac]))
    }

    fn tool(self, serial: u32) -> Box<OfflineTool> {
        let mut config = access::Config::new(known_as(serial), PortNumber::ZERO, mac_id(TOOL));
        config.bus_off_interrupt = self.bus_off_interrupt();
        Box::new(OfflineTool::new(tool::Config::new(config)))
    }
}

impl Device {
    pub(super) const fn role(&self) -> Role {
        match self {
            Self::Master(_) => Role::Master,
            Self::Slave(_) | Self::Capable(_) => Role::Slave,
            Self::Tool(_) => Role::Tool,
        }
    }

    pub(super) fn input(&mut self, now: Instant, input: Input) {
        match self {
            Self::Master(master) => master.input(now, input),
            Self::Slave(slave) => slave.input(now, input),
            Self::Capable(slave) => slave.input(now, input),
            Self::Tool(tool) => tool.input(now, input),
        }
    }

    /// The next thing that it wants; of what it tells only that which a slave tells.
    pub(super) fn poll(&mut self, now: Instant) -> Option<Action<Option<Event>>> {
        match self {
            Self::Master(master) => master.poll(now).map(|action| action.map_event(|_| None)),
            Self::Slave(slave) => slave.poll(now).map(|action| action.map_event(Some)),
            Self::Capable(slave) => slave.poll(now).map(|action| action.map_event(Some)),
            Self::Tool(tool) => tool.poll(now).map(|action| action.map_event(|_| None)),
        }
    }

    pub(super) fn deadline(&self) -> Option<Instant> {
        let deadline = match self {
            Self::Master(master) => master.deadline(),
            Self::Slave(slave) => slave.deadline(),
            Self::Capable(slave) => slave.deadline(),
            Self::Tool(tool) => tool.deadline(),
        };
        deadline.map(|deadline| deadline.at)
    }

    pub(super) fn max_in_flight(&self) -> usize {
        match self {
            Self::Master(master) => master.max_in_flight(),
            Self::Slave(slave) => slave.max_in_flight(),
            Self::Capable(slave) => slave.max_in_flight(),
            Self::Tool(tool) => tool.max_in_flight(),
        }
    }

    /// What is behind a slave.
    pub(super) fn block(&self) -> Option<&Small> {
        match self {
            Self::Slave(slave) => Some(slave.application()),
            Self::Capable(slave) => Some(slave.application()),
            Self::Master(_) | Self::Tool(_) => None,
        }
    }

    pub(super) fn block_mut(&mut self) -> Option<&mut Small> {
        match self {
            Self::Slave(slave) => Some(slave.application_mut()),
            Self::Capable(slave) => Some(slave.application_mut()),
            Self::Master(_) | Self::Tool(_) => None,
        }
    }
}

/// What tells the device of this serial number from every other.
pub(super) fn known_as(serial: u32) -> devicenet_core::message::DeviceIdentity {
    devicenet_core::message::DeviceIdentity { vendor: VENDOR.into(), serial }
}

/// That of every device of the suites.
pub(super) const VENDOR: u16 = 0x1234;
