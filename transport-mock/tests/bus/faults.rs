//! Things that go wrong on the wire.

use std::time::Duration;

use link_core::wire::{Field, bits};
use link_core::{BusErrorKind, Filter, Frame, LinkEvent, TxOutcome, frame::standard_id};
use transport_mock::record::Outcome;
use transport_mock::{Change, ErrorState, Fault, FaultId, Flag, Scope, Which};

use crate::harness::{Bench, Probe, bits as bits_between, data};

const FAULT: FaultId = FaultId(1);

fn flip(bench: &mut Bench, bit: u32, scope: Scope) {
    bench.change(Change::FaultOn(FAULT, Fault::FlipBit { frame: 0, bit, scope }));
}

/// The bit of `frame` that is the `nth` of `field`, stuff bits not counted.
fn bit_of(frame: &Frame, field: Field, nth: usize) -> u32 {
    let mut places = bits(frame).enumerate().filter(|(_, bit)| bit.field == field && !bit.stuff);
    places.nth(nth).unwrap().0 as u32
}

/// The whole bus sees one bit wrong: what its sender makes of it.
#[test]
fn every_kind_of_error_is_detected_where_it_belongs() {
    let frame = data(0x2AA, &[0x5A]);
    for (bit, kind) in [
        (bit_of(&frame, Field::Data, 3), BusErrorKind::Bit),
        (bit_of(&frame, Field::CrcDelimiter, 0), BusErrorKind::Bit),
        (bit_of(&frame, Field::AckDelimiter, 0), BusErrorKind::Bit),
        (bit_of(&frame, Field::AckSlot, 0), BusErrorKind::Ack),
    ] {
        let mut bench = Bench::new(3);
        flip(&mut bench, bit, Scope::Bus);
        bench.send(0, frame);
        bench.run_bits(400);
        let error = bench.errors.iter().find(|error| error.sender).unwrap();
        assert_eq!((error.kind, error.place.unwrap().0), (kind, bit), "{:#?}", bench.lines);
        assert!(matches!(bench.frames[0].outcome, Outcome::Error(_)));
        assert_eq!(bench.frames[1].outcome, Outcome::Ok, "it is sent again");
        assert_eq!(bench.probe(2).frames(), [frame], "and received once");
        assert_eq!(bench.counters(0).0, 7, "8 for the error, 1 less for the success");
    }
}

#[test]
fn a_receiver_that_misreads_a_data_bit_finds_a_crc_error_after_the_ack_delimiter() {
    let frame = data(0x2AA, &[0x5A]);
    let mut bench = Bench::new(3);
    let scope = Scope::Node(bench.id(2));
    flip(&mut bench, bit_of(&frame, Field::Data, 3), scope);
    bench.send(0, frame);
    bench.run_bits(400);
    let first = bench.errors[0];
    assert_eq!((first.node, first.kind), (bench.id(2), BusErrorKind::Crc));
    assert_eq!(first.place, Some((bit_of(&frame, Field::AckDelimiter, 0), Field::AckDelimiter)));
    // Its flag begins in the end of frame, where the others take it for a form error (the sender: a bit error).
    assert_eq!(bench.errors[1].place.unwrap().1, Field::EndOfFrame);
    assert_eq!(bench.probe(1).frames(), [frame], "nobody has accepted the first");
    assert_eq!(bench.probe(2).frames(), [frame]);
}

#[test]
fn six_equal_bits_are_a_stuff_error() {
    // Five dominant bits with the start of frame; the stuff bit behind them is flipped for one receiver.
    let frame = data(0x000, &[]);
    let stuff = bits(&frame).position(|bit| bit.stuff).unwrap() as u32;
    let mut bench = Bench::new(3);
    let scope = Scope::Node(bench.id(2));
    flip(&mut bench, stuff, scope);
    bench.send(0, frame);
    bench.run_bits(300);
    assert_eq!(bench.errors[0].kind, BusErrorKind::Stuff);
    assert_eq!(bench.errors[0].node, bench.id(2));
    // Six dominant bits of its flag; the sender notices at its next recessive bit, so the flags overlap: 6 to 12 bits.
    assert_eq!(bench.probe(1).frames(), [frame]);
    assert_eq!(bench.probe(2).frames(), [frame]);
}

/// A receiver whose flag comes first sees the others' flags behind its own: REC 1 + 8.
#[test]
fn the_one_that_was_wrong_is_blamed_most() {
    let frame = data(0x2AA, &[0x5A]);
    let mut bench = Bench::new(3);
    let scope = Scope::Node(bench.id(2));
    flip(&mut bench, bit_of(&frame, Field::Data, 3), scope);
    bench.send(0, frame);
    bench.run_bits(70);
    assert_eq!(bench.counters(2), (0, 1 + 8));
    assert_eq!(bench.counters(1), (0, 1));
    assert_eq!(bench.counters(0), (8, 0));
}

#[test]
fn superposed_flags_last_6_to_12_bits() {
    let frame = data(0x2AA, &[0x5A, 0, 0xFF, 0]);
    let mut lengths = Vec::new();
    for bit in 1..frame.bit_len() {
        for everybody in [false, true] {
            let mut bench = Bench::new(3);
            let scope = if everybody { Scope::Bus } else { Scope::Node(bench.id(2)) };
            flip(&mut bench, bit, scope);
            bench.send(0, frame);
            bench.run_bits(300);
            let Outcome::Error(error) = bench.frames[0].outcome else { continue };
            lengths.push(bits_between(error.at, bench.frames[0].end) - 8);
        }
    }
    assert_eq!((lengths.iter().min(), lengths.iter().max()), (Some(&6), Some(&12)), "{lengths:?}");
}

#[test]
fn a_passive_flag_disturbs_nobody() {
    let mut bench = Bench::new(3);
    // Node 2 is alone for a while, and comes back error-passive with a TEC of 128.
    let passive = bench.id(2);
    bench.change(Change::Split(vec![passive]));
    bench.send(2, data(0x200, &[]));
    bench.run_bits(3_000);
    bench.tell(2, Probe::withdraw_last);
    bench.run_bits(100);
    bench.change(Change::Join);
    bench.run_bits(20);
    assert_eq!(bench.network.error_state(passive), Some(ErrorState::Passive));

    let (frames, errors) = (bench.frames.len(), bench.errors.len());
    let frame = data(0x2AA, &[0x5A]);
    flip(&mut bench, bit_of(&frame, Field::Data, 3), Scope::Node(passive));
    bench.send(0, frame);
    bench.run_bits(200);
    assert_eq!(bench.frames.len(), frames + 1);
    assert_eq!(bench.frames[frames].outcome, Outcome::Ok);
    assert_eq!(bench.probe(1).frames(), [frame]);
    assert_eq!(bench.errors.len(), errors + 1);
    assert_eq!(bench.errors[errors].flag, Flag::Passive);
    assert!(bench.probe(2).frames().is_empty(), "it has lost the frame");
}

#[test]
fn a_spoilt_end_makes_duplicates_for_all_but_one() {
    let frame = data(0x123, &[9]);
    let mut bench = Bench::new(4);
    let receiver = bench.id(3);
    bench.change(Change::FaultOn(FAULT, Fault::SpoiltEnd { receiver, filter: None, which: Which::Next(1) }));
    bench.send(0, frame);
    bench.run_bits(400);
    assert_eq!(bench.probe(1).frames(), [frame, frame]);
    assert_eq!(bench.probe(2).frames(), [frame, frame]);
    assert_eq!(bench.probe(3).frames(), [frame]);
    assert_eq!(bench.probe(0).outcomes(), [TxOutcome::Sent]);
    assert_eq!(bench.errors[0].place.unwrap().1, Field::EndOfFrame);
}

#[test]
fn only_frames_that_a_receiver_hears_can_be_spoilt_for_it() {
    let mut bench = Bench::new(3);
    let receiver = bench.id(2);
    bench.change(Change::FaultOn(FAULT, Fault::SpoiltEnd { receiver, filter: None, which: Which::Next(1) }));
    // One of its own, and one that is sent while it is away.
    bench.send(2, data(0x100, &[]));
    bench.run_bits(200);
    bench.change(Change::Cut(receiver));
    bench.send(0, data(0x101, &[]));
    bench.run_bits(200);
    bench.change(Change::Plug(receiver));
    bench.run_bits(200);
    assert_eq!((bench.frames.len(), bench.errors.len()), (2, 0));
    bench.send(0, data(0x102, &[]));
    bench.run_bits(200);
    assert_eq!(bench.errors[0].node, receiver);
}

/// An overrun: the controller acknowledges, the node never sees the frame, and no other node can know.
#[test]
fn an_overrun_loses_frames_of_one_receiver_only() {
    let mut bench = Bench::new(3);
    let receiver = bench.id(2);
    let filter = Some(Filter::exact(standard_id(0x101)));
    bench.change(Change::FaultOn(FAULT, Fault::Overrun { receiver, filter, which: Which::All }));
    bench.send(0, data(0x100, &[]));
    bench.send(0, data(0x101, &[]));
    bench.run_bits(300);
    assert_eq!(bench.probe(1).frames().len(), 2);
    assert_eq!(bench.probe(2).frames(), [data(0x100, &[])]);
    assert!(bench.probe(2).link_events().contains(&LinkEvent::Overrun { lost: 1 }));
    assert_eq!(bench.probe(0).outcomes().len(), 2);
}

#[test]
fn noise_bursts_delay_frames_and_lose_none() {
    let mut bench = Bench::new(3);
    bench.change(Change::FaultOn(
        FAULT,
        Fault::Bursts { gap: Duration::from_millis(5), length: Duration::from_micros(60), scope: Scope::Bus },
    ));
    for n in 0..50 {
        bench.send(0, data(0x100, &[n]));
        bench.run_bits(2_000);
    }
    bench.change(Change::FaultOff(FAULT));
    bench.run_bits(5_000);
    assert!(!bench.errors.is_empty());
    let mut got = bench.probe(1).frames();
    got.dedup();
    assert_eq!(got, (0..50).map(|n| data(0x100, &[n])).collect::<Vec<_>>());
}

/// A bus that is dominant for good: a sender goes bus-off, a receiver only becomes error-passive.
#[test]
fn a_stuck_bus_drives_the_sender_off() {
    let mut bench = Bench::new(2);
    bench.send(0, data(0x100, &[]));
    bench.run_bits(10);
    let (pull, every) = (Duration::from_millis(1), Duration::ZERO);
    bench.change(Change::FaultOn(FAULT, Fault::Babble { pull, every }));
    bench.run_bits(1_000);
    assert_eq!(bench.network.error_state(bench.id(0)), Some(ErrorState::BusOff));
    assert_eq!(bench.network.error_state(bench.id(1)), Some(ErrorState::Passive));
    bench.change(Change::FaultOff(FAULT));
    bench.run_bits(100);
    assert_eq!(bench.network.error_state(bench.id(1)), Some(ErrorState::Passive));
}

/// Otherwise noise that comes and goes would do the same each time.
#[test]
fn a_fault_that_is_switched_on_again_draws_other_numbers() {
    let mut bench = Bench::new(1);
    let mut errors = Vec::new();
    for _ in 0..2 {
        let began = bench.network.now();
        bench.change(Change::FaultOn(FAULT, Fault::BitFlips { rate: 0.002, scope: Scope::Bus }));
        bench.run_bits(2_000);
        bench.change(Change::FaultOff(FAULT));
        bench.run_bits(100);
        let seen: Vec<u64> = bench.errors.drain(..).map(|error| bits_between(began, error.at)).collect();
        assert!(!seen.is_empty());
        errors.push(seen);
    }
    assert_ne!(errors[0], errors[1]);
}

#[test]
fn the_same_seed_gives_the_same_lines_and_another_seed_others() {
    let run = |seed| {
        let config =
            transport_mock::BusConfig { seed, shared: None, ..Bench::new(1).network.config().clone() };
        let mut bench = Bench::with(config, 4);
        bench.change(Change::FaultOn(FAULT, Fault::BitFlips { rate: 0.002, scope: Scope::Bus }));
        for n in 0..40 {
            bench.send(usize::from(n % 4), data(0x100 + u16::from(n % 4), &[n]));
            bench.run_bits(300);
        }
        bench.lines
    };
    assert_eq!(run(5), run(5));
    assert_ne!(run(5), run(6));
}
