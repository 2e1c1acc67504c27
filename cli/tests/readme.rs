//! What the README shows of the program is what the program prints.
#![allow(clippy::expect_used, reason = "a test may panic")]

use std::process::Command;

/// An example of the README: what is shown, and what the program prints.
struct Example {
    shown: String,
    printed: String,
}

/// Runs the example whose command line begins with these words.
fn example(words: &str) -> Example {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let readme = std::fs::read_to_string(format!("{root}/README.md")).expect("the README");
    let (_, rest) = readme.split_once(&format!("$ devicenet {words} ")).expect("the example");
    let (more, rest) = rest.split_once('\n').expect("its output");
    let (shown, _) = rest.split_once("```").expect("the end of its output");
    let output = Command::new(env!("CARGO_BIN_EXE_devicenet"))
        .current_dir(root)
        .args(words.split(' ').chain(more.split(' ')))
        .output()
        .expect("the program runs");
    let printed = String::from_utf8(output.stdout).expect("UTF-8");
    Example { shown: shown.to_owned(), printed }
}

/// Lines may be left out.
fn every_line_is_printed(Example { shown, printed }: &Example) {
    for line in shown.lines() {
        assert!(printed.lines().any(|other| other == line), "not printed any more: {line}");
    }
    assert!(shown.lines().count() > 5);
}

#[test]
fn the_recording_in_the_readme_is_decoded_as_shown() {
    every_line_is_printed(&example("decode"));
}

#[test]
fn the_capture_in_the_readme_is_decoded_as_shown() {
    every_line_is_printed(&example("decode --time"));
}

#[test]
fn the_finding_in_the_readme_is_printed_as_shown() {
    let Example { shown, printed } = example("eds check");
    assert!(
        shown.lines().count() == 4 && printed.contains(shown.trim_end()),
        "not printed any more: {shown}"
    );
}

#[test]
fn the_scan_in_the_readme_is_printed_as_shown() {
    let Example { shown, printed } = example("scan");
    assert_eq!(printed, shown);
}
