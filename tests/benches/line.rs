//! How many virtual seconds a second of computing gives with the real machines: a master and 63 slaves that exchange two
//! bytes in each direction by poll, interscan delay 0.
//!
//! A ratio is what counts here, so this prints ratios: `cargo bench -p devicenet-tests --bench line`.
#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::cast_precision_loss,
    clippy::unwrap_used,
    reason = "a benchmark on a host"
)]

use std::time::{Duration, Instant as WallInstant};

use devicenet_tests::line::{Line, Plan};
use link_core::BitRate;
use transport_mock::Ignore;

fn main() {
    println!("| Line | Times real time | Frames/s | ns/frame |");
    println!("|---|---|---|---|");
    for (words, slaves, bit_rate) in [
        ("8 slaves, 500 kbit/s", 8, BitRate::K500),
        ("63 slaves, 500 kbit/s", 63, BitRate::K500),
        ("63 slaves, 125 kbit/s", 63, BitRate::K125),
    ] {
        let mut line = Line::running(&Plan { slaves: 1..=slaves, ..Plan::new(bit_rate) });
        // The fastest of some runs: whatever else the machine does only makes it slower.
        let (mut fastest, mut frames) = (f64::MAX, 0.0);
        for _ in 0..RUNS {
            let counted = |line: &Line| f64::from(line.master().counters().scans) * 2.0 * f64::from(slaves);
            let (before, end) = (counted(&line), line.network.now() + VIRTUAL);
            let started = WallInstant::now();
            line.network.run_until(end, &mut Ignore);
            let spent = started.elapsed().as_secs_f64();
            if spent < fastest {
                (fastest, frames) = (spent, counted(&line) - before);
            }
        }
        println!(
            "| {words} | {:.0} | {:.0} | {:.0} |",
            VIRTUAL.as_secs_f64() / fastest,
            frames / fastest,
            fastest * 1e9 / frames
        );
    }
}

/// How much is simulated in a run.
const VIRTUAL: Duration = Duration::from_secs(2);
/// How often each line is measured.
const RUNS: u32 = 5;
