//! What a client has sent and received, told in intervals.

use core::time::Duration;

use link_core::{Frame, Instant};

/// Counts for one client.
#[derive(Debug, Default)]
pub(super) struct Statistics {
    received: Count,
    sent: Count,
    interval: Option<Interval>,
}

#[derive(Debug)]
struct Interval {
    every: Duration,
    next: Instant,
}

#[derive(Clone, Copy, Debug, Default)]
struct Count {
    bytes: u64,
    frames: u64,
}

impl Count {
    fn add(&mut self, frame: &Frame) {
        self.frames += 1;
        self.bytes += frame.data().len() as u64;
    }
}

impl Statistics {
    /// A frame of another was on the bus.
    pub(super) fn received(&mut self, frame: &Frame) {
        self.received.add(frame);
    }

    /// A frame of this client was on the bus.
    pub(super) fn sent(&mut self, frame: &Frame) {
        self.sent.add(frame);
    }

    /// Tells them so often from now on; zero is never.
    pub(super) fn tell(&mut self, now: Instant, every: Duration) {
        self.interval = (!every.is_zero()).then(|| Interval { every, next: now + every });
    }

    /// Goes on counting, and tells nothing.
    pub(super) fn tell_no_more(&mut self) {
        self.interval = None;
    }

    /// When they are to be told next.
    pub(super) fn deadline(&self) -> Option<Instant> {
        self.interval.as_ref().map(|interval| interval.next)
    }

    /// `< stat rbytes rpackets tbytes tpackets >`, if it is time.
    pub(super) fn tick(&mut self, now: Instant) -> Option<String> {
        let interval = self.interval.as_mut().filter(|interval| interval.next <= now)?;
        interval.next = now + interval.every;
        let (rx, tx) = (self.received, self.sent);
        Some(format!("< stat {} {} {} {} >", rx.bytes, rx.frames, tx.bytes, tx.frames))
    }
}
