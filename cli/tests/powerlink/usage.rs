//! What is wrong is said in one line, and with the exit code that it has everywhere.

use std::io::Write as _;
use std::process::Command;

use crate::rig::{Cable, devicenet};

/// The exit code, and the line that says what is wrong.
#[track_caller]
fn refused(command: &mut Command) -> (i32, String) {
    let output = command.output().unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    let errors: Vec<&str> = err.lines().filter_map(|line| line.strip_prefix("error: ")).collect();
    assert!(errors.len() == 1 && output.stdout.is_empty(), "{err}");
    (output.status.code().unwrap(), errors.concat())
}

fn cn(interface: &str) -> Command {
    devicenet(&["powerlink", "cn", interface, "--node", "1"])
}

fn mn(interface: &str, file: &str) -> Command {
    devicenet(&["powerlink", "mn", interface, file])
}

#[test]
fn a_wrong_interface_is_told_with_those_that_there_are() {
    for command in [&mut cn("nosuch0"), &mut mn("nosuch0", "network.toml")] {
        let (code, error) = refused(command);
        assert_eq!(code, 3);
        assert!(error.starts_with("there is no interface nosuch0; "), "{error}");
    }
    let (code, error) = refused(&mut cn("lo"));
    assert_eq!(code, 3);
    assert!(error.starts_with("lo is not an Ethernet interface; "), "{error}");
}

#[test]
#[ignore = "needs a namespace"]
fn without_permission_it_says_what_it_would_send() {
    let cable = Cable::new("per0", "per1");
    let (code, error) = refused(&mut cn(cable.0));
    assert_eq!(code, 4);
    assert!(
        error.starts_with("would send on per0 as node 1: answers to a managing node; say --allow-tx"),
        "{error}"
    );
    let (code, error) = refused(&mut mn(cable.0, "network.toml"));
    assert_eq!(code, 4);
    let what = "would send on per0 as managing node 240: NMTResetNode to every node, a cycle of 50ms, and to node 1 its";
    assert!(error.starts_with(what), "{error}");
}

/// Who is root in the namespace drops all rights.
#[test]
#[ignore = "needs a namespace"]
fn without_the_right_it_names_the_command_that_gives_it() {
    let cable = Cable::new("rig0", "rig1");
    let mut command = Command::new("setpriv");
    command.args([
        "--bounding-set=-all",
        "--no-new-privs",
        env!("CARGO_BIN_EXE_devicenet"),
        "powerlink",
        "cn",
    ]);
    let (code, error) = refused(command.args([cable.0, "--node", "1", "--allow-tx"]));
    assert_eq!(code, 3);
    let how = concat!("as root: setcap cap_net_raw+ep ", env!("CARGO_BIN_EXE_devicenet"));
    assert!(error.ends_with(how), "{error}");
}

#[test]
fn inputs_have_room_in_what_is_mapped() {
    let (code, error) = refused(cn("nosuch0").args(["--inputs", "0102"]));
    assert_eq!((code, error.as_str()), (2, "--inputs has 2 bytes, but --digital 1 and --analog 0 have 1"));
}

/// Each mistake with file, line and column.
#[test]
fn a_wrong_network_file_is_told_with_the_place() {
    let path = std::env::temp_dir().join(format!("devicenet-network-{}.toml", std::process::id()));
    let file = path.to_str().unwrap();
    for (text, place, words) in [
        ("cycle = \"20ms\"", "", "there is no [[node]]; expected at least one"),
        ("cycle = 20\n[[node]]\nnode = 1", ":1:9", "20"),
        ("cyclee = \"20ms\"", ":1:1", "there is no key `cyclee`, did you mean `cycle`?"),
        ("[[node]]\nmandatory = true", ":1:1", "`node`, the number of the node, is missing"),
        ("[[node]]\nnode = 240", ":2:8", "240 is out of range; expected 1 to 239"),
        ("[[node]]\nnode = 1\n[[node]]\nnode = 1", ":4:8", "node 1 is there twice"),
        ("[[node]]\nnode = 1\npreq_limit = 35", ":3:14", "35 is out of range; expected 36 to 1490"),
        ("loss_of_soc_tolerance = \"5s\"\n[[node]]\nnode = 1", ":1:25", "expected at most 4.2s"),
        ("[[node]]\nnode = 1\noutputs = \"5\"", ":3:11", "expected an even number of hexadecimal digits"),
        (
            "[[node]]\nnode = 1\noutputs = \"5a\"\nmap_outputs = [{ object = \"0x6411/1\", bits = 16 }]",
            ":3:11",
            "1 byte; `map_outputs` of this node has 2 bytes",
        ),
        (
            "[[node]]\nnode = 1\nmap_outputs = [{ object = \"0x6200/1\", bits = 8 }]\noutputs = \"5a0201\"",
            ":4:11",
            "3 bytes; `map_outputs` of this node has 1 byte",
        ),
        (
            "[[node]]\nnode = 1\nidentity = { vendor = -1 }",
            ":3:23",
            "-1 is out of range; expected 0 to 4294967295",
        ),
        (
            "[[node]]\nnode = 1\nmap_inputs = [{ object = \"6000\", bits = 8 }]",
            ":3:26",
            "expected index and sub-index",
        ),
        (
            "[[node]]\nnode = 1\nmap_inputs = [{ object = \"6000/1\", bits = 8 }]",
            ":3:26",
            "expected index and sub-index of an object, such as \"0x6200/1\"",
        ),
        (
            "[[node]]\nnode = 1\nasync_only = true\nmap_inputs = [{ object = \"0x6000/1\", bits = 8 }]",
            ":4:15",
            "a node with `async_only` is not polled, and has no process data",
        ),
        (
            "[[node]]\nnode = 1\nmap_inputs = [{ object = \"0x6000/1\" }]",
            ":3:15",
            "`bits`, the length of the object, is missing",
        ),
        (
            "[[node]]\nnode = 1\nmap_inputs = [{ object = \"0x6000/1\", bits = 8 }, { object = \"0x6000/2\", bits = 8, offset = 7 }]",
            ":3:50",
            "bits 0 to 7 are those of 0x6000/1",
        ),
        (
            "[[node]]\nnode = 1\nmap_inputs = [{ object = \"0x6000/1\", bits = 11912, offset = 8 }]",
            ":3:15",
            "it ends at byte 1490; `pres_limit` of this node is 36",
        ),
        ("[node]\nnode = 1", ":1:1", "`[node]` is one table; expected `[[node]]`, as many as there are"),
        (
            "[[node]]\nnode = 1\nmap_inputs = { object = \"0x6000/1\" }",
            ":3:14",
            "expected a list, such as [{ .. }]",
        ),
        (
            "[[node]]\nnode = 1\nwrite = [{ object = \"0x6000/1\" }]",
            ":3:10",
            "expected either `data`, or `value` and `size`",
        ),
        (
            "[[node]]\nnode = 1\nwrite = [{ object = \"0x1/1\", value = 256, size = 1 }]",
            ":3:38",
            "256 does not fit into 1 byte",
        ),
    ] {
        std::fs::write(&path, text).unwrap();
        let (code, error) = refused(&mut mn("nosuch0", file));
        assert_eq!(code, 2, "{text}");
        assert!(error.starts_with(&format!("{file}{place}: ")) && error.contains(words), "{text}: {error}");
    }
    std::fs::remove_file(&path).unwrap();
    let (code, error) = refused(&mut mn("nosuch0", file));
    assert_eq!(code, 2);
    assert!(error.contains("the network cannot be read"), "{error}");
}

/// What only the whole tells is told before anything is opened, at its place.
#[test]
fn a_network_that_cannot_be_is_told() {
    let path = std::env::temp_dir().join(format!("devicenet-whole-{}.toml", std::process::id()));
    let file = path.to_str().unwrap();
    let long =
        format!("[[node]]\nnode = 1\nwrite = [{{ object = \"0x2000/1\", data = \"{}\" }}]", "00".repeat(300));
    let many: Vec<_> = (1..=255).map(|sub| format!("{{ object = \"0x6000/{sub}\", bits = 1 }}")).collect();
    let many = format!("[[node]]\nnode = 1\nmap_inputs = [{}]", many.join(",\n"));
    for (text, place, words) in [
        (
            "cycle = \"1ms\"\n[[node]]\nnode = 1",
            "1:9",
            "a cycle of 1ms is too short: it needs 2.055ms for its frames and waits",
        ),
        ("[[node]]\nnode = 1\npres_timeout = \"30ms\"", "1:1", "a cycle of 20ms is too short: it needs "),
        (
            "cycle = \"20.0005ms\"\n[[node]]\nnode = 1",
            "1:9",
            "a cycle of 20.0005ms; expected whole microseconds",
        ),
        (
            "multiplexed_cycles = 2\n[[node]]\nnode = 1\nmultiplexed_slot = 3",
            "4:20",
            "node 1: multiplexed slot 3: a multiplexed cycle has 2 cycles, counted from 0",
        ),
        (&long, "3:10", "node 1: 0x2000/1 has 300 bytes: there is room for "),
        (&many, "257:1", "node 1: inputs: 255 objects: a mapping has room for 254"),
    ] {
        std::fs::write(&path, text).unwrap();
        let (code, error) = refused(mn("nosuch0", file).arg("--allow-tx"));
        assert_eq!(code, 2, "{error}");
        assert!(error.starts_with(&format!("{file}:{place}: {words}")) && !error.contains('µ'), "{error}");
    }
    std::fs::remove_file(&path).unwrap();
}

/// A network file may come from standard input; a text of another encoding is told where it begins to be one.
#[test]
fn a_network_is_read_from_standard_input() {
    for (bytes, error) in [
        (&b"cycle = 20\n[[node]]\nnode = 1"[..], "(standard input):1:9: "),
        (b"cycle = \xFF\xFE", "(standard input):1:9: this is not UTF-8; expected a TOML text"),
        (b"[[node]]\nnode = 1", "there is no interface nosuch0"),
    ] {
        let (input, mut writer) = std::io::pipe().unwrap();
        writer.write_all(bytes).unwrap();
        drop(writer);
        let (_, told) = refused(mn("nosuch0", "-").arg("--allow-tx").stdin(input));
        assert!(told.starts_with(error), "{told}");
    }
}

/// The help is the reference of the network file.
#[test]
fn the_help_names_every_key_of_a_network_file() {
    let help = devicenet(&["powerlink", "mn", "--help"]).output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    let raw = include_str!("../../src/powerlink/mn/raw.rs");
    let keys = raw.lines().filter_map(|line| line.trim().strip_prefix("pub(super) ")?.split_once(':'));
    let keys: Vec<&str> = keys.map(|(key, _)| key).collect();
    assert!(keys.len() > 40);
    for key in keys {
        assert!(
            help.split(|character: char| !character.is_alphanumeric() && character != '_')
                .any(|word| word == key),
            "{key}"
        );
    }
}

/// What it says of a network file is one, each line as it stands there.
#[test]
fn the_network_file_in_the_help_is_not_broken() {
    let help = devicenet(&["powerlink", "mn", "--help"]).output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    let file = include_str!("../../src/powerlink/mn/network-file.txt");
    assert!(file.lines().all(|line| line.len() <= 100) && help.contains(file), "{help}");
}

#[test]
fn the_help_has_examples() {
    for command in [&["--help"][..], &["powerlink", "--help"]] {
        let help = devicenet(command).output().unwrap();
        let help = String::from_utf8(help.stdout).unwrap();
        assert!(help.contains("\n  devicenet powerlink cn eth0 --node 1 --allow-tx\n"), "{help}");
    }
}
