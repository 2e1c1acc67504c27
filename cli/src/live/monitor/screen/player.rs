//! How fast what is heard is shown.

use core::time::Duration;
use std::time;

use link_core::machine::Deadline;
use link_core::{Input, Instant, Port as _};

use super::keys::Keys;
use crate::exit::Failure;
use crate::live::monitor::model::Model;
use crate::live::port::{LivePort, PortError};

/// Feeds the model from the port.
#[derive(Debug)]
pub(super) struct Player {
    playback: Playback,
    /// Virtual time that is not played yet, of the last step or of real time.
    due: Duration,
    /// When it was called last.
    called: Option<time::Instant>,
    /// A recording that has come to its end stays on the screen.
    stays: bool,
    is_over: bool,
}

/// What the user sees of it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::live::monitor) enum Playback {
    /// The bus goes on, and the picture with it.
    Live,
    /// The bus goes on, the picture does not.
    Frozen,
    /// A scenario or a recording at a speed.
    Playing(Speed),
    /// It waits.
    Paused(Speed),
    /// It has come to its end.
    Ended,
}

/// How fast a scenario or a recording is played.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::live::monitor) enum Speed {
    /// So many times its own pace.
    Times(u32),
    /// As fast as it can be.
    Full,
}

impl Speed {
    const ALL: [Self; 4] = [Self::Times(1), Self::Times(10), Self::Times(100), Self::Full];

    fn next(self, is_faster: bool) -> Self {
        let place = Self::ALL.iter().position(|speed| *speed == self).unwrap_or_default();
        let place = if is_faster { (place + 1).min(Self::ALL.len() - 1) } else { place.saturating_sub(1) };
        Self::ALL[place]
    }
}

impl Player {
    pub(super) const fn live() -> Self {
        Self { playback: Playback::Live, due: Duration::ZERO, called: None, stays: false, is_over: false }
    }

    /// `stays`: until the user has seen enough.
    pub(super) const fn recorded(stays: bool) -> Self {
        Self {
            playback: Playback::Playing(Speed::Times(1)),
            due: Duration::ZERO,
            called: None,
            stays,
            is_over: false,
        }
    }

    pub(super) const fn playback(&self) -> Playback {
        self.playback
    }

    /// The picture is not to change.
    pub(super) fn is_frozen(&self) -> bool {
        self.playback == Playback::Frozen
    }

    /// There is nothing more to show.
    pub(super) const fn is_over(&self) -> bool {
        self.is_over
    }

    pub(super) fn pause(&mut self) {
        self.playback = match self.playback {
            Playback::Live => Playback::Frozen,
            Playback::Frozen => Playback::Live,
            Playback::Playing(speed) => Playback::Paused(speed),
            Playback::Paused(speed) => Playback::Playing(speed),
            Playback::Ended => Playback::Ended,
        };
        self.due = Duration::ZERO;
    }

    pub(super) fn faster(&mut self) {
        self.change(true);
    }

    pub(super) fn slower(&mut self) {
        self.change(false);
    }

    fn change(&mut self, is_faster: bool) {
        if let Playback::Playing(speed) | Playback::Paused(speed) = &mut self.playback {
            *speed = speed.next(is_faster);
        }
    }

    /// A little further, and there it waits.
    pub(super) fn step(&mut self) {
        if let Playback::Playing(speed) | Playback::Paused(speed) = self.playback {
            self.playback = Playback::Paused(speed);
            self.due = STEP;
        }
    }

    /// Lets the bus go on until it is time for the next picture, or a key is pressed.
    pub(super) fn play(
        &mut self,
        port: &mut LivePort,
        model: &mut Model,
        keys: &mut Keys,
    ) -> Result<(), Failure> {
        let now = time::Instant::now();
        let passed = self.called.replace(now).map_or(Duration::ZERO, |called| now - called);
        let until = match self.playback {
            Playback::Live | Playback::Frozen => Some(port.now().saturating_add(PICTURE)),
            Playback::Playing(Speed::Full) => Some(Instant::MAX),
            Playback::Playing(Speed::Times(times)) => {
                self.due += passed * times;
                Some(port.now().saturating_add(self.due))
            }
            Playback::Paused(_) if self.due > Duration::ZERO => Some(port.now().saturating_add(self.due)),
            Playback::Paused(_) | Playback::Ended => None,
        };
        if let Some(until) = until {
            self.feed(port, model, until, now + PICTURE)?;
        }
        match self.playback {
            // The port has waited.
            Playback::Live | Playback::Frozen => {}
            Playback::Playing(_) | Playback::Paused(_) | Playback::Ended => {
                keys.wait(PICTURE.saturating_sub(now.elapsed()));
            }
        }
        Ok(())
    }

    fn feed(
        &mut self,
        port: &mut LivePort,
        model: &mut Model,
        until: Instant,
        no_longer_than: time::Instant,
    ) -> Result<(), Failure> {
        let from = port.now();
        let mut at = from;
        let mut inputs = 0_u32;
        while at < until {
            let look = until.min(at.saturating_add(LOOK_EVERY));
            match port.wait(Some(Deadline { at: look, why: "the next picture" })) {
                Ok((now, input)) => {
                    model.see_port(port, now, input, |_| {})?;
                    at = at.max(now);
                    inputs += 1;
                    let is_long = input != Input::Tick && !inputs.is_multiple_of(LOOK_AT_THE_CLOCK);
                    if !is_long && time::Instant::now() >= no_longer_than {
                        break;
                    }
                }
                Err(PortError::Failed(failure)) => return Err(failure),
                Err(PortError::Over) => {
                    // The silence before the end counts.
                    let now = port.now();
                    model.see_port(port, now, Input::Tick, |_| {})?;
                    self.is_over = !self.stays;
                    self.playback = Playback::Ended;
                    break;
                }
            }
        }
        self.due = self.due.saturating_sub(at.saturating_since(from)).min(MOST_DUE);
        Ok(())
    }
}

/// Time from picture to picture.
const PICTURE: Duration = Duration::from_millis(80);
const STEP: Duration = Duration::from_millis(100);
/// How often time alone is given the word.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// The wall clock is asked after so many frames.
const LOOK_AT_THE_CLOCK: u32 = 64;
/// A machine that is too slow for the speed falls behind, and does not make up for it.
const MOST_DUE: Duration = Duration::from_secs(1);
