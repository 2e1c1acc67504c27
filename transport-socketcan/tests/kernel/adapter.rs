//! An adapter at a serial line, by the kernel's own driver: the test plays the adapter. Tests of other crates include this file by its
//! path.

use std::fs::File;
use std::io::{BufReader, Read as _, Write as _};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use transport_socketcan::Interface;

use super::real_kernel::ip;

/// The far end of the line, and the program that makes an interface of the near one. It has a controller with a bit rate and a listen-only
/// mode, and is down at first.
pub(crate) struct Adapter {
    pub(crate) name: &'static str,
    line: File,
    daemon: Child,
    said: Receiver<u8>,
}

impl Adapter {
    /// Attaches it by `slcand` with these options.
    pub(crate) fn attach(name: &'static str, options: &[&str]) -> Self {
        let line = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&line).unwrap();
        unlockpt(&line).unwrap();
        let tty = ptsname(&line, Vec::new()).unwrap().into_string().unwrap();
        let line = File::from(line);
        let other = BufReader::new(line.try_clone().unwrap());
        let (say, said) = sync_channel(4096);
        std::thread::spawn(move || {
            // A test that hears nothing of this has a line that gets full.
            other.bytes().map_while(Result::ok).try_for_each(|byte| say.send(byte)).unwrap_or_default();
        });
        let daemon = Command::new("slcand")
            .arg("-F")
            .args(options)
            .args([&tty, name])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("slcand, of can-utils");
        let begin = Instant::now();
        while Interface::find(name).is_err() {
            assert!(begin.elapsed() < PATIENCE, "slcand has made no interface {name}");
            std::thread::sleep(Duration::from_millis(10));
        }
        Self { name, line, daemon, said }
    }

    /// Sets it up, with what `ip link set NAME type can` takes.
    pub(crate) fn set_up(&self, mode: &[&str]) {
        ip(&[&["link", "set", self.name, "type", "can"], mode].concat());
        ip(&["link", "set", self.name, "up"]);
    }

    /// What it is told until this.
    #[track_caller]
    pub(crate) fn hears(&self, wanted: &str) -> String {
        let mut heard = String::new();
        while !heard.ends_with(wanted) {
            let byte = self.said.recv_timeout(PATIENCE);
            heard.push(byte.unwrap_or_else(|_| panic!("no {wanted:?}, but {heard:?}")).into());
        }
        heard
    }

    pub(crate) fn says(&mut self, words: &str) {
        self.line.write_all(words.as_bytes()).unwrap();
    }
}

impl Drop for Adapter {
    fn drop(&mut self) {
        let _ = self.daemon.kill().and_then(|()| self.daemon.wait());
    }
}

/// How long anything may take, on a machine that is busy.
const PATIENCE: Duration = Duration::from_secs(30);
