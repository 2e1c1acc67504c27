//! The same commands on interfaces of a real kernel, each node a process of its own.

use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};

use crate::devicenet;

/// Every test of this program that is marked as ignored, where there is CAN: in a user-mode kernel, or on this machine.
#[test]
fn on_a_real_kernel() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts/can-kernel");
    let check = Command::new(&script).arg("--ready").stdin(Stdio::null()).output().expect("the script runs");
    if !check.status.success() {
        let why = String::from_utf8_lossy(&check.stderr).trim().to_owned();
        assert!(std::env::var_os("DEVICENET_REQUIRE_CAN_KERNEL").is_none(), "no kernel with CAN: {why}");
        eprintln!("SKIPPED: the tests on a real kernel: {why}");
        return;
    }
    let run = Command::new(&script)
        .arg("--")
        .arg(std::env::current_exe().expect("this program"))
        .args(["--ignored", "--test-threads=1"])
        .stdin(Stdio::null())
        .output()
        .expect("the script runs");
    let (out, err) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    println!("{out}{err}");
    assert!(run.status.success(), "{}", run.status);
    assert!(!out.contains(" 0 passed"), "nothing ran");
}

/// A node in the background, which ends by itself.
struct Node {
    child: Child,
    out: BufReader<ChildStdout>,
    told: String,
}

impl Node {
    fn start(role: &str, bus: &str, name: &str, span: &str) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_devicenet"))
            .args([role, bus, "line.toml", "--node", name, "--allow-tx", "--listen", "1ms", "--for", span])
            .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/live"))
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let out = BufReader::new(child.stdout.take().unwrap());
        Self { child, out, told: String::new() }
    }

    /// Waits until it tells this.
    fn until(&mut self, words: &str) {
        while !self.told.lines().any(|line| line.contains(words)) {
            let read = self.out.read_line(&mut self.told).unwrap();
            assert!(read > 0, "{words} is missing in\n{}", self.told);
        }
    }

    /// Waits for its end.
    fn told(mut self) -> String {
        self.out.read_to_string(&mut self.told).unwrap();
        assert!(self.child.wait().unwrap().success(), "{}", self.told);
        core::mem::take(&mut self.told)
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        let _ = self.child.kill().and_then(|()| self.child.wait());
    }
}

#[test]
#[ignore = "needs vcan"]
fn a_master_and_three_slaves() {
    let slaves = ["valve", "gauge", "switch"].map(|name| Node::start("slave", "vcan0", name, "9s"));
    let master = Node::start("master", "vcan0", "scanner", "7s").told();
    for line in [
        "slave 10: Configuring -> Running",
        "slave 11: Configuring -> Running",
        "slave 12: Configuring -> Running",
        "slave 10: poll: input data 01 02 03",
        "slave 11: poll: input data 01 02 03 04 05 06 07 08 09 0A 0B 0C",
        "slave 12: COS/cyclic: input data 05",
    ] {
        assert!(master.contains(line), "{line} is missing in\n{master}");
    }
    let [valve, ..] = slaves.map(Node::told);
    assert!(valve.contains("poll: output data 80"), "{valve}");
}

#[test]
#[ignore = "needs vcan"]
fn one_mac_id_in_two_processes() {
    let mut first = Node::start("slave", "vcan1", "valve", "8s");
    first.until("-> OnLine");
    let second = Node::start("slave", "vcan1", "valve", "3s").told();
    let first = first.told();
    assert!(first.contains("-> OnLine") && !first.contains("-> CommFault"), "{first}");
    assert!(second.contains("-> CommFault") && !second.contains("-> OnLine"), "{second}");
}

#[test]
#[ignore = "needs vcan"]
fn nodes_are_listed_and_asked() {
    let mut gauge = Node::start("slave", "vcan1", "gauge", "120s");
    gauge.until("-> OnLine");
    let scan = devicenet(&["scan", "vcan1", "--allow-tx", "--json"]);
    assert_eq!(scan.code(), 0, "{}", scan.err());
    let [object] = &scan.json()[..] else { panic!("{}", scan.out()) };
    assert_eq!((&object["mac"], &object["product_name"]), (&11.into(), &"\"gauge\"".into()));
    let get = devicenet(&["get", "vcan1", "11", "1/1/6", "--allow-tx"]);
    assert_eq!(
        (get.out().as_str(), get.code()),
        ("node 11  Identity 1 Serial number: 9030\n", 0),
        "{}",
        get.err()
    );
    let set = devicenet(&["set", "vcan1", "11", "3/1/3", "1", "--allow-tx"]);
    assert_eq!(set.code(), 0, "{}", set.err());
    let get = devicenet(&["get", "vcan1", "11", "3/1/3", "--allow-tx"]);
    assert!(get.out().starts_with("node 11  DeviceNet 1 Bus-off interrupt: "), "{} {}", get.out(), get.err());
    assert_eq!(devicenet(&["get", "vcan1", "11", "3/1/3"]).code(), 4, "not without --allow-tx");
    let absent = devicenet(&["get", "vcan1", "13", "1/1/1", "--allow-tx"]);
    assert_eq!(absent.code(), 1, "{}", absent.err());
}

fn sh(script: &str) {
    let status = Command::new("sh").args(["-c", script]).stdin(Stdio::null()).status().unwrap();
    assert!(status.success(), "{script}");
}

#[test]
#[ignore = "needs vcan"]
fn an_interface_that_goes_down_ends_a_visit() {
    let begin = std::time::Instant::now();
    sh("(sleep 1.5; ip link set vcan1 down) >/dev/null 2>&1 &");
    let scan = devicenet(&["scan", "vcan1", "--allow-tx", "--listen", "1ms"]);
    sh("ip link set vcan1 up");
    assert_eq!((scan.code(), scan.out().as_str()), (3, ""), "{}", scan.err());
    assert_eq!(scan.error(), "vcan1 went down before everything was asked");
    assert!(begin.elapsed() < std::time::Duration::from_secs(10));
}

#[test]
#[ignore = "needs vcan"]
fn a_controller_that_is_off_the_bus_is_told_with_what_to_do() {
    for (listen, after) in [("1s", "0.3"), ("1ms", "1.5")] {
        sh(&format!("(sleep {after}; cansend vcan1 20000040#0000000000000000) >/dev/null 2>&1 &"));
        let get = devicenet(&["get", "vcan1", "10", "1/1/1", "--allow-tx", "--listen", listen]);
        assert_eq!(get.code(), 3, "{}", get.err());
        assert!(get.error().contains("bus-off") && get.error().contains("type can restart"), "{}", get.err());
    }
}

#[test]
#[ignore = "needs vcan"]
fn an_interrupted_listener_says_what_it_has_heard() {
    sh("(sleep 1; cansend vcan1 457#00341245230000) >/dev/null 2>&1 &");
    let scan = Command::new("timeout")
        .args(["--preserve-status", "-s", "INT", "2", env!("CARGO_BIN_EXE_devicenet")])
        .args(["scan", "vcan1", "--listen", "60s", "--json"])
        .output()
        .unwrap();
    let out = String::from_utf8(scan.stdout).unwrap();
    assert!(scan.status.success() && out.contains("\"mac\":10"), "{} {out}", scan.status);
}
