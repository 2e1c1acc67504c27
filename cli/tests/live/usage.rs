//! What is wrong on the command line is told before anything is sent: one line that says what to do, nothing on standard output, and the
//! exit code.

use crate::devicenet;

/// What goes on with an interface, a command each, without the interface.
const COMMANDS: [&[&str]; 8] = [
    &["scan"],
    &["scan", "--allow-tx"],
    &["get", "10", "1/1/1", "--allow-tx"],
    &["set", "10", "3/1/3", "1", "--allow-tx"],
    &["record", "--output", "not-recorded.log"],
    &["recover", "--allow-tx"],
    &["slave", "line.toml", "--node", "valve", "--allow-tx"],
    &["master", "line.toml", "--allow-tx"],
];

#[track_caller]
fn is_told(arguments: &[&str], code: i32, words: &str) {
    let run = devicenet(arguments);
    assert_eq!((run.code(), run.out().as_str()), (code, ""), "{arguments:?} {}", run.err());
    assert!(run.error().contains(words), "{arguments:?} {}", run.err());
}

#[cfg(target_os = "linux")]
#[test]
fn a_wrong_interface() {
    for command in COMMANDS {
        let on = |endpoint| [&[command[0], endpoint], &command[1..]].concat();
        // And then those that there are, or how to come by one.
        is_told(&on("no-such-can"), 3, "there is no interface no-such-can; th");
        is_told(&on("lo"), 3, "lo is not a CAN interface; th");
        is_told(
            &on("two.toml"),
            2,
            "two.toml is a file: write log:two.toml for a recording, sim:two.toml for a scenario",
        );
    }
}

#[test]
fn a_recording_cannot_be_asked() {
    let log = "log:../../../tests/captures/slave-01-startup-poll.log";
    for command in COMMANDS.into_iter().filter(|command| !["scan", "record"].contains(&command[0])) {
        is_told(
            &[&[command[0], log], &command[1..]].concat(),
            2,
            "is a recording, which cannot be asked: name an interface such as can0, or sim:FILE",
        );
    }
}

#[test]
fn a_wrong_node() {
    for command in ["get", "set"] {
        let value = &["1"][usize::from(command == "get")..];
        let of = |mac| [&[command, "sim:two.toml", mac, "3/1/3"], value].concat();
        is_told(&of("64"), 2, "a MAC ID is 0 to 63");
        is_told(&of("valve"), 2, "a MAC ID is 0 to 63");
        is_told(
            &of("62"),
            2,
            "node 62 is asked, so this command needs another MAC ID: choose a free one with --own-mac",
        );
    }
    is_told(
        &["slave", "sim:two.toml", "line.toml"],
        2,
        "several of the role slave, choose one with --node: valve, gauge, switch",
    );
    is_told(
        &["slave", "sim:two.toml", "line.toml", "--node", "vlave"],
        2,
        "there is no slave named vlave; there is valve, gauge, switch",
    );
    is_told(&["master", "sim:two.toml", "two.toml"], 2, "there is no node of the role master");
    is_told(&["master", "sim:two.toml", "none.toml"], 2, "none.toml: the scenario cannot be read");
}

#[test]
fn malformed_values() {
    let get = ["get", "sim:two.toml", "10"];
    let path = "CLASS/INSTANCE/ATTRIBUTE expected, three numbers up to 65535 such as 1/1/7";
    for attribute in ["1/1", "1/1/x", "70000/1/1", "1/1/7/1"] {
        is_told(&[&get[..], &[attribute]].concat(), 2, path);
    }
    is_told(
        &[&get[..], &["1/1/300"]].concat(),
        2,
        "attribute 300: it is one byte in the messages of DeviceNet, 0 to 255",
    );
    for (option, value, words) in [
        (
            "--listen",
            "5",
            r#"`5` has no unit; expected a time with a unit (ns, us, ms, s, min, h) such as "75ms""#,
        ),
        ("--own-mac", "64", "a MAC ID is 0 to 63"),
    ] {
        is_told(&[&get[..], &["1/1/1", option, value]].concat(), 2, words);
    }
    let set = ["set", "sim:two.toml", "10"];
    for (attribute, value, words) in [
        (
            "3/1/1",
            "64",
            "`64`: DeviceNet 1 MAC ID takes 0 to 63; to send 64 all the same, give its bytes: hex:40",
        ),
        ("3/1/1", "-1", "`-1`: DeviceNet 1 MAC ID takes 0 to 63"),
        ("5/2/9", "-1", "`-1`: Connection 2 expected_packet_rate takes 0 to 65535"),
        ("5/2/5", "0x800", "`0x800`: Connection 2 consumed_connection_id takes 0 to 2047 or 65535"),
        ("3/1/3", "one", "`one`: DeviceNet 1 Bus-off interrupt takes 0 to 1"),
        ("3/1/3", "hex:0", "`hex:0`: pairs of hexadecimal digits expected after hex:"),
        ("3/1/3", "hex:zz", "`hex:zz`: pairs of hexadecimal digits expected after hex:"),
    ] {
        is_told(&[&set[..], &[attribute, value]].concat(), 2, words);
    }
    let recover = ["recover", "sim:two.toml"];
    let assignment = "VENDOR:SERIAL=MAC expected, such as 0x1234:0x00002345=12";
    for (option, value, words) in [
        ("--assign", "1:2", assignment),
        ("--assign", "1:2=64", "`64`: a MAC ID from 0 to 63 expected after the ="),
        ("--identify", "5", "VENDOR:SERIAL expected, such as 0x1234:0x00002345"),
    ] {
        is_told(&[&recover[..], &[option, value]].concat(), 2, words);
    }
    for (first, second, words) in [
        ("1:2=5", "1:2=6", "0x0001:0x00000002 is given two MAC IDs: give each device one"),
        ("1:2=5", "1:3=5", "MAC ID 5 is given to two devices: give each its own"),
    ] {
        is_told(&[&recover[..], &["--assign", first, "--assign", second]].concat(), 2, words);
    }
    let endpoint = "an interface such as can0, sim:FILE or log:FILE expected";
    for text in ["", "log:", "sim:", "LOG:two.log", "can0:1"] {
        is_told(&["monitor", text], 2, endpoint);
    }
    is_told(
        &["monitor", "no/such.log"],
        2,
        "no interface has a / in its name: write log:no/such.log for a recording, sim:no/such.log for a scenario",
    );
    let record = ["record", "sim:two.toml", "--output", "not-recorded.log"];
    for (option, value, words) in [
        ("--trigger", "now", "expected timeout, timeout=MAC, duplicate, error, bus-off"),
        ("--before", "5", "`5` has no unit"),
        ("--for", "soon", "expected a time with a unit"),
        ("--count", "0", "0 is not in 1..=1000"),
    ] {
        is_told(&[&record[..], &[option, value]].concat(), 2, words);
    }
}

/// What a line of the help says stands on it, as it was written: no wider than the help is.
#[test]
fn the_help_has_every_endpoint_and_no_line_that_is_broken() {
    for command in ["scan", "get", "set", "record", "recover", "slave", "master", "monitor"] {
        let help = devicenet(&[command, "--help"]).out();
        let listens = ["scan", "record", "monitor"].contains(&command);
        assert_eq!(help.contains("log:- for"), listens, "{command}: {help}");
        let (_, codes) = help.split_once("Exit codes:").unwrap();
        let (codes, _) = codes.split_once("Examples:").unwrap();
        for line in codes.lines().filter(|line| !line.is_empty() && command != "set") {
            let begins = line.starts_with("     ")
                || line.trim_start().starts_with(|digit: char| digit.is_ascii_digit());
            assert!(begins, "{command}: {line}");
        }
    }
}

#[test]
fn a_recording_in_place_of_a_scenario() {
    is_told(
        &["monitor", "sim:../../../tests/captures/slave-01-startup-poll.log"],
        2,
        "slave-01-startup-poll.log is a recording: write log:../../../tests/captures/slave-01-startup-poll.log to play it",
    );
}

#[test]
fn what_excludes_each_other() {
    for arguments in
        [&["--expect", "line.toml", "--learn", "1s"][..], &["--text", "--json"], &["--for", "0s"]]
    {
        let run = devicenet(&[&["monitor", "sim:two.toml"], arguments].concat());
        assert_eq!((run.code(), run.out().as_str()), (2, ""), "{arguments:?} {}", run.err());
    }
}

#[test]
fn a_scenario_without_a_scan_list_says_of_nobody_that_it_belongs_here() {
    let log = "../../../tests/captures/slave-01-startup-poll.log";
    for command in [&["monitor", "sim:drop.toml"][..], &["decode", "--summary", log]] {
        is_told(
            &[command, &["--expect", "two.toml"]].concat(),
            2,
            "two.toml: there is no master with a scan list, which says who belongs to the bus",
        );
    }
}

/// The master of line.toml has a switch in its scan list that is not on this bus, and the others have other sizes: it tells so,
/// and asks for a release only those that it had.
#[test]
fn a_master_tells_which_slaves_it_has_no_io_with() {
    let run = devicenet(&["master", "sim:two.toml", "line.toml", "--listen", "3s", "--for", "5s"]);
    assert_eq!(run.code(), 1, "{}", run.err());
    assert!(!run.err().contains("did not answer the release"), "{}", run.err());
    assert!(!run.err().contains("12\n"), "{}", run.err());
    assert_eq!(
        run.error(),
        "in the end there was no I/O with 10 (status 77 data size does not match the scan list), 11 (status 77 data size does \
         not match the scan list), 12 (status 84 slave is being initialised): devicenet monitor sim:two.toml says why, and \
         what to check"
    );
}

#[test]
fn a_slave_whose_mac_id_is_taken_is_a_finding() {
    let run = devicenet(&[
        "slave",
        "sim:two.toml",
        "line.toml",
        "--node",
        "valve",
        "--listen",
        "3s",
        "--for",
        "5s",
    ]);
    assert_eq!(run.code(), 1, "{}", run.err());
    assert_eq!(
        run.error(),
        "node 10 is faulted, another node on sim:two.toml has MAC ID 10: give this one another in line.toml, or take that \
         one off"
    );
}

#[test]
fn a_bit_rate_that_cannot_be() {
    let log: String = (0..500).map(|n| format!("(1.{:06}) can7 455#5555555555555555\n", n * 600)).collect();
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("faster-than-said.log");
    std::fs::write(&path, log).unwrap();
    let endpoint = format!("log:{}", path.display());
    for json in ["--text", "--json"] {
        let run = devicenet(&["monitor", &endpoint, json, "--bit-rate", "125k"]);
        assert_eq!(run.code(), 2, "{}", run.err());
        assert_eq!(
            run.error(),
            format!(
                "{}: --bit-rate is too low: 125 kbit/s cannot carry the frames of can7, which need 250 kbit/s at least",
                path.display()
            )
        );
        let run = devicenet(&["monitor", &endpoint, json, "--bit-rate", "250k"]);
        assert_eq!(run.code(), 0, "{}", run.err());
    }
    // Once, and not by much, time stamps may have been late.
    let log = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, log.lines().take(150).map(|line| format!("{line}\n")).collect::<String>()).unwrap();
    let run = devicenet(&["monitor", &endpoint, "--json", "--bit-rate", "125k"]);
    assert_eq!(run.code(), 0, "{}", run.err());
    assert_eq!(
        run.err().matches("--bit-rate is in doubt: once, the frames of can7 came closer").count(),
        1,
        "{}",
        run.err()
    );
    let last = run.json().pop().unwrap();
    assert_eq!((&last["bit_rate"], &last["bit_rate_source"]), (&250_000.into(), &"least".into()));
    let run = devicenet(&["monitor", "sim:drop.toml", "--bit-rate", "250k"]);
    assert_eq!(run.code(), 2, "{}", run.err());
    assert_eq!(
        run.error(),
        "sim:drop.toml: --bit-rate says 250 kbit/s, but it has 125 kbit/s: leave --bit-rate out"
    );
}

#[test]
fn a_dash_is_no_interface_and_an_empty_file_no_recording() {
    for command in ["monitor", "scan", "record"] {
        let run = devicenet(&[command, "-"]);
        assert_eq!((run.code(), run.out().as_str()), (2, ""), "{}", run.err());
        assert!(run.error().ends_with("standard input is a recording: write log:-"), "{}", run.err());
    }
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("empty.toml");
    std::fs::write(&path, "").unwrap();
    let run = devicenet(&["monitor", &format!("sim:{}", path.display())]);
    assert_eq!(run.code(), 2);
    assert!(run.error().contains("there is no table [bus]"), "{}", run.err());
}
