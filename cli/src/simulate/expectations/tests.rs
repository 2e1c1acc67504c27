//! A run of one node, told by hand, against what can be expected of it.

use super::*;
use crate::scenario::EventName;
use std::path::Path;

const NODE: NodeIndex = NodeIndex(0);

fn status(state: StateName) -> Status {
    Status { state: Some(state), ..Status::default() }
}

/// Nonexistent, at 1 s sending, at 2 s waiting for no time and on line, at 5 s bus-off, at 6 s the end.
#[track_caller]
fn judge(expectation: &str) -> Result<(), String> {
    judge_of("", expectation)
}

#[track_caller]
fn judge_of(bus: &str, expectation: &str) -> Result<(), String> {
    let bus = if bus.is_empty() { String::new() } else { format!("{bus}\n") };
    let text = format!(
        "[bus]\n{bus}[[node]]\nname = \"valve\"\nprotocol = \"devicenet\"\nrole = \"access\"\nmac = 1\n\
         identity = {{ vendor = 1, serial = 1 }}\n[[expect]]\nnode = \"valve\"\n{expectation}"
    );
    let scenario = Scenario::parse("s.toml", &text, Path::new("")).unwrap();
    let mut judge = Judge::new(&scenario, |_| status(StateName::Nonexistent));
    judge.changed(Instant::from_millis(1_000), NODE, status(StateName::SendingDupMac));
    judge.changed(Instant::from_millis(2_000), NODE, status(StateName::WaitingDupMac));
    judge.happened(Instant::from_millis(2_000), NODE, EventName::Sent);
    judge.changed(Instant::from_millis(2_000), NODE, status(StateName::OnLine));
    let off = Status { tec: 256, bus_off: true, ..status(StateName::CommFault) };
    judge.changed(Instant::from_millis(5_000), NODE, off);
    judge.happened(Instant::from_millis(5_000), NODE, EventName::BusOff);
    let verdict = judge.finish(Instant::from_millis(6_000));
    match (verdict.failures.as_slice(), verdict.held, verdict.unjudged) {
        ([], 1, 0) => Ok(()),
        ([], 0, 1) => Err("unjudged".to_owned()),
        ([failure], 0, 0) => Err(failure.to_string()),
        other => panic!("{other:?}"),
    }
}

#[track_caller]
fn fails(expectation: &str, found: &str) {
    let text = judge(expectation).unwrap_err();
    assert_eq!(text, format!("line 8: valve: expected {found}"));
}

#[test]
fn by_a_time() {
    assert_eq!(judge("by = \"2s\"\nstate = \"online\""), Ok(()));
    fails(
        "by = \"1.9s\"\nstate = \"online\"",
        "online by 1.9s; found sending_dup_mac since 1s; it came at 2s",
    );
    fails(
        "from = \"5.5s\"\nto = \"5.6s\"\nstate = \"online\"",
        "online from 5.5s to 5.6s; found comm_fault since 5.5s; it never came after",
    );
    assert_eq!(judge("by = \"9s\"\nstate = \"online\""), Ok(()));
    assert_eq!(judge("by = \"9s\"\ntec = 7"), Err("unjudged".to_owned()));
}

#[test]
fn what_lasts_no_time_is_seen_too() {
    assert_eq!(judge("by = \"3s\"\nstate = \"waiting_dup_mac\""), Ok(()));
    fails("never = true\nstate = \"waiting_dup_mac\"", "never waiting_dup_mac; found waiting_dup_mac at 2s");
}

#[test]
fn at_a_time_the_last_change_counts() {
    assert_eq!(judge("at = \"2s\"\nstate = \"online\""), Ok(()));
    fails("at = \"2s\"\nstate = \"waiting_dup_mac\"", "waiting_dup_mac at 2s; found online since 2s");
    assert_eq!(judge("at = \"6s\"\nbus_off = true"), Ok(()));
    assert_eq!(judge("at = \"7s\"\nbus_off = true"), Err("unjudged".to_owned()));
}

#[test]
fn always_and_never() {
    assert_eq!(judge("always = true\nfrom = \"2s\"\nto = \"4s\"\nstate = \"online\""), Ok(()));
    fails(
        "always = true\nfrom = \"2s\"\nto = \"5s\"\nstate = \"online\"",
        "always online from 2s to 5s; found comm_fault at 5s",
    );
    assert_eq!(judge("never = true\nto = \"4.9s\"\nbus_off = true"), Ok(()));
    fails("never = true\ntec = \">255\"", "never TEC > 255; found TEC 256 at 5s");
}

#[test]
fn all_of_it_at_the_same_moment() {
    fails(
        "by = \"6s\"\nstate = \"online\"\nbus_off = true",
        "online and bus-off by 6s; found comm_fault, bus-off since 5s; it never came after",
    );
}

/// It is on line at 2 s, and lasts to the end of the run at 6 s, four seconds before that of the scenario.
#[test]
fn without_to_it_is_the_end_of_the_run() {
    assert_eq!(judge("never = true\nevent = \"defended\""), Ok(()));
    assert_eq!(judge("never = true\nfrom = \"6s\"\nstate = \"online\""), Ok(()));
    assert_eq!(judge("never = true\nfrom = \"7s\"\nstate = \"online\""), Err("unjudged".to_owned()));
    assert_eq!(judge("always = true\nfrom = \"5s\"\nbus_off = true"), Ok(()));
    fails(
        "always = true\nfrom = \"2s\"\nstate = \"online\"",
        "always online from 2s on; found comm_fault at 5s",
    );
    assert_eq!(judge("from = \"5s\"\nbus_off = true"), Ok(()));
    assert_eq!(judge("from = \"5s\"\nstate = \"online\""), Err("unjudged".to_owned()));
}

/// The run goes on after the end of the scenario, here at 3 s.
#[test]
fn a_longer_run_is_looked_at_to_its_end() {
    let judge = |expectation: &str| judge_of("duration = \"3s\"", expectation);
    assert_eq!(
        judge("never = true\nbus_off = true").unwrap_err(),
        "line 9: valve: expected never bus-off; found bus-off at 5s"
    );
    assert_eq!(
        judge("always = true\nfrom = \"2s\"\nstate = \"online\"").unwrap_err(),
        "line 9: valve: expected always online from 2s on; found comm_fault at 5s"
    );
    assert_eq!(judge("from = \"3s\"\nbus_off = true"), Ok(()));
    assert_eq!(
        judge("from = \"3s\"\ntec = 7").unwrap_err(),
        "line 9: valve: expected TEC = 7 from 3s on; found TEC 256 since 5s; it never came after"
    );
    assert_eq!(judge("never = true\nto = \"3s\"\nbus_off = true"), Ok(()));
}

/// At 2 s the node sends, and is on line after everything that happens then.
#[test]
fn an_event_is_looked_at_with_what_the_node_has_become_at_its_time() {
    assert_eq!(judge("by = \"3s\"\nevent = \"sent\"\nstate = \"online\""), Ok(()));
    fails(
        "by = \"3s\"\nevent = \"sent\"\nstate = \"waiting_dup_mac\"",
        "sent and waiting_dup_mac by 3s; found sent at 2s, but online; it never came after",
    );
    assert_eq!(judge("by = \"6s\"\nevent = \"bus_off\"\nstate = \"comm_fault\"\ntec = 256"), Ok(()));
    fails("never = true\nevent = \"sent\"\nstate = \"online\"", "never sent and online; found it at 2s");
    assert_eq!(judge("never = true\nevent = \"sent\"\nstate = \"comm_fault\""), Ok(()));
}

#[test]
fn events() {
    assert_eq!(judge("by = \"5s\"\nevent = \"bus_off\""), Ok(()));
    fails("by = \"4s\"\nevent = \"bus_off\"", "bus_off by 4s; found no bus_off; it came at 5s");
    fails("never = true\nevent = \"bus_off\"", "never bus_off; found it at 5s");
    assert_eq!(judge("never = true\nto = \"6s\"\nevent = \"defended\""), Ok(()));
    assert_eq!(judge("from = \"5s\"\nto = \"6s\"\nevent = \"bus_off\""), Ok(()), "at the first moment too");
}
