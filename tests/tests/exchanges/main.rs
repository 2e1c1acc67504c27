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

mod bench;
mod device;
mod documents;
mod recorded;
mod script;

use script::Exchange;

/// Every line of every exchange was written from CIP Vol. 3, by hand: a failing one means that the code is wrong.
#[test]
fn every_exchange_goes_as_it_is_written() {
    for exchange in script::all() {
        exchange.play();
    }
}

/// The same in words, as the passive decoder has them.
#[test]
fn exchanges_in_words() {
    for (file, exchanges) in script::files() {
        let words: Vec<String> = exchanges.iter().map(Exchange::words).collect();
        insta::with_settings!({ snapshot_suffix => file, prepend_module_to_snapshot => false, omit_expression => true }, {
            insta::assert_snapshot!("words", words.join("\n"));
        });
    }
}
