//! A program that runs in the background, and what it tells.

use std::io::{BufRead as _, BufReader, Read as _};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

/// A program in the background. It is gone at the end of the test.
pub(crate) struct Process {
    child: Child,
    lines: Receiver<String>,
    told: String,
    errors: Option<JoinHandle<String>>,
}

/// How a program ended.
pub(crate) struct Ended {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Process {
    pub(crate) fn start(arguments: &[&str]) -> Self {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/live");
        Self::spawn(Command::new(env!("CARGO_BIN_EXE_devicenet")).args(arguments).current_dir(folder))
    }

    pub(crate) fn spawn(command: &mut Command) -> Self {
        let mut child =
            command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let (sender, lines) = channel();
        let out = BufReader::new(child.stdout.take().unwrap());
        std::thread::spawn(move || {
            // The test may have seen enough.
            out.lines().map_while(Result::ok).try_for_each(|line| sender.send(line)).unwrap_or_default();
        });
        let mut err = child.stderr.take().unwrap();
        let errors = std::thread::spawn(move || {
            let mut text = String::new();
            err.read_to_string(&mut text).unwrap();
            text
        });
        Self { child, lines, told: String::new(), errors: Some(errors) }
    }

    /// A node of a scenario on an interface, until it is interrupted.
    pub(crate) fn node(role: &str, bus: &str, file: &str, name: &str) -> Self {
        Self::start(&[role, bus, file, "--node", name, "--allow-tx", "--listen", "1ms"])
    }

    /// Waits until it has told a line with these words, from now on.
    #[track_caller]
    pub(crate) fn until(&mut self, words: &str) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            match self.lines.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
                Ok(line) => {
                    self.told += &format!("{line}\n");
                    if line.contains(words) {
                        return;
                    }
                }
                Err(why) => panic!("{words}: {why} after\n{}", self.told),
            }
        }
    }

    /// Waits until it has told all of this, from now on and in whatever order.
    #[track_caller]
    pub(crate) fn until_all(&mut self, words: &[&str]) {
        let begin = self.told.len();
        for words in words {
            if !self.told[begin..].contains(words) {
                self.until(words);
            }
        }
    }

    pub(crate) fn signal(&self, signal: Signal) {
        // It is there until its end was waited for.
        kill_process(Pid::from_child(&self.child), signal).unwrap();
    }

    pub(crate) fn runs(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// Waits for its end.
    #[track_caller]
    pub(crate) fn ended(mut self) -> Ended {
        let deadline = Instant::now() + PATIENCE;
        loop {
            match self.lines.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
                Ok(line) => self.told += &format!("{line}\n"),
                Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) => panic!("it does not end:\n{}", self.told),
            }
        }
        let code = self.child.wait().unwrap().code().expect("an exit code");
        let err = self.errors.take().unwrap().join().unwrap();
        Ended { code, out: core::mem::take(&mut self.told), err }
    }

    /// Interrupts it, and waits for its end.
    #[track_caller]
    pub(crate) fn interrupted(self) -> Ended {
        self.signal(Signal::INT);
        self.ended()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill().and_then(|()| self.child.wait());
    }
}

/// Waits until something is so.
#[track_caller]
pub(crate) fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < deadline, "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Waits until so many ports listen on an interface: each wants error frames, whatever its filter is.
#[track_caller]
pub(crate) fn wait_for_listeners(bus: &str, count: usize) {
    wait_until("nobody listens", || {
        let table = std::fs::read_to_string("/proc/net/can/rcvlist_err").unwrap();
        table.lines().filter(|line| line.split_whitespace().next() == Some(bus)).count() >= count
    });
}

/// How long anything may take, on a machine that is busy.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);
