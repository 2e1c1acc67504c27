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
    drive_off(&mut bench, 0);
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

/// Sends until it is bus-off, all alone but for noise.
fn drive_off(bench: &mut Bench, node: usize) {
    let fault = transport_mock::FaultId(1);
    let scope = transport_mock::Scope::Node(bench.id(node));
    bench.change(Change::FaultOn(fault, transport_mock::Fault::BitFlips { rate: 0.1, scope }));
    bench.send(node, data(0x100, &[0x55; 8]));
    while bench.probe(node).when(LinkEvent::BusOff).is_none() {
        bench.run_bits(10);
    }
    bench.change(Change::FaultOff(fault));
}

#[test]
fn a_node_is_told_its_counters_and_then_what_they_mean() {
    let mut bench = Bench::new(2);
    drive_off(&mut bench, 0);
    let told: Vec<LinkEvent> = bench
        .probe(0)
        .link_events()
        .into_iter()
        .filter(|event| !matches!(event, LinkEvent::Up | LinkEvent::BusError(_)))
        // The noise between the frames counts for REC.
        .map(|event| match event {
            LinkEvent::Counters { tec, .. } => LinkEvent::Counters { tec, rec: 0 },
            other => other,
        })
        .collect();
    let counters = |tec| LinkEvent::Counters { tec, rec: 0 };
    assert_eq!(
        told,
        [
            counters(96),
            LinkEvent::ErrorWarning,
            counters(128),
            LinkEvent::ErrorPassive,
            counters(256),
            LinkEvent::BusOff
        ]
    );
}

/// 128 sequences of 11 recessive bits, not 1408 recessive bits: those between a frame that others send and the next count
/// only as whole sequences. After an acknowledged frame there are 11 recessive bits before the next one on a full bus.
#[test]
fn bus_off_recovery_goes_on_under_traffic_and_begins_anew_with_a_new_mode() {
    let mut bench = Bench::new(3);
    drive_off(&mut bench, 0);
    bench.run_bits(100);
    for n in 0..200 {
        bench.send(1, data(0x200, &[n]));
    }
    bench.run_bits(10);
    bench.tell(0, |probe| probe.link(LinkCommand::Reset));
    let ups =
        |bench: &Bench| bench.probe(0).link_events().iter().filter(|&&event| event == LinkEvent::Up).count();
    let (before, frames) = (ups(&bench), bench.frames.len());
    while ups(&bench) == before {
        bench.run_bits(1);
    }
    assert_eq!(bench.frames.len() - frames, 128, "one sequence after each frame");

    let mut bench = Bench::new(2);
    drive_off(&mut bench, 0);
    bench.run_bits(100);
    bench.tell(0, |probe| probe.link(LinkCommand::Reset));
    bench.run_bits(127 * 11);
    let mode = bench.network.mode(bench.id(0));
    bench.tell(0, |probe| probe.link(LinkCommand::SetMode(mode)));
    bench.run_bits(128 * 11 - 1);
    assert_eq!(ups(&bench), before);
    bench.run_bits(2);
    assert_eq!(ups(&bench), before + 1);
}

/// Many twins, each with its own data, which all send one frame from the same bit on. After 16 rounds all are error-passive,
/// and from then on one gets through in each round while the others take 8 more: 16 rounds to go until TEC 256.
///
/// With a bystander that acknowledges, 16 of any number get through. Without one the first is not acknowledged; some bits
/// behind the others, it acknowledges the second, and is then sent at once, in the error delimiter of those that are still
/// transmitters: a form error, 8 more, so that 15 get through.
#[test]
fn of_many_twins_sixteen_get_through_with_a_bystander_and_fifteen_without() {
    for bystander in [true, false] {
        let most = if bystander { 16 } else { 15 };
        for twins in [2_u8, 3, 10, most, most + 1, 63] {
            let mut bench = Bench::new(usize::from(twins) + usize::from(bystander));
            for twin in 0..twins {
                bench.send(usize::from(twin), data(0x3FF, &[twin, 0x55, !twin]));
            }
            bench.run_bits(60_000);
            for twin in 0..usize::from(twins) {
                let is_off = bench.network.error_state(bench.id(twin)) == Some(ErrorState::BusOff);
                assert_eq!(
                    is_off,
                    twin >= usize::from(most),
                    "{twins} twins, node {twin}, bystander {bystander}"
                );
                let expected = if is_off { TxOutcome::Dropped } else { TxOutcome::Sent };
                assert_eq!(bench.probe(twin).outcomes(), [expected], "{twins} twins, node {twin}");
            }
            if bystander {
                let heard = bench.probe(usize::from(twins)).frames().len();
                assert_eq!(heard, usize::from(twins.min(most)), "what was sent was heard once");
            }
        }
    }
}
