//! The built-in plant, which is the same on every machine.

use std::process::Command;

use super::{Scratch, devicenet, stderr, stdout};

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
    assert!(text.contains("\nscanner: ") && text.contains(" scans, min "), "the figures are missing");
    assert!(text.lines().count() < 480, "too long to be read");
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
fn another_seed_gives_another_run() {
    let run = |seed| devicenet(&["simulate", "--seed", seed]).stdout;
    assert_ne!(run("1"), run("2"));
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
    // Only the built-in plant ends with its figures.
    let figures = stdout(&devicenet(&["simulate", "--summary"])).to_owned();
    let trace = stdout(&read).split("\n\n35 of ").next().unwrap_or_default();
    let built_in = devicenet(&["simulate"]);
    assert!(stdout(&built_in).starts_with(trace) && stdout(&built_in).ends_with(&figures));
}
