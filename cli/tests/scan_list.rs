#![allow(clippy::expect_used, reason = "a test may panic")]
//! `devicenet decode --scanlist`: what the traffic tells of a master's scan list is a scan list of a scenario.

use std::path::Path;
use std::process::{Command, Output};

use devicenet_cli::scenario::{Role, Scenario};
use devicenet_cli::simulate::PLANT;
use devicenet_core::master::ScanEntry;

/// The plant is recorded, its scan list rebuilt from the recording alone, and given to a master again.
#[test]
fn the_scan_list_of_the_plant_is_rebuilt_from_its_traffic() {
    let log = std::env::temp_dir().join(format!("devicenet-scan-list-{}.log", std::process::id()));
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_devicenet")).args(arguments).arg(&log).output();
        String::from_utf8(output.expect("the program runs").stdout).expect("UTF-8")
    };
    run(&["simulate", "--record"]);
    let list = run(&["decode", "--scanlist"]);
    let _ = std::fs::remove_file(&log);
    assert!(list.starts_with("# The scan list of MAC ID 0, seen on "), "{list}");

    let node = "[bus]\n[[node]]\nname = \"m\"\nprotocol = \"devicenet\"\nrole = \"master\"\nmac = 0\n\
                identity = { vendor = 1, serial = 1 }\n";
    let rebuilt = Scenario::parse("rebuilt", &format!("{node}{list}"), Path::new("")).expect(&list);
    let plant = Scenario::parse("plant", PLANT, Path::new("")).expect("the plant");
    let entries = |scenario: &Scenario| -> Vec<ScanEntry> {
        match scenario.nodes.first().map(|node| &node.role) {
            Some(Role::Master(master)) => master.scan.iter().map(|slave| slave.entry).collect(),
            _ => Vec::new(),
        }
    };
    let (rebuilt, planned) = (entries(&rebuilt), entries(&plant));
    assert_eq!(rebuilt.len(), 5, "{list}");
    for rebuilt in &rebuilt {
        let planned = planned.iter().find(|entry| entry.mac_id == rebuilt.mac_id).expect(&list);
        assert_eq!(
            (
                rebuilt.mac_id,
                rebuilt.poll,
                rebuilt.bit_strobe,
                rebuilt.change_of_state,
                rebuilt.multicast_poll
            ),
            (
                planned.mac_id,
                planned.poll,
                planned.bit_strobe,
                planned.change_of_state,
                planned.multicast_poll
            ),
            "{list}"
        );
        assert!(planned.key.product_code.is_none_or(|code| rebuilt.key.product_code == Some(code)), "{list}");
    }
}

fn scan_list_of(capture: &str) -> Output {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/captures").join(capture);
    let output =
        Command::new(env!("CARGO_BIN_EXE_devicenet")).args(["decode", "--scanlist"]).arg(path).output();
    output.expect("the program runs")
}

/// The recording ends with the release of the slave.
#[test]
fn a_slave_that_was_released_was_in_the_scan_list() {
    let output = scan_list_of("slave-01-startup-poll.log");
    let list = String::from_utf8(output.stdout).expect("UTF-8");
    let expected =
        "\n[[node.scan]]\nmac = 10\npoll = { produce = 3, epr = \"1s\" }\nkey = { vendor = 0x1234 }\n";
    assert!(list.starts_with("# The scan list of MAC ID 1, seen on can0\n"), "{list}");
    assert!(list.ends_with(expected), "{list}");
}

#[test]
fn a_recording_without_a_master_is_told_to_have_none() {
    let output = scan_list_of("bei-mhk5-cos.log");
    assert_eq!((output.status.code(), output.stdout.len()), (Some(0), 0));
    let told = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(told.contains("no scan list: the recording has no slave whose master is seen"), "{told}");
}

#[test]
fn a_scan_list_is_toml_and_nothing_else() {
    for other in [&["--json"][..], &["--record", "-"]] {
        let output = Command::new(env!("CARGO_BIN_EXE_devicenet"))
            .args(["decode", "--scanlist"])
            .args(other)
            .arg("-")
            .output()
            .expect("the program runs");
        assert_eq!(output.status.code(), Some(2), "{other:?}");
    }
}
