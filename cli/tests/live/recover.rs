//! `recover`: the second of two devices fresh from the factory has fallen silent.

use crate::{Run, devicenet};

fn recover(more: &[&str]) -> Run {
    devicenet(&[&["recover", "sim:twins.toml", "--listen", "6s"], more].concat())
}

#[test]
fn the_silent_one_is_found() {
    let run = recover(&[]);
    assert_eq!((run.out().as_str(), run.code()), ("faulted  0x1234:0x00002347\n", 0), "{}", run.err());
    assert!(run.err().contains("note: 1 faulted node; --identify"), "{}", run.err());
}

#[test]
fn it_is_given_the_next_free_mac_id() {
    let run = recover(&["--assign-free"]);
    let out = "faulted  0x1234:0x00002347\nrecovered  0x1234:0x00002347  is on line as node 2\n";
    assert_eq!((run.out().as_str(), run.code()), (out, 0), "MAC ID 1 is in use: {}", run.err());
}

#[test]
fn it_is_given_the_mac_id_that_is_said() {
    let run = recover(&["--assign", "0x1234:9031=12", "--json"]);
    let events = run.json();
    assert_eq!((events.len(), run.code()), (2, 0), "{}", run.out());
    assert_eq!((&events[1]["event"], &events[1]["mac"]), (&"recovered".into(), &12.into()));
    let run = recover(&["--assign", "0x1234:0x2347=1"]);
    assert!(
        run.out().ends_with("not recovered  0x1234:0x00002347  as node 1: another node has it\n"),
        "{}",
        run.out()
    );
    assert_eq!(run.code(), 1);
}

#[test]
fn a_device_that_is_not_there_does_not_react() {
    let run = recover(&["--assign", "1:1=9"]);
    assert!(
        run.out().ends_with("not recovered  0x0001:0x00000001  as node 9: it does not react\n"),
        "{}",
        run.out()
    );
    assert_eq!(run.code(), 1);
}

#[test]
fn one_flashes() {
    let run = recover(&["--identify", "0x1234:0x2347"]);
    assert_eq!(
        (run.out().as_str(), run.code()),
        ("faulted  0x1234:0x00002347\nflashing  0x1234:0x00002347\n", 0)
    );
}

#[test]
fn a_healthy_line_has_nobody_to_recover() {
    let run = devicenet(&["recover", "sim:two.toml", "--listen", "3s"]);
    assert_eq!((run.out().as_str(), run.code()), ("", 0));
    let note = "no node waits for a MAC ID, or none answered: one without the offline connection set cannot be found so";
    assert!(run.err().contains(note), "{}", run.err());
}

#[test]
fn who_is_not_there_is_not_said_to_flash() {
    let run = devicenet(&["recover", "sim:two.toml", "--listen", "3s", "--identify", "1:1"]);
    let line = "not asked to flash  0x0001:0x00000001: no such node answered to Who\n";
    assert_eq!((run.out().as_str(), run.code()), (line, 1), "{}", run.err());
    let run = recover(&["--identify", "1:1", "--json"]);
    let events = run.json();
    assert_eq!((events[0]["event"].as_str(), run.code()), (Some("found"), 1));
    assert_eq!(events[1]["event"], "not_identified");
    assert_eq!(events[1]["problem"], "no such node answered to Who");
}

#[test]
fn nothing_is_sent_without_permission_or_sense() {
    assert_eq!(devicenet(&["recover", "no-such-can"]).code(), 3);
    assert_eq!(recover(&["--assign", "1:1=62"]).code(), 2, "the command's own MAC ID");
    assert_eq!(recover(&["--assign", "1:1=9", "--assign-free"]).code(), 2);
    assert_eq!(recover(&["--assign", "1:1"]).code(), 2);
}
