//! The letter of the standard, bit by bit: overload frames, the end of a frame, and each rule of the error counters (Bosch
//! CAN 2.0 part B, 3.1.4, 3.2 and 8; ISO 11898-1).

use std::time::Duration;

use link_core::wire::{Field, TRAILER_BITS};
use link_core::{BusErrorKind, Frame, TxOutcome};
use transport_mock::record::Outcome;
use transport_mock::{Change, ErrorState, Fault, FaultId, Flag, Scope};

use crate::harness::{BIT, Bench, bits, data};

/// Inverts what all nodes see of a bit, counted from the start of the next frame; the end of frame is not the end.
fn flip(bench: &mut Bench, bit: u64) {
    let bit = u32::try_from(bit).unwrap();
    bench.change(Change::FaultOn(FaultId(bit), Fault::FlipBit { frame: 0, bit, scope: Scope::Bus }));
}

/// Holds the bus dominant for so many bits from now on, and waits until that is over.
fn pull(bench: &mut Bench, pulled: u64) {
    let (pull, every) = (Duration::from_nanos(pulled * BIT), Duration::from_secs(1_000));
    bench.change(Change::FaultOn(FaultId(0), Fault::Babble { pull, every }));
    bench.run_bits(pulled + 40);
    bench.change(Change::FaultOff(FaultId(0)));
}

fn len(frame: &Frame) -> u64 {
    u64::from(frame.bit_len())
}

#[test]
fn a_dominant_last_bit_of_the_end_of_frame_is_an_error_for_the_sender_only() {
    let frame = data(0x2AA, &[0x5A]);
    let mut bench = Bench::new(3);
    flip(&mut bench, len(&frame) - 1);
    bench.send(0, frame);
    bench.run_bits(300);
    assert_eq!(bench.errors.len(), 1, "{:#?}", bench.lines);
    assert!(bench.errors[0].sender && bench.errors[0].kind == BusErrorKind::Bit);
    // The receivers have accepted it already, and send overload flags, which count nowhere.
    assert_eq!(bench.probe(1).frames(), [frame, frame]);
    assert_eq!(bench.probe(0).outcomes(), [TxOutcome::Sent]);
    assert_eq!([bench.counters(0), bench.counters(1)], [(8 - 1, 0), (0, 0)]);
}

/// A dominant bit in the intermission: in its first two bits it is an overload condition, in the third a start of frame, with
/// which a node that waits sends from the first identifier bit on.
#[test]
fn a_dominant_bit_in_the_intermission_is_an_overload_or_a_start_of_frame() {
    let frame = data(0x2AA, &[0x5A]);
    // The bit, overload flag 6, delimiter 8, intermission 3.
    for (bit, distance) in [(0, 1 + 6 + 8 + 3), (1, 2 + 6 + 8 + 3), (2, 2)] {
        let mut bench = Bench::new(3);
        flip(&mut bench, len(&frame) + bit);
        bench.send(0, frame);
        bench.send(0, frame);
        bench.run_bits(300);
        assert_eq!(bits(bench.frames[0].start, bench.frames[1].start), len(&frame) + distance);
        assert!(bench.frames.iter().all(|seen| seen.outcome == Outcome::Ok), "{:#?}", bench.lines);
        assert_eq!(bench.probe(2).frames(), [frame, frame]);
        assert!(bench.errors.is_empty() && bench.counters.is_empty());
    }
}

/// A lone node is not acknowledged: active flag from the ACK delimiter on, 6 bits, and a delimiter of 8.
#[test]
fn a_dominant_bit_in_a_delimiter_is_a_form_error_and_in_its_last_bit_an_overload() {
    let frame = data(0x2AA, &[0x5A]);
    let delimiter = len(&frame) - u64::from(TRAILER_BITS) + 2 + 6;
    for (bit, tec) in [(1, 8 + 8), (6, 8 + 8), (7, 8)] {
        let mut bench = Bench::new(1);
        flip(&mut bench, delimiter + bit);
        bench.send(0, frame);
        bench.run_bits(delimiter + 8 + 6 + 8);
        assert_eq!(bench.counters(0), (tec, 0), "bit {bit} of the delimiter: {:#?}", bench.lines);
        assert_eq!(bench.errors.len(), usize::from(tec / 8));
    }
}

/// Rule 3, exception 2: the stuff bit was sent recessive and seen dominant. The other way round it is a bit error like any.
#[test]
fn a_stuff_error_in_the_arbitration_field_costs_its_sender_nothing() {
    for (id, stuff_bit, kind, tec) in [(0x000, 5, BusErrorKind::Stuff, 0), (0x7C5, 6, BusErrorKind::Bit, 8)] {
        let frame = data(id, &[]);
        let mut bench = Bench::new(2);
        flip(&mut bench, stuff_bit);
        bench.send(0, frame);
        bench.run_bits(30);
        let error = bench.errors.iter().find(|error| error.sender).unwrap();
        assert_eq!((error.kind, error.place.unwrap()), (kind, (stuff_bit as u32, Field::Arbitration)));
        assert_eq!(error.flag, Flag::Active);
        assert_eq!(bench.counters(0), (tec, 0));
    }
}

/// Rule 3, exception 1: only if it sees no dominant bit during its passive flag.
#[test]
fn a_passive_sender_without_acknowledgement_counts_if_its_flag_meets_a_dominant_bit() {
    let frame = data(0x2AA, &[]);
    let flag = len(&frame) - u64::from(TRAILER_BITS) + 2;
    // The six bits of the flag, and the bit behind it, which is in the delimiter already.
    for (bit, tec) in [(0, 136), (5, 136), (6, 128)] {
        let mut bench = Bench::new(1);
        bench.send(0, frame);
        bench.run_bits(3_000);
        assert_eq!(bench.counters(0), (128, 0));
        flip(&mut bench, flag + bit);
        bench.run_bits(200);
        assert_eq!(bench.counters(0), (tec, 0), "bit {bit}");
    }
}

/// Idle, then dominant: start of frame and five more are a stuff error (REC 1); flag 6; the first dominant bit behind it
/// counts 8 (rule 2), and so does each eighth (rule 6). After five dominant bits it is the sixth recessive one that is wrong.
#[test]
fn dominant_bits_behind_a_flag_count_eight_each_eighth() {
    for (pulled, rec) in [(5, 1), (6, 1), (12, 1), (13, 9), (19, 9), (20, 17), (27, 17), (28, 25), (36, 33)] {
        let mut bench = Bench::new(2);
        pull(&mut bench, pulled);
        assert_eq!([bench.counters(0), bench.counters(1)], [(0, rec); 2], "{pulled} bits");
    }
}

#[test]
fn error_passive_receivers_acknowledge_and_are_active_after_a_good_frame() {
    let frame = data(0x2AA, &[1]);
    let mut bench = Bench::new(2);
    pull(&mut bench, 12 + 8 * 16);
    assert_eq!([bench.counters(0), bench.counters(1)], [(0, 1 + 8 + 8 * 16); 2]);
    assert_eq!(bench.network.error_state(bench.id(1)), Some(ErrorState::Passive));
    bench.send(0, frame);
    bench.run_bits(200);
    assert_eq!(bench.probe(0).outcomes(), [TxOutcome::Sent]);
    assert_eq!(bench.counters(0), (0, 137), "what it sends says nothing of how it hears");
    assert_eq!(bench.counters(1), (0, 127));
    assert_eq!(bench.network.error_state(bench.id(1)), Some(ErrorState::Active));
}

/// 11 recessive bits are there only from the ACK delimiter on.
#[test]
fn a_node_that_starts_in_a_frame_takes_part_from_the_next_one_on() {
    let frame = data(0x2AA, &[0; 8]);
    let mut bench = Bench::new(3);
    let late = bench.id(2);
    bench.change(Change::PowerOff(late));
    bench.run_bits(1);
    bench.send(0, frame);
    bench.send(0, frame);
    bench.run_bits(20);
    bench.change(Change::PowerOn(late));
    bench.run_bits(300);
    assert_eq!(bench.frames[0].receivers, [1]);
    assert_eq!(bench.frames[1].receivers, [1, 2]);
    assert_eq!(bits(bench.frames[0].end, bench.frames[1].start), 3);
}
