//! Scenario files: a bus, its nodes, what happens to them and what is expected, in TOML.
//!
//! `docs/scenarios.md` is the reference of every table and key. A key that means nothing where it stands, a name that
//! nobody has, a number out of range: each is a [`ScenarioError`] with file, line and column.

mod check;
mod diagnostic;
mod model;
mod raw;
mod replay;
mod values;

use std::io::Read as _;
use std::path::Path;

pub use check::LONGEST_RUN;
pub(crate) use check::toml_error;
pub use diagnostic::ScenarioError;
pub use model::{
    AccessNode, Action, Attribute, Bus, ConnectionName, ConnectionStateName, DeviceNode, DeviceStateName, Do,
    EventName, Expectation, Fault, FaultKind, Kind, ManagerNode, MasterNode, ModeName, NexConnection,
    NexNode, Node, NodeIndex, Note, Output, Pattern, Planned, PlannedIo, Protocol, Recorded, Role,
    ScannedSlave, Scenario, Sizes, SlaveNode, SlaveStateName, StateName, WatchdogName, What, When, Write,
};
pub use values::{Comparison, Relation, Time, TimeError, TimeRange};

impl Scenario {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// The first defect of the file, or that it cannot be read.
    pub fn load(path: &Path) -> Result<Self, ScenarioError> {
        Self::from_bytes(&path.display().to_string(), std::fs::read(path), path.parent())
    }

    /// Reads and checks standard input. Recordings that it names are looked for in the current folder.
    ///
    /// # Errors
    /// The first defect of the text, or that it cannot be read.
    pub fn from_stdin() -> Result<Self, ScenarioError> {
        Self::from_bytes(STANDARD_INPUT, standard_input(), None)
    }

    fn from_bytes(
        name: &str,
        bytes: std::io::Result<Vec<u8>>,
        folder: Option<&Path>,
    ) -> Result<Self, ScenarioError> {
        let text = toml_text(name, "scenario", bytes)?;
        Self::parse(name, &text, folder.unwrap_or(Path::new("")))
    }

    /// Reads and checks a text. `file` is its name in errors; recordings that it names are looked for in `folder`.
    ///
    /// # Errors
    /// The first defect of the text.
    ///
    /// ```
    /// use devicenet_cli::scenario::Scenario;
    /// let error = Scenario::parse("a.toml", "[bus]\nbit_rate = 125", "".as_ref()).unwrap_err();
    /// assert_eq!((error.line, error.column), (2, 12));
    /// ```
    pub fn parse(file: &str, text: &str, folder: &Path) -> Result<Self, ScenarioError> {
        check::scenario(file, text, folder)
    }
}

/// The name of standard input in errors.
pub(crate) const STANDARD_INPUT: &str = "(standard input)";

/// All of standard input.
pub(crate) fn standard_input() -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    std::io::stdin().lock().read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of a file that was read, a `what`.
///
/// # Errors
/// It could not be read, or is no text.
pub(crate) fn toml_text(
    name: &str,
    what: &str,
    bytes: std::io::Result<Vec<u8>>,
) -> Result<String, ScenarioError> {
    let bytes =
        bytes.map_err(|error| ScenarioError::of_file(name, format!("the {what} cannot be read: {error}")))?;
    String::from_utf8(bytes).map_err(|error| {
        let valid =
            String::from_utf8_lossy(&error.as_bytes()[..error.utf8_error().valid_up_to()]).into_owned();
        ScenarioError::at(
            name,
            &valid,
            &(valid.len()..valid.len()),
            "this is not UTF-8; expected a TOML text",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::raw::{
        RawAction, RawBus, RawExpect, RawFault, RawIdentity, RawIo, RawKey, RawNode, RawNote, RawPlanned,
        RawPlannedIo, RawRead, RawScan, RawWrite, Table,
    };
    use super::*;

    /// The reference of scenario files.
    const PAGE: &str = include_str!("../../../docs/scenarios.md");

    #[track_caller]
    fn named(section: &str, names: &[&str]) {
        let section = PAGE.split(&format!("\n## {section}\n")).nth(1).unwrap();
        let own = section.split("\n## ").next().unwrap();
        for name in names {
            let is_in = own.contains(&format!("`{name}`")) || own.contains(&format!("`{name} = "));
            assert!(is_in, "`{name}` is missing in docs/scenarios.md, {section}");
        }
    }

    #[test]
    fn the_reference_names_every_key_and_every_value() {
        named("`[bus]`", RawBus::KEYS);
        named("`[[node]]`", RawNode::KEYS);
        named("`[[node]]`", RawIdentity::KEYS);
        named("`[[node]]`", RawScan::KEYS);
        for inner in [RawIo::KEYS, RawKey::KEYS, RawWrite::KEYS] {
            let section = PAGE.split("\n### Slaves\n").nth(1).unwrap();
            assert!(inner.iter().all(|key| section.contains(&format!("{key} = "))), "{inner:?}");
        }
        named("`[[node]]`", RawPlanned::KEYS);
        for inner in [RawPlannedIo::KEYS, RawRead::KEYS] {
            let section = PAGE.split("\n### Network managers\n").nth(1).unwrap();
            assert!(inner.iter().all(|key| section.contains(&format!("{key} = "))), "{inner:?}");
        }
        named("`[[node]]`", &NexConnection::ALL.iter().map(|name| name.name()).collect::<Vec<_>>());
        named("`[[node]]`", &WatchdogName::ALL.iter().map(|name| name.name()).collect::<Vec<_>>());
        named("`[[node]]`", check::ROLES);
        named("`[[action]]`", RawAction::KEYS);
        named("`[[action]]`", check::ACTIONS);
        named("`[[fault]]`", RawFault::KEYS);
        named("`[[fault]]`", check::FAULTS);
        named("`[[expect]]`", RawExpect::KEYS);
        named("`[[expect]]`", &StateName::ALL.iter().map(|state| state.name()).collect::<Vec<_>>());
        named("`[[expect]]`", &ConnectionName::ALL.iter().map(|name| name.name()).collect::<Vec<_>>());
        named("`[[expect]]`", &ConnectionStateName::ALL.iter().map(|state| state.name()).collect::<Vec<_>>());
        named("`[[expect]]`", &ModeName::ALL.iter().map(|mode| mode.name()).collect::<Vec<_>>());
        named("`[[expect]]`", &DeviceStateName::ALL.iter().map(|state| state.name()).collect::<Vec<_>>());
        named("`[[expect]]`", &SlaveStateName::ALL.iter().map(|state| state.name()).collect::<Vec<_>>());
        named("`[[expect]]`", &EventName::ALL.iter().map(|event| event.name()).collect::<Vec<_>>());
        named("`[[note]]`", RawNote::KEYS);
    }

    #[test]
    fn the_examples_of_the_reference_are_a_scenario_that_holds() {
        let blocks = PAGE.split("```toml\n").skip(1).filter_map(|block| block.split("```").next());
        let text: String = blocks.collect();
        let scenario = Scenario::parse("docs/scenarios.md", &text, Path::new("")).unwrap();
        let outcome = crate::simulate::outcome(&scenario, crate::simulate::Settings::default());
        assert_eq!((outcome.verdict.held, outcome.verdict.failures), (15, Vec::new()));
    }
}
