//! A slave without the parts that one may do without.

use std::vec::Vec;

use cip_core::connection::TimerResolution;
use cip_core::message::{AllocationChoice, ResetType};
use cip_core::object::Identity;
use link_core::frame::standard_id;
use link_core::{Action, FilterSet, Frame, Input, Instant, LinkEvent, Machine};

use super::bus::*;
use crate::MacId;
use crate::access::{BusOffWhileChecking, CounterSetMode, Fault, NetworkStatus};
use crate::slave::{
    Application, Config, Group2OnlyServer, InvalidSlave, IoKind, IoMode, Options, Parts, PollOnly, SlaveEvent,
};

/// A device with the parts that these bits stand for.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct Small<const PARTS: u16 = TELLING>(Block);

impl<const PARTS: u16> Application for Small<PARTS> {
    const IO: AllocationChoice = Block::IO;
    const PARTS: Parts = Parts::from_bits_retain(PARTS);
    type Long = PollOnly;

    fn identity(&self) -> Identity<'_> {
        self.0.identity()
    }

    fn produced(&self, connection: IoKind) -> &[u8] {
        self.0.produced(connection)
    }

    fn consumed(&mut self, connection: IoKind) -> &mut [u8] {
        self.0.consumed(connection)
    }
}

/// Of a configuration.
type Change = fn(&mut Config);

#[test]
fn what_is_left_out_cannot_be_configured() {
    let refused = |change: Change| {
        let mut config = Config::new(&device(), MacId::DEFAULT);
        change(&mut config);
        Group2OnlyServer::<Small>::new(config, Small(block())).err()
    };
    assert_eq!(refused(|_| {}), None);
    assert_eq!(refused(|config| config.resolution = TimerResolution::FINEST), None);
    let cases: [(Change, Parts); 12] = [
        (|config| config.bit_rate.detect = true, Parts::BIT_RATE_DETECTION),
        (|config| config.heartbeat_interval = Some(0), Parts::HEARTBEAT),
        (|config| config.options.insert(Options::SHUTDOWN_MESSAGE), Parts::SHUTDOWN_MESSAGE),
        (|config| config.options.insert(Options::ANSWER_SHORT_BODY), Parts::CHOICES),
        (|config| config.failures.group_2_only_failure = true, Parts::CHOICES),
        (|config| config.resolution = TimerResolution::new(2).unwrap(), Parts::CHOICES),
        (|config| config.receive_time_out = 100, Parts::CHOICES),
        (|config| config.access.accept_bad_dlc = false, Parts::CHOICES),
        (|config| config.access.same_mac_id_restarts = false, Parts::CHOICES),
        (|config| config.access.counter_set_mode = CounterSetMode::OnlyZero, Parts::CHOICES),
        (
            |config| config.access.bus_off_while_checking = BusOffWhileChecking::FollowInterrupt,
            Parts::CHOICES,
        ),
        (|config| config.access.quick_connect = true, Parts::OPTIONAL_ATTRIBUTES),
    ];
    for (change, part) in cases {
        assert_eq!(refused(change), Some(InvalidSlave::PartLeftOut(part)));
    }
}

/// A node that a duplicate keeps off line hears the offline connection set only if it has that part.
#[test]
fn without_the_offline_set_a_fault_is_silence() {
    let config = Config::new(&device(), MacId::DEFAULT);
    let mut small = Group2OnlyServer::<Small>::new(config.clone(), Small(block())).unwrap();
    assert_eq!(answers_to_who(&mut small), 0);
    assert_eq!(small.access().filter(), FilterSet::none());
    let mut complete = Group2OnlyServer::<Block>::new(config, block()).unwrap();
    assert_eq!(answers_to_who(&mut complete), 1);
}

/// How often a node that is faulted by a duplicate answers the question who is there.
fn answers_to_who<A: Application>(slave: &mut Group2OnlyServer<A>) -> usize {
    let frame = |id, data: &[u8]| Input::Frame(Frame::new(standard_id(id), data).unwrap());
    slave.handle(Instant::ZERO, Input::Link(LinkEvent::Up)).for_each(drop);
    // Another node has MAC ID 63: its duplicate MAC ID check response.
    slave.handle(Instant::ZERO, frame(0x5FF, &[0x80, 1, 0, 2, 0, 0, 0])).for_each(drop);
    assert_eq!(slave.access().fault(), Some(Fault::DuplicateMacId));
    // The request was with the controller.
    let given_back = Input::TxDone(crate::access::Access::TOKEN, link_core::TxOutcome::Withdrawn);
    slave.handle(Instant::ZERO, given_back).for_each(drop);
    // Who, every node; the delay is the port number, 0.
    let actions = slave.handle(Instant::ZERO, frame(0x7ED, &[0x3F, 0x4B, 0x00]));
    actions.filter(|action| matches!(action, Action::Transmit(..))).count()
}

/// What a part decides is not there without it, and nothing else is missing.
#[test]
fn a_small_slave_answers_as_a_complete_one() {
    let mut complete = Bus::<Block, 0>::online(config(), block()).allocated(0x01);
    let mut small = Bus::<Small, 0>::online(config(), Small(block())).allocated(0x01);
    for attribute in 1..=12 {
        let request = [MASTER, 0x0E, 0x03, 0x01, attribute];
        complete.hears(REQUEST, &request);
        small.hears(REQUEST, &request);
        match attribute {
            1..=5 => assert_eq!(complete.response(), small.response(), "attribute {attribute}"),
            10 => assert_eq!(complete.response(), [MASTER, 0x8E, 0x00], "Quick Connect is off"),
            12 => complete.skip(),
            _ => assert_eq!(complete.response(), NOT_SUPPORTED),
        }
        if attribute > 5 {
            assert_eq!(small.response(), NOT_SUPPORTED, "attribute {attribute}");
        }
    }
}

/// Without choices there are no steps to which a rate is rounded.
#[test]
fn a_small_slave_takes_every_packet_rate_as_it_is() {
    let mut complete = Bus::<Block, 0>::online(config(), block()).allocated(0x03);
    let mut small = Bus::<Small, 0>::online(config(), Small(block())).allocated(0x03);
    for (asked, rounded) in [(0, 0), (1, 10), (75, 80), (65_530, 65_530)] {
        let [low, high] = u16::to_le_bytes(asked);
        let answer = |used| [&[MASTER, 0x90], &u16::to_le_bytes(used)[..]].concat();
        complete.hears(REQUEST, &[MASTER, 0x10, 0x05, 0x02, 0x09, low, high]);
        assert_eq!(complete.response(), answer(rounded));
        small.hears(REQUEST, &[MASTER, 0x10, 0x05, 0x02, 0x09, low, high]);
        assert_eq!(small.response(), answer(asked));
    }
}

/// Delete, Apply_Attributes, Find_Next_Object_Instance, the Reset of all instances, Get_Attributes_All of Identity.
#[test]
fn a_small_slave_has_the_services_that_a_connection_must_have() {
    let mut complete = Bus::<Block, 0>::online(config(), block()).allocated(0x03);
    let mut small = Bus::<Small, 0>::online(config(), Small(block())).allocated(0x03);
    let same: [&[u8]; 3] =
        [&[0x0E, 0x05, 0x02, 0x01], &[0x10, 0x05, 0x02, 0x09, 0x50, 0x00], &[0x05, 0x05, 0x02]];
    for body in same {
        let request = [&[MASTER], body].concat();
        complete.hears(REQUEST, &request);
        small.hears(REQUEST, &request);
        let answer = complete.response();
        assert_eq!(answer[1], body[0] | 0x80);
        assert_eq!(small.response(), answer);
    }
    for body in [
        [0x05, 0x05, 0x00].as_slice(),
        &[0x0D, 0x05, 0x02],
        &[0x11, 0x05, 0x00, 9],
        &[0x09, 0x05, 0x02],
        &[0x01, 0x01, 0x01],
    ] {
        small.hears(REQUEST, &[&[MASTER], body].concat());
        assert_eq!(small.response(), [MASTER, 0x94, 0x08, 0xFF], "{body:02X?}");
    }
}

/// The attributes 1 to 4 of the DeviceNet object, and 17 and 18 of a Connection object.
#[test]
fn a_small_slave_has_no_settings_that_it_need_not_have() {
    let mut small = Bus::<Small, 0>::online(config(), Small(block())).allocated(0x03);
    for (attribute, value) in [(1, 5), (2, 1), (3, 1), (4, 0)] {
        small.asks(&[0x10, 3, 1, attribute, value], &[0x94, 0x08, 0xFF]);
    }
    small.asks(&[0x10, 5, 2, 17, 10, 0], &[0x94, 0x14, 0xFF]);
    small.asks(&[0x10, 5, 2, 18, 1], &[0x94, 0x14, 0xFF]);
    small.asks(&[0x0E, 5, 2, 18], &[0x94, 0x14, 0xFF]);
    small.asks(&[0x10, 5, 2, 12, 2], &[0x90]);
    const OPTIONAL: u16 = Parts::OPTIONAL_ATTRIBUTES.union(Parts::EVENTS).bits();
    let mut optional = Bus::<Small<OPTIONAL>, 0>::online(config(), Small(block())).allocated(0x03);
    optional.asks(&[0x10, 3, 1, 1, 5], &[0x94, 0x0E, 0xFF]);
    optional.asks(&[0x10, 3, 1, 10, 1], &[0x90]);
    optional.asks(&[0x10, 5, 2, 18, 1], &[0x90]);
}

/// What cannot be set is not as it was out of the box either.
#[test]
fn without_settings_a_reset_keeps_the_mac_id() {
    let mut small = Bus::<Small, 0>::online(config(), Small(block())).allocated(0x01);
    small.asks(&[0x05, 1, 1, 1], &[0x85]);
    assert_eq!(small.slave.access().mac_id(), config().access.mac_id);
    let reset = SlaveEvent::Reset(ResetType::OUT_OF_BOX);
    assert_eq!(small.events.last(), Some(&reset));
}

/// Without reports a duplicate MAC ID and a frame that means nothing are counted, and nobody is told.
#[test]
fn what_is_not_reported_is_counted() {
    fn told<A: Application>(application: A) -> usize {
        let mut slave = Group2OnlyServer::<A>::new(config(), application).unwrap();
        let frame = |id, data: &[u8]| Input::Frame(Frame::new(standard_id(id), data).unwrap());
        let inputs = [
            Input::Link(LinkEvent::Up),
            frame(REQUEST, &[MASTER, 0x0E, 1, 1, 1]),
            frame(CHECK, &[0x80, 1, 0, 2, 0, 0, 0]),
        ];
        let is_event = |action: &Action<_>| matches!(action, Action::Event(_));
        let told =
            inputs.map(|input| slave.handle(Instant::ZERO, input).filter(is_event).count()).into_iter().sum();
        assert_eq!(slave.access().fault(), Some(Fault::DuplicateMacId));
        let counted = u32::from(A::PARTS.contains(Parts::COUNTERS));
        let counters = slave.access().counters();
        assert_eq!((u32::from(counters.duplicates), counters.discarded), (counted, counted));
        told
    }
    assert!(told(block()) > 2);
    assert_eq!(told::<Small<COUNTED>>(Small(block())), 0);
    assert_eq!(told::<Small>(Small(block())), 0);
}

/// Without events nothing is told, and everything happens all the same: data, their rest, a reset.
#[test]
fn a_silent_slave_is_asked() {
    let mut silent = Bus::<Small<0>, 0>::online(config(), Small(block())).established(0x03, &[2]);
    silent.hears(POLL, &[0x01]);
    silent.sends(POLL_RESPONSE, &[0x34, 0x12]);
    assert_eq!(silent.slave.application().0.outputs, [0x01]);
    silent.wait(1000);
    silent.is_state(2, 4);
    assert_eq!(silent.slave.application().0.outputs, [0x00]);
    silent.asks(&[0x05, 1, 1], &[0x85]);
    assert!(!silent.slave.access().is_online());
    assert_eq!(silent.events, []);
}

#[test]
fn what_indicators_show_can_be_asked_without_events() {
    let is_status = |event: &SlaveEvent| matches!(event, SlaveEvent::NetworkStatus(_));
    let mut complete = Bus::<Block, 0>::online(config(), block());
    let mut small = Bus::<Small, 0>::online(config(), Small(block()));
    let allocate = [MASTER, 0x4B, 0x03, 0x01, 0x01, MASTER];
    complete.hears(UNCONNECTED, &allocate);
    small.hears(UNCONNECTED, &allocate);
    assert!(complete.events.iter().any(is_status));
    assert!(!small.events.iter().any(is_status));
    assert_eq!(small.slave.network_status(), NetworkStatus::SolidGreen);
    assert_eq!(small.slave.module_status(), complete.slave.module_status());
}

/// Poll that has memory for itself alone runs, times out and comes back as any other.
#[test]
fn poll_alone_is_poll() {
    fn told<A: Application>(application: A) -> Vec<SlaveEvent> {
        let mut bus = Bus::<A, 0>::online(config(), application).established(0x03, &[2]);
        bus.hears(POLL, &[0x01]);
        bus.sends(POLL_RESPONSE, &[0x34, 0x12]);
        bus.wait(1000);
        bus.is_state(2, 4);
        bus.asks(&[0x05, 5, 2], &[0x85]);
        bus.hears(POLL, &[]);
        bus.sends(POLL_RESPONSE, &[0x34, 0x12]);
        bus.wait(20_000);
        assert_eq!(bus.slave.counters().timed_out, 3);
        bus.events
    }
    let (complete, small) = (told(block()), told::<Small<COUNTED>>(Small(block())));
    // What is only reported, and the indicators, are parts of their own.
    let is_for_the_application =
        |event: &SlaveEvent| matches!(event, SlaveEvent::Received(_) | SlaveEvent::Mode(..));
    let needed: Vec<_> = complete.into_iter().filter(is_for_the_application).collect();
    assert!(needed.contains(&SlaveEvent::Mode(IoKind::Poll, IoMode::Fault)));
    assert_eq!(needed, small);
}

/// Events besides reports.
const TELLING: u16 = Parts::EVENTS.bits();
const COUNTED: u16 = Parts::COUNTERS.bits() | TELLING;
/// Attribute not supported.
const NOT_SUPPORTED: [u8; 4] = [MASTER, 0x94, 0x14, 0xFF];

/// After an input and after a command a small slave is to be asked what follows; after that nothing is pending until the next. A
/// complete one knows that nothing follows from a tick.
#[test]
fn what_may_follow_is_fetched_once() {
    type Own = Bus<Small, 0>;
    type Command = fn(&mut Own);
    let commands: [(&str, Command); 5] = [
        ("an input", |bus| bus.slave.input(bus.now, Input::Tick)),
        ("new data", |bus| bus.slave.inputs_changed(bus.now)),
        ("access to the application", |bus| bus.slave.application_mut().0.inputs = [1, 2]),
        ("a reset", |bus| bus.slave.reset(bus.now)),
        ("a new MAC ID", |bus| bus.slave.set_mac_id(bus.now, MacId::MIN).unwrap()),
    ];
    for (what, command) in commands {
        let mut bus = Own::online(config(), Small(block()));
        let is_pending = |bus: &Own| bus.slave.deadline().is_some_and(|deadline| deadline.at <= bus.now);
        assert!(!is_pending(&bus), "{what}");
        command(&mut bus);
        assert!(is_pending(&bus), "{what}");
        while bus.slave.poll(bus.now).is_some() {}
        assert!(!is_pending(&bus), "{what}");
    }
    let mut complete = Bus::<Block, 0>::online(config(), block());
    complete.slave.input(complete.now, Input::Tick);
    assert!(complete.slave.deadline().is_none_or(|deadline| deadline.at > complete.now));
}
