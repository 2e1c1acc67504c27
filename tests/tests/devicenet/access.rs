//! Network access on the simulated bus: controllers that count errors, wait for acknowledges and collide.

use devicenet_core::MacId;
use devicenet_core::access::{Access, AccessEvent, Config, Fault, StateKind};
use devicenet_core::message::{DeviceIdentity, PortNumber};
use link_core::{BitRate, Instant};
use transport_mock::{BusConfig, Change, Network, NodeConfig, NodeId, Record};

/// A bus of nodes whose serial number is their place on it. The vendor is fictitious.
struct Plant {
    network: Network<AccessEvent>,
    /// `seconds identifier data` of every frame that was sent to its end.
    trace: Vec<String>,
}

impl Plant {
    fn new() -> Self {
        Self { network: Network::new(BusConfig::new(BitRate::K125, 1)), trace: Vec::new() }
    }

    fn add(&mut self, mac: u8, power_up_millis: u64) -> NodeId {
        let serial = u32::try_from(self.network.nodes().count()).unwrap() + 1;
        let device = DeviceIdentity { vendor: 0x1234.into(), serial };
        let mut config = NodeConfig::named(format!("node {serial}"));
        config.power_up = Some(Instant::from_millis(power_up_millis));
        self.network.add(config, Access::new(Config::new(device, PortNumber::ZERO, MacId::new(mac).unwrap())))
    }

    fn run(&mut self, until_millis: u64) {
        let trace = &mut self.trace;
        self.network.run_until(Instant::from_millis(until_millis), &mut |record: &Record<
            '_,
            AccessEvent,
        >| {
            if let Record::Done { at, outcome: link_core::TxOutcome::Sent, node, .. } = record {
                trace.push(format!("{at:.1} node {}", node.index() + 1));
            }
        });
    }

    fn node(&self, node: NodeId) -> &Access {
        self.network.machine(node).unwrap()
    }

    #[track_caller]
    fn is(&self, node: NodeId, kind: StateKind) {
        assert_eq!(self.node(node).state().kind(), kind, "{}", self.network.name(node));
    }
}

#[test]
fn a_lone_node_gets_on_line_two_seconds_after_another_one_appears() {
    let mut plant = Plant::new();
    let lone = plant.add(5, 0);
    plant.run(10_000);
    plant.is(lone, StateKind::SendingDupMac);
    assert!(plant.network.counters(lone).tec <= 128, "error-passive at most");
    assert!(plant.node(lone).counters().unacknowledged > 100);
    assert_eq!(plant.trace, Vec::<String>::new());

    let second = plant.add(6, 10_000);
    plant.run(11_990);
    plant.is(lone, StateKind::WaitingDupMac);
    plant.run(12_100);
    plant.is(lone, StateKind::OnLine);
    plant.is(second, StateKind::OnLine);
}

#[test]
fn the_veteran_keeps_its_mac_id_and_the_newcomer_falls_silent() {
    let mut plant = Plant::new();
    let veteran = plant.add(37, 0);
    let other = plant.add(1, 0);
    let newcomer = plant.add(37, 5000);
    plant.run(20_000);
    plant.is(veteran, StateKind::OnLine);
    plant.is(other, StateKind::OnLine);
    assert_eq!(plant.node(newcomer).fault(), Some(Fault::DuplicateMacId));
    assert_eq!(plant.node(veteran).counters().responses, 1);
    assert_eq!(
        plant.trace,
        ["0.0 node 2", "0.0 node 1", "1.0 node 2", "1.0 node 1", "5.0 node 3", "5.0 node 1"],
        "two requests of the first two, one of the newcomer, one response"
    );
}

/// Of two that check, one falls silent at the other's request, and has nothing more to say against it.
#[test]
fn of_two_that_check_the_one_that_asks_later_gets_on_line() {
    let mut plant = Plant::new();
    plant.add(1, 0);
    let (first, second) = (plant.add(37, 0), plant.add(37, 300));
    plant.run(20_000);
    assert_eq!(plant.node(first).fault(), Some(Fault::DuplicateMacId));
    plant.is(second, StateKind::OnLine);
}

/// Their requests have the same identifier and different data, so they destroy each other until both senders are
/// error-passive and their error flags no longer disturb. Then the one with the dominant bit (the lower serial number)
/// gets through, and the repetition of the other silences it. Nobody goes off the bus.
#[test]
fn twins_that_start_at_the_same_moment_destroy_each_others_requests_until_they_are_error_passive() {
    let mut plant = Plant::new();
    let bystander = plant.add(1, 0);
    let (dominant, recessive) = (plant.add(37, 0), plant.add(37, 0));
    plant.run(20_000);
    plant.is(bystander, StateKind::OnLine);
    assert_eq!(plant.node(dominant).fault(), Some(Fault::DuplicateMacId));
    plant.is(recessive, StateKind::OnLine);
    for twin in [dominant, recessive] {
        assert!(plant.network.counters(twin).tec >= 127, "sixteen errors, two successes at most");
        assert_eq!(plant.node(twin).bus_off_counter(), 0);
    }
}

/// Two segments are powered up apart, each with a node of that MAC ID, and joined. Nothing happens until one of the two
/// has to defend itself: the answer silences the other.
#[test]
fn joined_segments_with_the_same_mac_id_fault_one_of_the_two() {
    let mut plant = Plant::new();
    let here = [plant.add(37, 0), plant.add(1, 0)];
    let there = [plant.add(37, 0), plant.add(2, 0)];
    plant.network.schedule(Instant::ZERO, Change::Split(there.to_vec()));
    plant.network.schedule(Instant::from_millis(5000), Change::Join);
    plant.run(6000);
    for node in here.into_iter().chain(there) {
        plant.is(node, StateKind::OnLine);
    }
    let newcomer = plant.add(37, 7000);
    plant.run(20_000);
    assert_eq!(plant.node(newcomer).fault(), Some(Fault::DuplicateMacId));
    let online = [here[0], there[0]].map(|node| plant.node(node).is_online());
    assert!(!(online[0] && online[1]), "two nodes with one MAC ID on line: {online:?}");
}

/// Tries the check with every distance between two twins: never both on line, whatever collides with what.
#[test]
fn twins_never_both_get_on_line() {
    for distance in (0..2500).step_by(50).chain(0..4) {
        let mut plant = Plant::new();
        plant.add(1, 0);
        let twins = [plant.add(37, 0), plant.add(37, distance)];
        plant.run(10_000);
        let online = twins.map(|twin| plant.node(twin).is_online());
        assert_ne!(online, [true, true], "{distance} ms apart");
    }
}
