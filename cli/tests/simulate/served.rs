//! `--serve`: the simulated bus for programs that speak socketcand.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use super::python::with_python_can;
use super::{Scratch, VALVE, devicenet, stderr, stdout};

/// A way onto the bus that has no power while a test runs.
const DARK: &str = r#"
[[node]]
name = "dark"
role = "external"
power_up = "10h"
"#;

/// A served bus. Ends with the test.
struct Served {
    child: Child,
    port: String,
    _scenario: Scratch,
}

impl Served {
    fn start(name: &str) -> Self {
        let scenario = Scratch::new(name, &format!("{VALVE}{DARK}").replace("3s", "24h"));
        let mut child = Command::new(env!("CARGO_BIN_EXE_devicenet"))
            .args(["simulate", "--serve", "127.0.0.1:0", scenario.path()])
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program runs");
        let mut line = String::new();
        let stderr = child.stderr.take().expect("its standard error");
        BufReader::new(stderr).read_line(&mut line).expect("it tells where it serves");
        let port = line.trim().rsplit(':').next().expect("a port").to_owned();
        assert!(line.contains("serving can0, dark at 127.0.0.1:"), "{line}");
        Self { child, port, _scenario: scenario }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(format!("127.0.0.1:{}", self.port)).expect("it listens");
        stream.set_read_timeout(Some(core::time::Duration::from_secs(30))).expect("a timeout");
        stream
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What comes until `end` comes.
#[track_caller]
fn hear(stream: &mut TcpStream, end: &str) -> String {
    let mut heard = Vec::new();
    let mut byte = [0];
    while !heard.ends_with(end.as_bytes()) {
        // A signal that interrupts the wait is no answer.
        let read = stream.read_exact(&mut byte);
        assert!(read.is_ok(), "{read:?} after {}", String::from_utf8_lossy(&heard));
        heard.push(byte[0]);
    }
    String::from_utf8(heard).expect("ASCII")
}

#[test]
fn a_client_sends_on_the_served_bus_and_hears_the_answer() {
    let served = Served::start("served.toml");
    let mut client = served.connect();
    client.write_all(b"< open can0 >< rawmode >< send 457 7 0 99 99 1 0 0 0 >").expect("it is read");
    // The node with MAC ID 10 defends it.
    let heard = hear(&mut client, " 80341245230000 >");
    assert!(heard.starts_with("< hi >< ok >< ok >"), "{heard}");
    assert!(heard.contains("< frame 457 "), "{heard}");
}

#[test]
fn a_bad_client_does_not_take_the_server_down() {
    let served = Served::start("rubbish.toml");
    let mut bad = served.connect();
    bad.write_all(b"\x00\xff<<<< send zzz >< open nowhere >").expect("it is read");
    let heard = hear(&mut bad, "no such bus, there is can0, dark >");
    assert!(heard.contains("< error zzz is not an identifier >"), "{heard}");
    drop(bad);
    let mut good = served.connect();
    good.write_all(b"< open can0 >< echo >").expect("it is read");
    assert_eq!(hear(&mut good, "< echo >"), "< hi >< ok >< echo >");
}

#[test]
fn an_address_that_others_can_reach_needs_permission() {
    let output = devicenet(&["simulate", "--serve", "0.0.0.0:0"]);
    assert_eq!(output.status.code(), Some(4));
    assert!(stderr(&output).contains("--allow-remote"), "{}", stderr(&output));
    assert_eq!(devicenet(&["simulate", "--serve", "nonsense"]).status.code(), Some(2));
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = taken.local_addr().expect("its address").to_string();
    assert_eq!(devicenet(&["simulate", "--serve", &address]).status.code(), Some(3));
}

#[test]
fn python_can_sits_on_the_served_bus() {
    let Some(python) = with_python_can("python_can_sits_on_the_served_bus") else { return };
    let served = Served::start("python.toml");
    let mut witness = served.connect();
    witness.write_all(b"< open can0 >< rawmode >< echo >").expect("it is read");
    hear(&mut witness, "< echo >");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/python/socketcand.py");
    let output =
        Command::new(&python).arg(script).args(["127.0.0.1", &served.port]).output().expect("python runs");
    assert!(output.status.success(), "{}{}", stdout(&output), stderr(&output));
    hear(&mut witness, "< rtr 321 ");
    assert!(hear(&mut witness, ">").ends_with(" 2 >"));
}
