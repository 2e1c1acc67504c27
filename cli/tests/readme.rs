//! What the README shows of the program is what the program prints.
#![allow(clippy::expect_used, reason = "a test may panic")]

use std::process::Command;

#[test]
fn the_recording_in_the_readme_is_decoded_as_shown() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let readme = std::fs::read_to_string(format!("{root}/README.md")).expect("the README");
    let (_, rest) = readme.split_once("$ devicenet decode ").expect("an example of decode");
    let (file, rest) = rest.split_once('\n').expect("its output");
    let (shown, _) = rest.split_once("```").expect("the end of its output");
    let output = Command::new(env!("CARGO_BIN_EXE_devicenet"))
        .args(["decode", &format!("{root}/{file}")])
        .output()
        .expect("the program runs");
    let printed = String::from_utf8(output.stdout).expect("UTF-8");
    for line in shown.lines() {
        assert!(printed.lines().any(|other| other == line), "not printed any more: {line}");
    }
    assert!(shown.lines().count() > 5);
}

#[test]
fn the_capture_in_the_readme_is_decoded_as_shown() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let readme = std::fs::read_to_string(format!("{root}/README.md")).expect("the README");
    let (_, rest) = readme.split_once("$ devicenet decode --time ").expect("an example of POWERLINK");
    let (options, rest) = rest.split_once('\n').expect("its output");
    let (shown, _) = rest.split_once("```").expect("the end of its output");
    let output = Command::new(env!("CARGO_BIN_EXE_devicenet"))
        .current_dir(root)
        .args(["decode", "--time"])
        .args(options.split(' '))
        .output()
        .expect("the program runs");
    let printed = String::from_utf8(output.stdout).expect("UTF-8");
    for line in shown.lines() {
        assert!(printed.lines().any(|other| other == line), "not printed any more: {line}");
    }
    assert!(shown.lines().count() > 5);
}

#[test]
fn the_finding_in_the_readme_is_printed_as_shown() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let readme = std::fs::read_to_string(format!("{root}/README.md")).expect("the README");
    let (_, rest) = readme.split_once("$ devicenet eds check ").expect("an example of eds check");
    let (file, rest) = rest.split_once('\n').expect("its output");
    let (shown, _) = rest.split_once("```").expect("the end of its output");
    let output = Command::new(env!("CARGO_BIN_EXE_devicenet"))
        .current_dir(root)
        .args(["eds", "check", file])
        .output()
        .expect("the program runs");
    let printed = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(
        shown.lines().count() == 4 && printed.contains(shown.trim_end()),
        "not printed any more: {shown}"
    );
}

#[test]
fn the_scan_in_the_readme_is_printed_as_shown() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let readme = std::fs::read_to_string(format!("{root}/README.md")).expect("the README");
    let (_, rest) = readme.split_once("$ devicenet scan ").expect("an example of scan");
    let (endpoint, rest) = rest.split_once('\n').expect("its output");
    let (shown, _) = rest.split_once("```").expect("the end of its output");
    let output = Command::new(env!("CARGO_BIN_EXE_devicenet"))
        .current_dir(root)
        .args(["scan", endpoint])
        .output()
        .expect("the program runs");
    assert_eq!(String::from_utf8(output.stdout).expect("UTF-8"), shown);
}
