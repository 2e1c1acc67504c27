//! Prints the tables of `docs/results.md` about a line of 63 slaves: the scan cycle, and the time from power-up to I/O.
//!
//! `cargo run --release -p devicenet-tests --example line-figures`

use devicenet_tests::line::{bring_up_table, bring_ups, scan_cycles, scan_table};

fn main() {
    println!("{}", scan_table(&scan_cycles()));
    print!("{}", bring_up_table(&bring_ups()));
}
