//! What SocketCAN's broadcast manager does for a client: frames in cycles, subscriptions that filter and throttle.

use core::time::Duration;

use link_core::{Frame, Id, Instant};

use super::session::Effect;

/// What a client has asked for.
#[derive(Debug, Default)]
pub(super) struct Broadcast {
    jobs: Vec<Job>,
    subscriptions: Vec<Subscription>,
}

/// A frame that is sent in cycles.
#[derive(Debug)]
struct Job {
    frame: Frame,
    every: Duration,
    next: Instant,
}

/// A client's wish to receive an identifier.
#[derive(Debug)]
struct Subscription {
    id: Id,
    /// At most one frame in this time; zero is no limit.
    every: Duration,
    /// Only when one of these bits has changed; `None` is always.
    mask: Option<[u8; 8]>,
    last: Option<(Instant, Frame)>,
    /// The newest frame of a time that is not over, and when it came.
    held: Option<(Instant, Frame)>,
}

impl Broadcast {
    /// Sends a frame now and in cycles, which are as long as a frame at least; once if they have no length.
    pub(super) fn add(
        &mut self,
        now: Instant,
        every: Duration,
        frame: Frame,
        effects: &mut Vec<Effect>,
    ) -> Result<(), String> {
        self.jobs.retain(|job| job.frame.id() != frame.id());
        if !every.is_zero() {
            let every = every.max(SHORTEST_CYCLE);
            if self.jobs.len() == MOST_ENTRIES {
                return Err(format!("at most {MOST_ENTRIES} frames are sent in cycles"));
            }
            self.jobs.push(Job { frame, every, next: now + every });
        }
        effects.push(Effect::Send(frame));
        Ok(())
    }

    /// Sends this instead of the frame with the same identifier, at the same times.
    pub(super) fn update(&mut self, frame: Frame) -> Result<(), String> {
        let job = self.jobs.iter_mut().find(|job| job.frame.id() == frame.id());
        job.ok_or(NOTHING_SENT)?.frame = frame;
        Ok(())
    }

    /// No longer sends the frame with this identifier.
    pub(super) fn delete(&mut self, id: Id) -> Result<(), String> {
        let place = self.jobs.iter().position(|job| job.frame.id() == id).ok_or(NOTHING_SENT)?;
        self.jobs.remove(place);
        Ok(())
    }

    /// Delivers an identifier, at most once in `every`, and only what has changed under the mask.
    pub(super) fn subscribe(&mut self, every: Duration, id: Id, mask: Option<[u8; 8]>) -> Result<(), String> {
        self.unsubscribe(id);
        if self.subscriptions.len() == MOST_ENTRIES {
            return Err(format!("at most {MOST_ENTRIES} subscriptions"));
        }
        self.subscriptions.push(Subscription { id, every, mask, last: None, held: None });
        Ok(())
    }

    /// No longer delivers an identifier.
    pub(super) fn unsubscribe(&mut self, id: Id) {
        self.subscriptions.retain(|subscription| subscription.id != id);
    }

    /// A frame was on the bus.
    pub(super) fn frame(&mut self, now: Instant, frame: &Frame, effects: &mut Vec<Effect>) {
        for subscription in self.subscriptions.iter_mut().filter(|item| item.id == frame.id()) {
            subscription.take(now, frame, effects);
        }
    }

    /// When [`tick`](Self::tick) has something to do next.
    pub(super) fn deadline(&self) -> Option<Instant> {
        let jobs = self.jobs.iter().map(|job| job.next);
        jobs.chain(self.subscriptions.iter().filter_map(Subscription::due)).min()
    }

    /// Time has passed.
    pub(super) fn tick(&mut self, now: Instant, effects: &mut Vec<Effect>) {
        for job in self.jobs.iter_mut().filter(|job| job.next <= now) {
            effects.push(Effect::Send(job.frame));
            // A server that fell behind sends once, not all that it missed.
            job.next = (job.next + job.every).max(now + Duration::from_nanos(1));
        }
        for subscription in &mut self.subscriptions {
            subscription.tick(now, effects);
        }
    }
}

impl Subscription {
    fn take(&mut self, now: Instant, frame: &Frame, effects: &mut Vec<Effect>) {
        if let (Some(mask), Some((_, last))) = (&self.mask, &self.last)
            && !differ(last, frame, mask)
        {
            self.held = None;
            return;
        }
        match self.last {
            Some((then, _)) if now < then + self.every => self.held = Some((now, *frame)),
            _ => self.deliver(now, now, frame, effects),
        }
    }

    /// The time of a frame that is held may be over.
    fn tick(&mut self, now: Instant, effects: &mut Vec<Effect>) {
        if self.due().is_some_and(|due| due <= now)
            && let Some((came, frame)) = self.held
        {
            self.deliver(now, came, &frame, effects);
        }
    }

    fn deliver(&mut self, now: Instant, came: Instant, frame: &Frame, effects: &mut Vec<Effect>) {
        self.last = Some((now, *frame));
        self.held = None;
        effects.push(Effect::Reply(received(came, frame)));
    }

    /// When the frame that is held may go.
    fn due(&self) -> Option<Instant> {
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

const NOTHING_SENT: &str = "nothing is sent with this identifier";
const MOST_ENTRIES: usize = 256;
/// What a frame without data takes at 1 Mbit/s, intermission included: more of them find no room on any bus.
const SHORTEST_CYCLE: Duration = Duration::from_micros(47);
