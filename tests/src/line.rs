//! A line: one master and its slaves, which exchange two bytes in each direction by poll, on the simulated bus.

use core::ops::RangeInclusive;
use core::time::Duration;

use cip_core::code::{DeviceType, VendorId};
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use devicenet_core::master::{self, Master, MasterEvent, PollConnection, ScanEntry, SlaveState};
use devicenet_core::slave::{self, Slave};
use devicenet_core::tool::{OfflineTool, ToolEvent};
use devicenet_core::{Identifier, MacId};
use link_core::{BitRate, Frame, Instant};
use transport_mock::record::Outcome;
use transport_mock::{BusConfig, Change, Network, NodeConfig, NodeId, Reaction, Record};

use crate::block::Block;

mod measure;
mod tables;

pub use measure::{BringUp, Scan, Traffic};
pub use tables::{bring_up_table, bring_ups, scan_cycles, scan_table};

/// The master of a line, with room for messages of several fragments.
pub type LineMaster = Master<63, 64>;
/// A slave of a line.
pub type LineSlave = Slave<LineBlock, 64, 0>;
/// The device behind it.
pub type LineBlock = Block<2, 2>;

/// What a line is like.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Of the bus.
    pub bit_rate: BitRate,
    /// The scan list. The master is MAC ID 0.
    pub slaves: RangeInclusive<u8>,
    /// How long each slave takes from a frame to what follows from it. The master takes no time.
    pub reaction: Duration,
    /// Of the master.
    pub interscan_delay: Duration,
    /// Expected packet rate of every poll connection, in ms.
    pub expected_packet_rate: u16,
    /// Of every slave, in seconds.
    pub heartbeat: Option<u8>,
    /// Slaves from this one on are switched on later.
    pub late: Option<(u8, Instant)>,
}

impl Plan {
    /// 63 slaves that react at once, scans without a pause, expected packet rate 200 ms, no heartbeat.
    #[must_use]
    pub const fn new(bit_rate: BitRate) -> Self {
        Self {
            bit_rate,
            slaves: 1..=63,
            reaction: Duration::ZERO,
            interscan_delay: Duration::ZERO,
            expected_packet_rate: 200,
            heartbeat: None,
            late: None,
        }
    }
}

/// A line that runs in virtual time, and what was seen of it.
#[derive(Debug)]
pub struct Line {
    /// The bus and its nodes.
    pub network: Network<Told>,
    /// The master.
    pub master: NodeId,
    /// The slaves, in the order of their MAC IDs.
    pub slaves: Vec<NodeId>,
    /// Every frame that was sent to its end.
    pub sent: Vec<Sent>,
    /// Attempts to send that an error ended.
    pub destroyed: usize,
    /// What the nodes told.
    pub told: Vec<(Instant, NodeId, Told)>,
}

/// A frame that was sent to its end.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Sent {
    /// The begin of its first bit.
    pub start: Instant,
    /// The end of its last bit.
    pub end: Instant,
    /// Its identifier.
    pub id: Identifier,
    /// The frame.
    pub frame: Frame,
}

/// What a node of a line tells.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Told {
    /// The master.
    Master(MasterEvent),
    /// A slave.
    Slave(slave::Event),
    /// A tool.
    Tool(ToolEvent),
}

impl Line {
    /// The master and its slaves, each given power at zero unless it is late.
    ///
    /// # Panics
    /// When the plan is not that of a network.
    #[must_use]
    pub fn new(plan: &Plan) -> Self {
        let mut network = Network::new(BusConfig::new(plan.bit_rate, 1));
        let mut config = master::Config::new(identity(MASTER_SERIAL), mac(0));
        config.interscan_delay = plan.interscan_delay;
        let mut master = LineMaster::new(config);
        master.set_run(true);
        for number in plan.slaves.clone() {
            master.add_slave(Instant::ZERO, entry(number, plan.expected_packet_rate)).expect("a valid entry");
            master.set_output(mac(number), &data(number, 0xA5)).expect("two bytes");
        }
        let master = network.add(NodeConfig::named("master"), master);
        let mut line =
            Self { network, master, slaves: Vec::new(), sent: Vec::new(), destroyed: 0, told: Vec::new() };
        for number in plan.slaves.clone() {
            let late = plan.late.filter(|(first, _)| number >= *first).map_or(Instant::ZERO, |(_, at)| at);
            let device = block(number);
            let mut config = slave::Config::new(&device.identity, mac(number));
            config.heartbeat_interval = plan.heartbeat;
            let id = line.add_slave(&format!("slave {number}"), late, config, device);
            line.network.schedule(Instant::ZERO, Change::SetReaction(id, Reaction::Fixed(plan.reaction)));
            line.slaves.push(id);
        }
        line
    }

    /// A line of which every slave runs.
    ///
    /// # Panics
    /// When it takes more than ten seconds.
    #[must_use]
    pub fn running(plan: &Plan) -> Self {
        let mut line = Self::new(plan);
        line.run_until(|line| line.is_running(), Duration::from_secs(10));
        line
    }

    /// Adds a node that is not in the scan list, such as one fresh from the factory.
    pub fn add_slave(
        &mut self,
        name: &str,
        power_up: Instant,
        config: slave::Config,
        device: LineBlock,
    ) -> NodeId {
        let node = NodeConfig { power_up: Some(power_up), ..NodeConfig::named(name) };
        self.network.add(node, LineSlave::new(config, device).expect("a valid slave"))
    }

    /// Runs on, and keeps what is seen.
    pub fn run(&mut self, span: Duration) {
        let end = self.network.now() + span;
        let (sent, destroyed, told) = (&mut self.sent, &mut self.destroyed, &mut self.told);
        self.network.run_until(end, &mut |record: &Record<'_, Told>| match record {
            Record::Frame(attempt) if attempt.outcome == Outcome::Ok => {
                let id = Identifier::of_frame(attempt.frame).expect("frames of DeviceNet");
                sent.push(Sent { start: attempt.start, end: attempt.end, id, frame: *attempt.frame });
            }
            Record::Frame(_) => *destroyed += 1,
            Record::Event { at, node, event } => told.push((*at, *node, **event)),
            _ => {}
        });
    }

    /// Runs until something is so, and looks every millisecond.
    ///
    /// # Panics
    /// When it does not become so in time.
    #[track_caller]
    pub fn run_until(&mut self, is_so: impl Fn(&Self) -> bool, at_most: Duration) {
        let end = self.network.now() + at_most;
        while !is_so(self) {
            assert!(self.network.now() < end, "not so after {at_most:?}: {:?}", self.told.last());
            self.run(Duration::from_millis(1));
        }
    }

    /// Forgets what was seen.
    pub fn forget(&mut self) {
        self.sent.clear();
        self.told.clear();
        self.destroyed = 0;
    }

    /// The master.
    ///
    /// # Panics
    /// Never: it is always there.
    #[must_use]
    pub fn master(&self) -> &LineMaster {
        self.network.machine(self.master).expect("the master")
    }

    /// A slave.
    ///
    /// # Panics
    /// When the node is none.
    #[must_use]
    #[track_caller]
    pub fn slave(&self, node: NodeId) -> &LineSlave {
        self.network.machine(node).expect("a slave")
    }

    /// A tool.
    ///
    /// # Panics
    /// When the node is none.
    #[must_use]
    #[track_caller]
    pub fn tool(&self, node: NodeId) -> &OfflineTool {
        self.network.machine(node).expect("a tool")
    }

    /// Whether all I/O runs.
    #[must_use]
    pub fn is_running(&self) -> bool {
        let master = self.master();
        master.scan_list().all(|entry| master.state(entry.mac_id) == Some(SlaveState::Running))
    }

    /// The time of a bit.
    #[must_use]
    pub fn bit(&self) -> Duration {
        Duration::from_nanos(self.network.config().bit_rate.bit_time_nanos().unwrap_or(0))
    }

    /// The time that a frame takes on the bus, with the intermission after it.
    #[must_use]
    pub fn wire(&self, frame: &Frame) -> Duration {
        self.bit() * (frame.bit_len() + INTERMISSION)
    }
}

impl From<MasterEvent> for Told {
    fn from(event: MasterEvent) -> Self {
        Self::Master(event)
    }
}

impl From<slave::Event> for Told {
    fn from(event: slave::Event) -> Self {
        Self::Slave(event)
    }
}

impl From<ToolEvent> for Told {
    fn from(event: ToolEvent) -> Self {
        Self::Tool(event)
    }
}

/// A MAC ID.
///
/// # Panics
/// Above 63.
#[must_use]
#[track_caller]
pub fn mac(number: u8) -> MacId {
    MacId::new(number).expect("a MAC ID")
}

/// A device whose serial number and data follow from a number.
///
/// # Panics
/// Never: the identity is valid.
#[must_use]
pub fn block(number: u8) -> LineBlock {
    Block::new(identity(0x2211_0000 | u32::from(number)), data(number, 0x3C))
}

/// A device of a fictitious vendor.
///
/// # Panics
/// Never: the identity is valid.
#[must_use]
pub fn identity(serial: u32) -> DeviceIdentity {
    DeviceIdentity {
        vendor: VendorId(0x1234),
        device_type: DeviceType::GENERAL_PURPOSE_DISCRETE_IO,
        product_code: 42,
        revision: Revision::new(1, 1).expect("a revision"),
        serial,
        name: ProductName::new("Example Block of Sixteen Points").expect("a product name"),
    }
}

fn entry(number: u8, expected_packet_rate: u16) -> ScanEntry {
    let poll = PollConnection { produce: 2, consume: 2, expected_packet_rate };
    ScanEntry { poll: Some(poll), ..ScanEntry::explicit_only(mac(number)) }
}

/// Two bytes that differ from slave to slave, and so do the stuff bits.
const fn data(number: u8, mask: u8) -> [u8; 2] {
    [number.wrapping_mul(0x35) ^ mask, number.wrapping_mul(0x91) ^ 0x0F]
}

/// Bits between two frames.
const INTERMISSION: u32 = 3;
const MASTER_SERIAL: u32 = 1;
