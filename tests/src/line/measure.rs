//! What is measured on a line.

use core::time::Duration;

use devicenet_core::Identifier;
use devicenet_core::id::Purpose;
use devicenet_core::master::{MasterEvent, SlaveEvent, SlaveState};
use link_core::Instant;

use super::{Line, Plan, Sent, Told};

/// From a poll command to the first slave of the scan list to the next one.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Scan {
    /// When it began.
    pub start: Instant,
    /// How long it took.
    pub cycle: Duration,
    /// How many frames were sent in it.
    pub frames: usize,
    /// The time that they took on the wire, each with the intermission after it.
    pub wire: Duration,
    /// The part of that which is not I/O.
    pub other: Duration,
}

/// Wire time by kind of traffic.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Traffic {
    /// Duplicate MAC ID checks.
    pub access: Duration,
    /// Explicit messages and heartbeats.
    pub explicit: Duration,
    /// Poll commands and responses.
    pub io: Duration,
}

/// From power-up to the moment at which the last slave runs.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct BringUp {
    /// How long it took.
    pub time: Duration,
    /// What was on the bus.
    pub traffic: Traffic,
}

impl BringUp {
    /// Brings a line up.
    ///
    /// # Panics
    /// When it takes more than ten seconds.
    #[must_use]
    pub fn of(plan: &Plan) -> Self {
        let line = Line::running(plan);
        let runs = |told: &Told| {
            matches!(
                told,
                Told::Master(MasterEvent::Slave {
                    event: SlaveEvent::StateChanged { to: SlaveState::Running, .. },
                    ..
                })
            )
        };
        let last = line.told.iter().rfind(|(_, _, told)| runs(told));
        let end = last.map_or(Instant::ZERO, |(at, ..)| *at);
        let before: Vec<Sent> = line.sent.iter().copied().filter(|sent| sent.end <= end).collect();
        Self { time: end.saturating_since(Instant::ZERO), traffic: line.traffic(&before) }
    }

    /// What it takes at least: the waits of network access, one second after each of two requests, and the frames without
    /// which no slave comes up. The polls of slaves that run already are not among them.
    #[must_use]
    pub fn least(&self) -> Duration {
        ACCESS_WAITS + self.traffic.access + self.traffic.explicit
    }
}

impl Line {
    /// The whole scans among the frames that were seen.
    #[must_use]
    pub fn scans(&self) -> Vec<Scan> {
        let first = self.master().scan_list().next().map(|entry| Identifier::poll_command(entry.mac_id));
        let begins = self.sent.iter().enumerate().filter(|(_, sent)| Some(sent.id) == first);
        let begins: Vec<usize> = begins.map(|(place, _)| place).collect();
        let scan = |pair: &[usize]| {
            let frames = &self.sent[pair[0]..pair[1]];
            let traffic = self.traffic(frames);
            let other = traffic.access + traffic.explicit;
            Scan {
                start: frames[0].start,
                cycle: self.sent[pair[1]].start.saturating_since(frames[0].start),
                frames: frames.len(),
                wire: traffic.io + other,
                other,
            }
        };
        begins.windows(2).map(scan).collect()
    }

    /// The wire time of frames.
    #[must_use]
    pub fn traffic(&self, frames: &[Sent]) -> Traffic {
        let mut traffic = Traffic::default();
        for sent in frames {
            let wire = self.wire(&sent.frame);
            match sent.id.purpose() {
                Purpose::DuplicateMacCheck => traffic.access += wire,
                Purpose::PollCommand | Purpose::PollResponse => traffic.io += wire,
                _ => traffic.explicit += wire,
            }
        }
        traffic
    }
}

const ACCESS_WAITS: Duration = Duration::from_secs(2);
