//! The tables of `docs/results.md`.

use core::fmt::Write as _;
use core::time::Duration;

use link_core::BitRate;

use super::{BringUp, Line, Plan, Scan};

/// The scan cycles of 63 slaves, by bit rate and reaction time.
///
/// # Panics
/// When a line does not come up.
#[must_use]
pub fn scan_cycles() -> Vec<(Plan, Vec<Scan>)> {
    let plans = RATES.into_iter().flat_map(|bit_rate| {
        [0, 300, 2000].map(|micros| Plan { reaction: Duration::from_micros(micros), ..Plan::new(bit_rate) })
    });
    let measured = plans.map(|plan| {
        let mut line = Line::running(&plan);
        line.forget();
        line.run(Duration::from_millis(300));
        (plan, line.scans())
    });
    measured.collect()
}

/// Their table.
#[must_use]
pub fn scan_table(cycles: &[(Plan, Vec<Scan>)]) -> String {
    let mut table = String::from(
        "| Bit rate | Slaves react in | Frames | Wire time | Scan cycle | Cycle / wire |\n|---|---|---|---|---|---|\n",
    );
    for (plan, scans) in cycles {
        let scan = scans[0];
        let _ = writeln!(
            table,
            "| {} | {} µs | {} | {} | {} | {} |",
            plan.bit_rate,
            plan.reaction.as_micros(),
            scan.frames,
            millis(scan.wire),
            millis(scan.cycle),
            ratio(scan.cycle, scan.wire)
        );
    }
    table
}

/// From power-up to I/O of 63 slaves, by bit rate, interscan delay and reaction time.
///
/// # Panics
/// When a line does not come up.
#[must_use]
pub fn bring_ups() -> Vec<(Plan, BringUp)> {
    let plans = RATES.into_iter().flat_map(|bit_rate| {
        [(0, 0), (0, 300), (10, 0)].map(|(delay, reaction)| Plan {
            interscan_delay: Duration::from_millis(delay),
            reaction: Duration::from_micros(reaction),
            ..Plan::new(bit_rate)
        })
    });
    plans.map(|plan| (plan.clone(), BringUp::of(&plan))).collect()
}

/// Their table.
#[must_use]
pub fn bring_up_table(found: &[(Plan, BringUp)]) -> String {
    let mut table = String::from(
        "| Bit rate | Interscan delay | Slaves react in | Access and explicit frames | Polls meanwhile | \
         All 63 run after | / (2 s + frames) |\n|---|---|---|---|---|---|---|\n",
    );
    for (plan, found) in found {
        let _ = writeln!(
            table,
            "| {} | {} ms | {} µs | {} | {} | {} | {} |",
            plan.bit_rate,
            plan.interscan_delay.as_millis(),
            plan.reaction.as_micros(),
            millis(found.traffic.access + found.traffic.explicit),
            millis(found.traffic.io),
            millis(found.time),
            ratio(found.time, found.least())
        );
    }
    table
}

/// `16.478 ms`: integers are the same on every machine.
fn millis(span: Duration) -> String {
    let micros = span.as_micros();
    format!("{}.{:03} ms", micros / 1000, micros % 1000)
}

/// `1.002`, rounded down.
fn ratio(of: Duration, to: Duration) -> String {
    let thousandths = of.as_nanos() * 1000 / to.as_nanos().max(1);
    format!("{}.{:03}", thousandths / 1000, thousandths % 1000)
}

const RATES: [BitRate; 3] = [BitRate::K125, BitRate::K250, BitRate::K500];
