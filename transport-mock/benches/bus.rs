//! How many virtual seconds a second of computing gives: a polled network at full load, 500 kbit/s, frames of 8 bytes.
//!
//! A ratio is what counts here, so this prints ratios: `cargo bench -p transport-mock`.
#![allow(clippy::unwrap_used, clippy::arithmetic_side_effects, clippy::as_conversions)]

use std::convert::Infallible;
use std::time::{Duration, Instant as WallInstant};

use link_core::frame::standard_id;
use link_core::timers::TimerKey;
use link_core::{
    Action, BitRate, Deadline, Filter, FilterSet, Frame, Input, Instant, LinkEvent, Machine, Timers,
    TxOutcome, TxToken,
};
use transport_mock::{BusConfig, Change, Fault, FaultId, Ignore, Network, NodeConfig, Record, Sink, Which};

fn main() {
    println!(
        "{:<44} {:>9} {:>12} {:>9}",
        "500 kbit/s, full load, 8 data bytes", "x time", "frames/s", "ns/frame"
    );
    for slaves in [7, 63] {
        report(&format!("{} nodes polled", slaves + 1), slaves, 0, config(), 4, &mut Ignore);
    }
    let checked = BusConfig { shared: Some(|_| false), ..config() };
    report("64 nodes polled, producers checked", 63, 0, checked.clone(), 4, &mut Ignore);
    let mut records = 0_u64;
    let mut count = |_: &Record<'_, ()>| records += 1;
    report("64 nodes polled, every record seen", 63, 0, checked, 4, &mut count);
    for idle in [0, 56, 248, 1016] {
        report(&format!("8 nodes polled among {}", 8 + idle), 7, idle, config(), 4, &mut Ignore);
    }
    for slaves in [7, 63] {
        report(
            &format!("{} nodes polled, a fault in every frame", slaves + 1),
            slaves,
            0,
            config(),
            1,
            &mut Ignore,
        );
    }
    let exact = BusConfig { force_exact: true, ..config() };
    for slaves in [7, 63] {
        report(
            &format!("{} nodes polled, force_exact", slaves + 1),
            slaves,
            0,
            exact.clone(),
            1,
            &mut Ignore,
        );
    }
}

fn config() -> BusConfig {
    BusConfig { shared: None, ..BusConfig::new(BitRate::K500, 1) }
}

fn report(name: &str, slaves: u16, idle: u16, config: BusConfig, seconds: u64, sink: &mut impl Sink<()>) {
    // `cargo bench -p transport-mock -- WORDS` runs what has these words in its name.
    if std::env::args().skip(1).any(|word| !word.starts_with('-') && !name.contains(&word)) {
        return;
    }
    let mut network = Network::<()>::new(config);
    let only = |filter| NodeConfig { filter: FilterSet::from_iter([filter]), ..NodeConfig::named("") };
    let master =
        network.add_silent(only(Filter::standard(standard_id(RESPONSE), 0x7C0)), Master::new(slaves));
    for mac in 1..=slaves {
        network.add_silent(only(Filter::exact(command_id(mac))), Slave::new(mac));
    }
    for node in 0..idle {
        // Machines that are there, have a timer, and hear what nobody sends.
        let heard = Filter::exact(standard_id(0x700 | node & 0x7F));
        network.add_silent(only(heard), Slave::new(0));
    }
    if name.contains("fault") {
        // It strikes every frame, so that each is simulated bit by bit, and does no harm: this node only listens.
        let receiver = network.add_silent(
            NodeConfig { listen_only: true, ..only(Filter::exact(standard_id(0x7FF))) },
            Slave::new(0),
        );
        let fault = Fault::SpoiltEnd { receiver, filter: None, which: Which::All };
        network.schedule(Instant::from_millis(1), Change::FaultOn(FaultId(0), fault));
    }
    network.run_until(Instant::from_millis(100), sink);

    // The fastest of some runs: whatever else the machine does only makes it slower.
    let (mut fastest, mut frames) = (f64::MAX, 0.0);
    for _ in 0..RUNS {
        let counted = |network: &Network<()>| network.machine::<Master>(master).unwrap().frames;
        let (before, end) = (counted(&network), network.now() + Duration::from_secs(seconds));
        let started = WallInstant::now();
        network.run_until(end, sink);
        let spent = started.elapsed().as_secs_f64();
        if spent < fastest {
            (fastest, frames) = (spent, (counted(&network) - before) as f64);
        }
    }
    println!(
        "{name:<44} {:>9.0} {:>12.0} {:>9.0}",
        seconds as f64 / fastest,
        frames / fastest,
        fastest * 1e9 / frames
    );
}

/// Polls one slave after the other, without a pause, and watches that they answer.
#[derive(Clone, Debug)]
struct Master {
    slaves: u16,
    next: u16,
    frames: u64,
    ready: bool,
    timers: Timers<Watchdog, 1>,
}

impl Master {
    fn new(slaves: u16) -> Self {
        Self { slaves, next: 1, frames: 0, ready: false, timers: Timers::new() }
    }
}

impl Machine for Master {
    type Event = Infallible;

    fn input(&mut self, now: Instant, input: Input) {
        self.timers.advance(now);
        match input {
            Input::Link(LinkEvent::Up) => self.ready = true,
            Input::TxDone(_, TxOutcome::Sent) => {
                self.frames += 1;
                self.ready = true;
            }
            Input::Frame(_) => {
                self.frames += 1;
                self.timers.set_after(Watchdog, Duration::from_millis(100));
            }
            Input::Link(_) | Input::TxDone(..) | Input::Tick => {}
        }
    }

    fn poll(&mut self, now: Instant) -> Option<Action<Infallible>> {
        assert!(self.timers.take_expired(now).is_none(), "a slave does not answer");
        if !std::mem::take(&mut self.ready) {
            return None;
        }
        let mac = self.next;
        self.next = if mac == self.slaves { 1 } else { mac + 1 };
        let data = self.frames.to_le_bytes();
        Some(Action::Transmit(TxToken(0), Frame::new(command_id(mac), &data)?))
    }

    fn deadline(&self) -> Option<Deadline> {
        self.timers.next()
    }

    fn max_in_flight(&self) -> usize {
        1
    }
}

/// Answers each poll, and watches that it is polled.
#[derive(Clone, Debug)]
struct Slave {
    mac: u16,
    answer: Option<Frame>,
    timers: Timers<Watchdog, 1>,
}

impl Slave {
    fn new(mac: u16) -> Self {
        Self { mac, answer: None, timers: Timers::new() }
    }
}

impl Machine for Slave {
    type Event = Infallible;

    fn input(&mut self, now: Instant, input: Input) {
        self.timers.advance(now);
        if let Input::Frame(command) = input {
            self.timers.set_after(Watchdog, Duration::from_millis(500));
            self.answer = Frame::new(standard_id(RESPONSE | self.mac), command.data());
        }
    }

    fn poll(&mut self, now: Instant) -> Option<Action<Infallible>> {
        assert!(self.timers.take_expired(now).is_none(), "the master does not poll");
        Some(Action::Transmit(TxToken(0), self.answer.take()?))
    }

    fn deadline(&self) -> Option<Deadline> {
        self.timers.next()
    }

    fn max_in_flight(&self) -> usize {
        1
    }
}

#[derive(Clone, Copy, Debug)]
struct Watchdog;

impl TimerKey<1> for Watchdog {
    const ALL: [Self; 1] = [Self];
    const WHY: [&'static str; 1] = ["watchdog"];

    fn index(self) -> usize {
        0
    }
}

/// Group 2 message 5: the master's poll command.
fn command_id(mac: u16) -> link_core::StandardId {
    standard_id(0x405 | mac << 3)
}

/// Group 1 message 15: a slave's poll response.
const RESPONSE: u16 = 0x3C0;

/// How often each line is measured.
const RUNS: u32 = 10;
