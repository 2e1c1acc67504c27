//! The contract: frames and ticks in, actions out.
//!
//! It is that of [`crate::Machine`] with Ethernet frames, which are longer than a machine would keep: what is received is
//! borrowed, and what is sent is written into a buffer of the caller. Time, timers and deadlines are the same.
//!
//! A transmission is not answered: in a protocol for this contract one station decides who sends when, so nothing waits for
//! the medium, and the protocol itself notices a frame that does not arrive. A driver only tells when it handed the frame over.

use core::fmt::Debug;

#[cfg(doc)]
use super::MAX_FRAME;
use crate::{Deadline, Instant};

/// What a machine is told.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Input<'a> {
    /// A frame was received: from the destination MAC address on, without the CRC. Own frames are not delivered back.
    Frame(&'a [u8]),
    /// Something happened below the frame.
    Link(LinkEvent),
    /// Time has passed. Early or repeated ticks change nothing.
    Tick,
}

/// What an adapter can tell.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum LinkEvent {
    /// The link is there.
    Up,
    /// The link is gone.
    Down,
    /// A frame with a wrong checksum was received.
    CrcError,
    /// Two stations sent at once.
    Collision,
    /// Frames were lost before they could be looked at.
    FramesLost {
        /// How many; 0 if the adapter does not count.
        count: u32,
    },
    /// The frame that was to be sent last was not sent.
    NotSent,
}

/// What a machine wants done.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Action<'a, E> {
    /// Send this frame now: the adapter adds the CRC.
    Transmit(&'a [u8]),
    /// Something that the application may want to know.
    Event(E),
}

/// A protocol core on Ethernet: no clock, no socket, no queue of frames.
///
/// The order of calls:
///
/// 1. call [`input`](Self::input), or a command of the concrete machine;
/// 2. call [`poll`](Self::poll) until it returns `None`, and carry out what it returns;
/// 3. wait for the next input, until [`deadline`](Self::deadline) at the latest, and begin again.
pub trait Machine {
    /// What it tells the application.
    type Event: Debug;

    /// Takes note of something. Never fails, never blocks, and does a bounded amount of work.
    fn input(&mut self, now: Instant, input: Input<'_>);

    /// The next thing to do, or `None` when there is nothing more for now. A frame is written to the front of `buffer`,
    /// which must have room for the longest, [`MAX_FRAME`] bytes.
    fn poll<'b>(&mut self, now: Instant, buffer: &'b mut [u8]) -> Option<Action<'b, Self::Event>>;

    /// The frame of the last [`Transmit`](Action::Transmit) was handed to the adapter at this moment, which may be later than the
    /// `now` of [`poll`](Self::poll): a time-out for its answer counts from here. It is no input, and moves no clock: what
    /// arrived before may still have to be told. A driver whose time stands still meanwhile need not call it.
    fn sent(&mut self, at: Instant) {
        let _ = at;
    }

    /// When it must be called next; a moment that has passed while output is pending.
    fn deadline(&self) -> Option<Deadline>;
}
