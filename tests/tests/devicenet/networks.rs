//! Networks of real machines on the simulated bus: masters, slaves and a tool.

use cip_core::code::VendorId;
use devicenet_core::access::{self, Fault};
use devicenet_core::master::{
    self, ElectronicKey, IoInstance, Master, PollConnection, ReplacementMode, ScanEntry, ScannerStatus,
    SlaveState,
};
use devicenet_core::message::{DelayOffset, PortNumber};
use devicenet_core::slave::{self, Group2OnlyServer};
use devicenet_core::tool::{self, OfflineTool, ToolState};
use devicenet_tests::block::Block;
use devicenet_tests::line::{Told, identity, mac};
use link_core::{BitRate, Instant};
use transport_mock::{BusConfig, Change, Network, NodeConfig, NodeId, Record};

type Scanner = Master<63, 32>;
type Slave = Group2OnlyServer<Block<2, 1>>;

/// A line of nodes; each has its MAC ID as serial number, or another that it is given.
struct Line {
    network: Network<Told>,
    told: Vec<String>,
}

impl Line {
    fn new() -> Self {
        Self { network: Network::new(BusConfig::new(BitRate::K500, 1)), told: Vec::new() }
    }

    fn master(&mut self, number: u8, slaves: &[u8], change: impl FnOnce(&mut master::Config)) -> NodeId {
        let mut config = master::Config::new(identity(number.into()), mac(number));
        change(&mut config);
        let mut master = Scanner::new(config);
        for &slave in slaves {
            master.add_slave(Instant::ZERO, entry(slave)).unwrap();
            master.set_output(mac(slave), &[slave | 0x80]).unwrap();
        }
        master.set_run(true);
        self.network.add(named("master", number), master)
    }

    /// A slave that powers up at `seconds`; `None`: when somebody switches it on.
    fn slave(&mut self, number: u8, serial: u32, seconds: Option<u64>) -> NodeId {
        let device = identity(serial);
        let config = slave::Config::new(&device, mac(number));
        let block = Block::new(device, [number, 0x12]);
        let mut node = named("slave", number);
        node.power_up = seconds.map(|seconds| Instant::from_millis(1000 * seconds));
        self.network.add(node, Slave::new(config, block).unwrap())
    }

    fn at(&mut self, seconds: u64, change: Change<Told>) {
        self.network.schedule(Instant::from_millis(1000 * seconds), change);
    }

    fn run(&mut self, until_seconds: u64) {
        let told = &mut self.told;
        self.network.run_until(Instant::from_millis(1000 * until_seconds), &mut |record: &Record<
            '_,
            Told,
        >| {
            if let Record::Event { event, .. } = record {
                match event {
                    Told::Master(event) => told.push(event.to_string()),
                    Told::Tool(event) => told.push(event.to_string()),
                    Told::Slave(_) => {}
                }
            }
        });
    }

    fn scanner(&self, node: NodeId) -> &Scanner {
        self.network.machine(node).unwrap()
    }

    fn block(&self, node: NodeId) -> &Slave {
        self.network.machine(node).unwrap()
    }

    /// The slave runs, and data go both ways.
    #[track_caller]
    fn exchanges(&self, master: NodeId, slave: NodeId, number: u8) {
        let scanner = self.scanner(master);
        assert_eq!(scanner.state(mac(number)), Some(SlaveState::Running), "slave {number}");
        assert_eq!(scanner.status(mac(number)), Some(ScannerStatus::NORMAL), "slave {number}");
        let inputs = self.block(slave).application().inputs;
        assert_eq!(scanner.input_data(mac(number), IoInstance::Poll), Some(&inputs[..]), "slave {number}");
        assert_eq!(self.block(slave).application().outputs, [number | 0x80], "slave {number}");
    }

    #[track_caller]
    fn was_told(&self, words: &str) {
        assert!(self.told.iter().any(|told| told == words), "{words:?} is not among {:#?}", self.told);
    }
}

fn entry(number: u8) -> ScanEntry {
    let key =
        ElectronicKey { vendor: Some(VendorId(0x1234)), product_code: Some(42), ..ElectronicKey::default() };
    let poll = PollConnection { produce: 2, consume: 1, expected_packet_rate: 100 };
    ScanEntry { key, poll: Some(poll), replaceable: true, ..ScanEntry::explicit_only(mac(number)) }
}

fn named(role: &str, number: u8) -> NodeConfig {
    NodeConfig::named(format!("{role} {number}"))
}

#[test]
fn sixty_three_slaves_from_power_up_to_io() {
    let mut line = Line::new();
    let numbers: Vec<u8> = (1..64).collect();
    let master = line.master(0, &numbers, |_| {});
    let slaves: Vec<NodeId> =
        numbers.iter().map(|&number| line.slave(number, number.into(), Some(0))).collect();
    line.run(10);
    for (&slave, &number) in slaves.iter().zip(&numbers) {
        line.exchanges(master, slave, number);
        let counters = line.scanner(master).slave_counters(mac(number)).unwrap();
        assert_eq!((counters.established, counters.timeouts, counters.missed), (1, 0, 0), "slave {number}");
    }
    assert_eq!(line.scanner(master).counters().events_lost, 0);
}

#[test]
fn a_cut_slave_comes_back() {
    let mut line = Line::new();
    let master = line.master(0, &[10, 20], |_| {});
    let slaves = [line.slave(10, 10, Some(0)), line.slave(20, 20, Some(0))];
    line.at(6, Change::Cut(slaves[1]));
    line.at(20, Change::Plug(slaves[1]));
    line.run(5);
    line.exchanges(master, slaves[0], 10);
    line.exchanges(master, slaves[1], 20);
    line.run(19);
    line.was_told("slave 20: Running -> Waiting: timed out");
    line.exchanges(master, slaves[0], 10);
    let scanner = line.scanner(master);
    assert_eq!(scanner.status(mac(20)), Some(ScannerStatus::NOT_FOUND));
    assert_eq!(scanner.input_data(mac(20), IoInstance::Poll), None);
    assert_eq!(line.block(slaves[1]).application().outputs, [0], "its outputs rest");
    line.run(30);
    line.exchanges(master, slaves[0], 10);
    line.exchanges(master, slaves[1], 20);
    assert_eq!(line.scanner(master).slave_counters(mac(10)).unwrap().timeouts, 0);
}

/// The second master finds the slave owned, and gets it when the first is gone and its connections have timed out.
#[test]
fn two_masters_and_one_slave() {
    let mut line = Line::new();
    let first = line.master(0, &[10], |_| {});
    let second = line.master(1, &[10], |config| config.retry_at_most = core::time::Duration::from_secs(4));
    let slave = line.slave(10, 10, Some(0));
    line.at(0, Change::PowerOff(second));
    line.at(4, Change::PowerOn(second));
    line.run(10);
    line.exchanges(first, slave, 10);
    assert_eq!(line.scanner(second).status(mac(10)), Some(ScannerStatus::INITIALISATION_REFUSED));
    line.was_told("slave 10: Contacting -> Waiting: owned by another master");
    line.at(10, Change::PowerOff(first));
    line.run(40);
    line.exchanges(second, slave, 10);
}

/// Two masters that are switched on in the same bit want the same slaves, and begin with the same one in the same bit. They
/// part before either is bus-off, and each slave is one's.
#[test]
fn two_masters_at_once() {
    for slaves in [1, 8, 40] {
        let numbers: Vec<u8> = (10..10 + slaves).collect();
        let mut line = Line::new();
        let masters = [line.master(0, &numbers, |_| {}), line.master(1, &numbers, |_| {})];
        let nodes: Vec<NodeId> =
            numbers.iter().map(|&number| line.slave(number, number.into(), Some(0))).collect();
        line.run(20);
        for master in masters {
            assert!(line.scanner(master).access().is_online(), "{slaves} slaves");
        }
        assert!(line.scanner(masters[0]).counters().collisions > 0, "they do collide");
        for (&number, &node) in numbers.iter().zip(&nodes) {
            let runs =
                |master: &&NodeId| line.scanner(**master).state(mac(number)) == Some(SlaveState::Running);
            let owners: Vec<&NodeId> = masters.iter().filter(runs).collect();
            assert_eq!(owners.len(), 1, "slave {number} of {slaves}");
            line.exchanges(*owners[0], node, number);
        }
    }
}

/// A master that was restarted finds its own old connections, and gets on at once.
#[test]
fn a_master_that_was_restarted() {
    let mut line = Line::new();
    let master = line.master(0, &[10], |_| {});
    let slave = line.slave(10, 10, Some(0));
    line.at(5, Change::PowerCycle(master));
    line.run(8);
    line.exchanges(master, slave, 10);
}

/// A new device out of the box, at MAC ID 63, takes the place of the slave that died.
#[test]
fn a_replaced_slave() {
    let mut line = Line::new();
    let master = line.master(0, &[10, 20], |config| config.replacement = ReplacementMode::On);
    let dead = line.slave(10, 10, Some(0));
    let other = line.slave(20, 20, Some(0));
    let new = line.slave(63, 999, None);
    line.at(5, Change::PowerOff(dead));
    line.at(15, Change::PowerOn(new));
    line.run(40);
    line.was_told("replacement: the device at MAC ID 63 becomes slave 10");
    assert_eq!(line.block(new).access().mac_id(), mac(10));
    line.exchanges(master, new, 10);
    line.exchanges(master, other, 20);
}

/// A second device with MAC ID 10 is faulted; a tool finds it and gives it MAC ID 11, while the line runs.
#[test]
fn a_tool_recovers_a_duplicate_while_the_line_runs() {
    let mut line = Line::new();
    let master = line.master(0, &[10, 11], |_| {});
    let veteran = line.slave(10, 10, Some(0));
    let twin = line.slave(10, 0x0506_0708, Some(5));
    let known = devicenet_core::message::DeviceIdentity { vendor: VendorId(0x1234), serial: 0x77 };
    let config = tool::Config::new(access::Config::new(known, PortNumber::ZERO, mac(62)));
    let tool = line.network.add(named("tool", 62), OfflineTool::new(config));
    line.run(10);
    assert_eq!(line.block(twin).access().fault(), Some(Fault::DuplicateMacId));
    line.network.command(tool, OfflineTool::claim).unwrap().unwrap();
    line.run(13);
    assert_eq!(line.network.machine::<OfflineTool>(tool).unwrap().state(), ToolState::Owner);
    line.network
        .command(tool, |tool: &mut OfflineTool, now| tool.who(now, DelayOffset::SERIAL))
        .unwrap()
        .unwrap();
    line.run(17);
    line.was_told("found vendor 4660, serial 0x05060708");
    let found = devicenet_core::message::DeviceIdentity { vendor: VendorId(0x1234), serial: 0x0506_0708 };
    let give = |tool: &mut OfflineTool, now| tool.change_mac_id(now, found, mac(11));
    line.network.command(tool, give).unwrap().unwrap();
    line.run(40);
    line.was_told("vendor 4660, serial 0x05060708 is on line with MAC ID 11");
    line.exchanges(master, veteran, 10);
    assert_eq!(line.block(twin).access().mac_id(), mac(11));
    assert_eq!(line.scanner(master).state(mac(11)), Some(SlaveState::Running));
    assert_eq!(line.scanner(master).slave_counters(mac(10)).unwrap().timeouts, 0);
}
