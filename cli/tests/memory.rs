#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]
//! `monitor` on a full bus: memory that does not grow with time.
//!
//! `cargo test --release -p devicenet-cli --test memory -- --ignored --nocapture` watches a whole day.

use std::fmt::Write as _;
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
        .env("DEVICENET_WATCH", format!("{endpoint} {span}"))
        .stderr(Stdio::piped())
        .output()
        .unwrap();
    let (out, err) = (String::from_utf8(child.stdout).unwrap(), String::from_utf8(child.stderr).unwrap());
    let peak = err.lines().find_map(|line| line.strip_prefix("peak ")).unwrap_or_else(|| panic!("{err}"));
    let last = out.lines().rfind(|line| line.contains("\"last\":true")).unwrap();
    let summary = serde_json::from_str(last).unwrap();
    Watched { peak: peak.parse().unwrap(), summary }
}

#[test]
#[ignore = "is called by the others"]
fn the_process_that_is_measured() {
    let Ok(arguments) = std::env::var("DEVICENET_WATCH") else { return };
    let (endpoint, span) = arguments.split_once(' ').unwrap();
    let command = ["devicenet", "monitor", endpoint, "--json", "--for", span, "--interval", span];
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
