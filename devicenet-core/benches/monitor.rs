#![allow(
    clippy::arithmetic_side_effects,
    clippy::expect_used,
    missing_docs,
    reason = "a benchmark on a host"
)]
//! How many frames a second the monitor reads: a scan of three slaves with some explicit traffic.

use std::fmt::Write as _;

use devicenet_core::Identifier;
use devicenet_core::monitor::{Monitor, MonitorConfig};
use divan::counter::ItemsCount;
use link_core::{Frame, Instant};

fn main() {
    divan::main();
}

/// One scan, 32 frames: polls with 2 and 8 bytes, fragmented I/O, COS with acknowledge, explicit requests.
fn scan() -> Vec<Frame> {
    const SCAN: &[(u16, &[u8])] = &[
        (0x455, &[0x03]),
        (0x3CA, &[0x34, 0x12]),
        (0x45D, &[1, 2, 3, 4, 5, 6, 7, 8]),
        (0x3CB, &[8, 7, 6, 5, 4, 3, 2, 1]),
        (0x465, &[0x00, 1, 2, 3, 4, 5, 6, 7]),
        (0x465, &[0x81, 8, 9, 10]),
        (0x3CC, &[0x00, 1, 2, 3, 4, 5, 6, 7]),
        (0x3CC, &[0x81, 8, 9, 10]),
        (0x34D, &[0xFF, 0xDF]),
        (0x46A, &[]),
        (0x454, &[0x01, 0x0E, 0x05, 0x02, 0x01]),
        (0x453, &[0x01, 0x8E, 0x03]),
        (0x454, &[0x41, 0x0E, 0x01, 0x01, 0x01]),
        (0x453, &[0x41, 0x8E, 0x34, 0x12]),
        (0x454, &[0x01, 0x0E, 0x01, 0x01, 0x07]),
        (0x453, &[0x81, 0x00, 0x8E, 0x08, 0x47, 0x52, 0x54, 0x31]),
        (0x454, &[0x81, 0xC0, 0x00]),
        (0x453, &[0x81, 0x81, 0x2D, 0x44, 0x52, 0x54]),
        (0x454, &[0x81, 0xC1, 0x00]),
    ];
    let frames = SCAN.iter().map(|&(id, data)| Identifier::new(id).and_then(|id| id.frame(data)));
    let mut frames: Vec<Frame> = frames.map(|frame| frame.expect("a valid frame")).collect();
    // Polls are most of the traffic.
    let polls: Vec<Frame> = frames.iter().take(4).copied().cycle().take(13).collect();
    frames.extend(polls);
    frames
}

fn frames() -> Vec<Frame> {
    scan().into_iter().cycle().take(FRAMES).collect()
}

#[divan::bench]
fn observe(bencher: divan::Bencher<'_, '_>) {
    let frames = frames();
    bencher
        .counter(ItemsCount::new(FRAMES))
        .with_inputs(|| Box::new(Monitor::new(MonitorConfig::default())))
        .bench_refs(|monitor| {
            for (n, frame) in (1_u64..).zip(&frames) {
                divan::black_box(monitor.observe(Instant::from_micros(n * 300), n, frame));
            }
        });
}

#[divan::bench]
fn observe_and_print(bencher: divan::Bencher<'_, '_>) {
    let frames = frames();
    bencher
        .counter(ItemsCount::new(FRAMES))
        .with_inputs(|| Box::new(Monitor::new(MonitorConfig::default())))
        .bench_refs(|monitor| {
            let mut text = String::new();
            for (n, frame) in (1_u64..).zip(&frames) {
                text.clear();
                let reading = monitor.observe(Instant::from_micros(n * 300), n, frame);
                write!(text, "{reading}").expect("a string takes all");
                divan::black_box(&text);
            }
        });
}

const FRAMES: usize = 100_000;
