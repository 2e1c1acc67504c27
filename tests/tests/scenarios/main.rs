#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test may panic: that is how it fails"
)]
//! The scenario files of `tests/scenarios`: their expectations hold, and their traces are what they were.

mod actions;
mod devicenex;
mod duplicate_mac;
mod exchange;
mod faults;
mod health;
mod network_access;
mod plant;
mod reproducible;
mod results;
mod roles;

use std::path::Path;

use devicenet_cli::scenario::Scenario;
use devicenet_cli::simulate::{self, Outcome, Settings};

/// A scenario of `tests/scenarios`, by its name without `.toml`.
#[track_caller]
fn scenario(name: &str) -> Scenario {
    let path = devicenet_tests::workspace_root().join("tests/scenarios").join(format!("{name}.toml"));
    Scenario::load(&path).unwrap_or_else(|error| panic!("{error}"))
}

/// Runs it, and returns its trace.
#[track_caller]
fn run(name: &str) -> (String, Outcome) {
    simulate::trace(&scenario(name), Settings::default())
}

/// A valve with MAC ID 10 and a scanner with MAC ID 0, on line after two seconds; ten seconds.
const PAIR: &str = r#"
[bus]
[[node]]
name = "valve"
protocol = "devicenet"
role = "access"
mac = 10
identity = { vendor = 0x1234, serial = 1 }
[[node]]
name = "scanner"
protocol = "devicenet"
role = "access"
mac = 0
identity = { vendor = 0x1234, serial = 2 }
"#;

/// Runs the pair with more around it, and demands that every expectation holds.
#[track_caller]
fn holds(more: &str) -> Outcome {
    let (_, outcome) = traced(more);
    assert!(outcome.verdict.held > 0, "nothing is expected");
    outcome
}

/// As [`holds`], with the trace; nothing need be expected.
#[track_caller]
fn traced(more: &str) -> (String, Outcome) {
    traced_text("pair", &format!("{PAIR}{more}"))
}

/// Runs the scenario in a text, and demands that no expectation fails.
#[track_caller]
fn traced_text(name: &str, text: &str) -> (String, Outcome) {
    let scenario = Scenario::parse(name, text, Path::new("")).unwrap_or_else(|error| panic!("{error}"));
    let (trace, outcome) = simulate::trace(&scenario, Settings::default());
    assert_eq!(outcome.verdict.failures, [], "{trace}");
    (trace, outcome)
}

/// Runs a scenario, demands that its expectations hold, and compares its trace with the snapshot.
macro_rules! trace {
    ($test:ident, $name:literal, $look_for:literal) => {
        #[test]
        fn $test() {
            let (trace, outcome) = crate::run($name);
            assert_eq!(outcome.verdict.failures, [], "{trace}");
            assert!(outcome.verdict.held > 0, "the scenario expects nothing");
            insta::with_settings!({ description => $look_for, omit_expression => true, prepend_module_to_snapshot => false }, {
                insta::assert_snapshot!(concat!("scenario__", $name), trace);
            });
        }
    };
}
pub(crate) use trace;
