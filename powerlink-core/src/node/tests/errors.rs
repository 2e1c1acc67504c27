//! Lost frames, thresholds, invalid formats, and how they are told.

use core::time::Duration;

use super::bench::*;
use crate::NodeId;
use crate::nmt::NmtState;
use crate::node::{NodeError, NodeEvent};
use crate::wire::{EntryType, ErrorCode, ErrorEntry, Flags, NmtCommandId, RequestedService};
use link_core::ethernet::LinkEvent;

const CYCLE_TIME: Duration = Duration::from_millis(CYCLE);
const CYCLIC: [NmtState; 3] = [NmtState::ReadyToOperate, NmtState::Operational, NmtState::Stopped];

fn without_soc(bench: &mut Bench) {
    bench.preq(Flags::DATA_VALID, &[0]);
    bench.soa();
    bench.wait(CYCLE_TIME);
}

fn without_preq(bench: &mut Bench) {
    bench.soc();
    bench.soa();
    bench.wait(CYCLE_TIME);
}

fn without_soa(bench: &mut Bench) {
    bench.soc();
    bench.preq(Flags::DATA_VALID, &[0]);
    bench.wait(CYCLE_TIME);
}

/// Measured with openPOWERLINK 2.7.2: one lost SoC changes nothing, the second in a row leads to `PreOperational1`, and the
/// next SoC back.
#[test]
fn lost_socs() {
    for state in [NmtState::ReadyToOperate, NmtState::Operational] {
        let mut bench = Bench::in_state(state, config());
        bench.cycle();
        for _ in 0..20 {
            without_soc(&mut bench);
            bench.is(state);
            (0..9).for_each(|_| bench.cycle());
        }
        without_soc(&mut bench);
        bench.is(state);
        without_soc(&mut bench);
        bench.is(NmtState::PreOperational1);
        bench.tells(NodeEvent::Error(ErrorCode::LOSS_OF_SOC_THRESHOLD));
        assert!(bench.node.error_led());
        bench.soc();
        bench.is(NmtState::PreOperational2);
    }
}

/// The tolerance that openPOWERLINK's managing node writes, 50 ms, is longer than the cycle: the second is noticed nevertheless.
#[test]
fn lost_socs_before_their_time_is_over() {
    for (tolerance, cycle) in [(50_000_000, 20_000), (50_000_000, 50_000), (100_000, 20_000)] {
        let mut config = config();
        (config.values.loss_of_soc_tolerance, config.values.cycle_length) = (tolerance, cycle);
        let mut bench = Bench::in_state(NmtState::Operational, config);
        let cycle = Duration::from_micros(cycle.into());
        let without_soc = |bench: &mut Bench| {
            bench.wait(cycle);
            bench.preq(Flags::DATA_VALID, &[0]);
            bench.soa();
        };
        bench.soc();
        bench.preq(Flags::DATA_VALID, &[0]);
        bench.soa();
        without_soc(&mut bench);
        bench.is(NmtState::Operational);
        without_soc(&mut bench);
        bench.is(NmtState::PreOperational1);
    }
}

#[test]
fn silence() {
    for state in CYCLIC {
        let mut bench = Bench::in_state(state, config());
        bench.soc();
        bench.wait(CYCLE_TIME + Duration::from_micros(100) + CYCLE_TIME - Duration::from_nanos(1));
        bench.is(state);
        bench.wait(Duration::from_nanos(1));
        bench.is(NmtState::PreOperational1);
        bench.wait(Duration::from_secs(100));
        bench.is(NmtState::PreOperational1);
    }
    let mut bench = Bench::in_state(NmtState::PreOperational2, config());
    bench.soc();
    bench.wait(Duration::from_secs(2));
    bench.is(NmtState::PreOperational2);
}

#[test]
fn lost_preqs() {
    for state in [NmtState::ReadyToOperate, NmtState::Operational] {
        let mut bench = Bench::in_state(state, config());
        bench.cycle();
        without_preq(&mut bench);
        bench.is(state);
        without_preq(&mut bench);
        bench.is(NmtState::PreOperational1);
        bench.tells(NodeEvent::Error(ErrorCode::LOSS_OF_PREQ_THRESHOLD));
    }
    for state in [NmtState::PreOperational2, NmtState::Stopped] {
        let mut bench = Bench::in_state(state, config());
        (0..20).for_each(|_| without_preq(&mut bench));
        bench.is(state);
    }
}

#[test]
fn lost_soas_count_and_may_lead_to_a_reaction() {
    for (reacts, state) in [(true, NmtState::PreOperational1), (false, NmtState::Operational)] {
        let mut config = config();
        config.options.reacts_to_loss_of_soa = reacts;
        let mut bench = Bench::in_state(NmtState::Operational, config);
        bench.cycle();
        without_soa(&mut bench);
        without_soa(&mut bench);
        bench.is(NmtState::Operational);
        without_soa(&mut bench);
        bench.soc();
        assert_eq!(bench.node.state() == NmtState::Operational, state == NmtState::Operational);
    }
}

/// The answer to the poll comes first, then the reset. In `PreOperational2` the size is not checked.
#[test]
fn a_preq_of_invalid_format() {
    let frames: [(&str, &[u8]); 2] = [("longer than the limit", &[0; 37]), ("longer than the frame", &[])];
    for (what, data) in frames {
        for state in [NmtState::PreOperational2, NmtState::ReadyToOperate, NmtState::Operational] {
            let mut bench = Bench::in_state(state, config());
            bench.soc();
            if data.is_empty() {
                // Size 200 in a frame of 60 bytes.
                let mut frame = [0; 60];
                frame[..6].copy_from_slice(&MAC.0);
                frame[11..24].copy_from_slice(&[0xF0, 0x88, 0xAB, 3, 1, 240, 0, 1, 0, 0, 0, 200, 0]);
                bench.bytes(&frame);
            } else {
                bench.preq(Flags::DATA_VALID, data);
            }
            let rd = u8::from(state == NmtState::Operational);
            bench.says(&std::format!(
                "node 1 -> all: PRes, {}, EN=0 RD={rd}, PR=0 RS=0, 1 byte",
                state.code()
            ));
            if state == NmtState::PreOperational2 {
                bench.is(state);
                continue;
            }
            bench.is(NmtState::NotActive);
            assert!(bench.node.error_led(), "{what}");
            bench.tells(NodeEvent::Error(ErrorCode::INVALID_FORMAT));
        }
    }
}

#[test]
fn a_frame_that_is_cut_is_dropped() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    bench.soc();
    let mut frame = [0; 23];
    frame[..6].copy_from_slice(&MAC.0);
    frame[12..17].copy_from_slice(&[0x88, 0xAB, 3, 1, 240]);
    bench.bytes(&frame);
    bench.says_nothing();
    assert!(matches!(bench.events[..], [NodeEvent::BadFrame(_)]));
    assert_eq!(bench.node.counters().bad_frames, 1);
}

/// An error reaches the managing node: EN in the PRes, the entry in the StatusResponse, EA in the next PReq.
#[test]
fn an_error_is_told_until_it_is_acknowledged() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    for er in [Flags::EXCEPTION_RESET, Flags::empty()] {
        bench.invite(RequestedService::STATUS_REQUEST, NODE, er);
    }
    bench.forget();
    bench.link(LinkEvent::Down);
    bench.soc();
    bench.preq(Flags::DATA_VALID, &[0]);
    bench.says("node 1 -> all: PRes, NMT_OPERATIONAL, EN=1 RD=1, PR=0 RS=0, 1 byte");
    bench.asks(RequestedService::STATUS_REQUEST);
    bench.says("node 1 -> all: StatusResponse, NMT_OPERATIONAL, EC=0 EN=1, PR=0 RS=0, loss of link");
    bench.soc();
    bench.preq(Flags::DATA_VALID | Flags::EXCEPTION_ACKNOWLEDGE, &[0]);
    bench.soa();
    bench.forget();
    bench.link(LinkEvent::Down);
    bench.soc();
    bench.preq(Flags::DATA_VALID | Flags::EXCEPTION_ACKNOWLEDGE, &[0]);
    bench.says("node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=0 RS=0, 1 byte");
}

/// A node that is not polled has the EA of SoA alone, whatever that asks for.
#[test]
fn any_soa_for_the_node_acknowledges_an_error() {
    for state in [NmtState::PreOperational1, NmtState::Stopped] {
        let mut bench = Bench::in_state(state, config());
        for er in [Flags::EXCEPTION_RESET, Flags::empty()] {
            bench.invite(RequestedService::STATUS_REQUEST, NODE, er);
        }
        bench.forget();
        bench.link(LinkEvent::Down);
        bench.asks(RequestedService::STATUS_REQUEST);
        let code = state.code();
        bench
            .says(&std::format!("node 1 -> all: StatusResponse, {code}, EC=0 EN=1, PR=0 RS=0, loss of link"));
        let kind = EntryType::POWERLINK_EVENT;
        let entry = ErrorEntry { kind, code: ErrorCode(0x1234), ..ErrorEntry::default() };
        bench.node.report_error(bench.now, entry).unwrap();
        bench.invite(RequestedService::UNSPECIFIED_INVITE, NodeId(2), Flags::EXCEPTION_ACKNOWLEDGE);
        bench.asks(RequestedService::STATUS_REQUEST);
        bench
            .says(&std::format!("node 1 -> all: StatusResponse, {code}, EC=0 EN=1, PR=0 RS=0, loss of link"));
        bench.invite(RequestedService::UNSPECIFIED_INVITE, NODE, Flags::EXCEPTION_ACKNOWLEDGE);
        bench.says_nothing();
        bench.invite(RequestedService::STATUS_REQUEST, NODE, Flags::EXCEPTION_ACKNOWLEDGE);
        bench
            .says(&std::format!("node 1 -> all: StatusResponse, {code}, EC=0 EN=0, PR=0 RS=0, error 0x1234"));
    }
}

/// It would end the list in the history and in the StatusResponse: EN would tell of nothing.
#[test]
fn an_entry_that_ends_a_list_is_refused() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    for er in [Flags::EXCEPTION_RESET, Flags::empty()] {
        bench.invite(RequestedService::STATUS_REQUEST, NODE, er);
    }
    bench.forget();
    for kind in [0x0000, 0x0002, 0x8001, 0xCFFF].map(EntryType) {
        let entry = ErrorEntry { kind, code: ErrorCode(0x1234), ..ErrorEntry::default() };
        assert_eq!(bench.node.report_error(bench.now, entry), Err(NodeError::EndOfList(kind)));
    }
    assert_eq!(bench.node.dictionary().history().count(), 0);
    bench.soc();
    bench.preq(Flags::DATA_VALID, &[0]);
    bench.says("node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=0 RS=0, 1 byte");
    for (en, kind) in [(1, 0x1001), (0, 0x2001), (1, 0xF001)] {
        let entry = ErrorEntry { kind: EntryType(kind), code: ErrorCode(0x1234), ..ErrorEntry::default() };
        bench.node.report_error(bench.now, entry).unwrap();
        let acknowledged = if en == 1 { Flags::empty() } else { Flags::EXCEPTION_ACKNOWLEDGE };
        bench.invite(RequestedService::STATUS_REQUEST, NODE, acknowledged);
        bench.says(&std::format!(
            "node 1 -> all: StatusResponse, NMT_OPERATIONAL, EC=0 EN={en}, PR=0 RS=0, error 0x1234"
        ));
        bench.invite(RequestedService::NO_SERVICE, NODE, acknowledged ^ Flags::EXCEPTION_ACKNOWLEDGE);
    }
}

#[test]
fn process_data_that_do_not_fit_the_mapping_are_not_used() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    bench.soc();
    bench.preq(Flags::DATA_VALID, &[]);
    bench.is(NmtState::Operational);
    bench.tells(NodeEvent::Error(ErrorCode::PDO_SHORT));
}

/// Losses that a stopped node sees, and those that it does not.
#[test]
fn a_stopped_node_goes_on_with_the_cycle() {
    let mut bench = Bench::in_state(NmtState::Stopped, config());
    for _ in 0..20 {
        bench.soc();
        bench.soa();
        bench.wait(CYCLE_TIME);
    }
    bench.is(NmtState::Stopped);
    bench.command(NmtCommandId::ENTER_PRE_OPERATIONAL_2);
    bench.is(NmtState::PreOperational2);
}
