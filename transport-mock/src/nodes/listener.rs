//! Hears everything and says nothing.

use std::collections::VecDeque;
use std::convert::Infallible;

use link_core::{Action, Deadline, Frame, Input, Instant, LinkEvent, Machine};

use crate::NodeConfig;

/// Keeps the frames that it hears, and counts errors. It only listens if its [`NodeConfig`] says so; see
/// [`config`](Self::config).
#[derive(Clone, Debug)]
pub struct Listener {
    frames: VecDeque<(Instant, Frame)>,
    capacity: usize,
    heard: u64,
    errors: u64,
}

impl Listener {
    /// Keeps the last `capacity` frames.
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        Self { frames: VecDeque::with_capacity(capacity), capacity, heard: 0, errors: 0 }
    }

    /// A node that only listens.
    #[must_use]
    pub fn config(name: impl Into<String>) -> NodeConfig {
        NodeConfig { listen_only: true, ..NodeConfig::named(name) }
    }

    /// The last frames and when they ended, on the clock of the node, the oldest first.
    pub fn frames(&self) -> impl Iterator<Item = &(Instant, Frame)> {
        self.frames.iter()
    }

    /// How many frames were heard since power-up.
    #[must_use]
    pub const fn heard(&self) -> u64 {
        self.heard
    }

    /// How many errors were seen since power-up.
    #[must_use]
    pub const fn errors(&self) -> u64 {
        self.errors
    }
}

impl Machine for Listener {
    type Event = Infallible;

    fn input(&mut self, now: Instant, input: Input) {
        match input {
            Input::Frame(frame) => {
                self.heard += 1;
                if self.frames.len() == self.capacity {
                    self.frames.pop_front();
                }
                if self.capacity > 0 {
                    self.frames.push_back((now, frame));
                }
            }
            Input::Link(LinkEvent::BusError(_)) => self.errors += 1,
            Input::Link(_) | Input::TxDone(..) | Input::Tick => {}
        }
    }

    fn poll(&mut self, _: Instant) -> Option<Action<Infallible>> {
        None
    }

    fn deadline(&self) -> Option<Deadline> {
        None
    }

    fn max_in_flight(&self) -> usize {
        0
    }
}
