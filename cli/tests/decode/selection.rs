//! Which frames are shown, and how their times are counted.

use serde_json::Value;

use super::{assert_exit, capture, json_lines, run, run_with_input, stderr, stdout};

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
bus load at most 0.00 % at 125 kbit/s or more (--bit-rate says which), stuff bits and intermission included
verdict: silent: no frame was heard
";
    assert_eq!(stdout(&output), header);
    let objects = json_lines(&run_with_input(&["decode", "--summary", "--json", "-"], ""));
    assert_eq!((objects.len(), &objects[0]["summary"], &objects[0]["frames"]), (1, &"bus".into(), &0.into()));
}
