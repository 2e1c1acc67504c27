//! What is known of the bus, in memory that does not grow.
//!
//! ```text
//! frames, link events ─▶ decoder ─▶ load by node and purpose, response times, counters
//!                           │
//!                           ├─ doctor ─▶ findings
//!                           └─ looked at ─▶ events       picture ─▶ text, JSON, screen
//! ```

mod changes;
mod event;
mod link;
mod load;
mod picture;
mod problems;
mod purpose;
mod times;

use core::time::Duration;

use devicenet_core::MacId;
use devicenet_core::doctor::{Doctor, Severity};
use devicenet_core::monitor::{Kind, Monitor, MonitorConfig, Problem, Reading};
use link_core::{BitRate, Frame, Input, Instant, LinkEvent};

use crate::bus_rate::{BusRate, Doubt, LeastRate};
use crate::bus_time;
use crate::exit::Failure;
use crate::histogram::Histogram;
use crate::live::port::LivePort;
use crate::losses::Losses;
use crate::verdict::{self, Verdict};
use changes::Changes;
use load::{History, Tally, Window};

pub(super) use event::{Event, Happening, words};
pub(super) use link::LinkState;
pub(super) use load::Load;
use picture::Counters;
pub(super) use picture::{FindingPicture, NodePicture, Picture};
use problems::Problems;
pub(super) use purpose::Purpose;
pub(super) use times::Times;

/// What is known of the bus.
#[derive(Clone, Debug)]
pub(super) struct Model {
    monitor: Box<Monitor>,
    doctor: Box<Doctor>,
    bit_rate: BusRate,
    /// Of a bus whose bit rate neither a scenario nor a controller tells.
    least: LeastRate,
    /// The bit rate that the user has said, and what there is against it.
    doubt: Option<(BitRate, Doubt)>,
    /// When it began to listen.
    begin: Option<Instant>,
    now: Instant,
    link: LinkState,
    counters: Counters,
    losses: Losses,
    problems: Problems,
    total: Tally,
    /// Since the last report.
    interval: Tally,
    interval_began: Instant,
    window: Window,
    history: History,
    /// By MAC ID.
    responses: Vec<Responses>,
    changes: Changes,
    look_at: Instant,
}

/// The response times of a node.
#[derive(Clone, Debug, Default)]
struct Responses {
    io: Histogram,
    explicit: Histogram,
}

impl Model {
    /// `doctor` knows the same bit rate, if it is known.
    pub(super) fn new(bit_rate: Option<BusRate>, doctor: Box<Doctor>) -> Self {
        let least = LeastRate::new(bit_rate.and_then(BusRate::said));
        Self {
            monitor: Box::new(Monitor::new(MonitorConfig::default())),
            doctor,
            bit_rate: bit_rate.unwrap_or(BusRate::AtLeast(least.rate())),
            least,
            doubt: None,
            begin: None,
            now: Instant::ZERO,
            link: LinkState::Down,
            counters: Counters::default(),
            losses: Losses::default(),
            problems: Problems::default(),
            total: Tally::default(),
            interval: Tally::default(),
            interval_began: Instant::ZERO,
            window: Window::new(),
            history: History::new(),
            responses: vec![Responses::default(); MacId::COUNT],
            changes: Changes::new(),
            look_at: Instant::ZERO,
        }
    }

    /// Looks at a port after it has told of an input, and tells what follows.
    ///
    /// # Errors
    /// A recording does not fit into the bit rate that the user has said.
    pub(super) fn see_port(
        &mut self,
        port: &mut LivePort,
        at: Instant,
        input: Input,
        mut tell: impl FnMut(Event),
    ) -> Result<(), Failure> {
        if let Some((at, n)) = port.can_fd() {
            self.pass(at);
            self.counters.frames += 1;
            self.counters.problems += 1;
            self.problems.add(CAN_FD, Severity::Info);
            self.doctor.can_fd(at, n);
        }
        self.counters.unread = port.bad_entries();
        let told = self.doubt;
        self.see(at, port.entry(), input, &mut tell);
        match self.doubt {
            Some((said, doubt)) if told != self.doubt => port.doubt_bit_rate(said, doubt),
            _ => Ok(()),
        }
    }

    /// Takes an input of the interface, and tells what follows. `n` is the number of the entry of a recording that it comes from;
    /// without one, frames and error frames are counted.
    fn see(&mut self, at: Instant, n: Option<u64>, input: Input, mut tell: impl FnMut(Event)) {
        self.pass(at);
        let is_news = match input {
            Input::Frame(frame) => {
                self.counters.frames += 1;
                let n = n.unwrap_or(self.counters.entries());
                let reading = self.doctor.observe(&mut self.monitor, at, n, &frame);
                let seen = Seen::of(&reading);
                self.deduce(at, &frame);
                self.count(at, bus_time::bits(&frame), &seen);
                seen.is_news
            }
            Input::Link(event) => {
                self.link_event(at, event, &mut tell);
                let is_frame = matches!(event, LinkEvent::BusError(_));
                self.doctor.link(at, n.or(is_frame.then(|| self.counters.entries())), event);
                false
            }
            Input::Tick | Input::TxDone(..) => {
                self.doctor.tick(&self.monitor, at);
                false
            }
        };
        if let Some(lost) = self.losses.due(self.now) {
            tell(Event { at, what: Happening::Lost(lost) });
        }
        if is_news || at >= self.look_at {
            self.look_at = at + LOOK_EVERY;
            self.changes.look(&self.monitor, self.now, |what| tell(Event { at, what }));
        }
        while let Some(change) = self.doctor.poll() {
            tell(Event { at, what: Happening::Finding(change) });
        }
    }

    /// When it began to listen; `None` before the first input.
    pub(super) const fn begin(&self) -> Option<Instant> {
        self.begin
    }

    /// Whether a frame was heard, or one that was destroyed.
    pub(super) const fn is_silent(&self) -> bool {
        self.counters.entries() == 0
    }

    pub(super) const fn link(&self) -> LinkState {
        self.link
    }

    /// Whether all is well.
    pub(super) fn verdict(&self) -> Verdict {
        let Counters { unread, .. } = self.counters;
        let (frames, faulty_frames) = (self.counters.entries(), self.problems.faulty());
        Verdict::of(&self.doctor, verdict::Seen { frames, faulty_frames, unread })
    }

    /// It is so late.
    fn pass(&mut self, at: Instant) {
        self.now = self.now.max(at);
        if self.begin.is_none() {
            self.begin = Some(at);
            self.interval_began = at;
            self.look_at = at + LOOK_EVERY;
            self.window.0.begin(at);
            self.history.0.begin(at);
        }
        self.window.0.advance(self.now);
        self.history.0.advance(self.now);
    }

    /// What a bus whose bit rate only the user tells, or nobody, has shown of it.
    fn deduce(&mut self, at: Instant, frame: &Frame) {
        if matches!(self.bit_rate, BusRate::Known(_)) {
            return;
        }
        self.least.see(at, frame);
        let doubt = self.least.doubt();
        if doubt.is_some() && doubt != self.doubt {
            self.doubt = doubt;
            self.doctor.set_bit_rate(None);
        }
        if self.bit_rate.said().is_none() || self.doubt.is_some() {
            self.is_at_least(self.least.rate());
        }
    }

    /// What was counted at a lower bit rate took less of the time, now that it is known to be higher.
    fn is_at_least(&mut self, least: BitRate) {
        let rate = self.bit_rate.rate();
        self.bit_rate = BusRate::AtLeast(least);
        if least != rate {
            let scale = |busy: u64| (u128::from(busy) * u128::from(rate.0) / u128::from(least.0)) as u64;
            self.total.scale(scale);
            self.interval.scale(scale);
            self.window.0.each(|tally| tally.scale(scale));
            self.history.0.each(|cell| *cell = cell.map(scale));
        }
    }

    fn count(&mut self, at: Instant, bits: u32, seen: &Seen) {
        if let Some(problem) = &seen.problem {
            self.counters.problems += 1;
            self.problems.add(problem.code(), Severity::of(problem));
        }
        self.occupy(at, bits, seen.source.map_or(MacId::COUNT, index), seen.purpose);
        if let (Some(source), Some(latency)) = (seen.source, seen.latency) {
            let responses = &mut self.responses[index(source)];
            match seen.purpose {
                Purpose::Explicit => responses.explicit.record(latency),
                Purpose::Poll | Purpose::Strobe | Purpose::OtherIo => responses.io.record(latency),
                // An acknowledge is the master's, and there is none to a check.
                Purpose::Change
                | Purpose::Access
                | Purpose::Heartbeat
                | Purpose::Offline
                | Purpose::Foreign
                | Purpose::Errors => {}
            }
        }
    }

    /// Something that ends at a moment has taken so many bits of the bus.
    fn occupy(&mut self, at: Instant, bits: u32, node: usize, purpose: Purpose) {
        let busy = u64::from(bits) * self.bit_rate.rate().bit_time_nanos().unwrap_or_default();
        self.total.add(busy, node, purpose);
        self.interval.add(busy, node, purpose);
        let from = at.saturating_sub(Duration::from_nanos(busy));
        self.window.0.spread(from, at, |tally, busy| tally.add(busy, node, purpose));
        self.history.0.spread(from, at, |cell, busy| cell[purpose.index()] += busy);
    }

    fn link_event(&mut self, at: Instant, event: LinkEvent, tell: &mut impl FnMut(Event)) {
        match event {
            LinkEvent::BusError(_) => {
                self.counters.error_frames += 1;
                self.occupy(at, bus_time::ERROR_FRAME, MacId::COUNT, Purpose::Errors);
            }
            LinkEvent::Counters { tec, rec } => {
                (self.counters.tec, self.counters.rec) = (Some(tec), Some(rec))
            }
            LinkEvent::Overrun { lost } => {
                // One that does not count has lost one at least.
                self.counters.lost += u64::from(lost.max(1));
                self.losses.add(lost);
            }
            LinkEvent::ModeSet(mode) => self.bit_rate = BusRate::Known(mode.bit_rate),
            LinkEvent::Up
            | LinkEvent::Down
            | LinkEvent::ErrorWarning
            | LinkEvent::ErrorPassive
            | LinkEvent::ErrorActive
            | LinkEvent::BusOff
            | LinkEvent::FilterSet
            | LinkEvent::Refused(_) => {}
        }
        if let Some(state) = LinkState::after(event).filter(|state| *state != self.link) {
            self.link = state;
            tell(Event { at, what: Happening::Link(state) });
        }
    }
}

/// What is counted of a frame.
struct Seen {
    source: Option<MacId>,
    purpose: Purpose,
    latency: Option<Duration>,
    problem: Option<Problem>,
    /// It can change what is known of nodes and connections.
    is_news: bool,
}

impl Seen {
    fn of(reading: &Reading<'_>) -> Self {
        let is_answer = reading.kind != Kind::FragmentAck;
        let is_news = match reading.kind {
            Kind::Fragment => reading.message.is_some(),
            Kind::FragmentAck | Kind::Heartbeat | Kind::Foreign | Kind::Invalid | Kind::Reserved => false,
            kind => !kind.is_io(),
        };
        Self {
            source: reading.src,
            purpose: Purpose::of(reading.kind),
            latency: reading.request.filter(|_| is_answer).map(|request| request.latency),
            problem: reading.problem,
            is_news,
        }
    }
}

fn index(mac: MacId) -> usize {
    usize::from(mac.number())
}

/// The problem of a frame of CAN FD, which a rule judges.
const CAN_FD: &str = "can_fd_frame";
/// How often nodes and connections are looked at for what time alone has changed.
const LOOK_EVERY: Duration = Duration::from_millis(100);

#[cfg(test)]
mod tests {
    use link_core::frame::standard_id;

    use super::*;
    use crate::health;

    /// An interface goes on: what was counted is told at the rate that the frames need at least.
    #[test]
    fn a_rate_that_cannot_be_is_not_known_any_more() {
        let said = BitRate::K125;
        let mut model = Model::new(Some(BusRate::Said(said)), health::doctor(Some(said), None, None));
        let frame = Frame::new(standard_id(0x3C1), &[0x55; 8]).unwrap();
        let length = u64::from(bus_time::bits(&frame)) * 4_000;
        for n in 1..=1_000 {
            model.see(Instant::from_nanos(n * length), None, Input::Frame(frame), |_| {});
        }
        assert_eq!(model.doubt, Some((said, Doubt::TooLow(BitRate::K250))));
        assert_eq!(model.bit_rate, BusRate::AtLeast(BitRate::K250));
        assert_eq!(model.doctor.config().bit_rate, None);
        let load = model.picture().total.all;
        assert!((0.99..1.01).contains(&load), "{load}");
    }
}
