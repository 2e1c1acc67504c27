//! What SocketCAN's broadcast manager does for a client: frames in cycles, subscriptions that filter and throttle.

use core::time::Duration;

use link_core::{Frame, Id, Instant};

use super::session::Effect;

/// A frame that is sent in cycles.
#[derive(Debug)]
pub(super) struct Job {
    pub(super) frame: Frame,
    pub(super) every: Duration,
    pub(super) next: Instant,
}

/// A client's wish to receive an identifier.
#[derive(Debug)]
pub(super) struct Subscription {
    pub(super) id: Id,
    /// At most one frame in this time; zero is no limit.
    every: Duration,
    /// Only when one of these bits has changed; `None` is always.
    mask: Option<[u8; 8]>,
    last: Option<(Instant, Frame)>,
    /// The newest frame of a time that is not over.
    held: Option<Frame>,
}

impl Subscription {
    pub(super) const fn new(every: Duration, id: Id, mask: Option<[u8; 8]>) -> Self {
        Self { id, every, mask, last: None, held: None }
    }

    /// A frame with this identifier was on the bus.
    pub(super) fn take(&mut self, now: Instant, frame: &Frame, effects: &mut Vec<Effect>) {
        if let (Some(mask), Some((_, last))) = (&self.mask, &self.last)
            && !differ(last, frame, mask)
        {
            self.held = None;
            return;
        }
        match self.last {
            Some((then, _)) if now < then + self.every => self.held = Some(*frame),
            _ => self.deliver(now, frame, effects),
        }
    }

    fn deliver(&mut self, now: Instant, frame: &Frame, effects: &mut Vec<Effect>) {
        self.last = Some((now, *frame));
        self.held = None;
        effects.push(Effect::Reply(received(now, frame)));
    }

    /// The time of the frame that is held may be over.
    pub(super) fn tick(&mut self, now: Instant, effects: &mut Vec<Effect>) {
        if self.due().is_some_and(|due| due <= now)
            && let Some(frame) = self.held.take()
        {
            self.deliver(now, &frame, effects);
        }
    }

    /// When the frame that is held may go.
    pub(super) fn due(&self) -> Option<Instant> {
        self.held?;
        self.last.map(|(then, _)| then + self.every)
    }
}

fn differ(one: &Frame, other: &Frame, mask: &[u8; 8]) -> bool {
    let byte = |frame: &Frame, at: usize| frame.data().get(at).copied().unwrap_or(0);
    one.dlc() != other.dlc()
        || mask.iter().enumerate().any(|(at, mask)| (byte(one, at) ^ byte(other, at)) & mask != 0)
}

/// `< frame 123 23.424242 11223344 >`; clients expect the data in one word, and two spaces without data.
pub(super) fn received(at: Instant, frame: &Frame) -> String {
    use core::fmt::Write;
    let mut text = String::from(if frame.is_remote() { "< rtr " } else { "< frame " });
    let width = if frame.is_extended() { 8 } else { 3 };
    let _ = write!(text, "{:0width$X} {at:.6} ", frame.raw_id());
    if frame.is_remote() {
        let _ = write!(text, "{:X}", frame.dlc());
    }
    for byte in frame.data() {
        let _ = write!(text, "{byte:02X}");
    }
    text.push_str(" >");
    text
}
