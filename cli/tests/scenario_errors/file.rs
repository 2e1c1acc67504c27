//! The file as a whole, keys that nobody knows, and the bus.

use std::path::Path;

use devicenet_cli::scenario::{Do, Scenario};
use link_core::BitRate;

use crate::{BUS, TOOL, refused};

#[test]
fn syntax_and_the_bus() {
    refused("", "bus = ", "1:7: string values must be quoted, expected literal string");
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
    refused(
        BUS,
        "[[node]]\nidentity = 5",
        "3:12: invalid type: integer `5`, expected a table of keys and values",
    );
    refused(BUS, "seed = -1", "2:8: `seed` is -1; expected a number from 0");
    refused("", "", "s.toml: there is no table [bus]; expected [bus] and at least one [[node]]");
    refused(BUS, "", "s.toml: there is no [[node]]; expected at least one");
}

#[test]
fn keys_that_nobody_knows() {
    refused(
        "",
        "[buss]",
        "1:2: there is no key `buss`, did you mean `bus`? expected `title`, `bus`, `node`, `action`, `fault`, `expect` or `note`",
    );
    refused(
        BUS,
        "[[node]]\nnaem = 1",
        "3:1: there is no key `naem`, did you mean `name`? expected `name`, `count`, `protocol`, `role`, `mac`, `oa`, `power_up`, `reaction`, `bit_rate`, `clock_ppm`, `identity`, `port`, `boi`, `quick_connect`, `offline_set`, `switches`, `hello_wait`, `announcement`, `produce`, `consume`, `mini_who`, `idle_mini_who`, `roam_tries`, `connect_tries`, `spare_wait`, `learning`, `takeover_after`, `rejoin_after`, `planned`, `poll`, `bit_strobe`, `cos`, `cyclic`, `multicast_poll`, `input`, `ucmm`, `unconnected_port`, `heartbeat`, `shutdown_message`, `run`, `interscan_delay`, `response_wait`, `background_ratio`, `first_contact`, `retry_after`, `retry_at_most`, `replacement`, `replacement_retry`, `multicast_output`, `scan`, `file`, `log`, `only`, `frame` or `period`",
    );
    refused(
        TOOL,
        r#"power_upp = 1
[[node]]
name = "b"
role = "babbler""#,
        "5:1: there is no key `power_upp` for the role `external`, did you mean `power_up`? expected `name`, `count`, `role`, `power_up`, `reaction`, `bit_rate` or `clock_ppm`",
    );
    refused(
        TOOL,
        "[[expect]]
whatever = 1",
        "6:1: there is no key `whatever`; expected `by`, `at`, `from`, `to`, `never`, `always`, `node`, `state`, `oa`, `tec`, `rec`, `bus_off`, `event`, `connection`, `connection_state`, `mode`, `input`, `output`, `slave`, `slave_state`, `status`, `device` or `device_state`",
    );
    refused(BUS, "rate = 1", "2:1: there is no key `rate`; expected `bit_rate`, `seed` or `duration`");
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
