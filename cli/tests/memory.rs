#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    missing_docs
)]
//! `monitor` on a full bus, and `decode` of a long capture of Ethernet: memory that does not grow with time.
//!
//! `cargo test --release -p devicenet-cli --test memory -- --ignored --nocapture` watches a whole day, and decodes a million frames.

use std::fmt::Write as _;
use std::io::{BufWriter, Write as _};
use std::process::{Command, Stdio};
use std::time::Instant;

use clap::Parser as _;
use devicenet_cli::args::Cli;
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Every table has its size from the beginning. What is allowed is the length of numbers in the summary, and 80 bytes for each
/// second of the load's history, which is kept for five minutes.
#[test]
fn a_longer_time_needs_no_more_memory() {
    let [short, long] = ["10s", "30s"].map(|span| watch(8, span).peak);
    assert!(long <= short + 20 * 80 + SLACK, "{long} bytes instead of {short}");
}

/// No node of this network hears them, and each is counted.
#[test]
fn frames_of_can_fd_need_no_memory() {
    let [few, many] = [1_000, 50_000].map(|count| {
        let log: String = (0..count)
            .map(|n| format!("({}.{:06}) can0 123##10102\n", 1 + n / 1_000, n % 1_000 * 1_000))
            .collect();
        let path = format!("{}/fd-{count}.log", env!("CARGO_TARGET_TMPDIR"));
        std::fs::write(&path, log).unwrap();
        let watched = measure(&format!("log:{path}"), "1h");
        assert_eq!(watched.summary["frames"], count);
        assert_eq!(watched.summary["findings"][0]["count"], count);
        watched.peak
    });
    assert!(many <= few + 50 * 80 + SLACK, "{many} bytes instead of {few}");
}

#[test]
#[ignore = "takes minutes in release mode"]
fn a_day_needs_no_more_memory_than_six_minutes() {
    let minutes = watch(62, "6min");
    let begin = Instant::now();
    let day = watch(62, "24h");
    let (frames, load) = (day.summary["frames"].clone(), day.summary["load_total"]["all"].as_f64().unwrap());
    println!(
        "24 h, {frames} frames, load {:.2} %: {} bytes at most, {} in six minutes; {:.0} s",
        load * 100.0,
        day.peak,
        minutes.peak,
        begin.elapsed().as_secs_f64()
    );
    assert!(
        load > 0.95 && day.peak <= minutes.peak + SLACK,
        "{load}, {} instead of {}",
        day.peak,
        minutes.peak
    );
}

/// Whatever is made of the frames. The tables of a summary are full after 20 000.
#[test]
fn a_longer_capture_of_ethernet_needs_no_more_memory() {
    for options in [&["--summary", "--json"][..], &["--json"], &[]] {
        let [short, long] = [20_000, 100_000].map(|frames| decode(frames, options));
        assert!(long <= short + LONGER_NUMBERS, "{options:?}: {long} bytes instead of {short}");
    }
}

#[test]
#[ignore = "takes a minute"]
fn a_million_frames_of_ethernet_need_no_more_memory_than_some() {
    for options in [&["--summary", "--json"][..], &["--json"], &[]] {
        let short = decode(20_000, options);
        let begin = Instant::now();
        let long = decode(1_000_000, options);
        println!(
            "1 000 000 frames, {options:?}: {long} bytes at most, {short} of 20 000; {:.1} s",
            begin.elapsed().as_secs_f64()
        );
        assert!(long <= short + LONGER_NUMBERS, "{options:?}: {long} bytes instead of {short}");
    }
}

/// What a process of its own needs to decode a capture of so many frames, which comes through a pipe.
fn decode(frames: u64, options: &[&str]) -> usize {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "the_process_that_is_measured", "--ignored", "--nocapture"])
        .env("DEVICENET_ARGUMENTS", [&["decode", "-"], options].concat().join(" "))
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut capture = BufWriter::new(child.stdin.take().unwrap());
    // pcap in microseconds, little-endian, link type 1.
    let head = [0xD4, 0xC3, 0xB2, 0xA1, 2, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 1, 0, 0, 0];
    capture.write_all(&head).unwrap();
    for (n, frame) in (0..frames).zip(cycles()) {
        let micros = n * 500;
        let [seconds, micros] = [micros / 1_000_000, micros % 1_000_000].map(|part| part as u32);
        for field in [seconds, micros, frame.len() as u32, frame.len() as u32] {
            capture.write_all(&field.to_le_bytes()).unwrap();
        }
        capture.write_all(&frame).unwrap();
    }
    drop(capture);
    let ended = child.wait_with_output().unwrap();
    peak(&String::from_utf8(ended.stderr).unwrap())
}

/// Cycles of a network of ten nodes that changes all the time: PRes that are missing, states that come and go, SDO that is refused for
/// one object after another, strangers, other protocols, frames that end too early.
fn cycles() -> impl Iterator<Item = Vec<u8>> {
    (0_u64..).flat_map(|cycle| {
        let node = 1 + (cycle % 10) as u8;
        let frame = |group: u8, from: u8, message: &[u8]| {
            let mut frame = vec![0x01, 0x11, 0x1E, 0, 0, group, 2, 0, 0, 0, 0, from, 0x88, 0xAB];
            frame.extend(message);
            frame.resize(frame.len().max(60), 0);
            frame
        };
        let time = (cycle * 20_000).to_le_bytes();
        let state = [0x5D, 0x6D, 0xFD][(cycle / 10 % 3) as usize];
        let [low, high, sub, number] =
            [cycle, cycle >> 8, cycle >> 16, cycle << 2 | 2].map(|part| part as u8);
        let mut frames = vec![
            frame(1, 240, &[&[0x01, 255, 240, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0][..], &time].concat()),
            frame(2, 240, &[0x03, node, 240, 0, 1, 0, 0, 0, 2, 0, low, high]),
            frame(2, node, &[0x04, 255, node, state, 1, 0, 0, 0, 2, 0, high, low]),
            frame(3, 240, &[0x05, 255, 240, state, 0, 0, 0xFF, 240, 0x20]),
            // ReadByIndex, and its abort.
            frame(
                4,
                240,
                &[0x06, node, 240, 5, 2, number, 0, 0, 0, low, 0, 2, 4, 0, 0, 0, low, high, sub, 0],
            ),
            frame(3, 240, &[0x05, 255, 240, state, 0, 0, 0xFF, node, 0x20]),
            frame(
                4,
                node,
                &[0x06, 240, node, 5, number, number, 0, 0, 0, low, 0xC0, 2, 4, 0, 0, 0, 0, 0, 2, 6],
            ),
            // IPv4.
            frame(4, low, &[0; 46]),
        ];
        frames[7][12..14].copy_from_slice(&[0x08, 0x00]);
        match cycle % 7 {
            0 => drop(frames.remove(2)),
            1 => frames[1].truncate(20),
            2 => frames[2][11] = low,
            3 => frames[2][16] = 0x20 | low & 0x0F,
            _ => {}
        }
        frames
    })
}

/// What was needed, and the last summary.
struct Watched {
    peak: usize,
    summary: serde_json::Value,
}

/// A process of its own watches a full bus for a time.
fn watch(slaves: u8, span: &str) -> Watched {
    let path = format!("{}/full-{slaves}-{span}.toml", env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(&path, scenario(slaves)).unwrap();
    measure(&format!("sim:{path}"), span)
}

fn measure(endpoint: &str, span: &str) -> Watched {
    let child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "the_process_that_is_measured", "--ignored", "--nocapture"])
        .env("DEVICENET_ARGUMENTS", format!("monitor {endpoint} --json --for {span} --interval {span}"))
        .stderr(Stdio::piped())
        .output()
        .unwrap();
    let (out, err) = (String::from_utf8(child.stdout).unwrap(), String::from_utf8(child.stderr).unwrap());
    let last = out.lines().rfind(|line| line.contains("\"last\":true")).unwrap();
    let summary = serde_json::from_str(last).unwrap();
    Watched { peak: peak(&err), summary }
}

/// The last words of the process that is measured.
fn peak(err: &str) -> usize {
    let peak = err.lines().find_map(|line| line.strip_prefix("peak ")).unwrap_or_else(|| panic!("{err}"));
    peak.parse().unwrap()
}

#[test]
#[ignore = "is called by the others"]
fn the_process_that_is_measured() {
    let Ok(arguments) = std::env::var("DEVICENET_ARGUMENTS") else { return };
    let command = core::iter::once("devicenet").chain(arguments.split(' '));
    devicenet_cli::run(&Cli::parse_from(command)).unwrap();
    eprintln!("peak {}", MEMORY.peak_usage());
}

/// A master that polls its slaves without a pause: the bus is never idle.
fn scenario(slaves: u8) -> String {
    let mut text = String::from("[bus]\nbit_rate = 125_000\nduration = \"24h\"\n");
    for mac in 1..=slaves {
        let identity = format!(
            "{{ vendor = 0x1234, device_type = 0, product = 1, revision = [1, 1], serial = {mac}, name = \"slave {mac}\" }}"
        );
        writeln!(
            text,
            "[[node]]\nname = \"slave-{mac}\"\nprotocol = \"devicenet\"\nrole = \"slave\"\nmac = {mac}\n\
             identity = {identity}\npoll = {{ produce = 2, consume = 2 }}"
        )
        .unwrap();
    }
    text += "[[node]]\nname = \"scanner\"\nprotocol = \"devicenet\"\nrole = \"master\"\nmac = 0\ninterscan_delay = \"0s\"\n\
             identity = { vendor = 0x1234, device_type = 12, product = 2, revision = [1, 1], serial = 99, name = \"scanner\" }\n";
    for mac in 1..=slaves {
        writeln!(
            text,
            "[[node.scan]]\nmac = {mac}\npoll = {{ produce = 2, consume = 2 }}\nepr = \"200ms\"\noutput = \"0102\""
        )
        .unwrap();
    }
    text
}

/// Bytes.
const SLACK: usize = 2048;
/// Times and counts in a summary of some hundred lines, in bytes.
const LONGER_NUMBERS: usize = 16 * 1024;
