//! Expectations and notes.

use crate::{BUS, TOOL, VALVE, refused};

#[test]
fn expectations_and_notes() {
    refused(
        VALVE,
        r#"[[expect]]
node = "valve"
state = "online""#,
        "8:1: there is no time; expected one of `by`, `at`, `from` and `to`, `always = true` or `never = true`",
    );
    refused(
        VALVE,
        r#"[[expect]]
by = "1s"
never = true
node = "valve"
state = "online""#,
        "8:1: there are several times; expected one of `by`, `at`, `from` and `to`, `always = true` or `never = true`",
    );
    refused(
        VALVE,
        r#"[[expect]]
by = "1s"
node = "valve""#,
        "8:1: nothing is expected; expected one or more of `state`, `oa`, `tec`, `rec`, `bus_off`, `connection_state`, `mode`, `input`, `output`, `slave_state`, `status`, `device_state` or `event`",
    );
    refused(
        VALVE,
        r#"[[expect]]
by = "1s"
state = "online""#,
        "8:1: `node` is missing; expected whom it is about (only `never` may be about all)",
    );
    refused(
        VALVE,
        r#"[[expect]]
by = "1s"
node = "valve"
state = "up""#,
        "11:9: there is no state `up`; expected `nonexistent`, `sending_dup_mac`, `waiting_dup_mac`, `online` or `comm_fault`",
    );
    refused(
        VALVE,
        r#"[[expect]]
by = "1s"
node = "valve"
tec = "<x""#,
        r#"11:7: `<x` is not a comparison; expected a number, or one with a sign (<, <=, =, !=, >=, >) such as "<128""#,
    );
    refused(
        VALVE,
        r#"[[expect]]
by = "1s"
node = "valve"
connection = "poll""#,
        "8:1: nothing is expected; expected one or more of `state`, `oa`, `tec`, `rec`, `bus_off`, `connection_state`, `mode`, `input`, `output`, `slave_state`, `status`, `device_state` or `event`",
    );
    refused(
        VALVE,
        r#"[[expect]]
at = "1s"
node = "valve"
event = "bus_off""#,
        "11:9: an event lasts no time; expected `by`, `from` and `to`, or `never` instead of `at` or `always`",
    );
    refused(
        TOOL,
        r#"[[expect]]
at = "1s"
node = "tool"
state = "online""#,
        "8:9: `tool` has the role `external` and no state of network access; expected a node with the role `access`, `slave`, `master`, `tool`, `device` or `manager`",
    );
    refused(
        VALVE,
        r#"[[note]]
at = "1s""#,
        "8:1: `text`, the words of the note, is missing",
    );
}

#[test]
fn flags_are_true_or_not_there() {
    refused(
        VALVE,
        r#"[[expect]]
never = false
by = "1s"
node = "valve"
bus_off = true"#,
        r#"9:9: `never` is false, which says nothing; expected `never = true`, or no `never`"#,
    );
    refused(
        VALVE,
        r#"[[expect]]
always = false
by = "1s"
node = "valve"
bus_off = true"#,
        r#"9:10: `always` is false, which says nothing; expected `always = true`, or no `always`"#,
    );
}

#[test]
fn what_can_be_expected_of_a_role() {
    refused(
        TOOL,
        r#"[[expect]]
by = "1s"
node = "tool"
event = "defended""#,
        r#"8:9: `tool` has the role `external` and no event `defended`; expected a node with the role `access`, `slave`, `master`, `tool`, `device` or `manager`"#,
    );
    refused(
        BUS,
        r#"[[node]]
name = "ear"
role = "listener"
[[expect]]
by = "1s"
node = "ear"
event = "sent""#,
        r#"8:9: `ear` has the role `listener` and never sends; expected a node with another role"#,
    );
    refused(
        TOOL,
        r#"[[expect]]
never = true
event = "duplicate_mac_id""#,
        r#"5:1: there is no node of which this could be expected"#,
    );
    refused(
        TOOL,
        r#"[[expect]]
never = true
state = "comm_fault""#,
        r#"5:1: there is no node of which this could be expected"#,
    );
}

#[test]
fn a_time_that_ends_before_it_begins() {
    refused(
        VALVE,
        r#"[[expect]]
from = "2s"
to = "1s"
node = "valve"
bus_off = true"#,
        r#"10:6: `to` is before `from`; expected a later time"#,
    );
}
