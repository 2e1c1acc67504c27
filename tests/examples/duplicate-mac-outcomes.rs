//! Prints the table of `docs/results.md`: what becomes of nodes that are switched on with one MAC ID.
//!
//! `cargo run --release -p devicenet-tests --example duplicate-mac-outcomes`

fn main() {
    print!("{}", devicenet_tests::outcomes::table());
}
