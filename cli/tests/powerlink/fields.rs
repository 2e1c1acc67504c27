//! `docs/json.md` names what the commands print.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::rig::{Cable, NODE_OPERATIONAL, controlled, managing};

#[test]
#[ignore = "needs a namespace"]
fn the_reference_names_every_event_and_every_field() {
    let page = include_str!("../../../docs/json.md");
    let section = page.split("\n## powerlink cn and powerlink mn\n").nth(1).unwrap();
    let named: BTreeSet<&str> = section.split('`').skip(1).step_by(2).collect();
    let cable = Cable::new("fie0", "fie1");
    let (node, mut manager) = (controlled(cable.0, &["--json"]), managing(cable.1, &["--json"]));
    manager.until(NODE_OPERATIONAL);
    manager.until("inputs 050633");
    let ended = [manager.interrupted(), node.interrupted()];
    let lines: Vec<Value> = ended
        .iter()
        .flat_map(|ended| ended.out.lines())
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert!(lines.len() > 30);
    for line in ended.iter().flat_map(|ended| ended.out.lines()) {
        let at = ["{\"t\":", ",\"node\":", ",\"event\":"].map(|key| line.find(key).unwrap());
        let others =
            [",\"text\":", ",\"cause\":", ",\"data\":"].map(|key| line.find(key).unwrap_or(usize::MAX));
        assert!(at[0] == 0 && at[1] < at[2] && others.iter().all(|other| at[2] < *other), "{line}");
    }
    for line in &lines {
        let event = line["event"].as_str().unwrap();
        assert!(named.contains(event), "{event} is missing in docs/json.md");
        for field in line.as_object().unwrap().keys() {
            assert!(named.contains(field.as_str()), "{field} of {event} is missing in docs/json.md");
        }
    }
}
