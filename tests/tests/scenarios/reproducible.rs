//! The same scenario and seed give the same bytes; where chance has a part, another seed gives others.

use devicenet_cli::simulate::{self, Settings};

use crate::{scenario, traced_text};

fn trace(name: &str, seed: u64) -> String {
    simulate::trace(&scenario(name), Settings { seed: Some(seed), until: None }).0
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    for name in ["bus-off-boi-1", "segments-joined", "duplicate-3-at-once"] {
        assert_eq!(trace(name, 7), trace(name, 7), "{name}");
    }
}

/// The built-in plant, which the first command of the README shows.
#[test]
fn the_trace_of_the_built_in_plant() {
    let (trace, _) = traced_text("plant", simulate::PLANT);
    insta::with_settings!({
        description => "nine acts, each with its heading; what to look for is what the heading says",
        omit_expression => true,
        prepend_module_to_snapshot => false,
    }, {
        insta::assert_snapshot!("plant", trace);
    });
}

#[test]
fn another_seed_gives_other_bit_errors() {
    assert_ne!(trace("bus-off-boi-1", 1), trace("bus-off-boi-1", 2));
}

#[test]
fn without_chance_the_seed_does_not_matter() {
    assert_eq!(trace("duplicate-at-once", 1), trace("duplicate-at-once", 2));
}
