//! The transitions of the NMT state machine of a communicating node (CT1 to CT12), through frames, time and commands of the
//! application: what the node does by each, beside the state. Those that begin anew are in [`resets`](super::resets). Transcribed from the
//! table of EPSG DS 301; `docs/conformance.md` names the test of each.

use core::time::Duration;

use link_core::ethernet::LinkEvent;

use super::bench::*;
use crate::NodeId;
use crate::error::Symptom;
use crate::nmt::{Cause, NmtState};
use crate::node::{NodeEvent, Readiness};
use crate::wire::{Flags, NmtCommandId, RequestedService};

const POWERLINK: [NmtState; 5] = [
    NmtState::PreOperational1,
    NmtState::PreOperational2,
    NmtState::ReadyToOperate,
    NmtState::Operational,
    NmtState::Stopped,
];

/// The states that were entered since the last look, with what led there.
pub(super) fn ways(bench: &mut Bench) -> std::vec::Vec<(NmtState, Cause)> {
    let ways = bench.events.iter().filter_map(|event| match event {
        NodeEvent::StateChanged { to, cause, .. } => Some((*to, *cause)),
        _ => None,
    });
    let ways = ways.collect();
    bench.events.clear();
    ways
}

/// A node in a state, with its error signalling running, something waiting for the asynchronous slot, a value that was downloaded, and
/// an output.
pub(super) fn busy(state: NmtState) -> Bench {
    let mut bench = Bench::listening(config());
    if state.is_powerlink_mode() {
        bench.goes_to(NmtState::PreOperational1);
        for er in [Flags::EXCEPTION_RESET, Flags::empty()] {
            bench.invite(RequestedService::STATUS_REQUEST, NODE, er);
        }
        bench.writes(0x1006, 0, &50_000_u32.to_le_bytes()).unwrap();
        if state != NmtState::PreOperational1 {
            bench.goes_to(state);
        }
        bench.node.request_command(NmtCommandId::RESET_NODE, NODE).unwrap();
    } else {
        bench.goes_to(state);
    }
    bench.node.objects_mut().output = 9;
    bench.node.set_error_register(1);
    bench.forget();
    bench
}

/// The configuration that was downloaded counts only from here on, and the wait for a managing node begins.
#[test]
fn ct1_takes_the_configuration_over_and_waits_for_the_network() {
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    bench.writes(0x1F99, 0, &1_000_000_u32.to_le_bytes()).unwrap();
    bench.command(NmtCommandId::RESET_CONFIGURATION);
    bench.is(NmtState::NotActive);
    bench.wait(Duration::from_secs(1) - Duration::from_nanos(1));
    bench.is(NmtState::NotActive);
    bench.wait(Duration::from_nanos(1));
    bench.is(NmtState::BasicEthernet);
}

/// The frame is consumed: the request in it is not answered, and the SoC does not lead on.
#[test]
fn ct2_soa_soc_or_by_choice_a_poll() {
    let mut bench = Bench::listening(config());
    ways(&mut bench);
    bench.asks(RequestedService::IDENT_REQUEST);
    assert_eq!(ways(&mut bench), [(NmtState::PreOperational1, Cause::Soa)]);
    bench.says_nothing();
    bench.wait(Duration::from_secs(100));
    bench.is(NmtState::PreOperational1);
    let mut bench = Bench::listening(config());
    ways(&mut bench);
    bench.soc();
    assert_eq!(ways(&mut bench), [(NmtState::PreOperational1, Cause::Soc)]);
    for (ends, to) in [(false, None), (true, Some(NmtState::PreOperational1))] {
        let mut config = config();
        config.options.poll_ends_not_active = ends;
        for cause in [Cause::Preq, Cause::Pres] {
            let mut bench = Bench::listening(config);
            ways(&mut bench);
            if cause == Cause::Preq {
                bench.preq(Flags::DATA_VALID, &[1]);
            } else {
                bench.pres_of_another();
            }
            assert_eq!(ways(&mut bench), to.map(|to| (to, cause)).into_iter().collect::<std::vec::Vec<_>>());
            bench.says_nothing();
        }
    }
}

#[test]
fn ct3_basic_ethernet_timeout() {
    let mut bench = Bench::listening(config());
    ways(&mut bench);
    bench.wait(Duration::from_secs(5));
    assert_eq!(ways(&mut bench), [(NmtState::BasicEthernet, Cause::BasicEthernetTimeout)]);
    assert!(!bench.node.error_led());
}

/// Only a SoC: no command leads there.
#[test]
fn ct4_soc() {
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    for command in [
        NmtCommandId::START_NODE,
        NmtCommandId::STOP_NODE,
        NmtCommandId::ENTER_PRE_OPERATIONAL_2,
        NmtCommandId::ENABLE_READY_TO_OPERATE,
    ] {
        bench.command(command);
    }
    bench.soa();
    bench.is(NmtState::PreOperational1);
    bench.soc();
    bench.is(NmtState::PreOperational2);
    bench.preq(Flags::empty(), &[]);
    bench.says("node 1 -> all: PRes, NMT_PRE_OPERATIONAL_2, EN=0 RD=0, PR=0 RS=0, 1 byte");
}

/// The first of two conditions changes nothing that is seen; the second one leads on, whichever it is.
#[test]
fn ct5_ct6_ready_to_operate_needs_the_command_and_the_application() {
    let mut slow = config();
    slow.options.readiness = Readiness::ByApplication;
    for is_command_first in [true, false] {
        let mut bench = Bench::in_state(NmtState::PreOperational2, slow);
        let command = |bench: &mut Bench| bench.command(NmtCommandId::ENABLE_READY_TO_OPERATE);
        let ready = |bench: &mut Bench| {
            bench.node.ready(bench.now).unwrap();
            bench.drain();
        };
        let steps: [&dyn Fn(&mut Bench); 2] =
            if is_command_first { [&command, &ready] } else { [&ready, &command] };
        let [first, second] = steps;
        first(&mut bench);
        first(&mut bench);
        assert_eq!((bench.node.state(), ways(&mut bench)), (NmtState::PreOperational2, std::vec![]));
        second(&mut bench);
        let cause = if is_command_first { Cause::ApplicationReady } else { Cause::EnableReadyToOperate };
        assert_eq!(ways(&mut bench), [(NmtState::ReadyToOperate, cause)]);
        // Both are needed again.
        bench.command(NmtCommandId::STOP_NODE);
        bench.command(NmtCommandId::ENTER_PRE_OPERATIONAL_2);
        second(&mut bench);
        bench.is(NmtState::PreOperational2);
    }
}

/// The error indicator goes out.
#[test]
fn ct7_start_node() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    bench.cycle();
    bench.wait(Duration::from_millis(2 * CYCLE));
    bench.is(NmtState::PreOperational1);
    assert!(bench.node.error_led());
    bench.goes_to(NmtState::ReadyToOperate);
    assert!(bench.node.error_led());
    bench.command(NmtCommandId::START_NODE);
    assert_eq!(ways(&mut bench), [(NmtState::Operational, Cause::StartNode)]);
    assert!(!bench.node.error_led());
}

#[test]
fn ct8_stop_node() {
    for state in [NmtState::PreOperational2, NmtState::ReadyToOperate, NmtState::Operational] {
        let mut bench = Bench::in_state(state, config());
        bench.command(NmtCommandId::STOP_NODE);
        assert_eq!(ways(&mut bench), [(NmtState::Stopped, Cause::StopNode)]);
        bench.soc();
        bench.preq(Flags::DATA_VALID, &[1]);
        bench.says_nothing();
    }
}

#[test]
fn ct9_ct10_enter_pre_operational_2() {
    for state in [NmtState::Operational, NmtState::Stopped] {
        let mut bench = Bench::in_state(state, config());
        bench.command(NmtCommandId::ENTER_PRE_OPERATIONAL_2);
        assert_eq!(ways(&mut bench), [(NmtState::PreOperational2, Cause::EnterPreOperational2)]);
        bench.soc();
        bench.preq(Flags::DATA_VALID, &[1]);
        bench.says("node 1 -> all: PRes, NMT_PRE_OPERATIONAL_2, EN=0 RD=0, PR=0 RS=0, 1 byte");
    }
}

/// An entry, the error indicator, and no supervision of SoC any more; what waits for the asynchronous slot stays.
#[test]
fn ct11_cycle_error() {
    for state in POWERLINK.into_iter().filter(|state| state.is_cyclic()) {
        let mut bench = busy(state);
        for _ in 0..2 {
            bench.link(LinkEvent::CrcError);
        }
        assert_eq!(ways(&mut bench), [(NmtState::PreOperational1, Cause::CycleError)], "{state}");
        assert!(bench.node.error_led());
        assert_eq!(bench.node.dictionary().history().next().map(|entry| entry.code.0), Some(0x8164));
        bench.wait(Duration::from_secs(2));
        assert_eq!(bench.node.dictionary().counters.of(Symptom::LossOfSoc).cumulative, 0);
        bench.asks(RequestedService::NMT_REQUEST_INVITE);
        bench.says("node 1 -> MN: NMTRequest, NMTResetNode for node 1");
    }
}

/// Each of the four frames, a PReq for another node apart, which is not heard; and what was being sent to a client stops at once.
#[test]
fn ct12_any_frame_of_the_network() {
    for cause in [Cause::Soc, Cause::Soa, Cause::Preq, Cause::Pres] {
        let mut bench = Bench::in_state(NmtState::BasicEthernet, config());
        bench.sdo_of(NodeId::DIAGNOSTIC, "00 01 00 00");
        bench.says("node 1 -> diagnostic device: SDO, rcon=1/0 scon=1/0");
        match cause {
            Cause::Soc => bench.soc(),
            Cause::Soa => bench.soa(),
            Cause::Preq => bench.preq(Flags::empty(), &[]),
            _ => bench.pres_of_another(),
        }
        assert_eq!(ways(&mut bench), [(NmtState::PreOperational1, cause)]);
        bench.sdo_of(NodeId::DIAGNOSTIC, "01 02 00 00");
        bench.says_nothing();
        bench.asks(RequestedService::UNSPECIFIED_INVITE);
        bench.says("node 1 -> diagnostic device: SDO, rcon=2/0 scon=2/0");
    }
}
