//! A signal ends a run by the clock.

use std::io::{BufRead as _, BufReader, Read as _};
use std::process::{Command, Output, Stdio};

use super::{Scratch, VALVE, devicenet, stderr, stdout};

/// Runs a scenario by the clock with an expectation that lies far ahead, interrupts it, and gives what it wrote.
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
