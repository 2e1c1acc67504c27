#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::arithmetic_side_effects,
    clippy::indexing_slicing,
    missing_docs,
    reason = "a benchmark"
)]
//! Round trips a second: two machines on two ports, each in a process of its own, beside a plain C program over the same
//! virtual interface of the same kernel.
//!
//! `cargo bench -p transport-socketcan`. Outside of a kernel with CAN it runs itself in one, by `scripts/can-kernel`: once with
//! virtual interfaces as they are, once with those that echo each frame to its sender, as hardware does.

use core::ops::ControlFlow;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};

use link_core::{
    Action, Deadline, Filter, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, StandardId, TxToken,
    drive,
};
use transport_socketcan::SocketCanPort;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        [] => in_a_kernel(),
        ["compare", plain] => compare(plain),
        ["echo"] => run(Player::new(PONG, PING, u32::MAX)),
        ["ping", count] => run(Player::new(PING, PONG, count.parse().expect("a number"))),
        _ => ExitCode::from(2),
    }
}

const PING: u16 = 0x100;
const PONG: u16 = 0x101;
const BUS: &str = "vcan0";
/// So few that both programs of a pair find the machine in the same mood.
const COUNT: u32 = 1000;

/// Builds the C program, and goes where there is CAN.
fn in_a_kernel() -> ExitCode {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let plain = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("plain");
    let source = here.join("benches/round_trip/plain.c");
    let built =
        Command::new("cc").arg("-O2").arg("-o").arg(&plain).arg(source).status().expect("a C compiler: cc");
    assert!(built.success(), "cc failed");
    let this = std::env::current_exe().expect("this program");
    let kernels: [&[&str]; 2] = [&[], &["--echo"]];
    let succeeded = kernels.iter().all(|kernel| {
        let status = Command::new(here.join("../scripts/can-kernel"))
            .args(*kernel)
            .arg("--")
            .args([this.as_os_str(), "compare".as_ref(), plain.as_os_str()])
            .status();
        status.expect("scripts/can-kernel").success()
    });
    if succeeded { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// In turn, so that whatever else the machine does slows both.
fn compare(plain: &str) -> ExitCode {
    let this = std::env::current_exe().expect("this program");
    let has_echo = SocketCanPort::open(BUS).expect("a virtual interface").interface().has_echo();
    println!(
        "{BUS}, {}:",
        if has_echo { "which echoes frames to their sender" } else { "which echoes nothing" }
    );
    let mut pairs: Vec<(f64, f64)> = (0..ROUNDS)
        .map(|_| {
            let ours = seconds(&mut Command::new(&this), &mut Command::new(&this), &[]);
            let theirs = seconds(&mut Command::new(plain), &mut Command::new(plain), &[BUS]);
            println!("ours {:.1} us, plain C {:.1} us: {:.2}", each(ours), each(theirs), theirs / ours);
            (ours, theirs)
        })
        .collect();
    pairs.sort_by(|one, other| (one.1 / one.0).total_cmp(&(other.1 / other.0)));
    let (ours, theirs) = pairs[ROUNDS / 2];
    // What disturbs a round only makes it longer.
    let (best, their_best) =
        pairs.iter().fold((f64::MAX, f64::MAX), |best, pair| (best.0.min(pair.0), best.1.min(pair.1)));
    println!(
        "round trips, of those of plain C: {:.2} (median of {ROUNDS} pairs), {:.2} (the fastest of each, {:.1} and {:.1} us)",
        theirs / ours,
        their_best / best,
        each(best),
        each(their_best)
    );
    ExitCode::SUCCESS
}

/// The microseconds of one round trip.
fn each(seconds: f64) -> f64 {
    seconds * 1e6 / f64::from(COUNT)
}

const ROUNDS: usize = 25;

fn seconds(echo: &mut Command, ping: &mut Command, bus: &[&str]) -> f64 {
    let mut echo = Kill(echo.arg("echo").args(bus).stdout(Stdio::piped()).spawn().expect("the echo starts"));
    let mut ready = [0];
    echo.0.stdout.as_mut().expect("a pipe").read_exact(&mut ready).expect("the echo says that it listens");
    let output = ping.arg("ping").args(bus).arg(COUNT.to_string()).output().expect("the ping runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).trim().parse().expect("seconds")
}

struct Kill(Child);

impl Drop for Kill {
    fn drop(&mut self) {
        let _ = self.0.kill().and_then(|()| self.0.wait());
    }
}

fn run(mut player: Player) -> ExitCode {
    let mut port = SocketCanPort::open(BUS).expect("a virtual interface");
    let begin = std::time::Instant::now();
    drive(&mut player, &mut port, |_, _, ()| ControlFlow::Break(())).expect("the port works");
    println!("{:.9}", begin.elapsed().as_secs_f64());
    ExitCode::SUCCESS
}

/// Sends a frame when the answer to the last one is there, and the last one is on the bus; has a time-out like any protocol.
struct Player {
    own: Frame,
    other: StandardId,
    state: State,
    left: u32,
    filter_due: bool,
    in_flight: bool,
    time_out: Instant,
}

#[derive(PartialEq)]
enum State {
    Due,
    Waiting,
}

impl Player {
    fn new(own: u16, other: u16, count: u32) -> Self {
        let id = |raw| StandardId::new(raw).expect("an identifier");
        let state = if own == PING { State::Due } else { State::Waiting };
        let own = Frame::new(id(own), &[0; 8]).expect("eight bytes");
        Self {
            own,
            other: id(other),
            state,
            left: count,
            filter_due: true,
            in_flight: false,
            time_out: Instant::MAX,
        }
    }
}

impl Machine for Player {
    type Event = ();

    fn input(&mut self, now: Instant, input: Input) {
        match input {
            Input::Frame(frame) if frame.standard_data_id() == Some(self.other) => self.state = State::Due,
            Input::TxDone(..) => self.in_flight = false,
            Input::Link(LinkEvent::FilterSet) if self.own.raw_id() == u32::from(PONG) => {
                println!("ready");
                std::io::stdout().flush().expect("a pipe");
            }
            Input::Frame(_) | Input::Link(_) | Input::Tick => {}
        }
        self.time_out = now + core::time::Duration::from_secs(1);
    }

    fn poll(&mut self, _: Instant) -> Option<Action<()>> {
        if core::mem::take(&mut self.filter_due) {
            return Some(Action::Link(LinkCommand::SetFilter(
                [Filter::exact(self.other)].into_iter().collect(),
            )));
        }
        if self.in_flight || self.state == State::Waiting {
            return None;
        }
        if self.left == 0 {
            return Some(Action::Event(()));
        }
        self.left -= 1;
        (self.in_flight, self.state) = (true, State::Waiting);
        Some(Action::Transmit(TxToken(0), self.own))
    }

    fn deadline(&self) -> Option<Deadline> {
        Some(Deadline { at: self.time_out, why: "the answer" })
    }

    fn max_in_flight(&self) -> usize {
        1
    }
}
