//! Process data: whose they are, of which version, how long, and how that is changed.

use std::vec::Vec;

use super::bench::*;
use crate::NodeId;
use crate::dictionary::ObjectAddress;
use crate::error::Symptom;
use crate::nmt::NmtState;
use crate::node::{NodeEvent, VersionCheck};
use crate::wire::{AbortCode, ErrorCode, Flags, NmtCommandId, PdoVersion, Soc};

/// An object of one byte at a bit offset, as it stands in a mapping object.
fn byte_at(index: u16, sub: u8, offset: u16) -> [u8; 8] {
    let ([i0, i1], [o0, o1]) = (index.to_le_bytes(), offset.to_le_bytes());
    [i0, i1, sub, 0, o0, o1, 8, 0]
}

fn output_at(offset: u16) -> [u8; 8] {
    byte_at(0x6200, 1, offset)
}

/// A node in operation in which a mapping object has these entries.
fn mapping(object: u16, entries: &[[u8; 8]]) -> Bench {
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    assert_eq!(bench.writes(object, 0, &[0]), Ok(()));
    for (sub, entry) in (1..).zip(entries) {
        assert_eq!(bench.writes(object, sub, entry), Ok(()));
    }
    assert_eq!(bench.writes(object, 0, &[u8::try_from(entries.len()).unwrap()]), Ok(()));
    bench.goes_to(NmtState::Operational);
    bench
}

/// A node that takes its output from the PRes of node 2 as well: channel 1, the second byte.
fn consumer(state: NmtState) -> Bench {
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    for (index, sub, value) in [
        (0x1401, 1, &[2][..]),
        (0x1401, 2, &[0x10]),
        (0x1601, 0, &[0]),
        (0x1601, 1, &output_at(8)),
        (0x1601, 0, &[1]),
    ] {
        assert_eq!(bench.writes(index, sub, value), Ok(()), "0x{index:04X}/{sub}");
    }
    bench.goes_to(state);
    bench
}

/// The PRes of another node, in the states in which it counts.
#[test]
fn cross_traffic() {
    for (state, is_taken) in [
        (NmtState::PreOperational1, false),
        (NmtState::PreOperational2, false),
        (NmtState::ReadyToOperate, true),
        (NmtState::Operational, true),
        (NmtState::Stopped, false),
    ] {
        let mut bench = consumer(state);
        bench.node.objects_mut().output = 0;
        if state.is_cyclic() {
            bench.soc();
        }
        // Of a node that is not mapped.
        bench.pres_with(NodeId(3), PdoVersion(0x10), Flags::DATA_VALID, &[1, 2]);
        assert_eq!(bench.node.objects().output, 0, "{state}");
        bench.pres_with(NodeId(2), PdoVersion(0x10), Flags::DATA_VALID, &[1, 2]);
        assert_eq!(bench.node.objects().output, if is_taken { 2 } else { 0 }, "{state}");
        let event = NodeEvent::ProcessData { channel: 1, is_valid: state == NmtState::Operational };
        assert_eq!(bench.events.contains(&event), is_taken, "{state}");
        bench.says_nothing();
    }
}

/// Two channels for one node: the frame is that of the first, and the second is refused while the first is in use.
#[test]
fn a_frame_is_taken_by_one_channel() {
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    assert_eq!(bench.writes(0x1601, 1, &output_at(8)), Ok(()));
    assert_eq!(bench.writes(0x1601, 0, &[1]), Err(AbortCode::PARAMETER_INCOMPATIBLE));
    assert_eq!(bench.reads(0x1601, 0), Ok(std::vec![0]));
    assert_eq!(bench.writes(0x1600, 0, &[0]), Ok(()));
    assert_eq!(bench.writes(0x1601, 0, &[1]), Ok(()));
    assert_eq!(bench.writes(0x1600, 0, &[1]), Err(AbortCode::PARAMETER_INCOMPATIBLE));
    bench.goes_to(NmtState::Operational);
    bench.soc();
    bench.preq(Flags::DATA_VALID, &[1, 2]);
    assert_eq!(bench.node.objects().output, 2);
    bench.tells(NodeEvent::ProcessData { channel: 1, is_valid: true });
}

/// Short, of another version, and not valid: only the first two are errors, and none is used.
#[test]
fn cross_traffic_that_does_not_fit() {
    let cases = [
        (PdoVersion(0x10), Flags::DATA_VALID, &[1][..], Some(ErrorCode::PDO_SHORT)),
        (PdoVersion(0x20), Flags::DATA_VALID, &[1, 2], Some(ErrorCode::PDO_MAP_VERSION)),
        (PdoVersion(0x20), Flags::empty(), &[1, 2], None),
        (PdoVersion(0x10), Flags::empty(), &[1], None),
        (PdoVersion(0x10), Flags::empty(), &[1, 2], None),
    ];
    for (version, flags, data, error) in cases {
        let mut bench = consumer(NmtState::Operational);
        bench.soc();
        bench.pres_with(NodeId(2), version, flags, data);
        assert_eq!(bench.node.objects().output, 0);
        let told = bench.events.iter().find_map(|event| match event {
            NodeEvent::Error(code) => Some(*code),
            _ => None,
        });
        assert_eq!(told, error, "{version:?} {flags:?} {data:?}");
        assert_eq!(bench.node.counters().pdo_errors, u32::from(error.is_some()));
        bench.is(NmtState::Operational);
    }
}

#[test]
fn the_version_of_a_mapping() {
    let cases = [
        (VersionCheck::Main, [true, true, false]),
        (VersionCheck::Exact, [true, false, false]),
        (VersionCheck::None, [true, true, true]),
    ];
    for (check, expected) in cases {
        for (version, is_taken) in [0x00, 0x0F, 0x10].map(PdoVersion).into_iter().zip(expected) {
            let mut config = config();
            config.options.version_check = check;
            let mut bench = Bench::in_state(NmtState::Operational, config);
            bench.soc();
            bench.preq_of_version(version, Flags::DATA_VALID, &[0x77]);
            bench.says("node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=0 RS=0, 1 byte");
            assert_eq!(bench.node.objects().output, if is_taken { 0x77 } else { 0 }, "{check:?} {version:?}");
            let error = NodeEvent::Error(ErrorCode::PDO_MAP_VERSION);
            assert_eq!(bench.events.contains(&error), !is_taken, "{check:?} {version:?}");
            bench.is(NmtState::Operational);
        }
    }
}

/// What openPOWERLINK's managing node writes: out of use, the entries, into use again. It counts at once.
#[test]
fn the_mapping_changes() {
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    assert_eq!(bench.writes(0x1600, 1, &output_at(16)), Err(AbortCode::UNSUPPORTED_ACCESS), "in use");
    assert_eq!(bench.writes(0x1600, 0, &[0]), Ok(()));
    assert_eq!(bench.writes(0x1600, 1, &output_at(16)), Ok(()));
    assert_eq!(bench.writes(0x1600, 0, &[1]), Ok(()));
    assert_eq!(bench.writes(0x1A00, 0, &[0]), Ok(()));
    bench.goes_to(NmtState::Operational);
    bench.soc();
    bench.preq(Flags::DATA_VALID, &[1, 2, 3]);
    assert_eq!(bench.node.objects().output, 3);
    bench.says("node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=0 RS=0, 0 bytes");
    assert_eq!(bench.last.len(), 60, "of constant length");
    // NMTResetConfiguration keeps it, NMTResetCommunication brings back that of the manufacturer.
    bench.command(NmtCommandId::RESET_CONFIGURATION);
    assert_eq!(bench.node.dictionary().mappings.transmit.len(), 0);
    bench.command(NmtCommandId::RESET_COMMUNICATION);
    assert_eq!(bench.node.dictionary().mappings.transmit.len(), 1);
}

/// A limit counts from the next `ResetConfiguration` on, and an answer never has other data than its Size says.
#[test]
fn limits_count_after_the_next_reset() {
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    assert_eq!(bench.writes(0x1F98, 4, &40_u16.to_le_bytes()), Ok(()));
    bench.goes_to(NmtState::ReadyToOperate);
    bench.soc();
    bench.preq(Flags::empty(), &[0; 36]);
    bench.is(NmtState::ReadyToOperate);
    bench.soa();
    bench.soc();
    bench.preq(Flags::empty(), &[0; 37]);
    bench.is(NmtState::NotActive);

    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    assert_eq!(bench.writes(0x1F98, 4, &40_u16.to_le_bytes()), Ok(()));
    bench.command(NmtCommandId::RESET_CONFIGURATION);
    bench.goes_to(NmtState::ReadyToOperate);
    for (len, state) in
        [(37, NmtState::ReadyToOperate), (40, NmtState::ReadyToOperate), (41, NmtState::NotActive)]
    {
        bench.soc();
        bench.preq(Flags::empty(), &[0; 41][..len]);
        bench.is(state);
        bench.soa();
    }
}

/// A value out of the range of its object, and one that the application refuses: the others are taken, and the managing node is
/// not told of an error of the network.
#[test]
fn values_that_objects_do_not_take() {
    let entries = [byte_at(0x2002, 0, 0), byte_at(0x2003, 0, 8), output_at(16)];
    let (switch, busy) = (ObjectAddress::new(0x2002, 0), ObjectAddress::new(0x2003, 0));
    let cases = [
        (&entries[..1], &[2][..], Some((switch, AbortCode::VALUE_TOO_HIGH)), (1, 0)),
        (&entries[..1], &[0], None, (0, 0)),
        (&entries, &[3, 9, 4], Some((switch, AbortCode::VALUE_TOO_HIGH)), (1, 4)),
        (&entries, &[0, 9, 5], Some((busy, AbortCode::STATE)), (0, 5)),
        (&entries[1..], &[0, 9, 6], Some((busy, AbortCode::STATE)), (1, 6)),
    ];
    for (entries, data, fault, values) in cases {
        let mut bench = mapping(0x1600, entries);
        bench.node.objects_mut().switch = 1;
        bench.soc();
        bench.preq(Flags::DATA_VALID, data);
        bench.says("node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=0 RS=0, 1 byte");
        let objects = bench.node.objects();
        assert_eq!((objects.switch, objects.output), values, "{data:?}");
        assert_eq!(bench.node.counters().pdo_errors, u32::from(fault.is_some()), "{data:?}");
        let refused = fault.map(|(object, code)| NodeEvent::ValueRefused { channel: 0, object, code });
        let taken = NodeEvent::ProcessData { channel: 0, is_valid: true };
        let told: Vec<_> = std::iter::once(taken).chain(refused).collect();
        assert_eq!(bench.events, told, "{data:?}");
    }
    // Who says that its data are not valid promises nothing about them.
    let mut bench = mapping(0x1600, &entries);
    bench.command(NmtCommandId::ENTER_PRE_OPERATIONAL_2);
    bench.command(NmtCommandId::ENABLE_READY_TO_OPERATE);
    bench.soc();
    bench.forget();
    bench.preq(Flags::empty(), &[3, 9, 4]);
    assert_eq!((bench.node.objects().switch, bench.node.objects().output), (0, 4));
    assert_eq!(bench.events, [NodeEvent::ProcessData { channel: 0, is_valid: false }]);
    assert_eq!(bench.node.counters().pdo_errors, 0);
}

/// RD says so, and it is counted and told, as long as it lasts.
#[test]
fn a_value_that_cannot_be_read_is_not_valid() {
    let mut bench = mapping(0x1A00, &[byte_at(0x6000, 1, 8), byte_at(0x2003, 0, 0)]);
    bench.node.objects_mut().input = 7;
    for cycle in 1..=2 {
        let before = bench.node.counters().pdo_errors;
        bench.soc();
        assert_eq!(bench.node.counters().pdo_errors - before, 1, "cycle {cycle}");
        let object = ObjectAddress::new(0x2003, 0);
        bench.tells(NodeEvent::ValueUnreadable { object, code: AbortCode::STATE });
        bench.preq(Flags::DATA_VALID, &[0]);
        bench.says("node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=0, PR=0 RS=0, 2 bytes");
        assert_eq!(bench.last[24..26], [0, 7]);
        bench.soa();
    }
    // Without that object they are valid again.
    assert_eq!(bench.writes(0x1A00, 0, &[0]), Ok(()));
    assert_eq!(bench.writes(0x1A00, 0, &[1]), Ok(()));
    bench.soc();
    bench.preq(Flags::DATA_VALID, &[0]);
    bench.says("node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD=1, PR=0 RS=0, 2 bytes");
}

/// The mapping of the PRes is written between SoC and PReq: its Size is the new one, and its data, those of the mapping before, are
/// not valid.
#[test]
fn inputs_of_the_mapping_before_are_not_valid() {
    for (write, rd, len) in [
        ("00 1a 00 00 00", 0, "0 bytes"),
        ("00 1a 00 00 01", 0, "1 byte"),
        // The second entry is of no object: the mapping is out of use.
        ("00 1a 00 00 02", 0, "0 bytes"),
        ("00 16 00 00 00", 1, "1 byte"),
    ] {
        let mut bench = Bench::in_state(NmtState::Operational, config());
        bench.opens_connection(NodeId::MANAGING_NODE);
        bench.forget();
        bench.soc();
        bench.sdo(&std::format!("02 06 00 00 00 01 00 01 05 00 00 00 {write}"));
        for rd in [rd, 1] {
            bench.preq(Flags::DATA_VALID, &[0]);
            bench.says(&std::format!("node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD={rd}, PR=3 RS=1, {len}"));
            bench.soa();
            bench.soc();
        }
    }
}

#[test]
fn inputs_may_be_declared_invalid() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    for (are_valid, rd) in [(false, 0), (true, 1)] {
        bench.node.set_inputs_valid(are_valid);
        bench.soc();
        bench.preq(Flags::DATA_VALID, &[0]);
        bench.says(&std::format!("node 1 -> all: PRes, NMT_OPERATIONAL, EN=0 RD={rd}, PR=0 RS=0, 1 byte"));
        bench.soa();
    }
}

/// A node that is polled in one cycle of four. MC toggles with each multiplexed cycle.
fn multiplexed() -> Bench {
    let mut config = config();
    config.values.multiplexed_cycles = 4;
    Bench::in_state(NmtState::Operational, config)
}

fn multiplexed_cycle(bench: &mut Bench, toggle: &mut Flags, polled_in: Option<usize>) {
    toggle.toggle(Flags::MULTIPLEXED_CYCLE);
    for place in 0..4 {
        bench.soc_with(Soc { flags: *toggle, ..Soc::default() });
        if polled_in == Some(place) {
            bench.preq(Flags::DATA_VALID | Flags::MULTIPLEXED, &[0]);
            assert_eq!(bench.last[18] & 0x20, 0x20, "MS comes back");
        }
        bench.soa();
        bench.wait(core::time::Duration::from_millis(CYCLE));
    }
}

fn lost_preqs(bench: &Bench) -> u32 {
    bench.node.dictionary().counters.of(Symptom::LossOfPreq).cumulative
}

/// MS comes back in the PRes; a cycle without a PReq is no loss; a multiplexed cycle without one is.
#[test]
fn multiplexed_nodes() {
    for place in 0..4 {
        let (mut bench, mut toggle) = (multiplexed(), Flags::empty());
        (0..20).for_each(|_| multiplexed_cycle(&mut bench, &mut toggle, Some(place)));
        bench.is(NmtState::Operational);
        assert_eq!(lost_preqs(&bench), 0);
        multiplexed_cycle(&mut bench, &mut toggle, None);
        (0..10).for_each(|_| multiplexed_cycle(&mut bench, &mut toggle, Some(place)));
        assert_eq!(lost_preqs(&bench), 1, "in place {place}");
        bench.is(NmtState::Operational);
        multiplexed_cycle(&mut bench, &mut toggle, None);
        multiplexed_cycle(&mut bench, &mut toggle, None);
        bench.is(NmtState::Operational);
        toggle.toggle(Flags::MULTIPLEXED_CYCLE);
        bench.soc_with(Soc { flags: toggle, ..Soc::default() });
        assert_eq!(lost_preqs(&bench), 3);
        bench.is(NmtState::PreOperational1);
        bench.tells(NodeEvent::Error(ErrorCode::LOSS_OF_PREQ_THRESHOLD));
    }
}

/// A node that is not multiplexed does not say that it is.
#[test]
fn the_multiplexed_bit_comes_back_only_from_multiplexed_nodes() {
    let mut bench = Bench::in_state(NmtState::Operational, config());
    bench.soc();
    bench.preq(Flags::DATA_VALID | Flags::MULTIPLEXED, &[0]);
    assert_eq!(bench.last[18], 0x01);
}
