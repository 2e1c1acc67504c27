//! The scan cycle of 63 slaves with two bytes in each direction, and no interscan delay.
//!
//! Its measure is the exact time that its 126 frames take on the wire, each with the three bits of intermission. Commands
//! are pipelined: while a slave reacts, the next ones are polled, so that of all reactions at most one adds to a scan, that
//! of the slave that answers last. The bus is idle for no more than that and the moment for frames of higher identifiers.

use core::time::Duration;
use std::sync::LazyLock;

use devicenet_tests::line::{Plan, Scan, scan_cycles, scan_table};

static CYCLES: LazyLock<Vec<(Plan, Vec<Scan>)>> = LazyLock::new(scan_cycles);

/// `cycle <= 1.05 x measure` in every scan of slaves that react in this time, at 125, 250 and 500 kbit/s.
#[track_caller]
fn within_five_percent(micros: u64, measure: impl Fn(&Scan) -> Duration) {
    let of_reaction = CYCLES.iter().filter(|(plan, _)| plan.reaction == Duration::from_micros(micros));
    let cycles: Vec<_> = of_reaction.collect();
    assert_eq!(cycles.len(), 3);
    for (plan, scans) in cycles {
        assert!(scans.len() > 2);
        for scan in scans {
            assert!(scan.cycle * 100 <= measure(scan) * 105, "{plan:?}: {scan:?}");
        }
    }
}

#[test]
fn slaves_that_react_at_once_are_scanned_in_the_wire_time_of_their_frames() {
    within_five_percent(0, |scan| scan.wire);
}

#[test]
fn slaves_that_react_in_300_us_are_scanned_in_the_wire_time_and_one_reaction() {
    within_five_percent(300, |scan| scan.wire + Duration::from_micros(300));
}

/// Without pipelining 63 reactions of 2 ms would make 126 ms.
#[test]
fn slow_slaves_do_not_hold_up_each_other() {
    within_five_percent(2000, |scan| scan.wire);
}

#[test]
fn the_bus_is_idle_for_one_reaction_at_most_and_the_moment_for_others() {
    for (plan, scans) in &*CYCLES {
        for scan in scans {
            assert_eq!((scan.frames, scan.other), (126, Duration::ZERO), "{scan:?}");
            assert!(scan.cycle >= scan.wire, "{scan:?}");
            assert!(scan.cycle - scan.wire <= plan.reaction + MOMENT, "{plan:?}: {scan:?}");
            assert_eq!(scan.cycle, scans[0].cycle, "all take the same time");
        }
    }
}

#[test]
fn the_table_of_scan_cycles_is_computed() {
    let table = scan_table(&CYCLES);
    let document = devicenet_tests::read("docs/results.md");
    assert!(document.contains(&table), "docs/results.md should have this table:\n{table}");
}

/// In which frames of higher identifiers can begin, before the next scan does.
const MOMENT: Duration = Duration::from_micros(32);
