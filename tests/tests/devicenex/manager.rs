//! The network manager with devices on the simulated bus.

use std::time::Duration;

use devicenex_core::access::StateKind;
use devicenex_core::id::{Identifier, Layout};
use devicenex_core::manager::{
    DeviceState, IdentityPattern, ManagerEvent, PlannedConnection, PlannedDevice, PlannedEvent,
};
use link_core::{BitRate, Instant};
use transport_mock::nodes::Replay;
use transport_mock::{Change, NodeConfig, NodeId};

use super::plant::oa;
use super::works::*;

struct Paper {
    works: Works,
    manager: NodeId,
    a: NodeId,
    b1: NodeId,
    b2: NodeId,
    c: NodeId,
}

/// Figures 13 to 17: all devices are there before the manager, which comes after three seconds.
fn paper(consumer_rate: u16) -> Paper {
    let mut works = Works::at(BitRate::K125);
    let a = works.device("A", 3, 0xA, 0);
    let b1 = works.device("B1", 2, 0xB1, 0);
    let b2 = works.device("B2", 2, 0xB2, 0);
    let c = works.device("C", 4, 0xC, 0);
    let manager = works.manager(3000, works.config(1, 1), plant_of_the_paper(consumer_rate));
    let mut paper = Paper { works, manager, a, b1, b2, c };
    paper.works.run_ms(15_000);
    assert!(paper.runs());
    assert_eq!(paper.outputs(), [[0xB2, 0x00]; 2]);
    paper
}

impl Paper {
    fn runs(&self) -> bool {
        [5, 67, 109].iter().all(|&address| self.works.state(self.manager, address) == DeviceState::Running)
    }

    fn outputs(&self) -> [[u8; 2]; 2] {
        [self.a, self.c].map(|node| self.works.block(node).application().outputs)
    }

    fn standby(&self, node: NodeId) -> bool {
        self.works.block(node).access().state().kind() == StateKind::Standby
    }

    /// Requests for connections and on connections, since then, to the consumers.
    fn touched(&self, since: Instant) -> usize {
        let is = |(begin, _, frame): &&(Instant, Instant, _)| {
            let layout = Identifier::of_frame(frame).layout();
            let (Layout::Connection { route, .. } | Layout::Explicit { route, .. }) = layout else {
                return false;
            };
            *begin >= since && [oa(5), oa(109)].contains(&route.destination)
        };
        self.works.frames.iter().filter(is).count()
    }
}

/// Section 5 of the paper, as a whole: B2 is cut off, B1 takes over its address, A and C consume what it produces without
/// being touched; B2 comes back, and stands by.
#[test]
fn the_worked_example_of_the_paper() {
    let mut paper = paper(0);
    assert!(paper.standby(paper.b1));
    let cut = paper.works.network.now();
    paper.works.network.apply(Change::Cut(paper.b2));
    let end = cut + Duration::from_secs(10);
    paper.works.run(end);
    assert!(paper.runs());
    assert_eq!(paper.outputs(), [[0xB1, 0x00]; 2]);
    assert_eq!(paper.touched(cut), 0, "an EPR of 0: they wait for ever");
    let [b1, b2] = [0xB1, 0xB2].map(|serial| who(2, serial));
    let about = paper.works.about(paper.manager, 67);
    assert!(about.contains(&&PlannedEvent::Lost(Some(b2))));
    assert!(about.contains(&&PlannedEvent::Replaced { was: b2, by: b1 }));

    paper.works.network.apply(Change::Plug(paper.b2));
    let back = end + Duration::from_secs(10);
    paper.works.run(back);
    assert!(paper.standby(paper.b2));
    assert!(paper.works.told.iter().any(|(at, _, event)| *at > end && *event == ManagerEvent::Spare(b2)));
    assert!(paper.runs());

    // And the other way round.
    paper.works.network.apply(Change::Cut(paper.b1));
    paper.works.run(back + Duration::from_secs(10));
    assert_eq!(paper.outputs(), [[0xB2, 0x00]; 2]);
    assert_eq!(paper.touched(cut), 0);
}

/// The time without data: until the silence is noticed (four packet rates), two requests that are not answered, the two Hello
/// waits of the spare, and at most a tenth of a second.
#[test]
fn a_spare_is_there_within_the_hello_waits_and_a_tenth_of_a_second() {
    for rate in [BitRate::K125, BitRate::K500] {
        let mut paper = paper(0);
        let cut = paper.works.network.now();
        paper.works.network.apply(Change::Cut(paper.b2));
        paper.works.run(cut + Duration::from_secs(5));
        // What OA 67 produces on connection 7.
        let first = |since| {
            let mut data = paper.works.frames.iter().filter(|(begin, _, frame)| {
                *begin > since && Identifier::of_frame(frame).to_string() == "00860007"
            });
            data.next().expect("data").1
        };
        let silence = first(cut).saturating_since(cut);
        let detection = Duration::from_millis(4 * 100 + 2 * 500);
        let most = detection + Duration::from_millis(2 * 1000 + 100);
        assert!(silence <= most, "{silence:?} of {most:?} at {rate}");
        println!("replacement: {silence:?}, of which {detection:?} to detect the loss");
    }
}

/// Consumers that do not wait for ever time out meanwhile, and are made anew.
#[test]
fn consumers_that_timed_out_are_made_anew() {
    let mut paper = paper(200);
    let cut = paper.works.network.now();
    paper.works.network.apply(Change::Cut(paper.b2));
    paper.works.run(cut + Duration::from_secs(2));
    for address in [5, 109] {
        assert_eq!(
            paper.works.state(paper.manager, address),
            DeviceState::Connecting,
            "its producer is gone"
        );
    }
    paper.works.run(cut + Duration::from_secs(10));
    assert!(paper.runs());
    assert_eq!(paper.outputs(), [[0xB1, 0x00]; 2]);
}

/// Nobody can stand in: that is told once, and the device itself gets its address when it comes back.
#[test]
fn without_a_spare_the_device_is_waited_for() {
    let mut paper = paper(0);
    let cut = paper.works.network.now();
    paper.works.network.apply(Change::Cut(paper.b1));
    paper.works.network.apply(Change::Cut(paper.b2));
    paper.works.run(cut + Duration::from_secs(20));
    assert_eq!(paper.works.state(paper.manager, 67), DeviceState::Lost);
    let told = |event| paper.works.about(paper.manager, 67).iter().filter(|&&about| *about == event).count();
    assert_eq!(told(PlannedEvent::NoSpare), 1);
    let asked = paper.works.count("1FFE0100", cut + Duration::from_secs(10));
    assert!((4..=6).contains(&asked), "a Mini-who every two seconds: {asked}");
    // It kept its address, and says Hello with it.
    paper.works.network.apply(Change::Plug(paper.b2));
    paper.works.run(cut + Duration::from_secs(30));
    assert!(paper.runs());
    assert_eq!(paper.outputs(), [[0xB2, 0x00]; 2]);
    assert_eq!(paper.works.chief(paper.manager).counters().replaced, 0);
}

/// A new manager finds a running network: it reads, and changes nothing.
#[test]
fn a_restarted_manager_takes_over_without_disturbing() {
    for consumer_rate in [0, 500] {
        let mut paper = paper(consumer_rate);
        paper.works.network.apply(Change::PowerOff(paper.manager));
        let off = paper.works.network.now();
        paper.works.run(off + Duration::from_secs(5));
        paper.works.network.apply(Change::PowerOn(paper.manager));
        paper.works.run(off + Duration::from_secs(15));
        assert!(paper.runs());
        let sent = paper.works.of_manager(1, off);
        // Hello, Mini-who, and requests without a connection.
        assert!(sent.iter().all(|frame| frame.starts_with("1F") || frame.starts_with("1C")), "{sent:#?}");
        let now = paper.works.network.now();
        paper.works.network.apply(Change::Cut(paper.b2));
        paper.works.run(now + Duration::from_secs(10));
        assert!(paper.runs(), "it watches what it found");
        assert_eq!(paper.outputs(), [[0xB1, 0x00]; 2]);
    }
}

/// The second of two managers is passive: the first goes on.
#[test]
fn a_second_manager_leaves_the_work_to_the_first() {
    for serial in [0x0101, 0x7777] {
        let mut paper = paper(0);
        let config =
            devicenex_core::manager::Config { takeover_after: 30_000, ..paper.works.config(serial, 2) };
        let now = paper.works.network.now();
        let millis = |at: Instant| u64::try_from(at.saturating_since(Instant::ZERO).as_millis()).unwrap();
        let second = paper.works.manager(millis(now), config, plant_of_the_paper(0));
        paper.works.run(now + Duration::from_secs(30));
        let works = [paper.manager, second].map(|node| paper.works.chief(node).works());
        // One of them; which, the serial number decides when both have asked already.
        assert_eq!(works.iter().filter(|works| **works).count(), 1, "{works:?}");
        let yields = |event: &ManagerEvent| matches!(event, ManagerEvent::SecondManager { yields: true, .. });
        assert!(paper.works.told.iter().any(|(_, _, event)| yields(event)));
        assert_eq!(paper.touched(now), 0, "the devices do not notice");
        let (active, other) = if works[0] { (paper.manager, second) } else { (second, paper.manager) };
        // Both know the plant; the one that works replaces.
        paper.works.network.apply(Change::Cut(paper.b2));
        paper.works.run(now + Duration::from_secs(40));
        assert_eq!(paper.outputs(), [[0xB1, 0x00]; 2]);
        assert_eq!(paper.works.state(active, 67), DeviceState::Running);
        assert_eq!(paper.works.state(other, 67), DeviceState::Idle);
        if other == second {
            // It takes over half a minute after the last sign of the first.
            paper.works.network.apply(Change::PowerOff(active));
            paper.works.run(now + Duration::from_secs(90));
            assert_eq!(paper.works.state(other, 67), DeviceState::Running);
        }
    }
}

/// Before the manager, at the same time, long after it, in any order.
#[test]
fn devices_come_up_in_any_order() {
    for order in
        [[0, 0, 0, 0], [20_000, 0, 9000, 4000], [0, 30_000, 10_000, 5], [12_000, 12_000, 12_000, 12_000]]
    {
        let mut works = Works::at(BitRate::K250);
        let manager = works.manager(8000, works.config(1, 1), plant_of_the_paper(0));
        let consumers = [works.device("A", 3, 0xA, order[0]), works.device("C", 4, 0xC, order[1])];
        works.device("B2", 2, 0xB2, order[2]);
        works.device("B1", 2, 0xB1, order[3]);
        works.run_ms(60_000);
        for address in [5, 67, 109] {
            assert_eq!(works.state(manager, address), DeviceState::Running, "{order:?}");
        }
        for node in consumers {
            assert_eq!(works.block(node).application().outputs, [0xB2, 0x00], "{order:?}");
        }
    }
}

/// The device itself never comes: its spare may.
#[test]
fn a_spare_stands_in_for_a_device_that_was_never_seen() {
    let mut works = Works::at(BitRate::K250);
    let manager = works.manager(0, works.config(1, 1), plant_of_the_paper(0));
    works.device("B1", 2, 0xB1, 0);
    works.run_ms(12_000);
    assert_eq!(works.state(manager, 67), DeviceState::Missing);
    works.run_ms(30_000);
    assert_eq!(works.state(manager, 67), DeviceState::Running);
}

/// A device that loses its power for a moment has lost its address and its connections; it gets them back.
#[test]
fn a_device_that_restarts_is_brought_back() {
    let mut paper = paper(0);
    for node in [paper.b2, paper.a] {
        paper.works.network.apply(Change::PowerCycle(node));
        let now = paper.works.network.now();
        paper.works.run(now + Duration::from_secs(20));
        assert!(paper.runs());
        assert!(paper.standby(paper.b1), "nobody replaces it");
    }
    assert_eq!(paper.outputs(), [[0xB2, 0x00]; 2]);
}

/// The ROAMs of two devices that share the low half of their serial number have one identifier, and name the whole identity.
/// If both say Hello in the same bit time they collide, which is the paper's limit.
#[test]
fn devices_that_share_half_a_serial_number_get_their_own_address() {
    let plan = || {
        [(10, 0x0001_7777), (11, 0x0002_7777)]
            .map(|(address, serial)| PlannedDevice::new(oa(address), IdentityPattern::exact(who(2, serial))))
    };
    let mut works = Works::at(BitRate::K250);
    let manager = works.manager(0, works.config(1, 1), plan());
    let nodes = [works.device("first", 2, 0x0001_7777, 0), works.device("second", 2, 0x0002_7777, 20_000)];
    works.run_ms(40_000);
    for (node, address) in nodes.into_iter().zip([10, 11]) {
        assert_eq!(works.block(node).access().address(), oa(address));
        assert_eq!(works.state(manager, address), DeviceState::Running);
    }

    let mut works = Works::at(BitRate::K250);
    let manager = works.manager(0, works.config(1, 1), plan());
    let nodes = [works.device("first", 2, 0x0001_7777, 0), works.device("second", 2, 0x0002_7777, 0)];
    works.run_ms(40_000);
    let together = nodes.map(|node| works.network.counters(node).tec);
    assert!(together.iter().all(|&tec| tec > 0), "{together:?}");
    // Nodes of which one has begun to send a bit later, being error-passive, get through one after the other.
    for (node, address) in nodes.into_iter().zip([10, 11]) {
        assert_eq!(works.block(node).access().address(), oa(address));
        assert_eq!(works.state(manager, address), DeviceState::Running);
    }
}

/// A device that has the address of another network, and is planned here, is told its own over an explicit connection.
#[test]
fn a_misplaced_device_is_readdressed() {
    let mut works = Works::at(BitRate::K250);
    let mut strange = works.config(1, 1);
    strange.learning = true;
    let there = works.manager(0, strange, []);
    let node = works.device("A", 3, 0xA, 0);
    works.run_ms(15_000);
    let learned = works.block(node).access().address();
    assert!(works.block(node).access().is_online());
    assert_eq!(works.chief(there).devices().count(), 1);
    works.network.apply(Change::PowerOff(there));
    let plan = PlannedDevice::new(oa(5), IdentityPattern::product_of(who(3, 0)));
    let manager = works.manager(16_000, works.config(2, 2), [plan]);
    works.run_ms(45_000);
    assert_eq!(works.block(node).access().address(), oa(5));
    assert_eq!(works.state(manager, 5), DeviceState::Running);
    let device = who(3, 0xA);
    let misplaced = ManagerEvent::Misplaced { device, at: learned, planned: oa(5) };
    assert!(works.told.iter().any(|(_, _, event)| *event == misplaced));
    let readdressed = ManagerEvent::Readdressed { from: learned, to: oa(5), result: Ok(()) };
    assert!(works.told.iter().any(|(_, _, event)| *event == readdressed));
}

/// 126 devices that stand by: found by one Mini-who, addressed, and a producing connection made with each, all at once.
#[test]
fn a_full_network_is_addressed_and_connected_in_little_more_than_its_frames_need() {
    let mut works = Works::at(BitRate::K500);
    let addresses: Vec<_> = (0..127).filter(|&address| address != 1).collect();
    let plan = addresses.iter().map(|&address| {
        let mut planned = PlannedDevice::new(oa(address), IdentityPattern::product_of(who(2, 0)));
        planned.connections.push(PlannedConnection::producer(0)).unwrap();
        planned
    });
    let plan: Vec<_> = plan.collect();
    // They stand by when the manager comes: another one, to which they are unknown, let them find the rate.
    let config = NodeConfig { power_up: Some(Instant::ZERO), ..NodeConfig::named("ear") };
    works.network.add_silent(config, Replay::new(Vec::new()));
    let first = works.manager(10, works.config(0xFFFF, 0), []);
    for place in 0..126_u32 {
        works.device(&format!("{place}"), 2, 0x0102_0300 + place, 0);
    }
    works.run_ms(5000);
    works.network.apply(Change::PowerOff(first));
    let manager = works.manager(5000, works.config(1, 1), plan);
    let is_online = |works: &Works| works.chief(manager).works();
    works.run_till(Duration::from_secs(5), is_online);
    let asked = works.run_till(Duration::from_secs(5), |works| works.chief(manager).counters().mini_whos > 0);
    let runs =
        |works: &Works| works.chief(manager).devices().all(|device| device.state == DeviceState::Running);
    let done = works.run_till(Duration::from_secs(10), runs);
    let took = done.saturating_since(asked);
    let on_the_wire: Duration = works
        .frames
        .iter()
        .filter(|(begin, end, _)| *end > asked && *begin < done)
        .map(|(begin, end, _)| end.saturating_since(*begin))
        .sum();
    let needed = on_the_wire + Duration::from_secs(2);
    println!(
        "126 devices in Standby, from the Mini-who: {took:?}, of {needed:?} for the frames and two Hello waits"
    );
    assert!(took <= needed.mul_f64(1.25), "{took:?} of {needed:?}");
    assert_eq!(works.spoilt.iter().filter(|&&at| at > asked).count(), 0);
}
