//! A recording as a bus to listen to.

use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use std::borrow::Cow;
use std::collections::VecDeque;
use std::path::Path;

use link_core::machine::Deadline;
use link_core::{BitRate, Input, Instant, LinkEvent};

use super::port::PortError;
use crate::bus_rate::Doubt;
use crate::decode::note_the_rest;
use crate::exit::Failure;
use crate::recording::{ChannelId, Content, Network, RecordedFrame, Recording};
use crate::simulate;
use crate::standard::{Interruptible, is_standard, shown};
use crate::text::{count, printable};

/// A recording that is played to a listener, as fast as it is read. Its bad lines are told.
pub(super) struct Recorded {
    file: String,
    recording: Recording,
    /// That of its first entry: each channel is a bus of its own, and one is listened to.
    channel: Option<Option<ChannelId>>,
    /// The user knows of the others.
    is_told: bool,
    now: Instant,
    /// The time stamp of the last entry; `None` before the first.
    last: Option<Instant>,
    /// When that was.
    heard: Instant,
    /// A silence is played for so long; the rest of it is passed over.
    patience: Duration,
    bad_entries: u64,
    ahead: VecDeque<(Instant, Ahead)>,
    /// Of standard input, whose end is none when this is set.
    interrupted: Option<&'static AtomicBool>,
    /// When the frame of CAN FD was that the last tick stands for.
    can_fd: Option<Instant>,
    /// The number of the entry that these are of.
    ahead_entry: u64,
    /// That of the last one that was told.
    entry: u64,
}

/// What an entry is to a listener.
#[derive(Clone, Copy)]
enum Ahead {
    Input(Input),
    /// A frame of CAN FD, which no node of this network hears as a frame: a tick.
    CanFd,
}

impl Recorded {
    pub(super) fn open(path: &Path) -> Result<Self, Failure> {
        let file = shown(path, "<stdin>");
        let interrupted = is_standard(path).then(simulate::interruption).transpose()?;
        let opened = match interrupted {
            Some(interrupted) => Recording::from_reader(Interruptible::new(interrupted)),
            None => Recording::open(path),
        };
        let recording = opened.map_err(|error| match is_set(interrupted) {
            true => Failure::Interrupted("interrupted before anything was read".into()),
            false => Failure::Usage(format!("{file}: {error}")),
        })?;
        Ok(Self {
            file,
            recording,
            interrupted,
            channel: None,
            is_told: false,
            now: Instant::ZERO,
            last: None,
            heard: Instant::ZERO,
            patience: PATIENCE,
            bad_entries: 0,
            ahead: VecDeque::new(),
            can_fd: None,
            ahead_entry: 0,
            entry: 0,
        })
    }

    pub(super) const fn now(&self) -> Instant {
        self.now
    }

    /// The frame of CAN FD that the last tick stands for, and its number.
    pub(super) fn can_fd(&mut self) -> Option<(Instant, u64)> {
        Some((self.can_fd.take()?, self.entry))
    }

    /// Whether the last tick stands for one.
    pub(super) const fn has_can_fd(&self) -> bool {
        self.can_fd.is_some()
    }

    /// When an entry with this time stamp is: from its first frame on, as on a bus that one has just come to.
    fn moment(&self, stamp: Instant, last: Instant) -> Instant {
        self.heard + stamp.saturating_since(last)
    }

    /// The number of the entry that was told last.
    pub(super) const fn entry(&self) -> u64 {
        self.entry
    }

    /// Plays a silence for so long at least.
    pub(super) fn set_patience(&mut self, span: Duration) {
        self.patience = self.patience.max(span);
    }

    /// How many lines or records could not be read so far.
    pub(super) const fn bad_entries(&self) -> u64 {
        self.bad_entries
    }

    /// Tells what there is against the bit rate that the user has said.
    pub(super) fn doubt_bit_rate(&self, said: BitRate, doubt: Doubt) -> Result<(), Failure> {
        let bus = self.name_of(self.channel.flatten());
        doubt.tell(&self.file, said, &bus.unwrap_or("the bus".into()))
    }

    /// Says what there was besides the frames: what the recorder lost, and how many lines or records could not be read.
    pub(super) fn tell_the_rest(&self) {
        note_the_rest(&self.file, self.recording.notes(), Network::Can);
        if self.bad_entries > 0 {
            let what = count(self.bad_entries, self.recording.format().entry());
            crate::output::warn(format_args!("{}: {what} could not be read", self.file));
        }
    }

    /// The next input, or a tick at the deadline. In a silence that is longer than anybody is patient one tick, at the next input or at
    /// `end`, stands for all the rest: clocks are set, and sessions are recorded a day apart.
    pub(super) fn next(
        &mut self,
        deadline: Option<Deadline>,
        end: Instant,
    ) -> Result<(Instant, Input), PortError> {
        self.can_fd = None;
        let Some(last) = self.last else {
            self.last = Some(self.peek()?.map_or(Instant::ZERO, |(at, _)| at));
            return Ok((self.now, Input::Link(LinkEvent::Up)));
        };
        let Some((stamp, ahead)) = self.peek()? else { return Err(PortError::Over) };
        let at = self.moment(stamp, last);
        if let Some(deadline) = deadline.filter(|deadline| deadline.at < at) {
            self.now = if deadline.at <= self.heard.saturating_add(self.patience) {
                self.now.max(deadline.at)
            } else {
                self.pass_over(at.min(end))
            };
            return Ok((self.now, Input::Tick));
        }
        self.ahead.pop_front();
        self.entry = self.ahead_entry;
        // Where the clock was set back, time goes on; where two entries have changed places, it waits.
        if stamp >= last || last.saturating_since(stamp) >= SET_BACK {
            (self.last, self.heard) = (Some(stamp), at);
        }
        self.now = self.now.max(at);
        let input = match ahead {
            Ahead::Input(input) => input,
            Ahead::CanFd => {
                self.can_fd = Some(self.now);
                Input::Tick
            }
        };
        Ok((self.now, input))
    }

    /// Tells of it, unless that was done: then it is `until` already, or later.
    fn pass_over(&self, until: Instant) -> Instant {
        if until > self.now {
            let (since, silence) = (self.heard, until.saturating_since(self.heard).as_secs_f64());
            crate::output::note(format_args!(
                "{}: nothing was heard for {silence:.3} s after {since:.3} s; most of that is passed over",
                self.file
            ));
        }
        until.max(self.now)
    }

    fn peek(&mut self) -> Result<Option<(Instant, Ahead)>, PortError> {
        while self.ahead.is_empty() {
            let entry = self.recording.next();
            // It may be half of one.
            if is_set(self.interrupted) {
                return Ok(None);
            }
            match entry {
                None => return Ok(None),
                Some(Ok(RecordedFrame { channel, .. })) if !self.is_heard(channel) => {}
                Some(Ok(RecordedFrame { n, at, content, .. })) => {
                    self.ahead_entry = n;
                    match content {
                        Content::Classic(frame) => {
                            self.ahead.push_back((at, Ahead::Input(Input::Frame(frame))));
                        }
                        Content::Error(error) => {
                            let inputs = error.link_events().map(|event| Ahead::Input(Input::Link(event)));
                            self.ahead.extend(inputs.map(|input| (at, input)));
                        }
                        Content::Fd(_) => self.ahead.push_back((at, Ahead::CanFd)),
                    }
                }
                Some(Err(error)) if error.is_fatal() => {
                    return Err(PortError::Failed(Failure::Usage(format!("{}: {error}", self.file))));
                }
                Some(Err(error)) => {
                    self.bad_entries += 1;
                    crate::output::warn(format_args!("{}:{error}", self.file));
                }
            }
        }
        Ok(self.ahead.front().copied())
    }

    /// Whether an entry is of the channel that is listened to. That there are others is told once.
    fn is_heard(&mut self, channel: Option<ChannelId>) -> bool {
        let chosen = *self.channel.get_or_insert(channel);
        let is_heard = chosen == channel;
        if !is_heard && !core::mem::replace(&mut self.is_told, true) {
            crate::output::warn(format_args!(
                "{}: {} is listened to, {} and any other channel is left out; `devicenet decode` reads all",
                self.file,
                self.name_of(chosen).unwrap_or(NO_CHANNEL.into()),
                self.name_of(channel).unwrap_or(NO_CHANNEL.into()),
            ));
        }
        is_heard
    }

    fn name_of(&self, channel: Option<ChannelId>) -> Option<Cow<'_, str>> {
        channel.map(|channel| printable(self.recording.channels().name(channel)))
    }
}

fn is_set(interrupted: Option<&AtomicBool>) -> bool {
    interrupted.is_some_and(|interrupted| interrupted.load(Ordering::Relaxed))
}

/// In the place of its name.
const NO_CHANNEL: &str = "no channel";
/// By less, entries are only out of order.
const SET_BACK: Duration = Duration::from_secs(1);
/// Longer than the windows of the health rules, and than four times the expected packet rates in use. What takes longer is noticed
/// at the end of the silence.
const PATIENCE: Duration = Duration::from_secs(60);
