//! The same scenario and seed give the same bytes; where chance has a part, another seed gives others.

use devicenet_cli::simulate::{self, Settings};

use crate::scenario;

fn trace(name: &str, seed: u64) -> String {
    simulate::trace(&scenario(name), Settings { seed: Some(seed), until: None }).0
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    for name in ["bus-off-boi-1", "segments-joined", "duplicate-3-at-once"] {
        assert_eq!(trace(name, 7), trace(name, 7), "{name}");
    }
}

#[test]
fn another_seed_gives_other_bit_errors() {
    assert_ne!(trace("bus-off-boi-1", 1), trace("bus-off-boi-1", 2));
}

#[test]
fn without_chance_the_seed_does_not_matter() {
    assert_eq!(trace("duplicate-at-once", 1), trace("duplicate-at-once", 2));
}
