//! Scenario files.

use std::collections::HashSet;
use std::path::Path;

use devicenet_cli::scenario::{Scenario, ScenarioError};

/// Reads `data` as a scenario.
pub(super) fn check(data: &[u8]) {
    let Ok(text) = core::str::from_utf8(data) else { return };
    // A replay node may name a recording of the machine, which is not the business of a fuzzer.
    if text.contains("file") {
        return;
    }
    match Scenario::parse(FILE, text, Path::new("")) {
        Ok(scenario) => consistent(&scenario, text),
        Err(error) => placed(&error, text),
    }
}

/// What was accepted refers to itself only, within the time that it has.
fn consistent(scenario: &Scenario, text: &str) {
    assert_eq!(scenario.file, FILE);
    let names: HashSet<_> = scenario.nodes.iter().map(|node| &node.name).collect();
    assert_eq!(names.len(), scenario.nodes.len(), "names are unique");
    assert!(
        !names.is_empty() && !names.iter().any(|name| name.is_empty() || name.contains(char::is_whitespace))
    );
    // A table of the file makes at most as many nodes as there are MAC IDs.
    assert!(scenario.nodes.len() <= 64 * text.matches("node").count());
    for action in &scenario.actions {
        assert!(!action.nodes.is_empty() && action.nodes.iter().all(|node| node.0 < scenario.nodes.len()));
    }
    assert!(scenario.bus.bit_rate.bit_time_nanos().is_some_and(|bit| bit > 0));
    let again = Scenario::parse(FILE, text, Path::new(""));
    assert_eq!(again.as_ref(), Ok(scenario), "the same text is the same scenario");
}

/// The place of a defect lies within the text, or is the file as a whole.
fn placed(error: &ScenarioError, text: &str) {
    let shown = error.to_string();
    assert!(!error.message.is_empty() && shown.starts_with(FILE), "{shown}");
    if error.line == 0 {
        return;
    }
    // The place may be just behind the last character.
    let line = text.split('\n').nth(error.line - 1).unwrap_or_else(|| panic!("no such line: {shown}"));
    assert!((1..=line.chars().count() + 1).contains(&error.column), "no such column: {shown}");
}

const FILE: &str = "fuzz.toml";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scenario_and_one_with_a_defect() {
        check(b"[bus]\n[[node]]\nname = 'a'\nrole = 'listener'\n");
        check("[bus]\nbit_rate = 'ü'\n".as_bytes());
        check(b"[bus]\nbit_rate = 125");
    }
}
