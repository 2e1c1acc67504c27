//! `devicenet decode` as a user meets it: the built program, its output, its messages, its exit codes.
#![allow(
    clippy::arithmetic_side_effects,
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test may panic"
)]

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

fn capture(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../tests/captures").join(name);
    path.to_str().expect("a path in UTF-8").to_owned()
}

fn devicenet(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_devicenet"));
    command.args(arguments).env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE");
    command
}

fn run(arguments: &[&str]) -> Output {
    devicenet(arguments).output().unwrap()
}

/// Runs with a recording on standard input.
fn run_with_input(arguments: &[&str], input: &str) -> Output {
    let mut child = devicenet(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    child.wait_with_output().unwrap()
}

fn stdout(output: &Output) -> &str {
    str::from_utf8(&output.stdout).unwrap()
}

fn stderr(output: &Output) -> &str {
    str::from_utf8(&output.stderr).unwrap()
}

#[track_caller]
fn assert_exit(output: &Output, code: i32) {
    assert_eq!(output.status.code(), Some(code), "stderr: {}", stderr(output));
}

fn json_lines(output: &Output) -> Vec<Value> {
    stdout(output)
        .lines()
        .map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}")))
        .collect()
}

const CAPTURES: [&str; 12] = [
    "bei-mhk5-cos.log",
    "candump-L-mixed.log",
    "candump-ta.txt",
    "icpdas-can8124-poll.log",
    "icpdas-i7242d-cyclic.log",
    "inficon-get-set-assembly-path.log",
    "mks-baratron-explicit.log",
    "session-two-slaves-on-vcan.log",
    "slave-01-startup-poll.log",
    "slave-04-fragmented-response.log",
    "socketcan-le-usec.pcap",
    "socketcan.pcapng",
];

#[test]
fn every_capture_gives_a_line_and_an_object_for_each_frame() {
    for name in CAPTURES {
        let text = run(&["decode", &capture(name)]);
        let json = run(&["decode", "--json", &capture(name)]);
        let objects = json_lines(&json);
        assert_eq!(stdout(&text).lines().count(), objects.len(), "{name}");
        assert_eq!(text.status.code(), json.status.code(), "{name}");
        assert_eq!(stderr(&text), "", "{name}");
        assert!(stdout(&text).lines().all(|line| line.contains("  | ")), "{name}");
        for (object, n) in objects.iter().zip(1u64..) {
            let object = object.as_object().unwrap();
            let first: Vec<_> = object.keys().collect();
            for field in ["t", "n", "id", "ext", "rtr", "dlc", "data"] {
                assert!(object.contains_key(field), "{name}: {field} is missing in {first:?}");
            }
            assert_eq!(object["n"], n, "{name}");
        }
    }
}

#[test]
fn json_keeps_every_digit_of_the_time() {
    let output = run(&["decode", "--json", &capture("slave-01-startup-poll.log")]);
    let first = stdout(&output).lines().next().unwrap();
    let start =
        r#"{"t":1700000002.500300,"n":1,"id":1111,"ext":false,"rtr":false,"dlc":7,"data":"00341245230000","#;
    assert!(first.starts_with(start), "{first}");
}

#[test]
fn json_has_the_fields_of_a_response() {
    let output = run(&["decode", "--json", &capture("slave-01-startup-poll.log")]);
    let response = json_lines(&output).swap_remove(5);
    let expected = serde_json::json!({
        "t": 1_700_000_006.020_3, "n": 6, "id": 0x453, "ext": false, "rtr": false, "dlc": 4, "data": "0190c409",
        "channel": "can0", "protocol": "devicenet", "group": 2, "msg": 3, "src": 10, "dst": 1,
        "kind": "explicit_response", "service": 0x10, "service_name": "Set_Attribute_Single",
        "class": 5, "instance": 1, "attribute": 9, "attribute_name": "expected_packet_rate",
        "value": "c409", "value_text": "EPR 2500 ms", "request": { "n": 5, "latency": 0.0003 },
        "text": "10 -> 1  Set_Attribute_Single: EPR 2500 ms",
    });
    assert_eq!(response, expected);
}

#[test]
fn json_has_the_fields_of_what_is_no_devicenet() {
    let objects = json_lines(&run(&["decode", "--json", &capture("candump-L-mixed.log")]));
    let expected = serde_json::json!({
        "t": 1_700_000_000.000_5, "n": 6, "id": 4, "ext": false, "rtr": false, "dlc": 8, "data": "0004000000000000",
        "channel": "can0", "protocol": "unknown", "kind": "foreign",
        "problem": "error frame: controller problem", "problem_code": "error_frame",
        "text": "error frame: controller problem",
    });
    assert_eq!(objects[5], expected);
    assert_eq!((&objects[6]["kind"], &objects[6]["dlc"]), (&"foreign".into(), &9.into()));
}

#[test]
fn text_is_aligned_and_tells_who_and_what() {
    let output = run(&["decode", &capture("icpdas-can8124-poll.log")]);
    let expected = "\
1700000000.000000    10       44E  0A 4B 03 01 07 0A        | 10 -> 9  Allocate explicit + poll + bit-strobe, master 10
1700000000.001000     9       44B  0A CB 00                 | 9 -> 10  Allocate: body format 8/8
1700000000.002000    10       44C  0A 10 05 02 09 0A 0E     | 10 -> 9  Set_Attribute_Single Connection 2 EPR 3594 ms
1700000000.003000     9       44B  0A 90 10 0E              | 9 -> 10  Set_Attribute_Single: EPR 3600 ms (3594 ms requested)
";
    assert_eq!(stdout(&output), expected);
    assert_exit(&output, 0);
}

#[test]
fn filters_by_node_and_kind() {
    let file = capture("session-two-slaves-on-vcan.log");
    let all = json_lines(&run(&["decode", "--json", &file]));
    let of_60 = json_lines(&run(&["decode", "--json", "--mac", "60", &file]));
    let expected: Vec<_> = all.iter().filter(|object| object["src"] == 60 || object["dst"] == 60).collect();
    assert!(!expected.is_empty() && expected.len() < all.len());
    assert_eq!(of_60.iter().collect::<Vec<_>>(), expected);
    let polls = ["decode", "--json", "--kind", "poll_command", "--kind", "poll_response", &file];
    let kinds: Vec<_> = json_lines(&run(&polls)).iter().map(|object| object["kind"].clone()).collect();
    assert_eq!(kinds, ["poll_command", "poll_response", "poll_command", "poll_response"]);
    let unknown = run(&["decode", "--kind", "pol_command", &file]);
    assert_exit(&unknown, 2);
    assert!(stderr(&unknown).contains("poll_command"), "it suggests one: {}", stderr(&unknown));
}

#[test]
fn times_are_counted_from_where_the_reader_wants() {
    let log = "(1700000000.000500) can0 455#\n(1700000001.000500) can0 45D#\n(1700000001.000750) can0 45D#\n\
               (1700000001.000700) can0 45D#\n";
    let times = |format| {
        let output = run_with_input(&["decode", "--mac", "11", "--time", format, "-"], log);
        let words = stdout(&output).lines().map(|line| line.split_whitespace().next().unwrap().to_owned());
        words.collect::<Vec<_>>()
    };
    assert_eq!(times("absolute"), ["1700000001.000500", "1700000001.000750", "1700000001.000700"]);
    assert_eq!(times("relative"), ["1.000000", "1.000250", "1.000200"], "the first is not shown");
    assert_eq!(times("delta"), ["1.000000", "0.000250", "0.000000"]);
    let json = |format| run_with_input(&["decode", "--json", "--time", format, "-"], log).stdout;
    assert_eq!(json("delta"), json("absolute"));
}

/// What comes before is learned from, and the load is that of the part.
#[test]
fn a_part_of_a_recording_is_shown() {
    let file = capture("slave-01-startup-poll.log");
    let all = json_lines(&run(&["decode", "--json", &file]));
    let part = json_lines(&run(&["decode", "--json", "--from", "3.5s", "--to", "3600ms", &file]));
    let first = all[0]["t"].as_f64().unwrap();
    let is_in = |object: &&Value| (3.4999995..=3.6000005).contains(&(object["t"].as_f64().unwrap() - first));
    let expected: Vec<_> = all.iter().filter(is_in).collect();
    assert!(!expected.is_empty() && expected.len() < all.len());
    assert_eq!(part.iter().collect::<Vec<_>>(), expected);
    let summary =
        json_lines(&run(&["decode", "--summary", "--json", "--from", "3.5s", "--to", "3.6s", &file]));
    assert!(summary[0]["seconds"].as_f64().unwrap() <= 0.1, "{}", summary[0]);
    for wrong in [&["--from", "2s", "--to", "1s"][..], &["--from", "2"], &["--to", "soon"]] {
        assert_exit(&run(&[&["decode"], wrong, &[&file[..]]].concat()), 2);
    }
}

#[test]
fn findings_are_those_of_the_frames_shown() {
    let file = capture("slave-04-fragmented-response.log");
    assert_exit(&run(&["decode", &file]), 1);
    assert_exit(&run(&["decode", "--kind", "dup_mac_request", &file]), 0);
    assert_exit(&run(&["decode", "--summary", &file]), 1);
}

#[test]
fn the_summary_counts_nodes_and_connections() {
    let file = capture("slave-01-startup-poll.log");
    let output = run(&["decode", "--summary", "--bit-rate", "125k", &file]);
    let expected = "\
can0: 30 frames in 4.210 s, 0 with a problem
bus load 0.45 % at 125 kbit/s, stuff bits and intermission included

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

/// pcapng lets an interface have any name.
#[test]
fn the_name_of_an_interface_does_not_command_the_terminal() {
    use devicenet_cli::recording::{Content, WriteFormat, Writer};
    use link_core::{Frame, Instant, frame::standard_id};
    let mut bytes = Vec::new();
    let mut writer = Writer::new(&mut bytes, WriteFormat::PcapNg).unwrap();
    for name in ["can0", "\u{1B}[31m"] {
        let frame = Content::Classic(Frame::new(standard_id(0x455), &[]).unwrap());
        writer.write(Instant::ZERO, 9, name, &frame).unwrap();
    }
    writer.finish().unwrap();
    let file = temporary("names.pcapng");
    std::fs::write(&file, bytes).unwrap();
    for (arguments, expected) in [
        (&["decode", &file][..], " \u{FFFD}[31m/- "),
        (&["decode", "--summary", &file], "\n\u{FFFD}[31m: 1 frame in "),
    ] {
        let output = run(arguments);
        assert!(
            stdout(&output).contains(expected) && !stdout(&output).contains('\u{1B}'),
            "{}",
            stdout(&output)
        );
    }
    let objects = json_lines(&run(&["decode", "--json", &file]));
    assert_eq!(objects[1]["channel"], "\u{1B}[31m", "JSON escapes it");
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

#[test]
fn formats_of_the_same_traffic_decode_to_the_same_words() {
    let lines = |name| {
        let output = run(&["decode", &capture(name)]);
        stdout(&output).lines().take(20).map(str::to_owned).collect::<Vec<_>>()
    };
    let log = lines("slave-01-startup-poll.log");
    assert_eq!(lines("candump-ta.txt"), log);
    assert_eq!(lines("socketcan-le-usec.pcap"), log);
    assert_eq!(lines("socketcan.pcapng"), log);
}

#[test]
fn a_bad_line_is_a_warning_with_its_place_and_the_rest_is_read() {
    let log = "(1.000000) can0 456#014B03010301\n(1.000300) can0 453#01CBx\n(1.000400) can0 455#\n";
    let output = run_with_input(&["decode", "-"], log);
    assert_exit(&output, 1);
    assert_eq!(
        stderr(&output),
        "warning: <stdin>:2:25: two hexadecimal digits expected, \"x\" found\n\
         warning: <stdin>: 1 line could not be read\n"
    );
    assert_eq!(stdout(&output).lines().count(), 2);
}

/// candump says what it lost, a capture of several interfaces holds more than CAN: no findings, but worth knowing.
#[test]
fn what_a_recording_tells_besides_its_frames_is_a_note() {
    let output = run(&["decode", "--strict", &capture("candump/two.log")]);
    assert!(!stderr(&output).contains("could not be read"), "{}", stderr(&output));
    let note = format!(
        "note: {}: 4 frames were lost when it was recorded, as it says itself\n",
        capture("candump/two.log")
    );
    assert!(stderr(&output).ends_with(&note), "{}", stderr(&output));
}

/// A pcapng file by hand: an interface for Ethernet, one for CAN by the name of `CAN 1`, a packet of each, and a packet of an
/// interface that is not described.
#[test]
fn a_capture_of_more_than_can_is_recorded_with_names_of_one_word() {
    let block = |kind: u32, body: &[u8]| {
        let length = u32::try_from(12 + body.len()).unwrap().to_le_bytes();
        [&kind.to_le_bytes(), &length, body, &length].concat()
    };
    let packet = |interface: u8| {
        let fields = [interface, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 8, 0, 0, 0, 8, 0, 0, 0];
        block(6, &[&fields[..], &[0, 0, 4, 0x55, 0, 0, 0, 0]].concat())
    };
    let bytes = [
        block(0x0A0D_0D0A, &[0x4D, 0x3C, 0x2B, 0x1A, 1, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255]),
        block(1, &[1, 0, 0, 0, 0, 0, 0, 0]),
        block(1, b"\xE3\0\0\0\0\0\0\0\x02\0\x05\0CAN 1\0\0\0"),
        packet(0),
        packet(1),
        packet(2),
    ];
    let (file, copy) = (temporary("two-networks.pcapng"), temporary("two-networks.log"));
    std::fs::write(&file, bytes.concat()).unwrap();
    let output = run(&["decode", "--record", &copy, &file]);
    assert_exit(&output, 1);
    assert_eq!(
        stderr(&output),
        format!(
            "warning: {file}:record 3, byte 1: an interface that was described before expected, \"02 00 00 00\" found\n\
             note: {copy}: a name in a candump log is one word, so \"CAN 1\" is written as \"CAN_1\"\n\
             note: {file}: 1 packet is of other interfaces than CAN, and left out\n\
             warning: {file}: 1 record could not be read\n"
        )
    );
    assert_eq!(std::fs::read_to_string(copy).unwrap(), "(0.000000) CAN_1 455#\n");
}

#[test]
fn strict_stops_at_a_bad_line() {
    let log = "(1.000000) can0 456#014B03010301\nnonsense\n(1.000400) can0 455#\n";
    let output = run_with_input(&["decode", "--strict", "-"], log);
    assert_exit(&output, 2);
    assert_eq!(stderr(&output), "error: <stdin>:2:1: \"(\" and a time expected, \"nonsense\" found\n");
    assert_eq!(stdout(&output).lines().count(), 1, "what was read before is shown");
}

#[test]
fn what_is_no_recording_is_an_error() {
    let missing = run(&["decode", "no-such-file.log"]);
    assert_exit(&missing, 2);
    assert!(stderr(&missing).starts_with("error: no-such-file.log: No such file"), "{}", stderr(&missing));
    let manifest = run(&["decode", concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")]);
    assert_exit(&manifest, 2);
    assert!(
        stderr(&manifest)
            .contains("not a recording: candump log or screen output, pcap, pcapng or Vector ASC")
    );
    // It holds a log, which is not what is meant.
    let scenario = run(&["decode", concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/plant.toml")]);
    assert_exit(&scenario, 2);
    assert!(stderr(&scenario).contains("`devicenet simulate`"), "{}", stderr(&scenario));
    let directory = run(&["decode", env!("CARGO_MANIFEST_DIR")]);
    assert_exit(&directory, 2);
    let expected = concat!("error: ", env!("CARGO_MANIFEST_DIR"), ": is a directory, not a recording\n");
    assert_eq!(stderr(&directory), expected);
}

#[test]
fn a_cut_off_file_shows_its_frames_and_then_fails() {
    let whole = std::fs::read(capture("socketcan.pcapng")).unwrap();
    let file = temporary("cut.pcapng");
    std::fs::write(&file, &whole[..whole.len() - 8]).unwrap();
    let output = run(&["decode", &file]);
    assert_exit(&output, 2);
    assert_eq!(stdout(&output).lines().count(), 23);
    assert!(stderr(&output).ends_with("it ends within the record after frame 23\n"));
}

/// What was read before the damage is summed up and recorded.
#[test]
fn a_cut_off_file_is_summed_up_and_recorded_and_then_fails() {
    let whole = std::fs::read(capture("socketcan.pcapng")).unwrap();
    let (file, copy) = (temporary("cut-2.pcapng"), temporary("cut-2.log"));
    std::fs::write(&file, &whole[..whole.len() - 8]).unwrap();
    let output = run(&["decode", "--summary", "--record", &copy, &file]);
    assert_exit(&output, 2);
    assert!(
        stderr(&output).starts_with(&format!("error: {file}: the file is cut off")),
        "{}",
        stderr(&output)
    );
    assert!(stdout(&output).contains(": 23 frames in "), "{}", stdout(&output));
    assert_eq!(std::fs::read_to_string(&copy).unwrap().lines().count(), 23);
    let log = "(1.000000) can0 455#01\nnonsense\n(1.000400) can0 455#\n";
    let output = run_with_input(&["decode", "--summary", "--strict", "-"], log);
    assert!(
        stdout(&output).starts_with("can0: 1 frame in 0.000 s, 0 with a problem\n"),
        "{}",
        stdout(&output)
    );
    assert!(stderr(&output).starts_with("error: <stdin>:2:1: "), "{}", stderr(&output));
}

/// Whoever looks only at the beginning still gets the whole copy.
#[test]
fn a_copy_is_complete_when_the_words_are_not_wanted() {
    let (file, copy) = (temporary("long-2.log"), temporary("long-2-copy.log"));
    let log: String =
        (0..50_000).map(|n| format!("({}.{:06}) can0 455#0102\n", n / 1000, n % 1000 * 1000)).collect();
    std::fs::write(&file, &log).unwrap();
    let mut child = devicenet(&["decode", "--record", &copy, &file])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(stderr(&output), "");
    assert!(std::fs::read_to_string(&copy).unwrap() == log);
}

#[test]
fn a_node_sees_what_is_for_all() {
    let log = "\
(0.000000) can0 7ED#3F4B03
(0.001000) can0 7ED#3F4C
(0.002000) can0 7ED#4A4C
(0.003000) can0 7ED#4B4C
(0.004000) can0 7EC#4BCC
(0.005000) can0 7ED#0A4D341245230000
(0.006000) can0 45F#00341245230000
(0.007000) can0 7ED#034D341245230000
(0.008000) can0 401#
(0.009000) can0 408#0000000000000000
(0.010000) can0 781#0A4B0031
(0.011000) can0 781#0B4B0031
(0.012000) can0 457#00341245240000
(0.013000) can0 7EF#014B240001000000
";
    let shown = |mac| {
        let objects = json_lines(&run_with_input(&["decode", "--json", "--mac", mac, "-"], log));
        objects.iter().filter_map(|object| object["n"].as_u64()).collect::<Vec<_>>()
    };
    // Who and Identify to all; those that name it; what makes it 10; commands to many; UCMM; its check; the tool's claim.
    assert_eq!(shown("10"), [1, 2, 3, 6, 9, 10, 11, 13, 14]);
    // Identify and its answer; the device that has checked for 11 shall be 3.
    assert_eq!(shown("11"), [1, 2, 4, 5, 6, 7, 8, 9, 10, 12, 14]);
    assert_eq!(shown("3"), [1, 2, 6, 8, 9, 10, 14]);
}

#[test]
fn a_protocol_that_is_not_supported_is_refused_in_words() {
    let file = capture("slave-01-startup-poll.log");
    let words = run(&["decode", &file]);
    for protocol in ["auto", "devicenet"] {
        assert_eq!(stdout(&run(&["decode", "--protocol", protocol, &file])), stdout(&words), "{protocol}");
    }
    let refused = run(&["decode", "--protocol", "devicenex", &file]);
    assert_exit(&refused, 2);
    assert_eq!(stdout(&refused), "");
    assert!(stderr(&refused).starts_with("error: DeviceNeX is not supported yet"), "{}", stderr(&refused));
    let help = run(&["decode", "--help"]);
    assert!(stdout(&help).contains("DeviceNeX: not supported yet"), "{}", stdout(&help));
}

#[test]
fn wrong_usage_exits_with_2() {
    for arguments in [
        &["decode"][..],
        &["decode", "--mac", "64", "x"],
        &["decode", "--protocol", "profibus", "x"],
        &["decode", "--bit-rate", "fast", "x"],
        &["no-such-command"],
    ] {
        assert_exit(&run(arguments), 2);
    }
}

#[test]
fn help_of_every_command_has_an_example() {
    for arguments in [&["--help"][..], &["decode", "--help"]] {
        let output = run(arguments);
        assert_exit(&output, 0);
        let text = stdout(&output);
        assert!(text.contains("Example") && text.contains("  devicenet decode "), "{text}");
        assert!(text.contains("Exit codes:"), "{text}");
    }
}

/// The reader has seen enough: no message, no failure.
#[test]
fn a_closed_pipe_ends_quietly() {
    let file = temporary("long.log");
    let log: String =
        (0..50_000).map(|n| format!("({}.{:06}) can0 455#0102\n", n / 1000, n % 1000 * 1000)).collect();
    std::fs::write(&file, log).unwrap();
    let mut child =
        devicenet(&["decode", &file]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut reader = BufReader::new(child.stdout.take().unwrap());
    reader.read_line(&mut String::new()).unwrap();
    drop(reader);
    let output = child.wait_with_output().unwrap();
    assert_eq!(stderr(&output), "");
    assert_exit(&output, 0);
}

/// `candump -L can0 | devicenet decode -` shows a frame when it comes, not when a buffer is full.
#[test]
fn a_live_pipe_is_shown_at_once() {
    let mut child = devicenet(&["decode", "-"]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    let mut reader = BufReader::new(child.stdout.take().unwrap());
    for n in 0..3 {
        input.write_all(format!("({n}.000000) can0 455#0{n}\n").as_bytes()).unwrap();
        let mut line = String::new();
        reader.read_line(&mut line).unwrap();
        assert!(line.contains(&format!("455  0{n} ")), "{line}");
    }
    drop(input);
    assert!(child.wait().unwrap().code().is_some());
}

#[test]
fn a_copy_can_be_written_in_either_format_and_decodes_the_same() {
    let original = capture("candump-L-mixed.log");
    let json = |file: &str| json_lines(&run(&["decode", "--json", file]));
    for name in ["copy.pcapng", "copy.log"] {
        let copy = temporary(name);
        run(&["decode", "--record", &copy, &original]);
        let (mut expected, found) = (json(&original), json(&copy));
        if name.ends_with("pcapng") {
            // The copy has nanoseconds, the same number.
            assert_eq!(expected[0]["t"].as_f64(), found[0]["t"].as_f64());
        }
        for (expected, found) in expected.iter_mut().zip(&found) {
            expected["t"] = found["t"].clone();
        }
        assert_eq!(expected, found, "{name}");
    }
}

#[test]
fn a_recording_is_converted_on_standard_output_and_never_over_itself() {
    let output = run(&["decode", "--record", "-", &capture("candump-ta.txt")]);
    let original = std::fs::read_to_string(capture("slave-01-startup-poll.log")).unwrap();
    let first: String = original.lines().take(20).map(|line| format!("{line}\n")).collect();
    assert_eq!(stdout(&output), first);
    let file = temporary("itself.log");
    std::fs::write(&file, &original).unwrap();
    let link = temporary("itself-too.log");
    let _ = std::fs::remove_file(&link);
    std::fs::hard_link(&file, &link).unwrap();
    for name in [&file, &link] {
        let output = run(&["decode", "--record", name, &file]);
        assert_exit(&output, 2);
        let input = std::fs::File::open(&file).unwrap();
        let redirected = devicenet(&["decode", "--record", name, "-"]).stdin(input).output().unwrap();
        assert_exit(&redirected, 2);
        assert_eq!(std::fs::read_to_string(&file).unwrap(), original);
    }
}

#[test]
fn nothing_found_is_said_on_standard_error() {
    for arguments in [&["decode", "-"][..], &["decode", "--json", "-"], &["decode", "--summary", "-"]] {
        let output = run_with_input(arguments, "");
        assert_exit(&output, 0);
        assert_eq!(stderr(&output), "note: <stdin>: no frames\n");
    }
    let file = capture("icpdas-can8124-poll.log");
    let output = run(&["decode", "--mac", "0x3F", &file]);
    assert_exit(&output, 0);
    assert_eq!(
        (stdout(&output), stderr(&output)),
        ("", &*format!("note: {file}: no frame of 4 passed the filters\n"))
    );
    let output = run(&["decode", "--summary", "--mac", "63", &file]);
    let header = "\
can0: 0 frames in 0.003 s, 0 with a problem
bus load 0.00 % at 125 kbit/s, stuff bits and intermission included
";
    assert_eq!(stdout(&output), header);
    let objects = json_lines(&run_with_input(&["decode", "--summary", "--json", "-"], ""));
    assert_eq!((objects.len(), &objects[0]["summary"], &objects[0]["frames"]), (1, &"bus".into(), &0.into()));
}

#[test]
fn the_summary_tells_which_problems_there_are() {
    let log = "(1.000000) can0 7F0#\n(1.500000) can0 00000455#\n(1.700000) can0 00000456#\n\
               (2.000000) can0 20000004#0004000000000000\n";
    let output = run_with_input(&["decode", "--summary", "-"], log);
    assert_exit(&output, 1);
    let expected = "
problem              frames  first frame  first time  first in words
extended_identifier       2            2    1.500000  29-bit identifier
invalid_identifier        1            1    1.000000  identifier that must not be used
error_frame               1            4    2.000000  error frame: controller problem
";
    assert!(stdout(&output).ends_with(expected), "{}", stdout(&output));
    let objects = json_lines(&run_with_input(&["decode", "--summary", "--json", "-"], log));
    let problems: Vec<_> = objects.iter().filter(|object| object["summary"] == "problem").collect();
    assert_eq!(problems.len(), 3);
    let expected = serde_json::json!({
        "summary": "problem", "channel": "can0", "problem": "extended_identifier", "frames": 2,
        "first": { "n": 2, "t": 1.5, "text": "29-bit identifier" },
    });
    assert_eq!(*problems[0], expected);
}

#[test]
fn kinds_are_listed_in_the_help_and_taken_with_commas() {
    let help = run(&["decode", "--help"]);
    assert!(stdout(&help).contains("explicit_request, explicit_response"), "{}", stdout(&help));
    let file = capture("session-two-slaves-on-vcan.log");
    let apart = run(&["decode", "--kind", "poll_command", "--kind", "poll_response", &file]);
    let with_comma = run(&["decode", "--kind", "poll_command,poll_response", &file]);
    assert_eq!(stdout(&with_comma), stdout(&apart));
    assert_eq!(stdout(&with_comma).lines().count(), 4);
    let wrong = run(&["decode", "--mac", "abc", &file]);
    assert_exit(&wrong, 2);
    assert!(stderr(&wrong).contains("a MAC ID is 0 to 63"), "{}", stderr(&wrong));
}

#[test]
fn two_outputs_do_not_share_standard_output() {
    for option in ["--json", "--summary"] {
        let output = run(&["decode", option, "--record", "-", &capture("candump-ta.txt")]);
        assert_exit(&output, 2);
        assert_eq!(stdout(&output), "");
        let expected = format!("error: {option} and `--record -` both want standard output");
        assert!(stderr(&output).starts_with(&expected), "{}", stderr(&output));
    }
}

/// A path for this test process only.
fn temporary(name: &str) -> String {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("decode-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name).to_str().expect("a path in UTF-8").to_owned()
}
