//! Who goes first, and when.

use link_core::frame::{extended_id, standard_id};
use link_core::{Frame, TxOutcome};
use transport_mock::bus::SenderOutcome;
use transport_mock::record::Outcome;

use crate::harness::{Bench, bits, data};

/// Identifier 0x555, no data: 44 bits and no stuffing but in the CRC; with the intermission the next frame begins 47 bits
/// and the stuff bits later.
#[test]
fn an_empty_frame_and_the_intermission_take_47_bits_before_stuffing() {
    let mut bench = Bench::new(2);
    let frame = data(0x555, &[]);
    bench.send(0, frame);
    bench.send(0, frame);
    bench.run_bits(120);
    let stuffing = u64::from(frame.bit_len()) - 44;
    assert_eq!(bits(bench.frames[0].start, bench.frames[1].start), 47 + stuffing);
}

#[test]
fn the_lower_identifier_goes_first_and_the_others_follow() {
    let mut bench = Bench::new(4);
    for (node, id) in [(0, 0x300), (1, 0x100), (2, 0x200)] {
        bench.send(node, data(id, &[node as u8]));
    }
    bench.run_bits(400);
    let ids: Vec<u32> = bench.frames.iter().map(|seen| seen.frame.raw_id()).collect();
    assert_eq!(ids, [0x100, 0x200, 0x300]);
    assert!(bench.frames.iter().all(|seen| seen.outcome == Outcome::Ok));
    assert_eq!(bench.frames[0].senders.len(), 3);
    // 0x300 is 011_0000_0000 and 0x100 is 001_0000_0000: they differ in the second identifier bit, which is bit 2.
    assert_eq!(bench.frames[0].senders[0].outcome, SenderOutcome::LostArbitration { bit: 2 });
    assert_eq!(bench.probe(3).frames().len(), 3);
}

#[test]
fn at_equal_eleven_bits_data_beats_remote_beats_extended() {
    let base = 0x123;
    let frames = [
        Frame::new(extended_id(u32::from(base) << 18), &[]).unwrap(),
        Frame::remote(standard_id(base), 0).unwrap(),
        data(base, &[]),
        Frame::remote(extended_id(u32::from(base) << 18), 0).unwrap(),
    ];
    for exact in [false, true] {
        let mut bench = Bench::new(5);
        if exact {
            bench = Bench::with(
                transport_mock::BusConfig { force_exact: true, ..bench.network.config().clone() },
                5,
            );
        }
        for (node, frame) in frames.into_iter().enumerate() {
            bench.send(node, frame);
        }
        bench.run_bits(600);
        let order: Vec<Frame> = bench.frames.iter().map(|seen| seen.frame).collect();
        assert_eq!(order, [frames[2], frames[1], frames[0], frames[3]]);
        assert!(bench.frames.iter().all(|seen| seen.outcome == Outcome::Ok), "{:#?}", bench.lines);
    }
}

#[test]
fn identical_frames_of_two_senders_both_succeed_if_a_third_acknowledges() {
    let mut bench = Bench::new(3);
    bench.send(0, data(0x123, &[7]));
    bench.send(1, data(0x123, &[7]));
    bench.run_bits(200);
    assert_eq!(bench.frames.len(), 1);
    assert_eq!(bench.probe(0).outcomes(), [TxOutcome::Sent]);
    assert_eq!(bench.probe(1).outcomes(), [TxOutcome::Sent]);
    assert_eq!(bench.probe(2).frames(), [data(0x123, &[7])]);
    assert!(bench.probe(0).frames().is_empty() && bench.probe(1).frames().is_empty());
}

#[test]
fn identical_frames_fail_if_nobody_else_is_there() {
    let mut bench = Bench::new(2);
    bench.send(0, data(0x123, &[7]));
    bench.send(1, data(0x123, &[7]));
    bench.run_bits(60);
    assert_eq!(bench.counters(0), (8, 0));
    assert_eq!(bench.counters(1), (8, 0));
}

/// `floor((34 + 8n - 1) / 4)` stuff bits at most, and the wire needs as long as the frame says.
#[test]
fn the_worst_case_of_stuffing_takes_as_long_as_it_must() {
    // All dominant to the CRC, which is zero too: 34 bits, and a stuff bit after every fifth.
    let zeros = data(0, &[]);
    // 11111 00001 11100 ...: after the first run each stuff bit begins the next run of five.
    let dense = data(0x7C3, &[0x0F, 0x0F, 0x87, 0xC3, 0xE1, 0xF0, 0x78, 0x3C]);
    for frame in [zeros, dense] {
        let mut bench = Bench::new(2);
        bench.send(0, frame);
        bench.run_bits(200);
        let seen = &bench.frames[0];
        let n = frame.data().len() as u64;
        let taken = bits(seen.start, seen.end);
        assert_eq!(taken, u64::from(frame.bit_len()));
        let stuffed = taken - (44 + 8 * n);
        assert!((6..=(34 + 8 * n - 1) / 4).contains(&stuffed), "{frame}: {stuffed} stuff bits");
    }
}
