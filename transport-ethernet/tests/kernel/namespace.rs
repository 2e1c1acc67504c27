//! A network namespace for the tests of this program that need one, and cables of a test's own there. Tests of other crates include
//! this file by its path.

use std::process::{Command, Stdio};

/// Runs the tests of this program that are marked as ignored in a network namespace, which ends with them. It takes root, or a
/// kernel that lets users have namespaces.
pub(crate) fn run_ignored(arguments: &[&str]) {
    let unshare = || {
        let mut command = Command::new("unshare");
        command.arg("-rn").arg("--").stdin(Stdio::null());
        command
    };
    let check =
        unshare().args(["ip", "link", "add", "check0", "type", "veth", "peer", "name", "check1"]).output();
    let why = match check {
        Ok(output) if output.status.success() => None,
        Ok(output) => Some(String::from_utf8_lossy(&output.stderr).trim().to_owned()),
        Err(error) => Some(format!("unshare: {error}")),
    };
    if let Some(why) = why {
        assert!(std::env::var_os("DEVICENET_REQUIRE_VETH").is_none(), "no network namespace: {why}");
        eprintln!("SKIPPED: the tests on virtual cables: {why}");
        return;
    }
    let run = unshare()
        .arg(std::env::current_exe().expect("this program"))
        .arg("--ignored")
        .args(arguments)
        .output()
        .expect("unshare runs");
    let (out, err) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    println!("{out}{err}");
    assert!(run.status.success(), "{}", run.status);
    assert!(!out.contains(" 0 passed"), "nothing ran");
}

/// A cable with an interface at each end, gone at the end of the test.
pub(crate) struct Cable(pub(crate) &'static str, pub(crate) &'static str);

impl Cable {
    pub(crate) fn new(one: &'static str, other: &'static str) -> Self {
        let cable = Self(one, other);
        cable.plug();
        cable
    }

    pub(crate) fn plug(&self) {
        // The addresses stay the same when the adapter comes back.
        let (one, other) = (format!("02:00:00:00:{}", tail(self.0)), format!("02:00:00:01:{}", tail(self.1)));
        ip(&[
            "link", "add", self.0, "address", &one, "type", "veth", "peer", "name", self.1, "address", &other,
        ]);
        self.set(0, "up");
        self.set(1, "up");
    }

    /// Takes the adapters out of the machine.
    pub(crate) fn unplug(&self) {
        ip(&["link", "delete", self.0]);
    }

    /// Sets one end up or down; the other then has no cable.
    pub(crate) fn set(&self, end: usize, what: &str) {
        ip(&["link", "set", [self.0, self.1][end], what]);
    }
}

impl Drop for Cable {
    fn drop(&mut self) {
        let _ = Command::new("ip").args(["link", "delete", self.0]).output();
    }
}

/// Two bytes of an address that tell names apart.
fn tail(name: &str) -> String {
    let [high, low] =
        name.bytes().fold(0_u16, |sum, byte| sum.wrapping_mul(31).wrapping_add(byte.into())).to_be_bytes();
    format!("{high:02x}:{low:02x}")
}

pub(crate) fn ip(arguments: &[&str]) {
    let output = Command::new("ip").args(arguments).stdin(Stdio::null()).output().expect("ip runs");
    assert!(output.status.success(), "ip {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}
