//! `monitor`, as lines.

use std::io::{BufRead as _, BufReader, Write as _};
use std::process::{Command, Stdio};

use crate::devicenet;

macro_rules! assert_lines {
    ($name:literal, $description:literal, $lines:expr) => {
        insta::with_settings!({ description => $description, omit_expression => true, prepend_module_to_snapshot => false }, {
            insta::assert_snapshot!($name, $lines);
        });
    };
}

const RECORDING: &str = "log:../../../tests/captures/slave-01-startup-poll.log";

#[test]
fn a_node_that_stops_answering_in_words() {
    let run = devicenet(&["monitor", "sim:drop.toml", "--for", "25s", "--interval", "13s"]);
    assert_eq!((run.code(), run.err().as_str()), (1, ""));
    assert_lines!(
        "monitor__drop",
        "node 10 is cut off at 12 s and comes back at 18 s: what happens when, a summary at 13 s, all of it in the end",
        run.out()
    );
}

#[test]
fn a_recording_as_objects() {
    let run = devicenet(&["monitor", RECORDING, "--json"]);
    assert_eq!(run.err(), "");
    assert_lines!(
        "monitor__recording_json",
        "one object a line; the last is the summary, with every field that it has",
        run.out()
    );
    let last = run.json().pop().unwrap();
    assert_eq!(
        (&last["event"], &last["last"], &last["frames"]),
        (&"summary".into(), &true.into(), &30.into())
    );
}

/// Finding by finding: `decode` and `monitor` see the same in the same recording, and name the same frames.
#[test]
fn evidence_is_numbered_as_decode_counts() {
    let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/mixed.log");
    // An error frame, a line that cannot be read, a frame of CAN FD; a fault, polls without an answer, a node that checks twice.
    let mut log = String::from(
        "(1.000000) can0 20000088#0000040A00000000\n(1.010000) can0 20000088#0000040A00000000\nno frame\n\
         (1.020000) can0 123##1aabb\n(1.030000) can0 00000455#\n(1.040000) can0 45B#0BCD010004010000\n\
         (1.050000) can0 455#01\n(1.060000) can0 3CA#01\n",
    );
    for second in 2..7 {
        log += &format!("({second}.000000) can0 455#01\n({second}.100000) can0 20000088#0000040A00000000\n");
    }
    log += "(8.000000) can0 457#00341201000000\n(8.100000) can0 457#00341202000000\n(9.000000) can0 44D#01\n";
    std::fs::write(path, log).unwrap();
    let evidence = |objects: Vec<serde_json::Value>| -> Vec<(String, String)> {
        let findings = objects.iter().map(|found| (found["rule"].to_string(), found["evidence"].to_string()));
        findings.collect()
    };
    let monitored = devicenet(&["monitor", &format!("log:{path}"), "--json"]).json().pop().unwrap();
    let monitored = evidence(monitored["findings"].as_array().unwrap().clone());
    let decoded = devicenet(&["decode", "--summary", "--json", path]).json();
    let decoded = evidence(decoded.into_iter().filter(|object| object["summary"] == "finding").collect());
    assert_eq!(monitored, decoded);
    let silent = ("\"not_answering\"".to_owned(), "[8,10]".to_owned());
    assert!(monitored.len() == 4 && monitored.contains(&silent), "{monitored:?}");
}

/// The verdict, its words and the exit code are the same, whoever is asked.
#[test]
fn monitor_and_decode_have_one_verdict() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/captures");
    let mut states = std::collections::BTreeSet::new();
    let empty = concat!(env!("CARGO_TARGET_TMPDIR"), "/empty.log");
    std::fs::write(empty, "").unwrap();
    let restart = concat!(env!("CARGO_TARGET_TMPDIR"), "/restart.log");
    let checks = [1, 2, 10, 11].map(|second| format!("({second}.0) can0 457#00341201000000\n"));
    std::fs::write(restart, checks.concat()).unwrap();
    let captures =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path().display().to_string());
    let recordings = captures.filter(|path| path.ends_with(".log") && !path.ends_with("mixed.log"));
    for path in recordings.chain([empty.to_owned(), restart.to_owned()]) {
        let monitored = devicenet(&["monitor", &format!("log:{path}"), "--json"]);
        let decoded = devicenet(&["decode", "--summary", "--json", &path]);
        let verdict = monitored.json().pop().unwrap()["verdict"].clone();
        assert_eq!(verdict, decoded.json()[0]["verdict"], "{path}");
        assert_eq!(monitored.code(), decoded.code(), "{path}: {verdict}");
        let is_well = verdict["state"] == "healthy" || verdict["state"] == "silent";
        assert_eq!(monitored.code() == 0, is_well, "{path}: {verdict}");
        let words =
            |text: String| text.lines().rfind(|line| line.starts_with("verdict: ")).map(str::to_owned);
        let shown = words(devicenet(&["monitor", &format!("log:{path}")]).out());
        assert_eq!(shown, words(devicenet(&["decode", "--summary", &path]).out()), "{path}");
        states.insert(verdict["state"].to_string());
        if path == restart {
            assert_eq!((shown.as_deref(), monitored.code()), (Some("verdict: healthy, 1 info"), 0));
        }
    }
    assert_eq!(states.len(), 4, "{states:?}");
}

/// Nothing was wrong, because nothing was there.
#[test]
fn a_recording_without_a_frame_is_told() {
    let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/nothing.log");
    std::fs::write(path, "").unwrap();
    let run = devicenet(&["monitor", &format!("log:{path}")]);
    assert_eq!((run.code(), run.err()), (0, format!("note: {path}: no frames\n")));
    assert!(run.out().contains("verdict: silent: no frame was heard\n"), "{}", run.out());
}

/// A frame that is destroyed for one node in its last bit is sent again: the others have it twice, which makes no second sender.
#[test]
fn frames_that_are_sent_again_have_no_second_sender() {
    let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/again.toml");
    let scenario =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/live/drop.toml")).unwrap();
    let fault =
        "\n[[fault]]\nkind = \"lost_frame\"\nfrom = \"0s\"\nto = \"6s\"\nrate = 0.05\nnode = \"scanner\"\n";
    std::fs::write(path, scenario + fault).unwrap();
    let last =
        devicenet(&["monitor", &format!("sim:{path}"), "--json", "--for", "10s"]).json().pop().unwrap();
    let rules: Vec<_> =
        last["findings"].as_array().unwrap().iter().map(|found| found["rule"].clone()).collect();
    assert!(last["problems"].as_u64() > Some(9) && last["frames"].as_u64() > Some(1_000), "{last}");
    assert!(rules.is_empty(), "{rules:?}");
}

/// Every object has its kind and its time, and a summary comes at every interval.
#[test]
fn summaries_come_at_their_intervals() {
    let run = devicenet(&["monitor", "sim:drop.toml", "--for", "10s", "--interval", "2500ms", "--json"]);
    let objects = run.json();
    assert!(objects.iter().all(|object| object["event"].is_string() && object["t"].is_number()));
    let summaries: Vec<f64> = objects
        .iter()
        .filter(|object| object["event"] == "summary")
        .map(|object| object["t"].as_f64().unwrap())
        .collect();
    assert_eq!((summaries, run.code()), (vec![2.5, 5.0, 7.5, 10.0, 10.0], 0));
    let frames: Vec<u64> =
        objects.iter().filter_map(|object| object["nodes"][1]["frames"].as_u64()).collect();
    assert!(frames.is_sorted() && frames[0] > 0, "{frames:?}");
}

/// Somebody who listens must not acknowledge: a lone node stays alone. What it sends is heard all the same, since an
/// error-passive sender disturbs nobody.
#[test]
fn a_lone_node_stays_alone() {
    let run = devicenet(&["monitor", "sim:late.toml", "--for", "20s", "--json"]);
    let last = run.json().pop().unwrap();
    assert!(last["error_frames"].as_u64().unwrap() >= 16, "{last}");
    assert!(last["nodes"][0]["mac"] == 10 && last["nodes"][0]["state"] != "online", "{last}");
}

/// Of a bus that falls silent: at once, and not with the next summary.
#[test]
fn a_master_without_power_is_told_when_it_is_missed() {
    let scenario = "sim:../../../tests/scenarios/health/master_silent.toml";
    let run = devicenet(&["monitor", scenario, "--json", "--interval", "1min"]);
    let found = run.json().into_iter().find(|object| object["rule"] == "master_silent").unwrap();
    let (at, since) = (found["t"].as_f64().unwrap(), found["since"].as_f64().unwrap());
    assert!((0.4..0.6).contains(&(at - since)), "{found}");
}

/// What belongs to the bus is told by a scan list, or learned.
#[test]
fn who_does_not_belong_to_the_bus_is_told() {
    let scenario = "sim:../../../tests/scenarios/health/foreign_mac_id.toml";
    let rules = |options: &[&str]| {
        let run = devicenet(&[&["monitor", scenario, "--json"], options].concat());
        let last = run.json().pop().unwrap();
        let rules = last["findings"].as_array().unwrap().iter();
        rules.map(|finding| (finding["rule"].to_string(), finding["mac"].as_u64())).collect::<Vec<_>>()
    };
    let found = [("\"foreign_mac_id\"".to_owned(), Some(20))];
    assert_eq!(rules(&[]), []);
    assert_eq!(rules(&["--expect", "../../../tests/scenarios/health/foreign_mac_id.toml"]), found);
    assert_eq!(rules(&["--learn", "2100ms"]), found);
    assert_eq!(rules(&["--learn", "1h"]), []);
    let run = devicenet(&["monitor", scenario, "--expect", "missing.toml"]);
    assert!(run.code() == 2 && run.err().contains("missing.toml"), "{}", run.err());
}

/// The clock is set back by an hour, and two entries have changed places: time goes on, and a slave that falls silent is missed.
#[test]
fn a_recording_whose_clock_was_set_back() {
    let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/set-back.log");
    let mut log =
        String::from("(9000.000000) can0 455#01\n(9000.000900) can0 3CA#02\n(9000.000500) can0 44D#01\n");
    for tenth in 0..30 {
        log += &format!("(5400.{:06}) can0 455#01\n", tenth * 33_000);
    }
    for second in 5_401..5_404 {
        log += &format!("({second}.000000) can0 455#01\n");
    }
    std::fs::write(path, log).unwrap();
    let run = devicenet(&["monitor", &format!("log:{path}"), "--json"]);
    let objects = run.json();
    let last = objects.last().unwrap();
    assert!((last["t"].as_f64().unwrap() - 3.0009).abs() < 1e-6, "{last}");
    let found = objects.iter().find(|object| object["rule"] == "not_answering").unwrap();
    assert!((1.0..1.2).contains(&found["t"].as_f64().unwrap()), "{found}");
}

/// Each channel is a bus: what is sent on one is no answer on the other.
#[test]
fn one_channel_of_a_recording_is_listened_to() {
    let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/channels.log");
    let mut log = String::new();
    for second in 1..9 {
        log += &format!(
            "({second}.000000) can0 455#01\n({second}.000300) can1 3CA#02\n({second}.000500) can0 3CA#03\n"
        );
    }
    std::fs::write(path, log).unwrap();
    let run = devicenet(&["monitor", &format!("log:{path}"), "--json"]);
    let last = run.json().pop().unwrap();
    assert_eq!((&last["frames"], &last["problems"], run.code()), (&16.into(), &0.into(), 0), "{last}");
    assert_eq!(run.err().matches("can0 is listened to, can1").count(), 1, "{}", run.err());
}

#[test]
fn errors_in_a_recording_are_heard() {
    let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/errors.log");
    let lines = [
        "(1.000000) can0 40A#00",
        "(1.100000) can0 20000088#0000040A00000000",
        "(1.200000) can0 20000004#0001000000000000",
        "(1.300000) can0 20000040#0000000000000000",
        "(1.400000) can0 20000100#0000000000000000",
    ];
    std::fs::write(path, lines.join("\n") + "\n").unwrap();
    let run = devicenet(&["monitor", &format!("log:{path}"), "--json"]);
    let states: Vec<String> = (run.json().iter())
        .filter_map(|object| Some(object["state"].as_str().filter(|_| object["event"] == "link")?.to_owned()))
        .collect();
    assert_eq!(states, ["error_active", "bus_off", "error_active"]);
    let last = run.json().pop().unwrap();
    assert_eq!(
        (&last["error_frames"], &last["lost"], run.code()),
        (&1.into(), &1.into(), 1),
        "{}",
        run.err()
    );
}

/// Ctrl-C in the middle: a summary, and the exit code that says what was found.
#[test]
#[cfg(unix)]
fn an_interruption_ends_with_a_summary() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_devicenet"))
        .args(["monitor", "sim:long.toml", "--json", "--interval", "10min"])
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/live"))
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let first = lines.next().unwrap().unwrap();
    assert!(first.contains("error_active"), "{first}");
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let last = lines.last().unwrap().unwrap();
    assert!(last.contains("\"event\":\"summary\"") && last.contains("\"last\":true"), "{last}");
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

/// A pipe that stays open and silent: what came is told at once, and Ctrl-C is heard.
#[test]
#[cfg(unix)]
fn standard_input_is_interrupted() {
    for (command, code) in [("monitor", 0), ("scan", 0), ("record", 0)] {
        let output = concat!(env!("CARGO_TARGET_TMPDIR"), "/of-standard-input.log");
        let _ = std::fs::remove_file(output);
        let arguments: &[&str] = match command {
            "monitor" => &["monitor", "log:-", "--json"],
            "scan" => &["scan", "log:-", "--json"],
            _ => &["record", "log:-", "--json", "--output", output],
        };
        let mut child = Command::new(env!("CARGO_BIN_EXE_devicenet"))
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut pipe = child.stdin.take().unwrap();
        // More than a pipe holds: then it has begun to read.
        let frames = "(1.000000) can0 40A#00\n".repeat(10_000);
        pipe.write_all(format!("{frames}(2.000000) can0 40A#00\n(3.0").as_bytes()).unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let first = (command != "scan").then(|| lines.next().unwrap().unwrap());
        let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        assert!(killed.success());
        let last = lines.last().map(Result::unwrap);
        assert!(first.is_none_or(|first| first.contains("\"t\":0.0")));
        assert_eq!(last.is_some(), command != "scan", "nobody has said who he is");
        assert_eq!(child.wait().unwrap().code(), Some(code), "{command}");
        drop(pipe);
    }
}

#[test]
fn what_cannot_be_watched_is_told() {
    for (arguments, code, words) in [
        (&["monitor", "no-such-interface"][..], 3, "no-such-interface"),
        (&["monitor", "two.toml"], 2, "sim:two.toml for a scenario"),
        (&["monitor", "log:missing.log"], 2, "missing.log"),
        (&["monitor", "sim:drop.toml", "--interval", "1ms"], 2, "at least 10ms"),
        (&["monitor", "sim:drop.toml", "--bit-rate", "5"], 2, "a bit rate between"),
    ] {
        let run = devicenet(arguments);
        assert_eq!((run.code(), run.out().as_str()), (code, ""), "{arguments:?}");
        assert!(run.err().contains(words), "{}", run.err());
    }
}

/// Two frames from before the clock was set, then a session, and another a day later: a summary for each silence, and findings of what
/// was missed in it.
#[test]
fn a_long_silence_in_a_recording_is_passed_over() {
    let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/clock-jump.log");
    let mut log = String::from("(1.000000) can0 455#01\n(1.000900) can0 3CA#02\n");
    for begin in [1_700_000_000, 1_700_086_400] {
        for tenth in 0..30 {
            log += &format!("({begin}.{:06}) can0 455#01\n", tenth * 33_000);
        }
    }
    std::fs::write(path, log).unwrap();
    let run = devicenet(&["monitor", &format!("log:{path}"), "--json", "--interval", "10s"]);
    let objects = run.json();
    let summaries: Vec<_> = objects.iter().filter(|object| object["event"] == "summary").collect();
    assert!((14..=16).contains(&summaries.len()), "{}", summaries.len());
    assert_eq!(summaries.last().unwrap()["frames"], 62);
    let notes: Vec<String> =
        run.err().lines().filter(|line| line.contains("nothing was heard")).map(str::to_owned).collect();
    assert_eq!(notes.len(), 2, "{}", run.err());
    assert!(
        notes[0].ends_with("for 1699999998.999 s after 0.000 s; most of that is passed over"),
        "{notes:?}"
    );
    // What the rules take seconds for is noticed in the silence and not after it.
    let after = |object: &&serde_json::Value| object["t"].as_f64().is_some_and(|t| t > 1_699_999_999.0);
    let found = objects.iter().filter(after).find(|object| object["rule"] == "not_answering").unwrap();
    assert!(found["t"].as_f64().unwrap() < 1_699_999_999.0 + 60.0, "{found}");
    // An end that lies in the silence is kept.
    let run = devicenet(&["monitor", &format!("log:{path}"), "--json", "--for", "1h"]);
    assert_eq!(run.json().last().unwrap()["t"], 3_600.0);
}

#[test]
fn lines_that_cannot_be_read_are_counted_and_are_no_health() {
    let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/unreadable.log");
    std::fs::write(path, "(1.000000) can0 40A#00\nnot a frame\n(1.1) can0 ZZZ#\n(1.200000) can0 40A#00\n")
        .unwrap();
    for command in ["monitor", "scan"] {
        let run = devicenet(&[command, &format!("log:{path}")]);
        assert_eq!(run.code(), 1, "{command}: {}", run.err());
        assert!(
            run.err().contains("unreadable.log: 2 lines could not be read\n"),
            "{command}: {}",
            run.err()
        );
    }
}

/// As `candump -d` writes it: neither a bad line nor a finding, for all commands alike.
#[test]
fn what_a_recording_says_was_lost_is_told() {
    let path = crate::record::file("lost.log");
    let log = "(1.0) can0 40A#00\nDROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n(1.1) can0 40A#00\n";
    std::fs::write(&path, log).unwrap();
    let endpoint = format!("log:{}", path.display());
    let told = "lost.log: 3 frames were lost when it was recorded, as it says itself\n";
    let recording = crate::record::file("of-lost.log");
    for arguments in [
        &["monitor", &endpoint][..],
        &["scan", &endpoint],
        &["record", &endpoint, "--output", recording.to_str().unwrap()],
        &["decode", path.to_str().unwrap()],
    ] {
        let run = devicenet(arguments);
        assert_eq!((run.code(), run.err().contains(told)), (0, true), "{arguments:?} {}", run.err());
    }
}
