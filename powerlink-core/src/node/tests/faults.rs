//! What goes wrong around a node: echoes, frames twice or in another order, clocks and callers that fail, an adapter that takes nothing.

use core::time::Duration;

use link_core::ethernet::{Action, Input, LinkEvent, Machine};

use super::bench::*;
use crate::error::Symptom;
use crate::ethernet::group;
use crate::nmt::NmtState;
use crate::node::{NodeCounters, NodeEvent};
use crate::wire::{Flags, NmtCommandId, RequestedService};
use crate::{MacAddress, NodeId};

const CYCLE_TIME: Duration = Duration::from_millis(CYCLE);

/// Everything that a node sends, in an order of a whole life.
fn life(bench: &mut Bench, mut after_each: impl FnMut(&mut Bench)) {
    let steps: [fn(&mut Bench); 12] = [
        Bench::soa,
        |bench| bench.asks(RequestedService::IDENT_REQUEST),
        |bench| bench.asks(RequestedService::STATUS_REQUEST),
        |bench| bench.sdo("00 01 00 00"),
        |bench| bench.asks(RequestedService::UNSPECIFIED_INVITE),
        Bench::soc,
        |bench| bench.preq(Flags::DATA_VALID, &[1]),
        |bench| bench.command(NmtCommandId::ENABLE_READY_TO_OPERATE),
        |bench| bench.command(NmtCommandId::START_NODE),
        |bench| bench.node.request_command(NmtCommandId::STOP_NODE, NODE).unwrap(),
        |bench| bench.asks(RequestedService::NMT_REQUEST_INVITE),
        |bench| (0..20).for_each(|_| bench.cycle()),
    ];
    for step in steps {
        step(bench);
        after_each(bench);
    }
}

/// A hub or an adapter that hears itself: each frame comes back. It is counted, and nothing else is different.
#[test]
fn own_frames_that_come_back_are_counted() {
    let (mut alone, mut echoed) = (Bench::listening(config()), Bench::listening(config()));
    life(&mut alone, |_| {});
    life(&mut echoed, |bench| {
        let sent = std::mem::take(&mut bench.last);
        if !sent.is_empty() {
            bench.bytes(&sent);
        }
    });
    let echoes = echoed.node.counters().echoes;
    assert_eq!(echoes, 6, "Ident, Status, SDO, PRes, NMTRequest, and the last PRes");
    assert_eq!(echoed.events, alone.events);
    let counters = NodeCounters { echoes: 0, ..*echoed.node.counters() };
    assert_eq!(counters, *alone.node.counters());
    alone.is(NmtState::Operational);
}

/// The frames of a cycle.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Frame {
    Soc,
    Preq,
    Pres,
    Soa,
    Sdo,
}

impl Frame {
    const CYCLE: [Self; 5] = [Self::Soc, Self::Preq, Self::Pres, Self::Soa, Self::Sdo];

    fn is_heard_by(self, bench: &mut Bench) {
        match self {
            Self::Soc => bench.soc(),
            Self::Preq => bench.preq(Flags::DATA_VALID, &[0]),
            Self::Pres => bench.pres_of_another(),
            Self::Soa => bench.soa(),
            Self::Sdo => bench.sdo("00 00 00 00"),
        }
    }
}

/// Cycles with this order of frames in the first; how often each symptom was counted at most.
fn after_a_cycle_of(order: &[Frame]) -> u32 {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    bench.cycle();
    let symptoms = [Symptom::LossOfSoc, Symptom::LossOfPreq, Symptom::LossOfSoa];
    let counted =
        |bench: &Bench| symptoms.map(|symptom| bench.node.dictionary().counters.of(symptom).cumulative);
    let before = counted(&bench);
    order.iter().for_each(|frame| frame.is_heard_by(&mut bench));
    bench.wait(CYCLE_TIME);
    (0..16).for_each(|_| bench.cycle());
    let after = counted(&bench);
    for symptom in symptoms {
        assert_eq!(bench.node.dictionary().counters.of(symptom).threshold_count, 0, "{order:?}");
    }
    bench.is(NmtState::Operational);
    [0, 1, 2].map(|at| after[at] - before[at]).into_iter().max().unwrap()
}

/// One frame of a cycle comes twice: at most one symptom of a kind, and the node runs on.
#[test]
fn a_frame_that_comes_twice_changes_no_state() {
    for at in 0..Frame::CYCLE.len() {
        let mut order = Frame::CYCLE.to_vec();
        order.insert(at, order[at]);
        assert!(after_a_cycle_of(&order) <= 1, "{order:?}");
    }
    assert_eq!(after_a_cycle_of(&Frame::CYCLE), 0);
}

/// Two neighbours change places: the same.
#[test]
fn frames_in_another_order_change_no_state() {
    for at in 1..Frame::CYCLE.len() {
        let mut order = Frame::CYCLE.to_vec();
        order.swap(at - 1, at);
        assert!(after_a_cycle_of(&order) <= 1, "{order:?}");
    }
}

/// A command that comes twice is followed once.
#[test]
fn a_command_that_comes_twice_is_followed_once() {
    for (command, from, to) in [
        (NmtCommandId::START_NODE, NmtState::ReadyToOperate, NmtState::Operational),
        (NmtCommandId::STOP_NODE, NmtState::Operational, NmtState::Stopped),
        (NmtCommandId::ENTER_PRE_OPERATIONAL_2, NmtState::Stopped, NmtState::PreOperational2),
        (NmtCommandId::ENABLE_READY_TO_OPERATE, NmtState::PreOperational2, NmtState::ReadyToOperate),
    ] {
        let mut bench = Bench::in_state(from, config());
        bench.command(command);
        bench.command(command);
        bench.is(to);
        assert_eq!(bench.node.counters().commands_ignored, 1, "{command}");
    }
}

/// The time stands until the clock is where it was: nothing ends early, and afterwards the supervision goes on.
#[test]
fn a_clock_that_steps_back() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    bench.cycle();
    bench.wait(Duration::from_secs(1).saturating_sub(CYCLE_TIME * 50));
    bench.now = link_core::Instant::ZERO;
    for _ in 0..5 {
        bench.forget();
        bench.soc();
        bench.preq(Flags::DATA_VALID, &[0]);
        bench.says("node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=0 RS=0, 1 byte");
        bench.soa();
        bench.node.input(bench.now, Input::Tick);
        bench.drain();
        bench.now += Duration::from_millis(1);
    }
    bench.is(NmtState::Operational);
    let lost = bench.node.dictionary().counters.of(Symptom::LossOfSoc).cumulative;
    assert_eq!(lost, 0);
    bench.wait(Duration::from_secs(2));
    bench.is(NmtState::PreOperational1);
}

/// Nobody calls the node for seconds: every wait that ended meanwhile is served by the next call, before what it brings.
#[test]
fn called_seconds_late() {
    let late = |bench: &mut Bench, input: Input<'_>| {
        bench.now += Duration::from_secs(30);
        bench.node.input(bench.now, input);
        bench.drain();
    };
    let lost = |bench: &Bench| bench.node.dictionary().counters.of(Symptom::LossOfSoc).cumulative;
    let mut bench = Bench::listening(config());
    late(&mut bench, Input::Tick);
    bench.is(NmtState::BasicEthernet);
    let mut bench = Bench::in_state(NmtState::Operational, config());
    bench.cycle();
    late(&mut bench, Input::Tick);
    assert_eq!(lost(&bench), 2);
    bench.is(NmtState::PreOperational1);
    // A SoC that was waiting to be heard: CT11, then CT4.
    let mut bench = Bench::in_state(NmtState::Operational, config());
    bench.cycle();
    let mut soc = [0; 60];
    soc[..17].copy_from_slice(&[1, 0x11, 0x1E, 0, 0, 1, 2, 0, 0, 0, 0, 0xF0, 0x88, 0xAB, 1, 255, 240]);
    late(&mut bench, Input::Frame(&soc));
    assert_eq!(lost(&bench), 2);
    bench.is(NmtState::PreOperational2);
    // In `PreOperational1` only the clients are forgotten.
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    bench.opens_connection(NodeId::MANAGING_NODE);
    late(&mut bench, Input::Tick);
    bench.tells(NodeEvent::SdoClosed { client: NodeId::MANAGING_NODE, by_timeout: true });
}

/// Two clients that began at the same moment, and a SoC that is missed at the moment of both.
#[test]
fn two_deadlines_in_one_tick() {
    let clients = [NodeId::MANAGING_NODE, NodeId::DIAGNOSTIC];
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    bench.writes(0x1300, 0, &u32::try_from(CYCLE).unwrap().to_le_bytes()).unwrap();
    bench.writes(0x1C0B, 3, &1_u32.to_le_bytes()).unwrap();
    bench.goes_to(NmtState::Operational);
    bench.cycle();
    bench.soc();
    bench.now += Duration::from_micros(100);
    bench.soa();
    for client in clients {
        bench.opens_connection(client);
    }
    bench.forget();
    bench.now += CYCLE_TIME;
    bench.node.input(bench.now, Input::Tick);
    bench.drain();
    bench.is(NmtState::PreOperational1);
    for client in clients {
        assert!(bench.events.contains(&NodeEvent::SdoClosed { client, by_timeout: true }), "{client}");
    }
}

/// A buffer that is too short for each kind of frame, and an adapter that does not send: told and counted, and the node goes on.
#[test]
fn an_adapter_that_takes_nothing() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    bench.sdo("00 01 00 00");
    bench.node.request_command(NmtCommandId::STOP_NODE, NODE).unwrap();
    bench.cycle();
    bench.forget();
    let mut counted = bench.node.counters().not_sent;
    for service in [
        RequestedService::IDENT_REQUEST,
        RequestedService::STATUS_REQUEST,
        RequestedService::NMT_REQUEST_INVITE,
        RequestedService::UNSPECIFIED_INVITE,
    ] {
        bench.soc();
        bench.preq_undrained();
        for (room, is_poll) in [(59, true), (59, false)] {
            if !is_poll {
                bench.asks_undrained(service);
            }
            let mut short = std::vec![0; room];
            let mut told = 0;
            while let Some(action) = bench.node.poll(bench.now, &mut short) {
                match action {
                    Action::Transmit(bytes) => panic!("{service}: {bytes:02X?}"),
                    Action::Event(event) => told += u32::from(event == NodeEvent::BufferTooShort),
                }
            }
            assert_eq!(told, 1, "{service}");
            counted += 1;
            assert_eq!(bench.node.counters().not_sent, counted, "{service}");
        }
        bench.wait(CYCLE_TIME);
    }
    bench.link(LinkEvent::NotSent);
    assert_eq!(bench.node.counters().not_sent, counted + 1);
    bench.is(NmtState::Operational);
    bench.soc();
    bench.preq(Flags::DATA_VALID, &[0]);
    bench.says("node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=7 RS=1, 1 byte");
    // What the application asked for still waits.
    bench.asks(RequestedService::NMT_REQUEST_INVITE);
    bench.says("node 1 -> MN: NMTRequest, NMTStopNode for node 1");
}

/// What follows a message is padding, up to any length that an adapter hands over.
#[test]
fn frames_that_are_too_long() {
    for len in [60, 61, 1514, 1518, 1519, 9_018] {
        let mut bench = Bench::in_state(NmtState::Operational, config());
        let padded = |start: &[u8]| {
            let mut frame = start.to_vec();
            frame.resize(len.max(start.len()), 0xA5);
            frame
        };
        let of_mn = |mac: [u8; 6]| [&mac[..], &[2, 0, 0, 0, 0, 0xF0, 0x88, 0xAB]].concat();
        bench.bytes(&padded(&[of_mn(group::SOC.0), vec_of(&[1, 255, 240], 36)].concat()));
        bench.bytes(&padded(&[of_mn(MAC.0), vec_of(&[3, 1, 240, 0, 1, 0, 0, 0, 1, 0, 0x77], 25)].concat()));
        bench.says("node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=0 RS=0, 1 byte");
        assert_eq!(bench.node.objects().output, 0x77);
        bench.bytes(&padded(
            &[of_mn(group::SOA.0), vec_of(&[5, 255, 240, 0xFD, 0, 0, 1, 1, 0x20], 23)].concat(),
        ));
        assert_eq!(bench.last.len(), 176, "{len}");
        bench.bytes(&padded(&[of_mn(group::ASND.0), vec_of(&[6, 1, 240, 4, 0x22, 0], 20)].concat()));
        bench.is(NmtState::Stopped);
        assert_eq!(bench.node.counters().bad_frames, 0, "{len}");
    }
}

/// A POWERLINK frame, zeros behind its beginning up to the length of the whole frame.
fn vec_of(start: &[u8], len: usize) -> std::vec::Vec<u8> {
    let mut body = start.to_vec();
    body.resize(len - 14, 0);
    body
}

/// EPLVersion of a SoA is the managing node's to compare with that of the IdentResponse: a node answers whatever it says.
#[test]
fn another_version_of_the_protocol_is_answered() {
    for version in [0x00, 0x10, 0x21, 0x30, 0xFF] {
        let mut bench = Bench::in_state(NmtState::PreOperational1, config());
        let head = [&group::SOA.0[..], &[2, 0, 0, 0, 0, 0xF0, 0x88, 0xAB]].concat();
        bench.bytes(&[head, vec_of(&[5, 255, 240, 0x1D, 0, 0, 1, 1, version], 60)].concat());
        assert_eq!((bench.last.len(), bench.last[22]), (176, 0x20), "{version:#04X}");
    }
}

/// Who sends as node 240 is the managing node, from whatever MAC address: a frame has no other sign of it. Who does not, is not.
#[test]
fn a_spoofed_managing_node() {
    let spoofed = |mac: MacAddress, from: u8, body: &[u8]| {
        let rest = [2, 0, 0, 0, 0xBA, 0xD0, 0x88, 0xAB, body[0], body[1], from];
        [&mac.0[..], &rest, &body[2..], &[0; 30]].concat()
    };
    for (from, is_followed) in [(240, true), (2, false), (241, false), (253, false)] {
        let mut bench = Bench::in_state(NmtState::Operational, config());
        bench.soc();
        bench.bytes(&spoofed(MAC, from, &[3, 1, 0, 1, 0, 0, 0, 1, 0, 0x77]));
        assert_eq!(bench.node.objects().output == 0x77, is_followed, "PReq of {from}");
        bench.bytes(&spoofed(group::ASND, from, &[6, 1, 4, 0x22, 0]));
        assert_eq!(bench.node.state() == NmtState::Stopped, is_followed, "NMTStopNode of {from}");
    }
}
