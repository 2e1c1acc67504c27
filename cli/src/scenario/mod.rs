//! Scenario files: a bus, its nodes, what happens to them and what is expected, in TOML.
//!
//! Times are texts with a unit (`"300us"`, `"75ms"`, `"1.5s"`, `"2min"`), numbers may be hexadecimal. A time that may be
//! a range (`{ min = "0s", max = "5ms" }`) is drawn from the seed. A key that means nothing where it stands, a name
//! that nobody has, a number out of range: each is a [`ScenarioError`] with file, line and column. Only `[bus]` and one
//! `[[node]]` are required.
//!
//! # `[bus]`
//!
//! | key | value | default |
//! |---|---|---|
//! | `bit_rate` | bit/s, 10 000 to 1 000 000 | 125 000 |
//! | `seed` | of everything random | 1 |
//! | `duration` | how long the scenario runs | `"10s"` |
//!
//! Before it, `title = ".."` says what the scenario shows.
//!
//! # `[[node]]`
//!
//! | key | roles | value | default |
//! |---|---|---|---|
//! | `name` | all | unique, without spaces | required |
//! | `role` | all | `access`, `replay`, `listener`, `babbler`, `external` | required |
//! | `count` | all | so many nodes: `name-1`, `name-2` and so on, with serial numbers that rise; `name` means all | one node |
//! | `power_up` | all | time or range | `"0s"` |
//! | `reaction` | all | time or range from a frame's end to the earliest answer | `"0s"` |
//! | `bit_rate` | all | the node's own switch | that of the bus |
//! | `clock_ppm` | all | how much its clock runs fast, in millionths | 0 |
//! | `protocol` | access | `"devicenet"` | required |
//! | `mac` | access | MAC ID, 0 to 63 | required |
//! | `identity` | access | `{ vendor, serial, device_type, product, revision = [major, minor], name }` | vendor and serial required |
//! | `port` | access | physical port number, 0 to 127 | 0 |
//! | `boi` | access | bus-off interrupt: begin anew after bus-off | false |
//! | `quick_connect` | access | on line with the first check request | false |
//! | `offline_set` | access | can be repaired through the offline connection set | false |
//! | `file` or `log` | replay | a recording, by its path relative to the scenario or in place; its first frame is played at `power_up`, the others at their distances | one required |
//! | `only` | replay | the identifiers to play | all |
//! | `frame` | babbler | as candump writes it, `"7FF#00"` | required |
//! | `period` | babbler | from one to the next | as fast as the bus takes them |
//!
//! The role `access` is a DeviceNet node that performs network access (CIP Vol. 3, chapter 2) and nothing more: it checks
//! for a duplicate MAC ID, gets on line, defends its MAC ID, and obeys the offline connection set when it has it.
//! `listener` is listen-only; `external` is attached from outside, by `devicenet simulate --serve`.
//!
//! # `[[action]]`
//!
//! | key | value |
//! |---|---|
//! | `at` | time |
//! | `node` | name |
//! | `do` | `cut`, `plug`, `power_off`, `power_on`, `power_cycle`, `set_bit_rate`; of access nodes `set_mac`, `reset` |
//! | `value` | for the `set_` actions |
//!
//! # `[[fault]]`
//!
//! | `kind` | keys besides `from` (default the start) and `to` (default the end) |
//! |---|---|
//! | `bit_error` | `rate` per bit, or `bit` (0 is the start of frame) of one `frame` (0 is the next); `node` or `nodes`: only what these hear |
//! | `lost_frame` | `node` or `nodes`, `rate` per frame (default 1), `id`: they miss what all others receive, because they see the last bit but one of the frame wrong, or with `overrun = true` because they are too slow to read it |
//! | `noise` | `length` of a burst, mean `gap` between them; `node` or `nodes`: only what these hear |
//! | `babble` | `pull`, `every`: a transceiver holds the bus dominant, so long and so often; without them for good |
//! | `clock` | `ppm`, `node` or `nodes` |
//! | `segment` | `node` or `nodes`: they are apart from all others; of these faults only one at a time |
//!
//! # `[[expect]]`
//!
//! | when | meaning |
//! |---|---|
//! | `by = T` | at some moment from the start to T |
//! | `at = T` | at T, after everything that happens at T |
//! | `from = T`, `to = T` | at some moment between them, the first after everything that happens at it |
//! | `always = true` | at every moment, of the run or from `from` to `to` |
//! | `never = true` | at no moment, of the run or from `from` to `to` |
//!
//! | what | value |
//! |---|---|
//! | `state` | `nonexistent`, `sending_dup_mac`, `waiting_dup_mac`, `online`, `comm_fault` |
//! | `tec`, `rec` | comparison: `"<128"`, `">=96"`, `0` |
//! | `bus_off` | true or false |
//! | `event` | `sent`, `error_warning`, `error_passive`, `error_active`, `bus_off`, `state_changed`, `defended`, `duplicate_mac_id`, `not_acknowledged`, `mac_id_assigned`: see [`EventName`] |
//!
//! `node` says of whom; with a `count`, it is expected of each. Without it, `never` is of all nodes. What stands in one
//! table is expected at one and the same moment.
//!
//! # `[[note]]`
//!
//! `at` and `text`: a heading in the trace.

mod check;
mod diagnostic;
mod model;
mod raw;
mod replay;
mod values;

use std::path::Path;

pub use diagnostic::ScenarioError;
pub use model::{
    AccessNode, Action, Bus, Do, EventName, Expectation, Fault, FaultKind, Node, NodeIndex, Note, Recorded,
    Role, Scenario, StateName, What, When,
};
pub use values::{Comparison, Relation, Time, TimeError, TimeRange};

impl Scenario {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// The first defect of the file, or that it cannot be read.
    pub fn load(path: &Path) -> Result<Self, ScenarioError> {
        let name = path.display().to_string();
        let bytes = std::fs::read(path).map_err(|error| {
            ScenarioError::of_file(&name, format!("the scenario cannot be read: {error}"))
        })?;
        let text = String::from_utf8(bytes).map_err(|error| {
            let valid =
                String::from_utf8_lossy(&error.as_bytes()[..error.utf8_error().valid_up_to()]).into_owned();
            ScenarioError::at(
                &name,
                &valid,
                &(valid.len()..valid.len()),
                "this is not UTF-8; expected a TOML text",
            )
        })?;
        Self::parse(&name, &text, path.parent().unwrap_or(Path::new("")))
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
