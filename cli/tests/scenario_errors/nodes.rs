//! Nodes, by role.

use crate::{BUS, TOOL, refused};

#[test]
fn names_and_roles() {
    refused(
        BUS,
        r#"[[node]]
role = "access""#,
        "2:1: `name` of the node is missing",
    );
    refused(
        BUS,
        r#"[[node]]
name = "a b"
role = "listener""#,
        r#"3:8: the name is "a b"; expected one or more characters without spaces"#,
    );
    refused(
        BUS,
        r#"[[node]]
name = "a""#,
        "2:1: `role` of the node is missing",
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "spy""#,
        "4:8: there is no role `spy`; expected `access`, `slave`, `master`, `tool`, `device`, `manager`, `replay`, `listener`, `babbler` or `external`",
    );
    refused(
        TOOL,
        r#"[[node]]
name = "tool"
role = "listener""#,
        "6:8: there are two nodes `tool`; expected a name of its own for each",
    );
}

#[test]
fn network_access() {
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "access""#,
        r#"2:1: `protocol = "devicenet"` of the node is missing"#,
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "access"
protocol = "devicenex""#,
        "5:12: the role `access` is not one of devicenex; expected `devicenet`",
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "access"
protocol = "devicenet""#,
        "2:1: `mac`, the MAC ID of the node, is missing",
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "access"
protocol = "devicenet"
mac = 64"#,
        "6:7: `mac` is 64; expected a MAC ID, 0 to 63",
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "access"
protocol = "devicenet"
mac = "ten""#,
        r#"6:7: invalid type: string "ten", expected a whole number"#,
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "access"
protocol = "devicenet"
mac = 63"#,
        "2:1: `identity = { vendor = .., serial = .. }` of the node is missing",
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "access"
protocol = "devicenet"
mac = 63
identity = { vendor = 1 }"#,
        "7:12: `serial` of the identity is missing",
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "access"
protocol = "devicenet"
mac = 63
identity = { vendor = 0x10000, serial = 1 }"#,
        "7:23: `vendor` is 65536; expected a Vendor ID, 0 to 0xFFFF",
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "access"
protocol = "devicenet"
mac = 63
poll = { produce = 1 }"#,
        "7:8: `poll` means nothing for the role `access`; expected `name`, `count`, `role`, `power_up`, `reaction`, `bit_rate`, `clock_ppm`, `protocol`, `mac`, `identity`, `port`, `boi`, `quick_connect`, `offline_set` or `switches`",
    );
}

#[test]
fn times_and_rates() {
    refused(
        TOOL,
        r#"power_up = "-3s""#,
        r#"5:12: `-3s` must not be negative; expected a time with a unit (ns, us, ms, s, min, h) such as "75ms" or "1.5s""#,
    );
    refused(
        TOOL,
        r#"bit_rate = "auto""#,
        r#"5:12: `bit_rate` is "auto", and only a slave or a device detects the bit rate; expected a rate in bit/s"#,
    );
    refused(
        TOOL,
        r#"reaction = { min = "2ms", max = "1ms" }"#,
        "5:12: the range begins at 2ms and ends at 1ms before that",
    );
    refused(TOOL, r#"reaction = { min = "2ms" }"#, "5:12: missing field `max`");
    refused(
        TOOL,
        "reaction = 3",
        r#"5:12: invalid type: integer `3`, expected a time with a unit (ns, us, ms, s, min, h) such as "75ms" or "1.5s", or a range such as { min = "1ms", max = "2ms" }"#,
    );
}

#[test]
fn keys_of_another_role() {
    refused(
        TOOL,
        r#"protocol = "devicenet""#,
        r#"5:12: `protocol` means nothing for the role `external`; expected `name`, `count`, `role`, `power_up`, `reaction`, `bit_rate` or `clock_ppm`"#,
    );
    refused(
        TOOL,
        "mac = 3",
        "5:7: `mac` means nothing for the role `external`; expected `name`, `count`, `role`, `power_up`, `reaction`, `bit_rate` or `clock_ppm`",
    );
}

#[test]
fn recordings_and_frames() {
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "replay"
log = "(0.0) can0 20000004#0004000000000000""#,
        r#"2:1: nothing of the recording is left to be played; expected a frame"#,
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "replay"
only = [0x456]
log = "(0.0) can0 457#""#,
        r#"5:8: nothing of the recording is left to be played; expected a frame"#,
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "replay""#,
        "2:1: a replay has neither `file` nor `log`; expected one of them",
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "replay"
file = "x.log""#,
        "5:8: the recording folder/x.log cannot be read: No such file or directory (os error 2); expected a candump log",
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "babbler"
frame = "800#""#,
        r#"5:9: `800#` is not a frame; expected one such as "7ED#0A4D341245230000""#,
    );
}

#[test]
fn a_name_is_of_one_node_or_of_all_those_of_a_count() {
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "listener"
[[node]]
name = "a"
role = "listener"
count = 2"#,
        r#"6:8: there are two nodes `a`; expected a name of its own for each"#,
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "listener"
count = 2
[[node]]
name = "a"
role = "listener"
"#,
        r#"7:8: there are two nodes `a`; expected a name of its own for each"#,
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "listener"
count = 2
[[node]]
name = "a"
role = "listener"
count = 10"#,
        r#"7:8: there are two nodes `a`; expected a name of its own for each"#,
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "listener"
count = 2
[[node]]
name = "a-1"
role = "listener"
count = 2"#,
        r#"7:8: there are two nodes `a-1`; expected a name of its own for each"#,
    );
    refused(
        BUS,
        r#"[[node]]
name = "a-2"
role = "listener"
[[node]]
name = "a"
role = "listener"
count = 2"#,
        r#"6:8: there are two nodes `a-2`; expected a name of its own for each"#,
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "listener"
count = 128"#,
        r#"5:9: `count` is 128; expected a number of nodes, 1 to 127"#,
    );
}

#[test]
fn serial_numbers_rise_within_their_range() {
    refused(
        BUS,
        r#"[[node]]
name = "a"
count = 3
protocol = "devicenet"
role = "access"
mac = 1
identity = { vendor = 1, serial = 0xFFFF_FFFE }"#,
        r#"8:12: the serial numbers of 3 nodes rise beyond 0xFFFF_FFFF; expected a lower first"#,
    );
}

#[test]
fn a_scan_list_without_its_master() {
    refused(
        BUS,
        "[[node.scan]]\nmac = 1\n",
        "2:3: `[[node.scan]]` belongs below a `[[node]]`, and there is none before it",
    );
}
