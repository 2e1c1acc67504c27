//! `devicenet simulate` as a user meets it: the built program, its output, its messages, its exit codes.
#![allow(
    clippy::arithmetic_side_effects,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test may panic"
)]

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;

const VALVE: &str = r#"
[bus]
duration = "3s"
[[node]]
name = "valve"
protocol = "devicenet"
role = "access"
mac = 10
quick_connect = true
identity = { vendor = 0x1234, serial = 0x00002345 }
[[node]]
name = "can0"
role = "external"
"#;

/// A way onto the bus that has no power while a test runs.
const DARK: &str = r#"
[[node]]
name = "dark"
role = "external"
power_up = "10h"
"#;

/// A file of this test only, removed at its end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str, content: &str) -> Self {
        let path = std::env::temp_dir().join(format!("devicenet-simulate-{}-{name}", std::process::id()));
        std::fs::write(&path, content).expect("a temporary file");
        Self(path)
    }

    fn path(&self) -> &str {
        self.0.to_str().expect("a path in UTF-8")
    }

    fn read(&self) -> Vec<u8> {
        std::fs::read(&self.0).expect("it was written")
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn devicenet(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_devicenet")).args(arguments).output().expect("the program runs")
}

fn stdout(output: &Output) -> &str {
    core::str::from_utf8(&output.stdout).expect("UTF-8")
}

fn stderr(output: &Output) -> &str {
    core::str::from_utf8(&output.stderr).expect("UTF-8")
}

#[track_caller]
fn lines_of_json(output: &Output) -> Vec<Value> {
    stdout(output).lines().map(|line| serde_json::from_str(line).expect(line)).collect()
}

#[test]
fn the_built_in_plant_holds_what_it_promises() {
    let output = devicenet(&["simulate"]);
    assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));
    assert!(output.stderr.is_empty(), "{}", stderr(&output));
    let text = stdout(&output);
    for act in 1..=9 {
        assert!(text.lines().any(|line| line.starts_with(&format!("{act}. "))), "act {act} has no heading");
    }
    assert!(text.ends_with("expectations held\n"), "{text}");
    assert!(text.lines().count() < 250, "too long to be read");
}

#[test]
fn the_same_seed_gives_the_same_bytes_in_every_form() {
    let (one, other) = (Scratch::new("one.pcapng", ""), Scratch::new("other.pcapng", ""));
    let (first, second) = (Scratch::new("one.svg", ""), Scratch::new("other.svg", ""));
    let run = |record: &Scratch, svg: &Scratch, form: &[&str]| {
        let arguments = ["simulate", "--seed", "7", "--record", record.path(), "--svg", svg.path()];
        devicenet(&[&arguments, form].concat()).stdout
    };
    assert_eq!(run(&one, &first, &[]), run(&other, &second, &[]));
    assert_eq!(run(&one, &first, &["--json"]), run(&other, &second, &["--json"]));
    assert_eq!(one.read(), other.read());
    assert_eq!(first.read(), second.read());
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

#[test]
fn the_columns_of_the_trace_do_not_move() {
    let output = devicenet(&["simulate"]);
    let columns: std::collections::BTreeSet<_> =
        stdout(&output).lines().filter_map(|line| line.find(" | ")).collect();
    assert_eq!(columns.len(), 1, "{columns:?}");
}

#[test]
fn another_seed_gives_another_run() {
    let run = |seed| devicenet(&["simulate", "--seed", seed]).stdout;
    assert_ne!(run("1"), run("2"));
}

#[test]
fn an_expectation_that_fails_is_told_and_exits_1() {
    let text = format!("{VALVE}\n[[expect]]\nby = \"1ms\"\nnode = \"valve\"\nstate = \"comm_fault\"\n");
    let scenario = Scratch::new("fails.toml", &text);
    let output = devicenet(&["simulate", scenario.path()]);
    assert_eq!(output.status.code(), Some(1));
    let told = format!(
        "expectation failed: {}, line 15: valve: expected comm_fault by 1ms; found online since 936us; it never came \
         after\n0 of 1 expectation held\n",
        scenario.path()
    );
    assert!(stdout(&output).ends_with(&told), "{}", stdout(&output));

    let json = devicenet(&["simulate", "--json", scenario.path()]);
    assert_eq!(json.status.code(), Some(1));
    let lines = lines_of_json(&json);
    let failed = lines.iter().find(|line| line["event"] == "expectation").expect("the expectation");
    assert_eq!(
        (failed["line"].as_u64(), failed["found"].as_str().map(|text| &text[..6])),
        (Some(15), Some("online"))
    );
    let summary = lines.last().expect("the summary");
    assert_eq!((summary["event"].as_str(), summary["failed"].as_u64()), (Some("summary"), Some(1)));
}

#[test]
fn a_run_that_is_cut_short_judges_what_it_can() {
    let text = format!("{VALVE}\n[[expect]]\nat = \"2s\"\nnode = \"valve\"\nstate = \"online\"\n");
    let scenario = Scratch::new("short.toml", &text);
    let output = devicenet(&["simulate", "--until", "10ms", scenario.path()]);
    assert_eq!(output.status.code(), Some(0));
    assert!(stdout(&output).ends_with("0 of 0 expectations held, 1 lies after the end of the run\n"));
}

#[test]
fn the_help_tells_how_to_write_a_scenario() {
    let help = devicenet(&["simulate", "--help"]);
    for words in ["docs/scenarios.md", "--print-plant", "`-` for standard input"] {
        assert!(stdout(&help).contains(words), "{words} is missing");
    }
}

#[test]
fn the_plant_is_printed_and_standard_input_is_read() {
    let printed = devicenet(&["simulate", "--print-plant"]);
    assert_eq!(printed.status.code(), Some(0));
    let scratch = Scratch::new("printed.toml", stdout(&printed));
    let input = std::fs::File::open(&scratch.0).expect("it was written");
    let read = Command::new(env!("CARGO_BIN_EXE_devicenet"))
        .args(["simulate", "-"])
        .stdin(input)
        .output()
        .expect("the program runs");
    assert_eq!(stdout(&read), stdout(&devicenet(&["simulate"])));
}

#[test]
fn what_makes_no_sense_on_the_command_line_is_told() {
    for (arguments, told) in [
        (["--record", "-"], "--record -: standard output has the trace"),
        (["--svg", "-"], "--svg -: standard output has the trace"),
        (["--until", "-2s"], "`-2s` must not be negative"),
    ] {
        let output = devicenet(&[&["simulate"][..], &arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr(&output).contains(told), "{}", stderr(&output));
    }
}

#[test]
fn a_defect_of_the_scenario_exits_2_and_shows_the_line() {
    let scenario = Scratch::new("defect.toml", "[bus]\n[[node]]\nname = \"a\"\nrole = \"spy\"\n");
    let output = devicenet(&["simulate", scenario.path()]);
    assert_eq!(output.status.code(), Some(2));
    let told = stderr(&output);
    assert!(told.contains("4:8: there is no role `spy`; expected `access`"), "{told}");
    assert!(told.contains("4 | role = \"spy\"\n  |        ^^^^^"), "{told}");
    assert_eq!(devicenet(&["simulate", "no/such.toml"]).status.code(), Some(2));
    assert_eq!(devicenet(&["simulate", "--until", "10"]).status.code(), Some(2));
}

#[test]
fn json_has_the_fields_of_decode_and_the_states() {
    let output = devicenet(&["simulate", "--json"]);
    let lines = lines_of_json(&output);
    let request = lines.iter().find(|line| line["event"] == "frame").expect("a frame");
    assert_eq!(request["kind"], "dup_mac_request");
    assert_eq!(request["nodes"], serde_json::json!(["far"]));
    assert_eq!((request["id"].as_u64(), request["n"].as_u64()), (Some(0x457), Some(1)));
    assert_eq!(request["vendor"].as_u64(), Some(0x1234));
    assert_eq!(request["t"].as_f64(), Some(0.000_952));
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

#[test]
fn the_picture_has_a_row_for_each_node_and_a_legend() {
    let picture = Scratch::new("plant.svg", "");
    let output = devicenet(&["simulate", "--summary", "--svg", picture.path()]);
    assert_eq!(output.status.code(), Some(0));
    let svg = String::from_utf8(picture.read()).expect("UTF-8");
    assert!(svg.starts_with("<svg xmlns=") && svg.ends_with("</svg>\n"));
    assert_eq!(
        svg,
        include_str!("../../docs/plant.svg"),
        "the README shows another picture: cargo run --release -- simulate --summary --svg docs/plant.svg"
    );
    for words in
        ["scanner", "gripper", "on line", "bus load", "communication fault", "time in seconds", "8. Repair"]
    {
        assert!(svg.contains(&format!(">{words}")), "{words} is missing");
    }
}

#[test]
fn the_summary_is_a_table_with_the_last_states() {
    let output = devicenet(&["simulate", "--summary"]);
    let text = stdout(&output);
    let twin = text.lines().find(|line| line.starts_with("twin")).expect("the twin");
    let words: Vec<&str> = twin.split_whitespace().collect();
    assert_eq!(words[..4], ["twin", "access", "13", "online"]);
    assert!(text.contains("22s at 125 kbit/s: "), "{text}");
}

/// One node has defended its MAC ID, the other has restarted after it could not.
#[test]
fn the_decoder_finds_the_same_last_states_in_the_recording() {
    let recording = Scratch::new("states.log", "");
    assert_eq!(devicenet(&["simulate", "--record", recording.path()]).status.code(), Some(0));
    let output = devicenet(&["decode", "--summary", recording.path()]);
    let text = stdout(&output);
    for (node, serial) in [("10", "0x00005001"), ("20", "0x00004001")] {
        let row =
            text.lines().rfind(|line| line.split_whitespace().next() == Some(node) && line.ends_with(serial));
        assert!(row.is_some_and(|row| row.contains("  online  ")), "{text}");
    }
}

/// Runs a scenario by the clock with an expectation that lies far ahead, interrupts it, and gives what it wrote.
#[cfg(unix)]
#[track_caller]
fn interrupted(signal: &str, arguments: &[&str], recording: &Scratch, picture: &Scratch) -> Output {
    let expect = "\n[[expect]]\nat = \"1h\"\nnode = \"valve\"\nstate = \"online\"\n";
    let text = format!("{VALVE}{expect}").replace("3s", "2h");
    let scenario = Scratch::new(&format!("interrupted{signal}.toml"), &text);
    let mut child = Command::new(env!("CARGO_BIN_EXE_devicenet"))
        .args(["simulate", "--record", recording.path(), "--svg", picture.path()])
        .args(arguments)
        .arg(scenario.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program runs");
    // Once there is a frame, the handler is there.
    let mut stdout = BufReader::new(child.stdout.take().expect("its standard output"));
    let mut written = String::new();
    while !written.contains("dup MAC 10 request") {
        assert_ne!(stdout.read_line(&mut written).expect("a line"), 0, "it ended by itself: {written}");
    }
    let kill = Command::new("kill").args([signal, &child.id().to_string()]).status().expect("kill");
    assert!(kill.success());
    stdout.read_to_string(&mut written).expect("the rest");
    let output = child.wait_with_output().expect("it ends");
    Output { stdout: written.into_bytes(), ..output }
}

#[cfg(unix)]
#[test]
fn an_interruption_is_an_end_like_any_other() {
    for (signal, arguments) in [("-INT", &["--serve", "127.0.0.1:0"][..]), ("-TERM", &["--realtime"])] {
        let recording = Scratch::new(&format!("interrupted{signal}.pcapng"), "");
        let picture = Scratch::new(&format!("interrupted{signal}.svg"), "");
        let output = interrupted(signal, arguments, &recording, &picture);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let told = "\n0 of 0 expectations held, 1 lies after the end of the run\n";
        assert!(stdout(&output).ends_with(told), "{}", stdout(&output));
        assert!(String::from_utf8_lossy(&picture.read()).ends_with("</svg>\n"));
        let decoded = devicenet(&["decode", recording.path()]);
        assert!(stdout(&decoded).contains("dup MAC 10 request"), "{}", stdout(&decoded));
    }
}

/// A served bus. Ends with the test.
struct Served {
    child: Child,
    port: String,
    _scenario: Scratch,
}

impl Served {
    fn start(name: &str) -> Self {
        let scenario = Scratch::new(name, &format!("{VALVE}{DARK}").replace("3s", "24h"));
        let mut child = Command::new(env!("CARGO_BIN_EXE_devicenet"))
            .args(["simulate", "--serve", "127.0.0.1:0", scenario.path()])
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program runs");
        let mut line = String::new();
        let stderr = child.stderr.take().expect("its standard error");
        BufReader::new(stderr).read_line(&mut line).expect("it tells where it serves");
        let port = line.trim().rsplit(':').next().expect("a port").to_owned();
        assert!(line.contains("serving can0, dark at 127.0.0.1:"), "{line}");
        Self { child, port, _scenario: scenario }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(format!("127.0.0.1:{}", self.port)).expect("it listens");
        stream.set_read_timeout(Some(core::time::Duration::from_secs(30))).expect("a timeout");
        stream
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What comes until `end` comes.
#[track_caller]
fn hear(stream: &mut TcpStream, end: &str) -> String {
    let mut heard = Vec::new();
    let mut byte = [0];
    while !heard.ends_with(end.as_bytes()) {
        // A signal that interrupts the wait is no answer.
        let read = stream.read_exact(&mut byte);
        assert!(read.is_ok(), "{read:?} after {}", String::from_utf8_lossy(&heard));
        heard.push(byte[0]);
    }
    String::from_utf8(heard).expect("ASCII")
}

#[test]
fn a_client_sends_on_the_served_bus_and_hears_the_answer() {
    let served = Served::start("served.toml");
    let mut client = served.connect();
    client.write_all(b"< open can0 >< rawmode >< send 457 7 0 99 99 1 0 0 0 >").expect("it is read");
    // The node with MAC ID 10 defends it.
    let heard = hear(&mut client, " 80341245230000 >");
    assert!(heard.starts_with("< hi >< ok >< ok >"), "{heard}");
    assert!(heard.contains("< frame 457 "), "{heard}");
}

#[test]
fn a_bad_client_does_not_take_the_server_down() {
    let served = Served::start("rubbish.toml");
    let mut bad = served.connect();
    bad.write_all(b"\x00\xff<<<< send zzz >< open nowhere >").expect("it is read");
    let heard = hear(&mut bad, "no such bus, there is can0, dark >");
    assert!(heard.contains("< error zzz is not an identifier >"), "{heard}");
    drop(bad);
    let mut good = served.connect();
    good.write_all(b"< open can0 >< echo >").expect("it is read");
    assert_eq!(hear(&mut good, "< echo >"), "< hi >< ok >< echo >");
}

#[test]
fn an_address_that_others_can_reach_needs_permission() {
    let output = devicenet(&["simulate", "--serve", "0.0.0.0:0"]);
    assert_eq!(output.status.code(), Some(4));
    assert!(stderr(&output).contains("--allow-remote"), "{}", stderr(&output));
    assert_eq!(devicenet(&["simulate", "--serve", "nonsense"]).status.code(), Some(2));
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = taken.local_addr().expect("its address").to_string();
    assert_eq!(devicenet(&["simulate", "--serve", &address]).status.code(), Some(3));
}

/// Needs python-can (`pip install python-can`) in the `python3` of the path, or in that of `DEVICENET_PYTHON`.
#[test]
fn python_can_sits_on_the_served_bus() {
    let python = std::env::var("DEVICENET_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let has_it =
        Command::new(&python).args(["-c", "import can"]).output().is_ok_and(|output| output.status.success());
    if !has_it {
        assert!(
            std::env::var_os("DEVICENET_REQUIRE_PYTHON_CAN").is_none(),
            "DEVICENET_REQUIRE_PYTHON_CAN is set, and {python} has no python-can"
        );
        eprintln!("SKIPPED python_can_sits_on_the_served_bus: {python} has no python-can");
        return;
    }
    let served = Served::start("python.toml");
    let mut witness = served.connect();
    witness.write_all(b"< open can0 >< rawmode >< echo >").expect("it is read");
    hear(&mut witness, "< echo >");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/python/socketcand.py");
    let output =
        Command::new(&python).arg(script).args(["127.0.0.1", &served.port]).output().expect("python runs");
    assert!(output.status.success(), "{}{}", stdout(&output), stderr(&output));
    hear(&mut witness, "< rtr 321 ");
    assert!(hear(&mut witness, ">").ends_with(" 2 >"));
}
