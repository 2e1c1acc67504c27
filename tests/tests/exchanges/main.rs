#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test may panic: that is how it fails"
)]
//! Exchanges of a slave with the rest of the bus, frame by frame: those of `tests/exchanges`, and two that were recorded.

use std::panic::catch_unwind;

mod bus;
mod device;
mod documents;
mod exhaustive;
mod host;
mod log;
mod player;
mod recorded;
mod script;

/// Every line of every exchange was written from CIP Vol. 3, by hand: a failing one means that the code is wrong. The trace
/// has the same in words, with the times of the bus.
#[test]
fn every_exchange_goes_as_it_is_written() {
    let mut failed = Vec::new();
    for (file, exchanges) in script::files() {
        let mut traces = Vec::new();
        for exchange in &exchanges {
            match catch_unwind(|| exchange.play()) {
                Ok(trace) => traces.push(format!("{}\n{trace}", exchange.name)),
                Err(_) => failed.push(format!("{file}: {}", exchange.name)),
            }
        }
        if traces.len() == exchanges.len() {
            insta::with_settings!({ snapshot_suffix => file, prepend_module_to_snapshot => false, omit_expression => true }, {
                insta::assert_snapshot!("trace", traces.join("\n"));
            });
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
