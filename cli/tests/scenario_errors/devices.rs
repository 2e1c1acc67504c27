//! Slaves, masters, tools: their tables, what can be done to them, and what can be expected of them.

use crate::refused;

/// Eight lines; a key after it is on line 9.
const SLAVE: &str = "[bus]
[[node]]
name = \"valve\"
protocol = \"devicenet\"
role = \"slave\"
mac = 10
identity = { vendor = 0x1234, serial = 1 }
poll = { produce = 2, consume = 1 }
";
/// Seven lines; a table after it begins on line 8.
const MASTER: &str = "[bus]
[[node]]
name = \"scanner\"
protocol = \"devicenet\"
role = \"master\"
mac = 1
identity = { vendor = 0x1234, serial = 2 }
";
/// Ten lines more than [`MASTER`]: two slaves in the scan list.
const SCAN: &str = "[[node.scan]]
mac = 10
poll = { produce = 2, consume = 1 }
epr = \"75ms\"
[[node.scan]]
mac = 11
bit_strobe = { produce = 1 }
epr = \"75ms\"
output = \"\"
strobe_bit = true
";
/// Seven lines.
const TOOL: &str = "[bus]
[[node]]
name = \"tool\"
protocol = \"devicenet\"
role = \"tool\"
mac = 62
identity = { vendor = 0x9999, serial = 1 }
";

#[test]
fn the_connections_of_a_slave() {
    for (more, expected) in [
        ("poll = { }", "9:1: duplicate key"),
        ("bit_strobe = { }", "9:14: `bit_strobe` has no size; expected `produce` or `consume` in bytes"),
        ("bit_strobe = { produce = 9 }", "9:26: `produce` is 9; expected a number of bytes, 0 to 8"),
        (
            "bit_strobe = { produce = 1, consume = 1 }",
            "9:39: `consume` means nothing for `bit_strobe` of a slave; expected `produce`",
        ),
        ("cos = { produce = 449 }", "9:19: `produce` is 449; expected a number of bytes, 0 to 448"),
        (
            "cos = { produce = 1, epr = \"75ms\" }",
            "9:28: `epr` means nothing for `cos` of a slave; expected `produce` or `consume`",
        ),
        (
            "cos = { produce = 1, consume = 1 }",
            "9:32: what `cos` consumes comes with the poll command; expected `consume` of `poll` only",
        ),
        (
            "cos = { produce = 1 }\ncyclic = { produce = 2 }",
            "10:10: `cyclic` and `cos` are one connection, allocated in two ways; expected the same sizes of both",
        ),
        (
            "cos = { produces = 1 }",
            "9:9: there is no key `produces`, did you mean `produce`? expected `produce`, `consume`, `epr`, `inhibit` or `acknowledged`",
        ),
        ("input = \"01\"", "9:9: `input` has 1 byte; expected 2, as the longest connection produces"),
        ("input = \"0x01\"", "9:9: `input` is `0x01`; expected bytes in hex such as \"01FF\""),
        (
            "unconnected_port = false",
            "9:20: without `unconnected_port` and without `ucmm` nobody can reach the slave; expected one of them",
        ),
        ("heartbeat = \"1.5s\"", "9:13: `heartbeat` is 1.5s; expected whole seconds, 0s (none) to 255s"),
        (
            "run = true",
            "9:7: `run` means nothing for the role `slave`; expected `name`, `count`, `role`, `power_up`, `reaction`, `bit_rate`, `clock_ppm`, `protocol`, `mac`, `identity`, `port`, `boi`, `quick_connect`, `offline_set`, `switches`, `poll`, `bit_strobe`, `cos`, `cyclic`, `multicast_poll`, `input`, `ucmm`, `unconnected_port`, `heartbeat` or `shutdown_message`",
        ),
    ] {
        refused(SLAVE, more, expected);
    }
}

#[test]
fn a_master() {
    for (more, expected) in [
        ("background_ratio = 0", "8:20: `background_ratio` is 0; expected a number of scans, 1 to 65535"),
        (
            "first_contact = \"group3\"",
            "8:17: there is no first_contact `group3`; expected `group2` or `ucmm`",
        ),
        ("replacement = \"yes\"", "8:15: there is no replacement `yes`; expected `off`, `dry_run` or `on`"),
        (
            "multicast_output = \"01\"",
            "8:20: `multicast_output` has 1 byte; expected 0, as the multicast poll of the scan list consumes",
        ),
        ("scan = 3", "8:8: invalid type: integer `3`, expected a sequence"),
    ] {
        refused(MASTER, more, expected);
    }
}

#[test]
fn a_scan_list() {
    for (more, expected) in [
        ("[[node.scan]]", "8:1: `mac`, the MAC ID of the slave, is missing"),
        ("[[node.scan]]\nmac = 1", "9:7: `mac` is 1, the master's own; expected that of a slave"),
        (
            "[[node.scan]]\nmac = 2\n[[node.scan]]\nmac = 2",
            "11:7: MAC ID 2 is in the scan list already; expected one entry for each slave",
        ),
        (
            "[[node.scan]]\nmac = 2\npoll = { produce = 1 }",
            "10:8: `poll` has no expected packet rate; expected `epr = \"75ms\"` here or for the slave",
        ),
        (
            "[[node.scan]]\nmac = 2\npoll = { produce = 1, epr = \"1.5ms\" }",
            "10:29: `epr` is 1.5ms; expected whole milliseconds, 0ms to 65535ms",
        ),
        (
            "[[node.scan]]\nmac = 2\npoll = { produce = 1, inhibit = \"1ms\" }",
            "10:33: `inhibit` means nothing for `poll` of a scan list; expected `produce`, `consume` or `epr`",
        ),
        (
            "[[node.scan]]\nmac = 2\nepr = \"75ms\"\ncos = { produce = 1, inhibit = \"80ms\" }",
            "11:32: `inhibit` is 80ms, longer than `epr`; expected at most 75ms",
        ),
        (
            "[[node.scan]]\nmac = 2\nepr = \"75ms\"\ncos = { produce = 1 }\ncyclic = { produce = 1 }",
            "12:10: there are both `cos` and `cyclic`; expected one of them",
        ),
        (
            "[[node.scan]]\nmac = 2\nepr = \"75ms\"\npoll = { consume = 1 }\ncos = { produce = 1, consume = 1 }",
            "12:32: what `cos` consumes comes with the poll command; expected `consume` of `poll` only",
        ),
        (
            "[[node.scan]]\nmac = 2\nepr = \"75ms\"\npoll = { consume = 1 }\noutput = \"0102\"",
            "12:10: `output` has 2 bytes; expected 1, as the slave consumes",
        ),
        (
            "[[node.scan]]\nmac = 2\nstrobe_bit = true",
            "10:14: `strobe_bit` is for a slave with `bit_strobe`; expected that too",
        ),
        (
            "[[node.scan]]\nmac = 2\nreplaceable = true",
            "10:15: only a slave whose key names vendor and product can be replaced; expected `key = { vendor = .., product = .. }`",
        ),
        (
            "[[node.scan]]\nmac = 2\nkey = { serial = 1 }",
            "10:9: there is no key `serial`; expected `vendor`, `device_type`, `product` or `revision`",
        ),
        (
            "[[node.scan]]\nmac = 2\nkey = { revision = [1, 256] }",
            "10:20: `revision` is out of range; expected [major, minor], 0 to 255 each",
        ),
        (
            "[[node.scan]]\nmac = 2\nconfiguration = [{ class = 4, instance = 199, attribute = 3 }]",
            "10:18: `value`, the bytes that are written, is missing",
        ),
        (
            "[[node.scan]]\nmac = 2\nconfiguration = [{ class = 4, attribute = 3, value = \"01\" }]",
            "10:18: `instance` of the attribute that is written is missing",
        ),
        (
            "[[node.scan]]\nmac = 2\nrate = 3",
            "10:1: there is no key `rate`; expected `mac`, `poll`, `bit_strobe`, `cos`, `cyclic`, `multicast_poll`, `epr`, `key`, `background`, `replaceable`, `output`, `strobe_bit` or `configuration`",
        ),
    ] {
        refused(MASTER, more, expected);
    }
}

#[test]
fn a_configuration_has_room_in_the_master() {
    let line = format!("{{ class = 4, instance = 199, attribute = 3, value = \"{}\" }}", "00".repeat(200));
    refused(
        MASTER,
        &format!("[[node.scan]]\nmac = 2\nconfiguration = [{line}, {line}, {line}]"),
        "10:17: the configuration takes 621 bytes, seven for each line and its value; expected at most 448",
    );
}

#[test]
fn outputs_of_a_master() {
    let set = |value: &str| {
        format!("{SCAN}[[action]]\nat = \"1s\"\nnode = \"scanner\"\ndo = \"set_output\"\n{value}")
    };
    const EXPECTED: &str = "{ slave = \"valve\", data = \"01FF\" }, { slave = \"valve\", strobe_bit = true } or { multicast = \"01FF\" }";
    for (value, expected) in [
        ("", "18:1: `value`, the output data, is missing".to_owned()),
        (
            "value = { slave = 12, data = \"01\" }",
            "22:9: MAC ID 12 is not in the scan list of the master; expected `10` or `11`".to_owned(),
        ),
        (
            "value = { slave = \"scanner\", data = \"01\" }",
            "22:9: MAC ID 1 is not in the scan list of the master; expected `10` or `11`".to_owned(),
        ),
        (
            "value = { slave = \"lamp\", data = \"01\" }",
            "22:9: there is no node `lamp`; expected `scanner`".to_owned(),
        ),
        (
            "value = { slave = 10, data = \"0102\" }",
            "22:9: `value` has 2 bytes; expected 1, as the slave consumes".to_owned(),
        ),
        (
            "value = { slave = 10, strobe_bit = true }",
            "22:9: `strobe_bit` is for a slave with `bit_strobe` in the scan list".to_owned(),
        ),
        (
            "value = { multicast = \"01\" }",
            "22:9: `value` has 1 byte; expected 0, as the multicast poll of the scan list consumes"
                .to_owned(),
        ),
        ("value = { slave = 10 }", format!("22:9: this is no output; expected {EXPECTED}")),
        (
            "value = \"01\"",
            format!("22:9: invalid type: string \"01\", expected a table; expected {EXPECTED}"),
        ),
    ] {
        refused(MASTER, &set(value), &expected);
    }
}

#[test]
fn what_a_tool_recovers() {
    let recover =
        |value: &str| format!("[[action]]\nat = \"1s\"\nnode = \"tool\"\ndo = \"recover\"\n{value}");
    const EXPECTED: &str = "{ node = \"valve\", .. } or { vendor = 0x1234, serial = 0x00002345, .. }";
    for (value, expected) in [
        ("", "8:1: `value`, the device, is missing".to_owned()),
        (
            "value = { node = \"tool\" }",
            "12:9: `mac`, the MAC ID that the device shall have, is missing".to_owned(),
        ),
        ("value = { node = \"tool\", mac = 64 }", "12:9: `mac` is 64; expected a MAC ID, 0 to 63".to_owned()),
        ("value = { node = \"lamp\", mac = 3 }", "12:9: there is no node `lamp`; expected `tool`".to_owned()),
        ("value = { vendor = 1, mac = 3 }", format!("12:9: this is no device; expected {EXPECTED}")),
        (
            "value = { vendor = 65536, serial = 1, mac = 3 }",
            "12:9: `vendor` is 65536; expected a Vendor ID, 0 to 0xFFFF".to_owned(),
        ),
    ] {
        refused(TOOL, &recover(value), &expected);
    }
    refused(
        TOOL,
        "[[action]]\nat = \"1s\"\nnode = \"tool\"\ndo = \"identify\"\nvalue = { node = \"tool\", mac = 3 }",
        "12:9: `identify` takes no `mac`; expected the device only",
    );
    refused(
        TOOL,
        "[[action]]\nat = \"1s\"\nnode = \"tool\"\ndo = \"go_run\"",
        "11:6: `go_run` cannot be done to `tool`, whose role is `tool`; expected a node with the role `master`",
    );
}

#[test]
fn the_input_of_a_slave() {
    let set = |value: &str| format!("[[action]]\nat = \"1s\"\nnode = \"valve\"\ndo = \"set_input\"\n{value}");
    refused(SLAVE, &set(""), "9:1: `value`, the input data in hex, is missing");
    refused(SLAVE, &set("value = 1"), "13:9: `value` is an integer; expected the input data in hex, a text");
    refused(
        SLAVE,
        &set("value = \"01\""),
        "13:9: `value` has 1 byte; expected 2, as the longest connection of the slave produces",
    );
}

#[test]
fn what_can_be_expected_of_a_slave() {
    let expect = |what: &str| format!("[[expect]]\nby = \"1s\"\nnode = \"valve\"\n{what}");
    for (what, expected) in [
        (
            "connection = \"pol\"",
            "12:14: there is no connection `pol`; expected `explicit`, `poll`, `bit_strobe`, `cos`, `cyclic` or `multicast_poll`",
        ),
        (
            "connection_state = \"established\"",
            "12:20: `connection_state` needs `connection`; expected that too",
        ),
        (
            "connection = \"poll\"\nconnection_state = \"up\"",
            "13:20: there is no connection_state `up`; expected `non_existent`, `configuring`, `established`, `timed_out` or `deferred_delete`",
        ),
        (
            "state = \"online\"\nconnection = \"poll\"",
            "13:14: `connection` says nothing alone; expected `connection_state`, `mode`, `input`, `output` or an event of connections too",
        ),
        (
            "mode = \"running\"",
            "12:8: there is no mode `running`; expected `inactive`, `run`, `idle` or `fault`",
        ),
        ("output = \"1\"", "12:10: `output` is `1`; expected bytes in hex such as \"01FF\""),
        (
            "slave = 10\nslave_state = \"running\"",
            "12:9: `slave` needs the `node` of a master; expected that too",
        ),
        (
            "status = 0",
            "12:10: `valve` has the role `slave` and no `status`; expected a node with the role `master`",
        ),
        (
            "event = \"recovered\"",
            "12:9: `valve` has the role `slave` and no event `recovered`; expected a node with the role `tool`",
        ),
    ] {
        refused(SLAVE, &expect(what), expected);
    }
}

#[test]
fn what_can_be_expected_of_a_master() {
    let expect = |what: &str| format!("{SCAN}[[expect]]\nby = \"1s\"\nnode = \"scanner\"\n{what}");
    for (what, expected) in [
        (
            "slave = 12\nslave_state = \"running\"",
            "21:9: MAC ID 12 is not in the scan list of the master; expected `10` or `11`",
        ),
        (
            "slave = true\nslave_state = \"running\"",
            "21:9: invalid type: boolean `true`, expected the name of a slave, or its MAC ID",
        ),
        ("slave_state = \"running\"", "21:15: `slave_state` needs `slave`; expected that too"),
        (
            "slave = 10\nstate = \"online\"",
            "21:9: `slave` says nothing alone; expected `slave_state`, `status`, `input` or an event of slaves too",
        ),
        (
            "slave = 10",
            "18:1: nothing is expected; expected one or more of `state`, `oa`, `tec`, `rec`, `bus_off`, `connection_state`, `mode`, `input`, `output`, `slave_state`, `status`, `device_state` or `event`",
        ),
        (
            "slave = 10\nslave_state = \"up\"",
            "22:15: there is no slave_state `up`; expected `offline`, `waiting`, `contacting`, `configuring` or `running`",
        ),
        ("input = \"01\"", "21:9: the input of a master is that of a slave; expected `slave` too"),
        (
            "mode = \"run\"",
            "21:8: `scanner` has the role `master` and no `mode`; expected a node with the role `slave` or `device`",
        ),
    ] {
        refused(MASTER, &expect(what), expected);
    }
}

/// All slaves of a master get the same multicast poll command.
#[test]
fn a_multicast_poll_has_one_size() {
    let entry = |mac: u8, consume: u8| {
        format!(
            "[[node.scan]]\nmac = {mac}\nepr = \"1s\"\nmulticast_poll = {{ produce = 1, consume = {consume} }}\n"
        )
    };
    refused(
        MASTER,
        &(entry(10, 1) + &entry(11, 2)),
        "15:43: `consume` of `multicast_poll` is 2, and 1 for a slave before; expected the same, since all get one command",
    );
}
