#![allow(clippy::indexing_slicing, clippy::panic, clippy::unwrap_used, reason = "a test may panic")]
//! Every defect of a scenario is told with line, column, what was found and what was expected.

use std::path::Path;

use devicenet_cli::scenario::{Do, Scenario};
use link_core::BitRate;

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

#[test]
fn syntax_types_and_the_bus() {
    refused("", "bus = ", "1:7: string values must be quoted, expected literal string");
    refused(
        "",
        "[buss]",
        "1:2: there is no key `buss`, did you mean `bus`? expected `title`, `bus`, `node`, `action`, `fault`, `expect` or `note`",
    );
    refused(
        BUS,
        "[[node]]\nnaem = 1",
        "3:1: there is no key `naem`, did you mean `name`? expected `name`, `count`, `protocol`, `role`, `mac`, `power_up`, `reaction`, `bit_rate`, `clock_ppm`, `identity`, `port`, `boi`, `quick_connect`, `offline_set`, `file`, `log`, `only`, `frame` or `period`",
    );
    refused(
        TOOL,
        r#"power_upp = 1
[[node]]
name = "b"
role = "babbler""#,
        "5:1: there is no key `power_upp` for the role `external`, did you mean `power_up`? expected `name`, `count`, `protocol`, `role`, `power_up`, `reaction`, `bit_rate` or `clock_ppm`",
    );
    refused(
        TOOL,
        "[[expect]]
whatever = 1",
        "6:1: there is no key `whatever`; expected `by`, `at`, `from`, `to`, `never`, `always`, `node`, `state`, `tec`, `rec`, `bus_off` or `event`",
    );
    refused(
        TOOL,
        r#"power_up = "-3s""#,
        r#"5:12: `-3s` must not be negative; expected a time with a unit (ns, us, ms, s, min, h) such as "75ms" or "1.5s""#,
    );
    refused(BUS, "rate = 1", "2:1: there is no key `rate`; expected `bit_rate`, `seed` or `duration`");
    refused(
        BUS,
        r#"bit_rate = "fast""#,
        r#"2:12: invalid value: string "fast", expected a bit rate in bit/s such as 125_000, or a text such as "125k""#,
    );
    refused(
        BUS,
        "bit_rate = 125",
        "2:12: `bit_rate` is 125; expected a bit rate in bit/s: `10000`, `20000`, `50000`, `100000`, `125000`, `250000`, `500000` or `1000000`",
    );
    refused(
        BUS,
        "duration = 5",
        r#"2:12: invalid type: integer `5`, expected a time with a unit (ns, us, ms, s, min, h) such as "75ms" or "1.5s""#,
    );
    refused(
        BUS,
        r#"duration = "5""#,
        r#"2:12: `5` has no unit; expected a time with a unit (ns, us, ms, s, min, h) such as "75ms" or "1.5s""#,
    );
    refused(
        BUS,
        r#"duration = "5m""#,
        r#"2:12: `5m` has an unknown unit; expected a time with a unit (ns, us, ms, s, min, h) such as "75ms" or "1.5s""#,
    );
    refused(BUS, r#"duration = "0s""#, "2:12: `duration` is 0s; expected more than 0s, at most 86400s");
    refused(BUS, "seed = -1", "2:8: `seed` is -1; expected a number from 0");
    refused("", "", "s.toml: there is no table [bus]; expected [bus] and at least one [[node]]");
    refused(BUS, "", "s.toml: there is no [[node]]; expected at least one");
}

#[test]
fn nodes_and_their_roles() {
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
role = "slave""#,
        "4:8: a slave needs connections and I/O, which are not simulated; expected `access`, `replay`, `listener`, `babbler` or `external` (`access` gets on line and defends its MAC ID)",
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "manager""#,
        "4:8: `manager` is a role of DeviceNeX, which is not simulated; expected `access`, `replay`, `listener`, `babbler` or `external`",
    );
    refused(
        BUS,
        r#"[[node]]
name = "a"
role = "spy""#,
        "4:8: there is no role `spy`; expected `access`, `replay`, `listener`, `babbler` or `external`",
    );
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
        "5:12: `devicenex` is not simulated; expected `devicenet`",
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
        "7:8: `poll` means nothing for the role `access`; expected `name`, `count`, `protocol`, `role`, `power_up`, `reaction`, `bit_rate`, `clock_ppm`, `mac`, `identity`, `port`, `boi`, `quick_connect` or `offline_set`",
    );
    refused(
        TOOL,
        "mac = 3",
        "5:7: `mac` means nothing for the role `external`; expected `name`, `count`, `protocol`, `role`, `power_up`, `reaction`, `bit_rate` or `clock_ppm`",
    );
    refused(
        TOOL,
        r#"bit_rate = "auto""#,
        r#"5:12: `bit_rate` is "auto", and no role detects the bit rate; expected a rate in bit/s"#,
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
    refused(
        TOOL,
        r#"[[node]]
name = "tool"
role = "listener""#,
        "6:8: there are two nodes `tool`; expected a name of its own for each",
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
        "11:6: there is no action `cutt`; expected `cut`, `plug`, `power_off`, `power_on`, `power_cycle`, `set_mac`, `set_bit_rate` or `reset`",
    );
    refused(
        VALVE,
        r#"[[action]]
at = "1s"
node = "valve"
do = "set_input""#,
        "11:6: `set_input` needs a node with I/O, which is not simulated; expected `cut`, `plug`, `power_off`, `power_on`, `power_cycle`, `set_mac`, `set_bit_rate` or `reset`",
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
        "8:6: `set_mac` cannot be done to `tool`, whose role is `external`; expected a node with the role `access`",
    );
}

#[test]
fn faults() {
    refused(
        VALVE,
        r#"[[fault]]
kind = "gremlin""#,
        "9:8: there is no fault `gremlin`; expected `bit_error`, `lost_frame`, `noise`, `babble`, `clock` or `segment`",
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "bit_error""#,
        "8:1: `rate` per bit, or `bit` of one frame, is missing",
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "bit_error"
rate = 2.0"#,
        "10:8: `rate` is 2; expected a probability, 0 to 1",
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "noise"
rate = 0.5"#,
        "10:8: `rate` means nothing for the fault `noise`; expected `from`, `to`, `kind`, `gap`, `length`, `node` or `nodes`",
    );
    refused(
        VALVE,
        r#"[[fault]]
from = "3s"
to = "2s"
kind = "noise""#,
        "10:6: `to` is not after `from`; expected a later time",
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "segment""#,
        "8:1: the fault has neither `node` nor `nodes`; expected whom it is about",
    );
    refused(
        VALVE,
        r#"[[fault]]
kind = "segment"
nodes = ["valve", "pump"]"#,
        "10:19: there is no node `pump`; expected `valve`",
    );
}

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
        "8:1: nothing is expected; expected one or more of `state`, `tec`, `rec`, `bus_off` or `event`",
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
        "11:14: `connection` needs a node with I/O, which is not simulated; expected `state`, `tec`, `rec`, `bus_off` or `event`",
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
        "8:9: `tool` has the role `external` and no state of network access; expected a node with the role `access`",
    );
    refused(
        VALVE,
        r#"[[note]]
at = "1s""#,
        "8:1: `text`, the words of the note, is missing",
    );
}

#[test]
fn the_offending_line_is_shown() {
    let error = Scenario::parse("s.toml", "[bus]\nbit_rate = 125\n", Path::new("")).unwrap_err();
    let shown = error.to_string();
    let (message, excerpt) = shown.split_once('\n').unwrap();
    assert!(message.starts_with("s.toml:2:12: `bit_rate` is 125; expected"), "{message}");
    assert_eq!(excerpt, "  |\n2 | bit_rate = 125\n  |            ^^^");
}

#[test]
fn a_file_that_cannot_be_read_and_one_that_is_not_text() {
    let error = Scenario::load(Path::new("no/such.toml")).unwrap_err();
    assert!(error.to_string().starts_with("no/such.toml: the scenario cannot be read: "), "{error}");
    let path = std::env::temp_dir().join(format!("devicenet-not-utf8-{}.toml", std::process::id()));
    std::fs::write(&path, b"[bus]\nseed = \xff").unwrap();
    let error = Scenario::load(&path).unwrap_err();
    std::fs::remove_file(&path).unwrap();
    assert_eq!((error.line, error.column), (2, 8));
    assert_eq!(error.message, "this is not UTF-8; expected a TOML text");
}

#[test]
fn bit_rates_are_numbers_or_texts() {
    let text = TOOL.replace("[bus]", "[bus]\nbit_rate = \"250k\"")
        + "bit_rate = \"1M\"\n[[action]]\nat = \"1s\"\nnode = \"tool\"\ndo = \"set_bit_rate\"\nvalue = \"500k\"";
    let scenario = Scenario::parse("s.toml", &text, Path::new("")).unwrap();
    assert_eq!((scenario.bus.bit_rate.0, scenario.nodes[0].bit_rate.0), (250_000, 1_000_000));
    assert_eq!(scenario.actions[0].what, Do::SetBitRate(BitRate(500_000)));
}
