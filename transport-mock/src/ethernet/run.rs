//! Time passes on a segment.

use std::cmp::Ordering;
use std::time::Duration;

use link_core::Instant;
use link_core::ethernet::{Action, Input, LinkEvent, MAX_FRAME, MIN_FRAME, Machine};

use super::fault::{Fate, Passage};
use super::record::{FrameRecord, Keep, Record};
use super::segment::Segment;
use super::station::StationId;

/// Something that is going to happen to a station, unless its adapter loses its link or its power before.
#[derive(Debug)]
pub(super) struct Happening {
    at: Instant,
    order: u64,
    station: StationId,
    /// The [connection](super::station::Station::connection) for which it was planned.
    connection: u64,
    what: What,
}

#[derive(Debug)]
enum What {
    /// The next frame of the adapter is ready to be sent.
    Ready,
    /// A frame arrives.
    Arrival(Vec<u8>),
    /// A frame with a wrong CRC arrives.
    BadArrival,
}

impl<M: Machine> Segment<M> {
    /// Lets time pass.
    pub fn run_for(&mut self, span: Duration) {
        self.run_until(self.now + span);
    }

    /// Lets time pass up to a moment, which is the present one then.
    ///
    /// # Panics
    /// If a machine does not come to rest at one moment.
    pub fn run_until(&mut self, until: Instant) {
        while self.step(until) {}
        self.now = self.now.max(until);
    }

    /// Lets time pass until something holds. Returns whether it did within `limit`.
    ///
    /// # Panics
    /// If a machine does not come to rest at one moment.
    pub fn run_while(&mut self, limit: Duration, mut goes_on: impl FnMut(&Self) -> bool) -> bool {
        let until = self.now + limit;
        while goes_on(self) {
            if !self.step(until) {
                self.now = self.now.max(until);
                return !goes_on(self);
            }
        }
        true
    }

    /// Does the next thing that happens up to a moment. A frame comes before a deadline of the same moment.
    fn step(&mut self, until: Instant) -> bool {
        let deadline = self.deadlines.earliest();
        let happening = self.queue.peek().map(|happening| happening.at);
        if happening.is_some_and(|at| at <= deadline && at <= until) {
            let Some(Happening { at, station: id, connection, what, .. }) = self.queue.pop() else {
                return false;
            };
            self.now = self.now.max(at);
            let station = &mut self.stations[id.0];
            if connection != station.connection {
                return true;
            }
            match what {
                What::Ready => {
                    if let Some(bytes) = station.outbox.pop_front() {
                        self.send(Some(id), bytes);
                    }
                }
                What::Arrival(bytes) => self.input(id, Input::Frame(&bytes)),
                What::BadArrival => self.link(id, LinkEvent::CrcError),
            }
            return true;
        }
        if deadline > until || deadline == Instant::MAX {
            return false;
        }
        self.now = self.now.max(deadline);
        let id = StationId(self.deadlines.first());
        self.input(id, Input::Tick);
        let next = self.stations[id.0].machine.deadline();
        assert!(
            next.is_none_or(|next| next.at > self.now),
            "{}: a tick at {} does not serve its deadline ({})",
            self.name(id),
            self.now,
            next.map_or("", |next| next.why),
        );
        true
    }

    pub(super) fn link(&mut self, station: StationId, event: LinkEvent) {
        self.tell(station, event);
        self.drain(station);
    }

    fn tell(&mut self, station: StationId, event: LinkEvent) {
        if self.config.keep == Keep::All {
            self.records.push(Record::Link { at: self.now, station, event });
        }
        self.stations[station.0].machine.input(self.now, Input::Link(event));
    }

    fn input(&mut self, id: StationId, input: Input<'_>) {
        self.stations[id.0].machine.input(self.now, input);
        self.drain(id);
    }

    /// Carries out what a machine wants.
    pub(super) fn drain(&mut self, id: StationId) {
        let mut buffer = [BUFFER; MAX_FRAME];
        for actions in 0.. {
            assert!(
                actions < MOST_ACTIONS,
                "{}: more than {MOST_ACTIONS} actions at {}",
                self.name(id),
                self.now
            );
            let station = &mut self.stations[id.0];
            match station.machine.poll(self.now, &mut buffer) {
                None => {
                    let next = station.machine.deadline();
                    self.deadlines.set(id.0, next.map_or(Instant::MAX, |next| next.at));
                    return;
                }
                Some(Action::Transmit(_)) if !station.is_plugged => self.tell(id, LinkEvent::NotSent),
                Some(Action::Transmit(bytes)) => {
                    let bytes = bytes.to_vec();
                    let at = station.react(self.now);
                    station.outbox.push_back(bytes);
                    self.schedule(at, id, What::Ready);
                }
                Some(Action::Event(event)) => {
                    if self.config.keep == Keep::All {
                        self.records.push(Record::Event { at: self.now, station: id, event });
                    }
                }
            }
        }
    }

    /// Sends a frame as soon as the wire is free.
    pub(super) fn send(&mut self, from: Option<StationId>, bytes: Vec<u8>) {
        let start = self.wire_free.max(self.now);
        let end = start + byte_times(PREAMBLE + bytes.len().max(MIN_FRAME) + CRC);
        self.wire_free = end + byte_times(GAP);
        let number = self.sent;
        self.sent += 1;
        for to in self.stations().filter(|to| Some(*to) != from) {
            if !self.stations[to.0].is_plugged {
                continue;
            }
            let fate = self.judge(&Passage { start, number, from, to, bytes: &bytes });
            let at = end + self.config.propagation;
            match fate {
                Fate::Pass => self.schedule(at, to, What::Arrival(bytes.clone())),
                Fate::Lose => {}
                Fate::Corrupt => self.schedule(at, to, What::BadArrival),
                Fate::Twice => {
                    self.schedule(at, to, What::Arrival(bytes.clone()));
                    self.schedule(at, to, What::Arrival(bytes.clone()));
                }
                Fate::Late(delay) => self.schedule(at + delay, to, What::Arrival(bytes.clone())),
                Fate::Replace(other) => self.schedule(at, to, What::Arrival(other)),
            }
        }
        if self.config.keep != Keep::Nothing {
            let waited = start.saturating_since(self.now);
            self.records.push(Record::Frame(FrameRecord { start, end, waited, from, bytes }));
        }
    }

    /// The first fault that does not let a frame pass; all of them count it.
    fn judge(&mut self, passage: &Passage<'_>) -> Fate {
        let mut verdict = Fate::Pass;
        for fault in self.faults.iter_mut().flatten() {
            let fate = fault.judge(passage);
            if verdict == Fate::Pass {
                verdict = fate;
            }
        }
        verdict
    }

    fn schedule(&mut self, at: Instant, station: StationId, what: What) {
        let connection = self.stations[station.0].connection;
        self.queue.push(Happening { at, order: self.order, station, connection, what });
        self.order += 1;
    }
}

impl Ord for Happening {
    /// The earliest is the greatest, as a heap wants it.
    fn cmp(&self, other: &Self) -> Ordering {
        (other.at, other.order).cmp(&(self.at, self.order))
    }
}

impl PartialOrd for Happening {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Happening {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Happening {}

const fn byte_times(bytes: usize) -> Duration {
    Duration::from_nanos(bytes as u64 * NANOSECONDS_A_BYTE)
}

const PREAMBLE: usize = 8;
const CRC: usize = 4;
const GAP: usize = 12;
const NANOSECONDS_A_BYTE: u64 = 80;
/// What a machine finds in the buffer.
const BUFFER: u8 = 0xA5;
/// A machine has a bounded amount to say at one moment.
const MOST_ACTIONS: usize = 1_000;
