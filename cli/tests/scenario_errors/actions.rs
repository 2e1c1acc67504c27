//! Actions, and to whom they can be done.

use crate::{TOOL, VALVE, refused};

#[test]
fn actions_and_whom_they_can_be_done_to() {
    refused(
        VALVE,
        r#"[[action]]
at = "1s"
node = "vavle"
do = "cut""#,
        "10:8: there is no node `vavle`; expected `valve`",
    );
    refused(
        VALVE,
        r#"[[action]]
at = "11s"
node = "valve"
do = "cut""#,
        "9:6: `at` is 11s, after the end of the run; expected at most the duration, 10s",
    );
    refused(
        VALVE,
        r#"[[action]]
at = "1s"
node = "valve"
do = "cutt""#,
        "11:6: there is no action `cutt`; expected `cut`, `plug`, `power_off`, `power_on`, `power_cycle`, `set_mac`, `set_oa`, `readdress`, `set_bit_rate`, `reset`, `set_input`, `set_output`, `go_run`, `go_idle`, `claim`, `release`, `who`, `identify` or `recover`",
    );
    refused(
        VALVE,
        r#"[[action]]
at = "1s"
node = "valve"
do = "set_input"
value = "01""#,
        "11:6: `set_input` cannot be done to `valve`, whose role is `access`; expected a node with the role `slave` or `device`",
    );
    refused(
        VALVE,
        r#"[[action]]
at = "1s"
node = "valve"
do = "cut"
value = 1"#,
        "12:9: `cut` takes no `value`",
    );
    refused(
        VALVE,
        r#"[[action]]
at = "1s"
node = "valve"
do = "set_mac""#,
        "8:1: `value`, the MAC ID, is missing",
    );
    refused(
        VALVE,
        r#"[[action]]
at = "1s"
node = "valve"
do = "set_mac"
value = "x""#,
        "12:9: `value` is a string; expected the MAC ID, a number",
    );
    refused(
        TOOL,
        r#"[[action]]
at = "1s"
node = "tool"
do = "set_mac"
value = 3"#,
        "8:6: `set_mac` cannot be done to `tool`, whose role is `external`; expected a node with the role `access`, `slave`, `master` or `tool`",
    );
}

/// A list of many names helps nobody.
#[test]
fn a_node_that_is_not_among_many() {
    let many = format!("{VALVE}count = 63\n");
    let cut = |node: &str| format!("[[action]]\nat = \"1s\"\nnode = \"{node}\"\ndo = \"cut\"");
    refused(
        &many,
        &cut("valve-7"),
        "11:8: there is no node `valve-7`; expected `valve-07` perhaps, or another `name` of a [[node]]",
    );
    refused(&many, &cut("pump"), "11:8: there is no node `pump`; expected a `name` of a [[node]]");
}
