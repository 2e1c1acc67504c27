#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::arithmetic_side_effects,
    clippy::indexing_slicing,
    clippy::as_conversions,
    missing_docs,
    reason = "a benchmark"
)]
//! How long a node takes from PReq to PRes: a controlled node of POWERLINK on a port, beside a plain C program that answers without
//! looking, over the same virtual cable, in turn. Both are polled by the same C program.
//!
//! `cargo bench -p transport-ethernet`. It runs itself in a network namespace.

#[cfg(target_os = "linux")]
mod node;

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        [] => in_a_namespace(),
        ["compare", plain] => compare(plain),
        #[cfg(target_os = "linux")]
        ["node"] => node::run(NODE_END),
        _ => ExitCode::from(2),
    }
}

/// Builds the C program, and goes where interfaces can be made.
fn in_a_namespace() -> ExitCode {
    let plain = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("plain-answer");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/answer/plain.c");
    let built =
        Command::new("cc").arg("-O2").arg("-o").arg(&plain).arg(source).status().expect("a C compiler: cc");
    assert!(built.success(), "cc failed");
    let this = std::env::current_exe().expect("this program");
    let status = Command::new("unshare").args(["-rn", "--"]).arg(this).arg("compare").arg(plain).status();
    if status.expect("unshare").success() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// In turn, so that whatever else the machine does slows both.
fn compare(plain: &str) -> ExitCode {
    let ip = |arguments: &[&str]| assert!(Command::new("ip").args(arguments).status().expect("ip").success());
    ip(&["link", "add", NODE_END, "address", "02:00:00:00:00:01", "type", "veth", "peer", "name", OTHER_END]);
    ip(&["link", "set", NODE_END, "up"]);
    ip(&["link", "set", OTHER_END, "up"]);
    let this = std::env::current_exe().expect("this program");
    let mut pairs: Vec<(u64, u64)> = (0..ROUNDS)
        .map(|_| {
            let ours = median(plain, Command::new(&this).arg("node"));
            let theirs = median(plain, Command::new(plain).args(["echo", NODE_END]));
            println!("ours {:.1} us, plain C {:.1} us: {:.2}", us(ours), us(theirs), ratio(&(ours, theirs)));
            (ours, theirs)
        })
        .collect();
    pairs.sort_by(|one, other| ratio(one).total_cmp(&ratio(other)));
    let pair = pairs[ROUNDS / 2];
    println!(
        "PReq to PRes: {:.1} us, plain C {:.1} us: {:.2} of plain C (median of {ROUNDS} pairs)",
        us(pair.0),
        us(pair.1),
        ratio(&pair)
    );
    if ratio(&pair) <= MOST { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Polls a station, and tells the median in ns.
fn median(plain: &str, station: &mut Command) -> u64 {
    let mut station = Kill(station.stdout(Stdio::piped()).spawn().expect("the station starts"));
    let mut ready = [0];
    station
        .0
        .stdout
        .as_mut()
        .expect("a pipe")
        .read_exact(&mut ready)
        .expect("the station says that it listens");
    let output =
        Command::new(plain).args(["poll", OTHER_END, "02-00-00-00-00-01", COUNT]).output().expect("plain");
    assert!(output.status.success(), "{}", output.status);
    String::from_utf8_lossy(&output.stdout).trim().parse().expect("nanoseconds")
}

fn us(nanos: u64) -> f64 {
    nanos as f64 / 1000.0
}

fn ratio((ours, theirs): &(u64, u64)) -> f64 {
    *ours as f64 / *theirs as f64
}

struct Kill(Child);

impl Drop for Kill {
    fn drop(&mut self) {
        let _ = self.0.kill().and_then(|()| self.0.wait());
    }
}

const NODE_END: &str = "node";
const OTHER_END: &str = "mn";
const COUNT: &str = "2000";
const ROUNDS: usize = 25;
/// What an answer may take at most, of that of plain C.
const MOST: f64 = 1.5;
