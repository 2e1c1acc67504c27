//! The command line, its help, and pipes on either side.

use std::io::{BufRead as _, BufReader, Write as _};
use std::process::Stdio;

use super::{assert_exit, capture, devicenet, run, run_with_input, stderr, stdout, temporary};

#[test]
fn wrong_usage_exits_with_2() {
    for arguments in [
        &["decode"][..],
        &["decode", "--mac", "128", "x"],
        &["decode", "--mac", "64", "--protocol", "devicenet", "x"],
        &["decode", "--protocol", "profibus", "x"],
        &["decode", "--bit-rate", "fast", "x"],
        &["no-such-command"],
    ] {
        assert_exit(&run(arguments), 2);
    }
}

/// An option that could change nothing is not taken in silence.
#[test]
fn an_option_without_an_effect_is_refused_in_words() {
    let file = capture("slave-01-startup-poll.log");
    for (options, told) in [
        (&["--bit-rate", "500k"][..], "error: --bit-rate is for the bus load of a summary: add --summary"),
        (&["--bit-rate", "500k", "--json"], "error: --bit-rate is for"),
        (
            &["--time", "delta", "--summary"],
            "error: --time is for the lines of the text, and --summary prints none",
        ),
        (&["--time", "delta", "--scanlist"], "and --scanlist prints none"),
        (&["--time", "absolute", "--json"], "and --json prints none"),
        (&["--time", "delta", "--record", "-"], "and `--record -` prints none"),
        (&["--scanlist", "--mac", "10"], "'--scanlist' cannot be used with '--mac <N>'"),
        (&["--scanlist", "--from", "1s"], "'--scanlist' cannot be used with '--from <TIME>'"),
    ] {
        let output = run(&[&["decode"], options, &[&file]].concat());
        assert_exit(&output, 2);
        assert_eq!(stdout(&output), "");
        assert!(stderr(&output).contains(told), "{}", stderr(&output));
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

#[test]
fn devicenet_is_heard_or_told() {
    let file = capture("slave-01-startup-poll.log");
    let words = run(&["decode", &file]);
    for protocol in ["auto", "devicenet"] {
        let output = run(&["decode", "--protocol", protocol, &file]);
        assert_eq!((stdout(&output), stderr(&output)), (stdout(&words), ""), "{protocol}");
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

/// So many frames of 111 bits and more, every 0.6 ms.
fn burst(frames: u32) -> String {
    (0..frames).map(|n| format!("(1.{:06}) can7 455#5555555555555555\n", n * 600)).collect()
}

#[test]
fn a_bit_rate_that_cannot_carry_the_frames_is_refused() {
    let log = burst(500);
    for json in [&[][..], &["--json"]] {
        let summary =
            |rate: &[&str]| run_with_input(&[&["decode", "--summary", "-"], json, rate].concat(), &log);
        let output = summary(&["--bit-rate", "125k"]);
        assert_exit(&output, 2);
        assert_eq!(stdout(&output), "");
        assert_eq!(
            stderr(&output),
            "error: <stdin>: --bit-rate is too low: 125 kbit/s cannot carry the frames of can7, which need 250 kbit/s at \
             least\n"
        );
        for rate in [&["--bit-rate", "250k"][..], &["--bit-rate", "1M"], &[]] {
            let output = summary(rate);
            assert_eq!((stderr(&output), output.status.code()), ("", Some(0)), "{rate:?}");
        }
    }
}

/// Time stamps may be late.
#[test]
fn a_bit_rate_that_does_not_carry_the_frames_once_counts_as_not_known() {
    let output = run_with_input(&["decode", "--summary", "-", "--bit-rate", "125k"], &burst(150));
    assert_exit(&output, 0);
    assert_eq!(
        stderr(&output),
        "warning: <stdin>: --bit-rate is in doubt: once, the frames of can7 came closer together than 125 kbit/s can carry; unless \
         their time stamps were late it is too low, so it counts as not known\n"
    );
    let words = "at 250 kbit/s or more, stuff bits";
    assert!(stdout(&output).contains(words), "{}", stdout(&output));
}
