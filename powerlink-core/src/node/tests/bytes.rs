//! Whole frames, byte by byte: what makes a node drop a frame, and what does not. Made after the specification; those with a
//! verdict of openPOWERLINK 2.7.2 were sent to its controlled node.

use super::bench::*;
use super::resets::COMMUNICATING;
use crate::error::Symptom;
use crate::nmt::NmtState;
use crate::node::{NodeCounters, NodeEvent};
use crate::wire::{ErrorCode, MessageType};
use crate::{MacAddress, NodeId};

fn bytes(hex: &str) -> std::vec::Vec<u8> {
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect()
}

/// The node hears a frame in a state, within a cycle; what it counts by that.
fn hears(state: NmtState, hex: &str) -> (Bench, NodeCounters) {
    let mut bench = Bench::in_state(state, config());
    if state.is_cyclic() {
        bench.soc();
    }
    bench.node.clear_counters();
    bench.forget();
    bench.bytes(&bytes(hex));
    let counters = *bench.node.counters();
    (bench, counters)
}

const ALL: [NmtState; 4] =
    [NmtState::PreOperational1, NmtState::PreOperational2, NmtState::Operational, NmtState::Stopped];

/// PReq with Size 37 where the limit is 36: openPOWERLINK answers, and resets its communication.
#[test]
fn a_poll_longer_than_the_limit_is_answered_before_the_reset() {
    let mut frame = std::string::String::from("0200000000010200000000f088ab0301f0000100000025");
    frame.push_str(&"00".repeat(38));
    for (state, to) in [
        (NmtState::PreOperational2, NmtState::PreOperational2),
        (NmtState::ReadyToOperate, NmtState::NotActive),
        (NmtState::Operational, NmtState::NotActive),
    ] {
        let (mut bench, counters) = hears(state, &frame);
        let rd = u8::from(state == NmtState::Operational);
        bench.says(&std::format!("node 1 -> all: PRes, {}, EN=0 RD={rd}, PR=0 RS=0, 1 byte", state.code()));
        bench.is(to);
        assert_eq!(counters, NodeCounters { errors_untold: 0, ..NodeCounters::default() });
        let told = bench.events.contains(&NodeEvent::Error(ErrorCode::INVALID_FORMAT));
        assert_eq!(told, to == NmtState::NotActive);
    }
}

#[test]
fn an_unknown_message_type_is_dropped() {
    let frame = "0200000000010200000000f088ab0901f000010000000100000000000000000000000000000000000000000000000000000000000000000000000000";
    for state in ALL {
        let (mut bench, counters) = hears(state, frame);
        assert_eq!(counters, NodeCounters { unknown: 1, ..NodeCounters::default() });
        bench.says_nothing();
        bench.is(state);
    }
}

/// A PReq that ends in its Size, and a SoA that ends behind its target.
#[test]
fn cut_frames_are_dropped() {
    for frame in
        ["0200000000010200000000f088ab0301f0000100000001", "01111e0000030200000000f088ab05fff01d00000101"]
    {
        for state in ALL {
            let (mut bench, counters) = hears(state, frame);
            assert_eq!(counters, NodeCounters { bad_frames: 1, ..NodeCounters::default() });
            assert!(matches!(bench.events[..], [NodeEvent::BadFrame(_)]));
            bench.says_nothing();
            bench.is(state);
        }
    }
}

/// NMTStartNode for this node at the MAC address of another; and each message at the address of another message.
#[test]
fn foreign_addresses_are_dropped() {
    let rest = "0200000000f088ab";
    let at = |mac: &str, body: &str| std::format!("{mac}{rest}{body}");
    let soc = &*std::format!("01fff0{}", "00".repeat(19));
    let poll = "0301f000010000000000";
    let command = "0601f0042800";
    let ident = "05fff01d00000101200000";
    for (mac, body) in [
        ("02000000aaaa", command),
        ("01111e000001", command),
        ("01111e000003", soc),
        ("020000000001", soc),
        ("01111e000001", poll),
        ("ffffffffffff", poll),
        ("01111e000004", ident),
        ("01111e000005", soc),
    ] {
        for state in ALL {
            let (mut bench, counters) = hears(state, &at(mac, body));
            let expected = NodeCounters { other_destinations: 1, ..NodeCounters::default() };
            assert_eq!(counters, expected, "{mac} {body}");
            bench.says_nothing();
            bench.is(state);
        }
    }
    // An ASnd is accepted at three addresses.
    for mac in ["01111e000004", "020000000001", "ffffffffffff"] {
        let (bench, _) = hears(NmtState::PreOperational1, &at(mac, command));
        bench.is(NmtState::NotActive);
    }
}

/// A PReq in all but its source the managing node's: whatever the state, it is not answered, its data are not taken, and the
/// cycle does not know of it.
#[test]
fn a_poll_of_another_node_is_ignored() {
    for from in [0, 1, 2, 239, 241, 250, 252, 253, 254, 255] {
        let frame = std::format!("0200000000010200000000f088ab0301{from:02x}000100000001007700");
        for state in COMMUNICATING {
            let (mut bench, counters) = hears(state, &frame);
            bench.says_nothing();
            bench.is(state);
            assert_eq!(bench.node.objects().output, 0, "{from} in {state}");
            assert_eq!(counters, NodeCounters { foreign_frames: 1, ..NodeCounters::default() });
            let (message, from) = (MessageType::PREQ, NodeId(from));
            assert_eq!(bench.events, [NodeEvent::ForeignFrame { message, from }]);
            if state == NmtState::Operational {
                bench.soa();
                let lost = bench.node.dictionary().counters.of(Symptom::LossOfPreq).cumulative;
                assert_eq!(lost, 1, "that of the managing node is still due");
            }
        }
        // Neither for another node, nor to be told.
        let (bench, counters) = hears(NmtState::Operational, &frame.replace("ab0301", "ab0302"));
        assert_eq!((bench.events.len(), counters), (0, NodeCounters::default()));
    }
    // It does not keep a node out of `BasicEthernet`.
    let mut bench = Bench::in_state(NmtState::NotActive, config());
    bench.wait(core::time::Duration::from_secs(4));
    bench.bytes(&bytes("0200000000010200000000f088ab030102000100000001007700"));
    bench.wait(core::time::Duration::from_secs(1));
    bench.is(NmtState::BasicEthernet);
}

/// Nor do SoC and SoA of another node start a cycle, end one, or invite.
#[test]
fn a_cycle_of_another_node_is_ignored() {
    let soc = (MessageType::SOC, 1, "00".repeat(19));
    let soa = (MessageType::SOA, 3, std::format!("fd00000101{:02x}00", 0x20));
    for (message, group, rest) in [soc, soa] {
        for state in [ALL.as_slice(), &[NmtState::NotActive, NmtState::BasicEthernet]].concat() {
            for from in [0, 1, 2, 239, 241, 250, 253, 255] {
                let kind = message.0;
                let at = |from: u8| {
                    std::format!("01111e0000{group:02x}0200000000f088ab{kind:02x}ff{from:02x}{rest}")
                };
                let (mut bench, counters) = hears(state, &at(from));
                let case = std::format!("{message} of {from} in {state}");
                assert_eq!(counters, NodeCounters { foreign_frames: 1, ..NodeCounters::default() }, "{case}");
                let from = NodeId(from);
                assert_eq!(bench.events, [NodeEvent::ForeignFrame { message, from }], "{case}");
                bench.says_nothing();
                bench.is(state);
                let (bench, counters) = hears(state, &at(240));
                assert_eq!(counters, NodeCounters::default());
                assert!(!bench.events.iter().any(|event| matches!(event, NodeEvent::ForeignFrame { .. })));
            }
        }
    }
}

/// Nor does an NMT command of another node, in whatever state: plain or extended, to the node or to all. One that is not for this
/// node is nothing.
#[test]
fn a_command_of_another_node_is_ignored() {
    let [listed, unlisted] = ["02", "04"].map(|list| std::format!("4800{list}{}", "00".repeat(31)));
    let (reset, unknown) = ("2800", "7f00");
    for state in [ALL.as_slice(), &[NmtState::NotActive, NmtState::BasicEthernet]].concat() {
        for from in [0, 1, 2, 239, 241, 250, 253, 255] {
            let at = |to: u8, command: &str| {
                std::format!("01111e0000040200000000f088ab06{to:02x}{from:02x}04{command}")
            };
            for (to, command) in [(1, reset), (255, reset), (1, unknown), (1, &*listed), (255, &listed)] {
                let (mut bench, counters) = hears(state, &at(to, command));
                let case = std::format!("{command} of {from} in {state}");
                let address_conflicts = u32::from(from == 1);
                let foreign =
                    NodeCounters { foreign_frames: 1, address_conflicts, ..NodeCounters::default() };
                assert_eq!(counters, foreign, "{case}");
                bench.tells(NodeEvent::ForeignFrame { message: MessageType::ASND, from: NodeId(from) });
                bench.says_nothing();
                bench.is(state);
            }
            for (to, command) in [(2, reset), (1, &*unlisted), (255, &unlisted)] {
                let (bench, counters) = hears(state, &at(to, command));
                assert_eq!(counters.foreign_frames, 0, "{command} of {from} in {state}");
                bench.is(state);
            }
        }
    }
}

/// A PRes, IdentResponse, StatusResponse, NMTRequest or SDO under the number of this node: another one has it too. From its own
/// address they are echoes.
#[test]
fn another_node_with_the_same_number_is_told() {
    let bodies = [
        ("02", "04ff01fd0100000001005a"),
        ("04", &*std::format!("06ff0101{}", "00".repeat(158))),
        ("04", &*std::format!("06ff0102{}", "00".repeat(54))),
        ("04", "06f001032801"),
        ("04", "06f0010500010000"),
    ];
    for (group, body) in bodies {
        for state in ALL {
            let at = |mac: &str| std::format!("01111e0000{group}{mac}88ab{body}");
            let (mut bench, counters) = hears(state, &at("02000000aaaa"));
            assert_eq!(counters, NodeCounters { address_conflicts: 1, ..NodeCounters::default() }, "{body}");
            let source = MacAddress([2, 0, 0, 0, 0xAA, 0xAA]);
            assert_eq!(bench.events, [NodeEvent::AddressConflict { source }]);
            bench.says_nothing();
            bench.is(state);
            let (bench, counters) = hears(state, &at("020000000001"));
            assert_eq!(counters, NodeCounters { echoes: 1, ..NodeCounters::default() });
            assert_eq!(bench.events.len(), 0);
        }
    }
}

/// SoA IdentRequest with reserved bits, and with bit 7 of the message type.
#[test]
fn reserved_bits_are_ignored() {
    for kind in ["05", "85"] {
        let frame = std::format!("01111e0000030200000000f088ab{kind}fff01d00ff01012001{}", "00".repeat(30));
        for state in ALL {
            let (bench, counters) = hears(state, &frame);
            assert_eq!((bench.last.len(), counters), (176, NodeCounters::default()), "{state}");
        }
    }
}

/// A node that is asked for something it does not know says nothing: SyncRequest, and what is the manufacturer's.
#[test]
fn unknown_requests_and_services_are_ignored() {
    for service in ["06", "a0", "fe"] {
        let frame = std::format!("01111e0000030200000000f088ab05fff01d0000{service}0120");
        for state in ALL {
            let (mut bench, _) = hears(state, &frame);
            bench.says_nothing();
            bench.is(state);
        }
    }
    for service in ["06", "a0", "fe"] {
        let (mut bench, counters) = hears(
            NmtState::PreOperational1,
            &std::format!("01111e0000040200000000f088ab0601f0{service}0000"),
        );
        assert_eq!(counters, NodeCounters { unknown: 1, ..NodeCounters::default() });
        bench.says_nothing();
    }
}
