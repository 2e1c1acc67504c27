//! Trace, JSON, summary, picture and recording tell the same run.

use serde_json::Value;

use super::{Scratch, VALVE, devicenet, lines_of_json, stdout};

#[test]
fn the_columns_of_the_trace_do_not_move() {
    let output = devicenet(&["simulate"]);
    let columns: std::collections::BTreeSet<_> =
        stdout(&output).lines().filter_map(|line| line.find(" | ")).collect();
    assert_eq!(columns.len(), 1, "{columns:?}");
}

#[test]
fn a_heading_stays_one_line_and_does_not_command_the_terminal() {
    let text = "[bus]\nduration = \"1s\"\n[[node]]\nname = \"ear\"\nrole = \"listener\"\n\
        [[note]]\nat = \"0s\"\ntext = \"one\\u001b[2J\\ntwo\"\n";
    let scenario = Scratch::new("heading.toml", text);
    let output = devicenet(&["simulate", scenario.path()]);
    assert_eq!(stdout(&output).lines().next(), Some("one\u{FFFD}[2J\u{FFFD}two"));
}

#[test]
fn a_segment_does_not_know_what_is_on_the_other() {
    let text = r#"
[bus]
duration = "2s"
[[node]]
name = "near"
protocol = "devicenet"
role = "access"
mac = 10
identity = { vendor = 1, serial = 1 }
[[node]]
name = "far"
protocol = "devicenet"
role = "access"
mac = 10
power_up = "100ms"
identity = { vendor = 1, serial = 2 }
[[node]]
name = "near-ear"
role = "external"
[[node]]
name = "far-ear"
role = "external"
[[fault]]
kind = "segment"
nodes = ["far", "far-ear"]
"#;
    let output = |scenario: &Scratch| stdout(&devicenet(&["simulate", scenario.path()])).to_owned();
    let scenario = Scratch::new("apart.toml", text);
    let apart = output(&scenario);
    for line in lines_of_json(&devicenet(&["simulate", "--json", scenario.path()])) {
        if line["event"] == "frame" {
            let expected = (line["nodes"][0] == "far").then_some(1);
            assert_eq!(line["segment"].as_u64(), expected, "{line}");
        }
    }
    assert!(apart.contains("far") && !apart.contains("two nodes"), "{apart}");
    let whole = output(&Scratch::new("whole.toml", text.split("[[fault]]").next().expect("the nodes")));
    assert!(whole.contains("two nodes check MAC ID 10"), "{whole}");
}

/// Devices without an address wait for ever where nobody is a manager; without that line they seem to be broken.
#[test]
fn a_plant_without_a_manager_says_so() {
    let device = |name: &str, serial: u8, more: &str| {
        format!(
            "[[node]]\nname = \"{name}\"\nprotocol = \"devicenex\"\nrole = \"device\"\n\
             identity = {{ vendor = 0x1234, serial = {serial} }}\n{more}"
        )
    };
    let bus = "[bus]\nduration = \"5s\"\n[[node]]\nname = \"ear\"\nrole = \"external\"\n";
    let [one, two, three] = [("a", 1), ("b", 2), ("c", 3)].map(|(name, serial)| device(name, serial, ""));
    let placed = device("placed", 4, "oa = 5\n");
    let manager = device("manager", 5, "oa = 1\n").replace("role = \"device\"", "role = \"manager\"");
    for (nodes, expected) in [
        (one.clone() + &placed, Some("no node is a manager: a has no address, and nobody gives it one")),
        (
            one.clone() + &two,
            Some("no node is a manager: a and b have no address, and nobody gives them one"),
        ),
        (
            one.clone() + &two + &three,
            Some("no node is a manager: a and 2 others have no address, and nobody gives them one"),
        ),
        (placed, None),
        (one + &manager, None),
    ] {
        let scenario = Scratch::new("no-manager.toml", &(bus.to_owned() + &nodes));
        for options in [&["simulate"][..], &["simulate", "--summary"]] {
            let output = devicenet(&[options, &[scenario.path()]].concat());
            let told = stdout(&output).lines().find(|line| line.starts_with("no node is"));
            assert_eq!(told, expected, "{}", stdout(&output));
        }
    }
}

#[test]
fn json_has_the_fields_of_decode_and_the_states() {
    let output = devicenet(&["simulate", "--json"]);
    let lines = lines_of_json(&output);
    let request = lines.iter().find(|line| line["event"] == "frame").expect("a frame");
    assert_eq!(request["kind"], "dup_mac_request");
    assert_eq!(request["nodes"], serde_json::json!(["panel"]));
    assert_eq!((request["id"].as_u64(), request["n"].as_u64()), (Some(0x467), Some(1)));
    assert_eq!(request["vendor"].as_u64(), Some(0x1234));
    assert_eq!(request["t"].as_f64(), Some(0.051_272));
    let failed = lines.iter().find(|line| line["event"] == "error_frame").expect("an error frame");
    assert_eq!((failed["error"].as_str(), failed["by"].as_str()), (Some("ack"), Some("scanner")));
    let to: Vec<&str> = (lines.iter())
        .filter(|line| line["event"] == "state" && line["node"] == "scanner")
        .filter_map(|line| line["to"].as_str())
        .collect();
    assert_eq!(to, ["sending_dup_mac", "waiting_dup_mac", "sending_dup_mac", "waiting_dup_mac", "online"]);
    assert!(lines.iter().all(|line| line["t"].is_f64() && line["event"].is_string()));
}

/// The only node loses its power in the middle of a frame, which nobody is there to call an error.
#[test]
fn every_view_counts_error_frames_alike() {
    let action =
        |at: &str, what: &str| format!("[[action]]\nat = \"{at}\"\nnode = \"valve\"\ndo = \"{what}\"\n");
    let node = VALVE.split("[[node]]\nname = \"can0\"").next().expect("the first node").replace("3s", "50ms");
    let text = node + &action("500us", "power_off") + &action("10ms", "power_on");
    let scenario = Scratch::new("broken-off.toml", &text);
    let recording = Scratch::new("broken-off.log", "");
    let lines =
        lines_of_json(&devicenet(&["simulate", "--json", "--record", recording.path(), scenario.path()]));
    let count = |event: &str| lines.iter().filter(|line| line["event"] == event).count();
    let number = |value: &Value| value.as_u64().and_then(|number| usize::try_from(number).ok());
    let summary = lines.last().expect("the summary");
    assert_eq!(count("abandoned"), 1);
    assert_eq!(number(&summary["bus"]["abandoned"]), Some(1));
    assert!(count("error_frame") > 10);
    assert_eq!(number(&summary["bus"]["errors"]), Some(count("error_frame")));
    assert_eq!(number(&summary["nodes"][0]["failed"]), Some(count("error_frame")));
    let recorded = String::from_utf8(recording.read()).expect("ASCII").lines().count();
    assert_eq!(recorded, count("error_frame"));
    let table = devicenet(&["simulate", "--summary", scenario.path()]);
    assert!(stdout(&table).contains(" error frames, 1 broken off, load "), "{}", stdout(&table));
}

/// What frames take of the time is one figure, from whichever side it is seen; of what errors destroyed only the simulation knows how long
/// it was.
#[test]
fn every_view_has_the_load_of_frames() {
    let recording = Scratch::new("load.log", "");
    let simulated =
        lines_of_json(&devicenet(&["simulate", "--json", "--summary", "--record", recording.path()]));
    let bus = &simulated.last().expect("the summary")["bus"];
    let number = |value: &Value| value.as_f64().expect("a number");
    let (all, errors) = (number(&bus["load"]), number(&bus["error_load"]));
    let busy = (all - errors) * number(&bus["duration"]);
    let decoded = lines_of_json(&devicenet(&["decode", "--summary", "--json", recording.path()]));
    let decoded = &decoded[0];
    assert_eq!(decoded["error_frames"], bus["errors"]);
    let least = number(&decoded["error_load"]);
    assert!(least > 0.0 && least < errors, "{least}, {errors}");
    // From the begin of the first frame to the end of the last.
    let first_frame = 0.000_8;
    let span = number(&decoded["seconds"]) + first_frame;
    let frames = (number(&decoded["load"]) - least) * span;
    assert!((frames / busy - 1.0).abs() < 1e-4, "{frames} s instead of {busy}");
    let endpoint = format!("log:{}", recording.path());
    let monitored = lines_of_json(&devicenet(&["monitor", &endpoint, "--json", "--bit-rate", "125k"]));
    let last = monitored.last().expect("the last summary");
    let frames = number(&last["load_total"]["all"]) - number(&last["load_total"]["errors"]);
    let frames = frames * number(&last["t"]);
    assert!((frames / busy - 1.0).abs() < 1e-4, "{frames} s instead of {busy}");
}

/// All that is on the bus are error frames.
#[test]
fn a_node_that_is_alone_for_a_moment_is_found() {
    let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/scenarios/lone.toml");
    for (until, code, verdict) in [("940ms", 1, "verdict: 1 error\n"), ("490ms", 0, "verdict: healthy\n")] {
        let recording = Scratch::new("alone.log", "");
        devicenet(&["simulate", scenario, "--summary", "--until", until, "--record", recording.path()]);
        let output = devicenet(&["decode", "--summary", recording.path()]);
        assert_eq!(output.status.code(), Some(code), "{}", stdout(&output));
        assert!(stdout(&output).contains(verdict), "{}", stdout(&output));
        assert!(
            stdout(&output).contains(" error frames take about 13."),
            "how much of the load is known: {}",
            stdout(&output)
        );
    }
}

#[test]
fn a_recording_is_read_by_decode() {
    for name in ["plant.log", "plant.pcapng"] {
        let recording = Scratch::new(name, "");
        devicenet(&["simulate", "--summary", "--record", recording.path()]);
        let output = devicenet(&["decode", "--json", recording.path()]);
        let decoded = lines_of_json(&output);
        let simulated = lines_of_json(&devicenet(&["simulate", "--json"]));
        let frames: Vec<&Value> = simulated.iter().filter(|line| line["event"] == "frame").collect();
        let through: Vec<&Value> =
            decoded.iter().filter(|line| line["protocol"] == "devicenet" && line["id"].is_u64()).collect();
        assert_eq!(through.len(), frames.len(), "{name}");
        for (read, sent) in through.iter().zip(frames) {
            assert_eq!(
                (&read["t"], &read["id"], &read["data"]),
                (&sent["t"], &sent["id"], &sent["data"]),
                "{name}"
            );
        }
    }
}

/// One node has defended its MAC ID, the other has restarted after it could not.
#[test]
fn the_decoder_finds_the_same_last_states_in_the_recording() {
    let recording = Scratch::new("states.log", "");
    assert_eq!(devicenet(&["simulate", "--record", recording.path()]).status.code(), Some(0));
    let output = devicenet(&["decode", "--summary", recording.path()]);
    let text = stdout(&output);
    for (node, serial) in [("10", "0x00002001"), ("20", "0x00002011")] {
        let row =
            text.lines().rfind(|line| line.split_whitespace().next() == Some(node) && line.ends_with(serial));
        assert!(row.is_some_and(|row| row.contains("  online  ")), "{text}");
    }
}

#[test]
fn the_picture_has_a_row_for_each_node_and_a_legend() {
    let picture = Scratch::new("plant.svg", "");
    let output = devicenet(&["simulate", "--summary", "--svg", picture.path()]);
    assert_eq!(output.status.code(), Some(0));
    let svg = String::from_utf8(picture.read()).expect("UTF-8");
    assert!(svg.starts_with("<svg xmlns=") && svg.ends_with("</svg>\n"));
    assert!(
        svg == include_str!("../../../docs/plant.svg"),
        "the README shows another picture: cargo run --release -- simulate --summary --svg docs/plant.svg"
    );
    for words in [
        "scanner",
        "new-eye",
        "exchanging I/O",
        "bus load",
        "communication fault",
        "time in seconds",
        "6. Repair",
    ] {
        assert!(svg.contains(&format!(">{words}")), "{words} is missing");
    }
}

#[test]
fn the_summary_is_a_table_with_the_last_states() {
    let output = devicenet(&["simulate", "--summary"]);
    let text = stdout(&output);
    let twin = text.lines().find(|line| line.starts_with("twin")).expect("the twin");
    let words: Vec<&str> = twin.split_whitespace().collect();
    assert_eq!(words[..4], ["twin", "slave", "20", "online"]);
    assert!(text.contains("22s at 125 kbit/s: "), "{text}");
}

/// Named as in JSON, in JSON as well as in words, and told alike: what is selected is what all have of that kind.
#[test]
fn events_are_selected_by_their_names() {
    let all = lines_of_json(&devicenet(&["simulate", "--json"]));
    let name = |line: &Value| line["event"].as_str().expect("its name").to_owned();
    let is_end = |name: &str| matches!(name, "expectation" | "summary");
    let kinds: std::collections::BTreeSet<String> =
        all.iter().map(name).filter(|name| !is_end(name)).collect();
    assert!(kinds.len() > 10, "{kinds:?}");
    for kind in &kinds {
        let only = lines_of_json(&devicenet(&["simulate", "--json", "--event", kind]));
        let expected: Vec<&Value> =
            all.iter().filter(|line| name(line) == *kind || is_end(&name(line))).collect();
        assert_eq!(only.iter().collect::<Vec<_>>(), expected, "{kind}");
    }
    let without = lines_of_json(&devicenet(&["simulate", "--json", "--no-event", "scan,node"]));
    let expected: Vec<&Value> =
        all.iter().filter(|line| !matches!(name(line).as_str(), "scan" | "node")).collect();
    assert_eq!(without.iter().collect::<Vec<_>>(), expected);
}

#[test]
fn the_words_tell_by_name_what_they_are_silent_about() {
    let output = devicenet(&["simulate", "--event", "scan,input,output"]);
    let trace: Vec<&str> = stdout(&output).lines().filter(|line| line.contains(" | ")).collect();
    for words in ["| scan done", "| slave 10: poll: input data ", "| poll: output data "] {
        assert!(trace.iter().any(|line| line.contains(words)), "{words}: {trace:#?}");
    }
    let of_other_kinds =
        |line: &&&str| !["scan done", "input data", "output data"].iter().any(|it| line.contains(it));
    assert_eq!(trace.iter().find(of_other_kinds), None);
    assert!(!stdout(&devicenet(&["simulate"])).contains("scan done"));
    let output = devicenet(&["simulate", "--no-event", "frame,error_frame,state,change,note"]);
    assert!(!stdout(&output).contains("dup MAC"), "{}", stdout(&output));
    let refused = devicenet(&["simulate", "--summary", "--event", "scan"]);
    assert_eq!(refused.status.code(), Some(2));
}
