//! Error counters, error-passive and bus-off.

use link_core::{BusErrorKind, LinkCommand, LinkEvent, TxOutcome};
use transport_mock::{Change, ErrorState, Flag};

use crate::harness::{Bench, bits, data};

#[test]
fn a_lone_node_becomes_error_passive_after_16_attempts_and_never_bus_off() {
    let mut bench = Bench::new(1);
    bench.send(0, data(0x100, &[1, 2]));
    while bench.frames.len() < 16 {
        bench.run_bits(1);
    }
    assert_eq!(bench.counters(0), (128, 0));
    assert_eq!(bench.network.error_state(bench.id(0)), Some(ErrorState::Passive));
    assert_eq!(bench.errors[15].flag, Flag::Active, "the error that makes it passive is flagged actively");

    bench.run_bits(500_000);
    assert_eq!(bench.counters(0), (128, 0));
    assert!(bench.frames.len() > 5_000, "it tries for ever");
    assert!(bench.errors.iter().all(|error| error.kind == BusErrorKind::Ack));
    assert!(bench.errors[16..].iter().all(|error| error.flag == Flag::Passive));
    assert!(bench.probe(0).outcomes().is_empty());

    // A second node appears, and the next attempt succeeds.
    let second = bench.network.add_silent(
        transport_mock::NodeConfig { power_up: None, ..transport_mock::NodeConfig::named("second") },
        crate::harness::Probe::default(),
    );
    let attempts = bench.frames.len();
    bench.change(Change::PowerOn(second));
    bench.run_bits(300);
    assert_eq!(bench.probe(0).outcomes(), [TxOutcome::Sent]);
    assert!(bench.frames.len() <= attempts + 3);
    assert_eq!(bench.counters(0).0, 127);
    assert!(bench.probe(0).link_events().contains(&LinkEvent::ErrorActive));
}

/// ACK slot, active flag 6, delimiter 8, intermission 3; when error-passive, 8 more.
#[test]
fn an_error_passive_sender_waits_eight_bits_more() {
    let mut bench = Bench::new(1);
    let frame = data(0x100, &[]);
    bench.send(0, frame);
    bench.run_bits(5_000);
    // Up to and with the ACK slot.
    let spent = u64::from(frame.bit_len()) - 8;
    let gap = |n: usize| bits(bench.frames[n].start, bench.frames[n + 1].start);
    assert_eq!(gap(0), spent + 6 + 8 + 3);
    assert_eq!(gap(14), spent + 6 + 8 + 3);
    assert_eq!(gap(15), spent + 6 + 8 + 3 + 8, "the sixteenth error has made it passive");
    assert_eq!(gap(16), spent + 6 + 8 + 3 + 8);
}

/// Same identifier, different data, in step: both see bit errors and flag them, 8 each a round.
#[test]
fn twins_with_different_data_drive_each_other_passive_and_then_the_dominant_one_gets_through() {
    let mut bench = Bench::new(3);
    let (dominant, recessive) = (data(0x123, &[0x00]), data(0x123, &[0xFF]));
    bench.send(0, recessive);
    bench.send(1, dominant);
    while bench.frames.len() < 16 {
        bench.run_bits(1);
    }
    assert_eq!((bench.counters(0).0, bench.counters(1).0), (128, 128));
    bench.run_bits(1_000);
    // Passive flags disturb nobody: the dominant one is sent, the other takes 8 more, and then has the bus for itself.
    assert_eq!(bench.probe(2).frames(), [dominant, recessive]);
    assert_eq!(bench.probe(0).outcomes(), [TxOutcome::Sent]);
    assert_eq!(bench.probe(1).outcomes(), [TxOutcome::Sent]);
    assert_eq!(bench.counters(0).0, 128 + 8 - 1);
    assert_eq!(bench.counters(1).0, 128 - 1);
}

#[test]
fn bus_off_recovery_takes_128_times_11_recessive_bits_after_the_reset() {
    let mut bench = Bench::new(2);
    // An error in every frame, seen by both: the sender goes bus-off.
    bench.tell(0, |probe| probe.recovers = false);
    let scope = transport_mock::Scope::Node(bench.id(0));
    bench.change(Change::FaultOn(
        transport_mock::FaultId(1),
        transport_mock::Fault::BitFlips { rate: 0.1, scope },
    ));
    bench.send(0, data(0x100, &[0x55; 8]));
    while bench.probe(0).when(LinkEvent::BusOff).is_none() {
        bench.run_bits(10);
    }
    bench.change(Change::FaultOff(transport_mock::FaultId(1)));
    assert_eq!(bench.probe(0).outcomes(), [TxOutcome::Dropped]);
    assert_eq!(bench.network.error_state(bench.id(0)), Some(ErrorState::BusOff));
    bench.run_bits(10_000);
    assert_eq!(bench.network.error_state(bench.id(0)), Some(ErrorState::BusOff), "nothing without a reset");

    let ups =
        |bench: &Bench| bench.probe(0).link_events().iter().filter(|&&event| event == LinkEvent::Up).count();
    let before = ups(&bench);
    bench.tell(0, |probe| probe.link(LinkCommand::Reset));
    bench.run_bits(128 * 11 - 1);
    assert_eq!(ups(&bench), before);
    bench.run_bits(1);
    assert_eq!(ups(&bench), before + 1);
    assert_eq!(bench.counters(0), (0, 0));
    assert_eq!(bench.network.error_state(bench.id(0)), Some(ErrorState::Active));
}

/// Many twins, each with its own data, next to a healthy node. In each round all but the dominant one take 8 more; from
/// TEC 128 on there are 16 rounds to go until bus-off, so that 16 of any number get through.
#[test]
fn of_many_twins_sixteen_get_through_and_the_others_go_bus_off() {
    for twins in [2_u8, 3, 10, 16, 17, 63] {
        let mut bench = Bench::new(usize::from(twins) + 1);
        for twin in 0..twins {
            bench.send(usize::from(twin), data(0x3FF, &[twin, 0x55, !twin]));
        }
        bench.run_bits(60_000);
        let mut off = 0;
        for twin in 0..usize::from(twins) {
            let outcomes = bench.probe(twin).outcomes();
            let is_off = bench.network.error_state(bench.id(twin)) == Some(ErrorState::BusOff);
            off += usize::from(is_off);
            let expected = if is_off { TxOutcome::Dropped } else { TxOutcome::Sent };
            assert_eq!(outcomes, [expected], "{twins} twins, node {twin}");
        }
        let heard = bench.probe(usize::from(twins)).frames().len();
        assert_eq!(heard + off, usize::from(twins), "what was sent was heard once");
        assert_eq!(off, usize::from(twins).saturating_sub(16), "{twins} twins");
    }
}
