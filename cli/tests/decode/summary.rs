//! `--summary`: nodes, connections, problems, bus load.

use super::{assert_exit, capture, json_lines, run, run_with_input, stdout};

#[test]
fn the_summary_counts_nodes_and_connections() {
    let file = capture("slave-01-startup-poll.log");
    let output = run(&["decode", "--summary", "--bit-rate", "125k", &file]);
    let expected = "\
can0: 30 frames in 4.210 s, 0 with a problem
bus load 0.45 % at 125 kbit/s, stuff bits and intermission included
verdict: healthy

node  frames  bytes  problems    load  response p50      p99       max  access  device
   1      15     50         0  0.22 %             -        -         -  online
  10      15     54         0  0.23 %       0.30 ms  0.30 ms  0.300 ms  online  vendor 4660, serial 0x00002345

node  connection              frames  bytes  problems    load  response p50      p99       max  states seen
  10  duplicate MAC ID check       2     14         0  0.04 %             -        -         -
  10  explicit                    13     59         0  0.22 %       0.30 ms  0.30 ms  0.300 ms  non-existent, established
  10  poll                        11     15         0  0.13 %       0.30 ms  0.30 ms  0.300 ms  non-existent, configuring, established
  10  unconnected port             4     16         0  0.06 %       0.30 ms  0.30 ms  0.300 ms
";
    assert_eq!(stdout(&output), expected);
    let objects = json_lines(&run(&["decode", "--summary", "--json", &file]));
    let what: Vec<_> = objects.iter().map(|object| object["summary"].as_str().unwrap()).collect();
    assert_eq!(what, ["bus", "node", "node", "connection", "connection", "connection", "connection"]);
    assert_eq!(
        objects[2]["response"],
        serde_json::json!({ "count": 13, "p50": 0.0003, "p99": 0.0003, "max": 0.0003 })
    );
    assert_eq!(objects[5]["states"], serde_json::json!(["non_existent", "configuring", "established"]));
}

/// Two connections that one client has opened, and one of another, at the same server in the same group.
#[test]
fn the_summary_keeps_opened_connections_apart_and_both_directions_together() {
    let mut log = String::new();
    let mut put =
        |id: u16, data: &str| log += &format!("({}.000000) can0 {id:03X}#{data}\n", log.lines().count());
    // Group 3 of server 20: opened by 2 with instances 7 and 8, by 3 with instance 9.
    for (client, message, instance) in [(2, 1, 7), (2, 2, 8), (3, 1, 9)] {
        put(0x780 | client, &format!("144B003{message}"));
        put(0x754, &format!("{client:02X}CB000{message}{instance:02X}00"));
    }
    for (client, message) in [(2, 1), (2, 2), (2, 2), (3, 1)] {
        put(0x600 | message << 6 | client, "140E010101");
        put(0x600 | message << 6 | 20, &format!("{client:02X}8E3412"));
    }
    // It closes one, which then has been in both states.
    put(0x782, "144C0700");
    put(0x754, "02CC");
    let output = run_with_input(&["decode", "--summary", "--json", "-"], &log);
    assert_exit(&output, 0);
    let rows: Vec<_> = json_lines(&output)
        .into_iter()
        .filter(|object| object["summary"] == "connection")
        .map(|row| {
            let [node, name, client, frames, states] =
                ["node", "connection", "client", "frames", "states"].map(|field| row[field].to_string());
            [node, name.replace('"', ""), client, frames, states.replace('"', "")].join(" ")
        })
        .collect();
    assert_eq!(
        rows,
        [
            "20 UCMM null 8 []",
            "20 group 3 instance 7 2 2 [non_existent,established]",
            "20 group 3 instance 8 2 4 [established]",
            "20 group 3 instance 9 3 2 [established]",
        ]
    );
    let text = run_with_input(&["decode", "--summary", "-"], &log);
    assert!(
        stdout(&text).contains("  20  group 3 instance 9, client 3       2      9 "),
        "{}",
        stdout(&text)
    );
}

/// A tool that connects anew for every request: neither states nor frames are lost, and memory does not grow.
#[test]
fn any_number_of_opened_connections_is_summed_up() {
    let mut log = String::new();
    let mut n = 0;
    for instance in 10..2010_u16 {
        let [low, high] = instance.to_le_bytes();
        for (id, data) in [
            (0x782, "144B0031".to_owned()),
            (0x754, format!("02CB0001{low:02X}{high:02X}")),
            (0x642, "140E010101".to_owned()),
            (0x654, "028E3412".to_owned()),
            (0x782, format!("144C{low:02X}{high:02X}")),
            (0x754, "02CC".to_owned()),
        ] {
            log += &format!("({}.{:03}000) can0 {id:03X}#{data}\n", n / 1000, n % 1000);
            n += 1;
        }
    }
    let output = run_with_input(&["decode", "--summary", "--json", "-"], &log);
    assert_exit(&output, 0);
    let rows: Vec<_> =
        json_lines(&output).into_iter().filter(|object| object["summary"] == "connection").collect();
    assert_eq!(rows.len(), 1025);
    assert_eq!(rows.iter().filter_map(|row| row["frames"].as_u64()).sum::<u64>(), 12_000);
    let others = rows.iter().find(|row| row["connection"] == "further dynamic connections").unwrap();
    assert_eq!(others["frames"], 2 * (2000 - 1023));
    assert!(rows.iter().skip(2).all(|row| row["states"].to_string().contains("established")), "{}", rows[5]);
}

#[test]
fn the_summary_names_devices_and_nothing_on_the_bus_commands_the_terminal() {
    // The slave answers with its product name, in which a byte is ESC.
    let log = "(0.000000) can0 454#010E010107\n(0.001000) can0 453#018E0441621B64\n";
    let output = run_with_input(&["decode", "--summary", "-"], log);
    assert!(stdout(&output).starts_with("can0: 2 frames in 0.001 s, 0 with a problem\n"));
    assert!(
        stdout(&output).contains("  Ab\u{FFFD}d\n") && !stdout(&output).contains('\u{1B}'),
        "{}",
        stdout(&output)
    );
    let objects = json_lines(&run_with_input(&["decode", "--summary", "--json", "-"], log));
    let node = objects.iter().find(|object| object["summary"] == "node" && object["node"] == 10).unwrap();
    assert_eq!(node["product_name"], "Ab\u{FFFD}d");
    let (one, _) = log.split_at(log.find('\n').unwrap());
    let output = run_with_input(&["decode", "--summary", "-"], one);
    assert!(
        stdout(&output).starts_with("can0: 1 frame in 0.000 s, 0 with a problem\n"),
        "{}",
        stdout(&output)
    );
}

#[test]
fn the_summary_tells_which_problems_there_are() {
    let log = "(1.000000) can0 7F0#\n(1.500000) can0 00000455#\n(1.700000) can0 00000456#\n\
               (2.000000) can0 20000004#0004000000000000\n";
    let output = run_with_input(&["decode", "--summary", "-"], log);
    assert_exit(&output, 1);
    let expected = "
problem              severity  frames  first frame  first time  first in words
extended_identifier  info           2            2    1.500000  29-bit identifier
invalid_identifier   info           1            1    1.000000  identifier that must not be used
error_frame          info           1            4    2.000000  error frame: controller problem
";
    assert!(stdout(&output).ends_with(expected), "{}", stdout(&output));
    let objects = json_lines(&run_with_input(&["decode", "--summary", "--json", "-"], log));
    let problems: Vec<_> = objects.iter().filter(|object| object["summary"] == "problem").collect();
    assert_eq!(problems.len(), 3);
    let expected = serde_json::json!({
        "summary": "problem", "channel": "can0", "problem": "extended_identifier", "severity": "info", "frames": 2,
        "first": { "n": 2, "t": 1.5, "text": "29-bit identifier" },
    });
    assert_eq!(*problems[0], expected);
}

/// A filter hides frames, not time: the load of those shown is a part of the same whole.
#[test]
fn the_load_of_filtered_frames_is_that_of_the_whole_recording() {
    let log = "(0.000000) can0 455#00\n(0.500000) can0 457#00341245230000\n(1.000000) can0 455#00\n";
    let load = |arguments: &[&str]| {
        let objects = json_lines(&run_with_input(arguments, log));
        objects.into_iter().find(|object| object["summary"] == "node" && object["node"] == 10).unwrap()["load"].clone()
    };
    let all = load(&["decode", "--summary", "--json", "-"]);
    assert!(all.is_number());
    assert_eq!(load(&["decode", "--summary", "--json", "--kind", "dup_mac_request", "-"]), all);
}

/// The load is that of the frames on the wire: 100 frames of 8 bytes a second at 125 kbit/s.
#[test]
fn the_bus_load_is_exact() {
    let log: String =
        (0..=100).map(|n| format!("({}.{:02}0000) can0 455#5555555555555555\n", n / 100, n % 100)).collect();
    let objects = json_lines(&run_with_input(&["decode", "--summary", "--json", "-"], &log));
    // No stuff bits but those of identifier and CRC: the frame is the same each time.
    let frame = link_core::Frame::new(link_core::frame::standard_id(0x455), &[0x55; 8]).unwrap();
    // A second passes between the ends of the first and the last; the first one lies before it.
    let bits = f64::from(frame.bit_len() + 3);
    let expected = 101.0 * bits / (125_000.0 + bits);
    let load = objects[0]["load"].as_f64().unwrap();
    assert!((load - expected).abs() < 1e-12, "{load} instead of {expected}");
    assert_eq!(objects[0]["bit_rate"], 125_000);
}

/// Two polls without an answer, a second apart; neither the allocation nor the packet rate is known.
const SILENT: &str = "(1.000000) can0 455#01\n(1.000300) can0 3CA#02\n(2.000000) can0 455#01\n\
                      (3.000000) can0 455#01\n(3.500000) can0 44D#01\n(3.500300) can0 3C9#01\n";

#[test]
fn the_summary_says_what_is_wrong_and_what_to_check_next() {
    let output = run_with_input(&["decode", "--summary", "-"], SILENT);
    let expected = "
warning  node 10 has not answered its polls for more than 1000 ms
         since 2.000000, frames 3 4, code 72
         check power, plug and drop cable of node 10, then its indicators: red is a duplicate MAC ID or bus-off, and takes a \
                    power cycle
";
    assert!(stdout(&output).contains(expected), "{}", stdout(&output));
    assert_exit(&output, 1);
    let objects = json_lines(&run_with_input(&["decode", "--summary", "--json", "-"], SILENT));
    let finding = objects.iter().find(|object| object["summary"] == "finding").unwrap();
    for (field, value) in [
        ("channel", serde_json::json!("can0")),
        ("rule", serde_json::json!("not_answering")),
        ("severity", serde_json::json!("warning")),
        ("node", serde_json::json!(10)),
        ("scanner_status", serde_json::json!(72)),
        ("since", serde_json::json!(2.0)),
        ("evidence", serde_json::json!([3, 4])),
        ("facts", serde_json::json!({ "silence": { "exchange": "poll", "patience": 1.0 } })),
    ] {
        assert_eq!(finding[field], value, "{field}");
    }
    assert!(finding["advice"].as_str().unwrap().starts_with("check power"), "{finding}");
}

/// What is said in full by the rule has no facts.
#[test]
fn a_finding_without_facts_has_none() {
    let check = "(1.000000) can0 457#00341201000000\n(2.000000) can0 457#00341201000000\n\
                 (9.000000) can0 457#00341201000000\n";
    let objects = json_lines(&run_with_input(&["decode", "--summary", "--json", "-"], check));
    let finding = objects.iter().find(|object| object["summary"] == "finding").unwrap();
    assert_eq!((&finding["rule"], finding.get("facts")), (&"restarted".into(), None));
}

/// Of the node and of the time that is shown.
#[test]
fn findings_obey_the_filters() {
    for (filter, is_shown) in [
        (&["--mac", "10"][..], true),
        (&["--mac", "9"], false),
        (&["--from", "2.2s"], true),
        (&["--to", "900ms"], false),
    ] {
        let output = run_with_input(&[&["decode", "--summary"], filter, &["-"]].concat(), SILENT);
        assert_eq!(stdout(&output).contains("warning  "), is_shown, "{filter:?}");
    }
}

/// A node that restarts in order is worth knowing, and no reason to fail.
#[test]
fn what_is_only_worth_knowing_is_no_finding_for_the_shell() {
    let mut log = String::new();
    for seconds in [1, 2, 10, 11] {
        log += &format!("({seconds}.000000) can0 457#00341201000000\n");
    }
    let output = run_with_input(&["decode", "--summary", "-"], &log);
    assert!(stdout(&output).contains("info     node 10 has restarted\n"), "{}", stdout(&output));
    assert_exit(&output, 0);
}

/// What belongs to the bus is told by the scan lists of a scenario.
#[test]
fn strangers_and_wrong_devices_are_told_by_the_scan_lists() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let list = root.join("tests/scenarios/health/key_mismatch-not.toml").to_string_lossy().into_owned();
    // Vendor 0x4321 at a MAC ID where the key says 0x1234, and a MAC ID that no scan list has.
    let log = "(1.0) can0 457#00214301000000\n(2.0) can0 4A7#00341202000000\n";
    let rules = |options: &[&str]| -> Vec<String> {
        let output = run_with_input(&[&["decode", "--summary", "--json"], options, &["-"]].concat(), log);
        let findings = json_lines(&output).into_iter().filter(|object| object["summary"] == "finding");
        findings.map(|finding| finding["rule"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(rules(&["--expect", &list]), ["key_mismatch", "foreign_mac_id"]);
    assert_eq!(rules(&[]), [""; 0]);
    assert_exit(&run_with_input(&["decode", "--expect", &list, "-"], log), 2);
    assert_exit(&run_with_input(&["decode", "--summary", "--expect", "no such file", "-"], log), 2);
}
