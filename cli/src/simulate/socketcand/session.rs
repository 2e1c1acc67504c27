//! One client's side of the conversation, without socket and clock.

use core::time::Duration;
use std::sync::Arc;

use link_core::{Frame, Instant};

use super::broadcast::{Broadcast, received};
use super::framing::Framing;
use super::message::{self, Command};
use super::statistics::Statistics;

/// What a session wants done.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Effect {
    /// Write this to the client.
    Reply(String),
    /// Send this on the bus.
    Send(Frame),
    /// The client has said something wrong, and cannot be told in its mode.
    Complain(String),
    /// The client may not go on.
    Close,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Mode {
    /// No bus is open.
    NoBus,
    /// The client receives what it subscribed to, and may have frames sent in cycles.
    Bcm,
    /// The client receives everything.
    Raw,
    /// The client receives statistics only.
    Control,
}

/// What a client has said, and what it is to receive.
#[derive(Debug)]
pub(super) struct Session {
    /// The names of the buses that can be opened.
    channels: Arc<[String]>,
    /// The place of the open one in `channels`.
    channel: usize,
    mode: Mode,
    framing: Framing,
    broadcast: Broadcast,
    statistics: Statistics,
    /// The first frames of raw mode wait: see [`SETTLING`].
    held: Option<Held>,
}

#[derive(Debug)]
struct Held {
    until: Instant,
    lines: Vec<String>,
}

impl Session {
    /// What a server says first.
    pub(super) const GREETING: &'static str = "< hi >";

    pub(super) fn new(channels: Arc<[String]>) -> Self {
        Self {
            channels,
            channel: 0,
            mode: Mode::NoBus,
            framing: Framing::default(),
            broadcast: Broadcast::default(),
            statistics: Statistics::default(),
            held: None,
        }
    }

    /// The bus that the client has opened, by its place in the list given to [`new`](Self::new).
    pub(super) fn channel(&self) -> Option<usize> {
        (self.mode != Mode::NoBus).then_some(self.channel)
    }

    /// Takes bytes of the client, in whatever pieces they come.
    pub(super) fn receive(&mut self, now: Instant, bytes: &[u8], effects: &mut Vec<Effect>) {
        for byte in bytes {
            let Some(text) = self.framing.take(*byte) else { continue };
            self.release(effects);
            let command = text.map_err(str::to_owned).and_then(|text| message::parse(&text));
            if let Err(problem) = command.and_then(|command| self.execute(now, command, effects)) {
                effects.push(self.problem(problem));
            }
        }
    }

    /// A frame of another was on the bus.
    pub(super) fn frame(&mut self, at: Instant, frame: &Frame, effects: &mut Vec<Effect>) {
        if self.mode != Mode::NoBus {
            self.statistics.received(frame);
        }
        match self.mode {
            Mode::NoBus | Mode::Control => {}
            Mode::Raw => self.tell(received(at, frame), effects),
            Mode::Bcm => self.broadcast.frame(at, frame, effects),
        }
    }

    /// A frame of this client was on the bus.
    pub(super) fn sent(&mut self, frame: &Frame) {
        self.statistics.sent(frame);
    }

    /// A frame of this client will not be on the bus. In raw mode an error frame tells it, else words.
    pub(super) fn lost(&mut self, at: Instant, class: u32, words: &str, effects: &mut Vec<Effect>) {
        match self.mode {
            Mode::Raw => self.bus_error(at, class, effects),
            Mode::NoBus | Mode::Bcm | Mode::Control => effects.push(error(words)),
        }
    }

    /// An error frame of this SocketCAN class was on the bus.
    pub(super) fn bus_error(&mut self, at: Instant, class: u32, effects: &mut Vec<Effect>) {
        if self.mode == Mode::Raw {
            self.tell(format!("< error {class:03X} {at:.6} >"), effects);
        }
    }

    /// When [`tick`](Self::tick) has something to do next.
    pub(super) fn deadline(&self) -> Option<Instant> {
        let held = self.held.as_ref().map(|held| held.until);
        [self.broadcast.deadline(), self.statistics.deadline(), held].into_iter().flatten().min()
    }

    /// Time has passed.
    pub(super) fn tick(&mut self, now: Instant, effects: &mut Vec<Effect>) {
        if self.held.as_ref().is_some_and(|held| held.until <= now) {
            self.release(effects);
        }
        self.broadcast.tick(now, effects);
        effects.extend(self.statistics.tick(now).map(Effect::Reply));
    }

    fn execute(&mut self, now: Instant, command: Command, effects: &mut Vec<Effect>) -> Result<(), String> {
        let ok = Effect::Reply("< ok >".to_owned());
        match (self.mode, command) {
            (_, Command::Echo) => effects.push(Effect::Reply("< echo >".to_owned())),
            (Mode::NoBus, Command::Open { channel }) => {
                match self.channels.iter().position(|name| *name == channel) {
                    Some(place) => {
                        (self.channel, self.mode) = (place, Mode::Bcm);
                        effects.push(ok);
                    }
                    None => {
                        let there_is = self.channels.join(", ");
                        effects.push(error(&format!("no such bus, there is {there_is}")));
                        effects.push(Effect::Close);
                    }
                }
            }
            (_, Command::Open { .. }) => return Err("a bus is open".to_owned()),
            (Mode::NoBus, _) => return Err("no bus is open".to_owned()),
            (_, Command::RawMode) => {
                self.enter(Mode::Raw);
                self.held = Some(Held { until: now + SETTLING, lines: Vec::new() });
                effects.push(ok);
            }
            (_, Command::BcmMode) => {
                self.enter(Mode::Bcm);
                effects.push(ok);
            }
            (_, Command::ControlMode) => {
                self.enter(Mode::Control);
                effects.push(ok);
            }
            (Mode::Raw | Mode::Bcm, Command::Send(frame)) => effects.push(Effect::Send(frame)),
            (Mode::Control, Command::Statistics { every }) => self.statistics.tell(now, every),
            (Mode::Bcm, Command::Add { every, frame }) => self.broadcast.add(now, every, frame, effects)?,
            (Mode::Bcm, Command::Update(frame)) => self.broadcast.update(frame)?,
            (Mode::Bcm, Command::Delete(id)) => self.broadcast.delete(id)?,
            (Mode::Bcm, Command::Subscribe { every, id }) => self.broadcast.subscribe(every, id, None)?,
            (Mode::Bcm, Command::Filter { every, id, mask }) => {
                self.broadcast.subscribe(every, id, Some(mask))?;
            }
            (Mode::Bcm, Command::Unsubscribe(id)) => self.broadcast.unsubscribe(id),
            (Mode::Raw | Mode::Bcm, Command::Statistics { .. }) => {
                return Err("statistics are for controlmode".to_owned());
            }
            (Mode::Raw | Mode::Control, _) => return Err("not in this mode, say bcmmode first".to_owned()),
        }
        Ok(())
    }

    /// What the broadcast manager did ends with its mode, and so does the telling of statistics.
    fn enter(&mut self, mode: Mode) {
        self.mode = mode;
        self.broadcast = Broadcast::default();
        self.statistics.tell_no_more();
    }

    /// To the client in raw mode.
    fn tell(&mut self, line: String, effects: &mut Vec<Effect>) {
        match &mut self.held {
            Some(held) => {
                held.lines.push(line);
                if held.lines.len() == MOST_HELD {
                    self.release(effects);
                }
            }
            None => effects.push(Effect::Reply(line)),
        }
    }

    fn release(&mut self, effects: &mut Vec<Effect>) {
        let lines = self.held.take().map_or_else(Vec::new, |held| held.lines);
        effects.extend(lines.into_iter().map(Effect::Reply));
    }

    /// In raw mode `error` is followed by the numbers of an error frame, and clients that read it as such would stumble
    /// over words.
    fn problem(&self, words: String) -> Effect {
        match self.mode {
            Mode::Raw => Effect::Complain(words),
            Mode::NoBus | Mode::Bcm | Mode::Control => error(&words),
        }
    }
}

/// In words.
pub(super) fn error(problem: &str) -> Effect {
    Effect::Reply(format!("< error {problem} >"))
}

/// How long after `rawmode` the first frames wait, unless the client says something earlier: python-can takes everything
/// that one read gives for the answer, and a frame in the same TCP segment would make it give up.
const SETTLING: Duration = Duration::from_millis(20);
/// More lines than this are not kept back.
const MOST_HELD: usize = 1024;

#[cfg(test)]
mod tests;
