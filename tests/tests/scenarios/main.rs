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

mod actions_and_faults;
mod duplicate_mac;
mod network_access;
mod reproducible;
mod results;

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
