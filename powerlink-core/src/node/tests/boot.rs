//! From power-on to `Operational`, and what happens without a managing node.

use core::time::Duration;

use super::bench::*;
use crate::NodeId;
use crate::indicator::StatusLed;
use crate::nmt::{Cause, NmtState};
use crate::node::NodeEvent;
use crate::wire::{Flags, NmtCommandId, RequestedService};

/// openPOWERLINK 2.7.2 answers first.
#[test]
fn ec_may_follow_er_one_answer_later() {
    let mut config = config();
    config.options.clears_before_answer = false;
    let mut bench = Bench::in_state(NmtState::PreOperational1, config);
    for (er, ec) in [(true, 1), (false, 1), (false, 0)] {
        let flags = if er { Flags::EXCEPTION_RESET } else { Flags::empty() };
        bench.invite(RequestedService::STATUS_REQUEST, NODE, flags);
        bench.says(&std::format!(
            "node 1 -> all: StatusResponse, NMT_PRE_OPERATIONAL_1, EC={ec} EN=0, PR=0 RS=0"
        ));
    }
}

/// Though nobody fetched the answer behind which it was to follow.
#[test]
fn ec_follows_er_without_an_answer() {
    let mut config = config();
    config.options.clears_before_answer = false;
    let mut bench = Bench::in_state(NmtState::PreOperational1, config);
    bench.invite(RequestedService::STATUS_REQUEST, NODE, Flags::EXCEPTION_RESET);
    bench.forget();
    bench.asks_undrained(RequestedService::STATUS_REQUEST);
    bench.asks(RequestedService::STATUS_REQUEST);
    bench.says("node 1 -> all: StatusResponse, NMT_PRE_OPERATIONAL_1, EC=0 EN=0, PR=0 RS=0");
    assert_eq!(bench.node.counters().not_sent, 1);
}

/// The PRes has a constant length, whatever is mapped.
#[test]
fn the_length_of_a_pres_is_that_of_its_limit() {
    for limit in [36_usize, 37, 200] {
        let mut config = config();
        config.values.pres_limit = u16::try_from(limit).unwrap();
        let node = crate::ControlledNode::<Io, 200>::new(config, Io::default());
        let mut node = node.unwrap();
        let now = link_core::Instant::ZERO;
        use link_core::ethernet::{Action, Input, Machine};
        node.power_on(now);
        let mut buffer = [0xA5; 1514];
        let mut sent = 0;
        let frames = [
            "01111e0000030200000000f088ab05fff01d00000000200000",
            "01111e0000010200000000f088ab01fff00000000000000000000000000000000000000000",
            "0200000000010200000000f088ab0301f00001000000010020",
        ];
        for hex in [""].into_iter().chain(frames) {
            let bytes: std::vec::Vec<u8> = (0..hex.len())
                .step_by(2)
                .map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap())
                .collect();
            node.input(now, Input::Frame(&bytes));
            while let Some(action) = node.poll(now, &mut buffer) {
                if let Action::Transmit(bytes) = action {
                    sent = bytes.len();
                    assert!(bytes[25..].iter().all(|&byte| byte == 0), "padded with zeros");
                }
            }
        }
        assert_eq!(sent, 24 + limit);
    }
}

#[test]
fn data_that_do_not_count_are_not_used_in_operation() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    bench.soc();
    bench.preq(Flags::empty(), &[0x77]);
    bench.says("node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=0 RS=0, 1 byte");
    assert_eq!(bench.node.objects().output, 0);
}

#[test]
fn a_whole_start_and_its_indicators() {
    let mut bench = Bench::listening(config());
    bench.forget();
    bench.soa();
    bench.cycle();
    bench.command(NmtCommandId::ENABLE_READY_TO_OPERATE);
    bench.command(NmtCommandId::START_NODE);
    let leds: std::vec::Vec<_> = bench
        .events
        .iter()
        .filter_map(|event| match event {
            NodeEvent::StatusLed(led) => Some(*led),
            _ => None,
        })
        .collect();
    assert_eq!(leds, [StatusLed::SingleFlash, StatusLed::DoubleFlash, StatusLed::TripleFlash, StatusLed::On]);
}

/// The frame of CT2 is consumed: a SoC leads to `PreOperational1`, the next one to `PreOperational2`.
#[test]
fn a_start_by_soc_takes_two_cycles() {
    let mut bench = Bench::listening(config());
    bench.soc();
    bench.is(NmtState::PreOperational1);
    bench.wait(Duration::from_millis(CYCLE));
    bench.soc();
    bench.is(NmtState::PreOperational2);
}

#[test]
fn without_a_managing_node_it_settles_for_basic_ethernet() {
    let seconds = Duration::from_secs;
    let mut bench = Bench::listening(config());
    bench.wait(seconds(5) - Duration::from_nanos(1));
    bench.is(NmtState::NotActive);
    bench.wait(Duration::from_nanos(1));
    bench.is(NmtState::BasicEthernet);

    // Polls of others start the time anew, or do not.
    for (restarts, state) in [(true, NmtState::NotActive), (false, NmtState::BasicEthernet)] {
        let mut config = config();
        config.options.poll_restarts_basic_ethernet = restarts;
        let mut bench = Bench::listening(config);
        bench.wait(seconds(3));
        bench.pres_of_another();
        bench.wait(seconds(3));
        bench.is(state);
    }
    let mut never = config();
    never.values.basic_ethernet_timeout = 0;
    let mut bench = Bench::listening(never);
    bench.wait(seconds(100));
    bench.is(NmtState::NotActive);
}

#[test]
fn any_frame_of_the_network_ends_basic_ethernet() {
    let frames: [fn(&mut Bench); 4] =
        [Bench::soc, Bench::soa, |bench| bench.preq(Flags::empty(), &[]), Bench::pres_of_another];
    for frame in frames {
        let mut bench = Bench::in_state(NmtState::BasicEthernet, config());
        frame(&mut bench);
        bench.is(NmtState::PreOperational1);
        bench.says_nothing();
    }
    let mut deaf = config();
    deaf.options.pres_ends_basic_ethernet = false;
    let mut bench = Bench::in_state(NmtState::BasicEthernet, deaf);
    bench.pres_of_another();
    bench.is(NmtState::BasicEthernet);
}

#[test]
fn polls_end_not_active_only_where_that_is_chosen() {
    for (ends, state) in [(false, NmtState::NotActive), (true, NmtState::PreOperational1)] {
        let mut config = config();
        config.options.poll_ends_not_active = ends;
        for cause in [Cause::Preq, Cause::Pres] {
            let mut bench = Bench::listening(config);
            bench.forget();
            match cause {
                Cause::Preq => bench.preq(Flags::empty(), &[]),
                _ => bench.pres_of_another(),
            }
            bench.is(state);
            bench.says_nothing();
            let (from, to) = (NmtState::NotActive, NmtState::PreOperational1);
            let told = NodeEvent::StateChanged { from, to, cause };
            assert_eq!(bench.events.contains(&told), ends, "{cause}: {:?}", bench.events);
        }
    }
}

#[test]
fn an_application_may_take_its_time() {
    let mut slow = config();
    slow.options.readiness = crate::node::Readiness::ByApplication;
    let mut bench = Bench::in_state(NmtState::PreOperational2, slow);
    bench.command(NmtCommandId::ENABLE_READY_TO_OPERATE);
    bench.is(NmtState::PreOperational2);
    assert!(bench.node.ready(bench.now).is_ok());
    bench.drain();
    bench.tells(NodeEvent::StateChanged {
        from: NmtState::PreOperational2,
        to: NmtState::ReadyToOperate,
        cause: Cause::ApplicationReady,
    });
    assert!(bench.node.ready(bench.now).is_err(), "only in PreOperational2");
}

/// Frames for others, at other addresses, and the node's own.
#[test]
fn what_is_not_for_this_node_is_left_alone() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    bench.invite(RequestedService::IDENT_REQUEST, NodeId(2), Flags::empty());
    bench.says_nothing();
    let before = *bench.node.counters();
    let foreign = "02000000aaaa0200000000f088ab0601f004280000";
    let echo = "01111e00000402000000000188ab0601f004280000";
    let unknown = "0200000000010200000000f088ab0901f000010000";
    for hex in [foreign, echo, unknown] {
        let bytes: std::vec::Vec<u8> =
            (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect();
        bench.bytes(&bytes);
    }
    bench.is(NmtState::Operational);
    let counters = bench.node.counters();
    assert_eq!(
        (counters.other_destinations, counters.echoes, counters.unknown),
        (before.other_destinations + 1, before.echoes + 1, before.unknown + 1)
    );
}
