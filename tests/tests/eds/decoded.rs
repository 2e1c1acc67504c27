//! `decode --eds`: a session with the device of `block.eds`, named.

use std::path::PathBuf;

use clap::Parser as _;
use devicenet_cli::args::{Cli, Command};
use devicenet_cli::decode::{Decoder, Sheets};
use devicenet_cli::recording::Recording;

use super::path;

/// Node 10 is the device of the file, node 11 another.
const SESSION: &str = "\
(0.000) can0 457#00341245230000
(1.000) can0 456#014B03010301
(1.001) can0 453#01CB00
(1.010) can0 454#010E0F0201
(1.011) can0 453#018E0800
(1.020) can0 454#010E010101
(1.021) can0 453#018E3412
(1.030) can0 454#010E010102
(1.031) can0 453#018E0700
(1.040) can0 454#010E010103
(1.041) can0 453#018E2A00
(1.050) can0 454#0110050209E803
(1.051) can0 453#0190E803
(1.060) can0 454#010E0F0201
(1.061) can0 453#018E0800
(1.070) can0 454#01100F010101
(1.071) can0 453#0190
(1.080) can0 455#FF
(1.081) can0 3CA#8102
(1.090) can0 455#FF
(1.091) can0 3CA#81
(1.100) can0 454#010E046503
(1.101) can0 453#018E8101
(2.000) can0 45E#014B03010301
(2.001) can0 45B#01CB00
(2.010) can0 45C#010E0F0201
(2.011) can0 45B#018E0800
(3.000) can0 457#00771245230000
(3.010) can0 454#010E0F0201
(3.011) can0 453#018E0800
";

fn decoded(options: &[&str]) -> String {
    let arguments = [&["devicenet", "decode", "-"], options].concat();
    let Command::Decode(args) = Cli::parse_from(arguments).command else { panic!("decode") };
    let sheets = Sheets::read(&args.eds).unwrap_or_else(|failure| panic!("{failure}"));
    let json = options.contains(&"--json");
    let mut decoder = Decoder::new(&args, json, false).with_sheets(sheets);
    let mut recording = Recording::from_reader(SESSION.as_bytes()).expect("a recording");
    let mut out = Vec::new();
    while let Some(frame) = recording.next() {
        decoder.frame(&mut out, &frame.expect("a frame"), recording.channels());
    }
    String::from_utf8(out).expect("UTF-8")
}

fn block() -> PathBuf {
    path("block")
}

#[test]
fn a_device_is_known_by_its_identity() {
    let text = decoded(&["--eds", block().to_str().expect("UTF-8")]);
    insta::with_settings!({
        description => "names only after vendor, device type and product code of node 10 were read, none for data of another \
            size, none for node 11, none after a node of another vendor has taken MAC ID 10",
        omit_expression => true, prepend_module_to_snapshot => false
    }, {
        insta::assert_snapshot!("decode__identity", text);
    });
}

#[test]
fn a_node_is_given_its_file() {
    let text = decoded(&["--eds", &format!("11={}", block().display())]);
    let named: Vec<&str> = text.lines().filter(|line| line.contains('[')).collect();
    assert_eq!(named.len(), 1, "{text}");
    assert!(named[0].ends_with("[Input filter: 0.8 ms]"), "{}", named[0]);
}

#[test]
fn names_are_an_object() {
    let text = decoded(&["--json", "--eds", block().to_str().expect("UTF-8")]);
    let objects =
        text.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).expect("an object"));
    let named: Vec<_> = objects.filter(|object| !object["eds"].is_null()).collect();
    assert_eq!(named.len(), 6);
    assert_eq!(named[2]["eds"]["text"], "[Outputs: FF]");
    let poll = &named[3];
    assert_eq!(poll["kind"], "poll_response");
    assert_eq!(poll["eds"]["text"], "[Inputs: 0x81 (IN0, IN7); State: Fault (2)]");
    let state = &poll["eds"]["values"][1];
    let expected =
        serde_json::json!({ "name": "State", "text": "Fault (2)", "param": 4, "first_bit": 8, "bits": 4 });
    assert_eq!(state, &expected);
}
