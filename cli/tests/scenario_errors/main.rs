#![allow(clippy::indexing_slicing, clippy::panic, clippy::unwrap_used, reason = "a test may panic")]
//! Every defect of a scenario is told with line, column, what was found and what was expected.

mod actions;
mod devices;
mod expectations;
mod faults;
mod file;
mod nex;
mod nodes;

use std::path::Path;

use devicenet_cli::scenario::Scenario;

const BUS: &str = "[bus]\n";
/// Seven lines; a table after it begins on line 8.
const VALVE: &str = "[bus]
[[node]]
name = \"valve\"
protocol = \"devicenet\"
role = \"access\"
mac = 10
identity = { vendor = 0x1234, serial = 1 }
";
const TOOL: &str = "[bus]\n[[node]]\nname = \"tool\"\nrole = \"external\"\n";

#[track_caller]
fn refused(before: &str, text: &str, expected: &str) {
    let text = format!("{before}{text}");
    let found = match Scenario::parse("s.toml", &text, Path::new("folder")) {
        Ok(_) => panic!("this has no defect:\n{text}"),
        Err(error) if error.line == 0 => format!("s.toml: {}", error.message),
        Err(error) => format!("{}:{}: {}", error.line, error.column, error.message),
    };
    assert_eq!(found, expected, "\n{text}");
}
