//! A kernel with CAN for the tests of this program that need one, and interfaces of a test's own there. Tests of other crates
//! include this file by its path.

use std::path::Path;
use std::process::{Child, Command, Stdio};

/// Runs the tests of this program that are marked as ignored where there is CAN: in a user-mode kernel that
/// `scripts/can-kernel` boots, or on this machine. Each entry is a kernel, all run at once: the script's options, and the arguments of
/// this program.
pub(crate) fn run_ignored(kernels: &[(&[&str], &[&str])]) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts/can-kernel");
    let check = Command::new(&script).arg("--ready").stdin(Stdio::null()).output().expect("the script runs");
    if !check.status.success() {
        let why = String::from_utf8_lossy(&check.stderr).trim().to_owned();
        assert!(std::env::var_os("DEVICENET_REQUIRE_CAN_KERNEL").is_none(), "no kernel with CAN: {why}");
        eprintln!("SKIPPED: the tests on a real kernel: {why}");
        return;
    }
    let start = |(options, arguments): &(&[&str], &[&str])| {
        Command::new(&script)
            .args(*options)
            .arg("--")
            .arg(std::env::current_exe().expect("this program"))
            .arg("--ignored")
            .args(*arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the script runs")
    };
    let running: Vec<Child> = kernels.iter().map(start).collect();
    for run in running {
        let run = run.wait_with_output().expect("it ends");
        let (out, err) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
        println!("{out}{err}");
        assert!(run.status.success(), "{}", run.status);
        assert!(!out.contains(" 0 passed"), "nothing ran");
    }
}

/// A virtual interface that is gone at the end.
pub(crate) struct Interface(pub(crate) &'static str);

impl Interface {
    pub(crate) fn new(name: &'static str) -> Self {
        let interface = Self(name);
        interface.plug();
        interface
    }

    pub(crate) fn plug(&self) {
        ip(&["link", "add", self.0, "type", "vcan"]);
        self.set("up");
    }

    pub(crate) fn unplug(&self) {
        ip(&["link", "delete", self.0]);
    }

    pub(crate) fn set(&self, what: &str) {
        ip(&["link", "set", self.0, what]);
    }
}

impl Drop for Interface {
    fn drop(&mut self) {
        let _ = Command::new("ip").args(["link", "delete", self.0]).output();
    }
}

pub(crate) fn ip(arguments: &[&str]) {
    run("ip", arguments);
}

/// Runs a program that must succeed, and gives what it prints.
pub(crate) fn run(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).stdin(Stdio::null()).output().unwrap();
    assert!(output.status.success(), "{program} {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}
