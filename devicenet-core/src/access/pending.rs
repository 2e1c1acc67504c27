//! The events that are still to be told, in little memory.
//!
//! What a frame said is the longest part of an event, and an input is one frame at most: it is kept once, however many
//! events tell of it.

use link_core::link::LinkCommandKind;
use link_core::{Frame, Queue, TxOutcome};

use super::event::{AccessEvent, Outgoing};
use super::state::{Cause, StateKind};
use crate::id::{Identifier, MacId};
use crate::message::{Direction, DuplicateMacCheck};

/// Events that are still to be told.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Events {
    queue: Queue<Pending, CAPACITY>,
    /// What the frame said that some of them tell of; `None` if there are no events.
    heard: Option<Heard>,
}

/// An [`AccessEvent`] without what a frame said. It begins with 1, so that places without one are zeros.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[repr(u8)]
pub(super) enum Pending {
    StateChanged {
        from: StateKind,
        to: StateKind,
        cause: Cause,
    } = 1,
    Duplicate {
        direction: Direction,
    },
    Challenged,
    NotAcknowledged,
    NotSent {
        what: Outgoing,
        outcome: TxOutcome,
    },
    MacIdAssigned {
        from: MacId,
        to: MacId,
    },
    MacIdLocked {
        requested: MacId,
    },
    Identify {
        on: bool,
    },
    BadFrame,
    /// In bytes, so that it begins anywhere.
    FramesLost {
        count: [u8; 4],
    },
    LinkRefused(LinkCommandKind),
}

/// What a frame said.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Heard {
    Check(DuplicateMacCheck),
    Malformed { id: Identifier, data: [u8; Frame::MAX_DATA], len: u8 },
}

/// There is no room for another event.
#[derive(Clone, Copy)]
pub(super) struct Lost;

impl Events {
    pub(super) const fn new() -> Self {
        Self { queue: Queue::new(), heard: None }
    }

    pub(super) const fn is_empty(&self) -> bool {
        self.queue.is_empty()
    }

    /// Keeps what a frame said, for the events that follow from it.
    ///
    /// # Errors
    /// Events tell of another frame that said something else, and were not fetched.
    pub(super) fn hear(&mut self, heard: Heard) -> Result<(), Lost> {
        match (&self.heard, &heard) {
            (None, _) => {}
            (Some(Heard::Check(known)), Heard::Check(check)) if known == check => {}
            (Some(_), _) => return Err(Lost),
        }
        self.heard = Some(heard);
        Ok(())
    }

    pub(super) fn push(&mut self, event: Pending) -> Result<(), Lost> {
        self.queue.push(event).map_err(|_| Lost)
    }

    pub(super) fn pop(&mut self) -> Option<AccessEvent> {
        let event = self.queue.pop()?;
        let heard = self.heard;
        if self.queue.is_empty() {
            self.heard = None;
        }
        let other = || match heard {
            Some(Heard::Check(check)) => Some(check),
            Some(Heard::Malformed { .. }) | None => None,
        };
        Some(match event {
            Pending::StateChanged { from, to, cause } => AccessEvent::StateChanged { from, to, cause },
            Pending::Duplicate { direction } => AccessEvent::Duplicate { direction, other: other() },
            Pending::Challenged => AccessEvent::Challenged { other: other() },
            Pending::NotAcknowledged => AccessEvent::NotAcknowledged,
            Pending::NotSent { what, outcome } => AccessEvent::NotSent { what, outcome },
            Pending::MacIdAssigned { from, to } => AccessEvent::MacIdAssigned { from, to },
            Pending::MacIdLocked { requested } => AccessEvent::MacIdLocked { requested },
            Pending::Identify { on } => AccessEvent::Identify { on },
            Pending::BadFrame => {
                let Some(Heard::Malformed { id, data, len }) = heard else { return None };
                AccessEvent::BadFrame { id, data, len }
            }
            Pending::FramesLost { count } => AccessEvent::FramesLost { count: u32::from_le_bytes(count) },
            Pending::LinkRefused(kind) => AccessEvent::LinkRefused(kind),
        })
    }
}

impl Heard {
    pub(super) fn malformed(id: Identifier, field: &[u8]) -> Self {
        let mut data = [0; Frame::MAX_DATA];
        for (to, from) in data.iter_mut().zip(field) {
            *to = *from;
        }
        // It is from a frame.
        let len = u8::try_from(field.len()).unwrap_or(u8::MAX);
        Self::Malformed { id, data, len }
    }
}

/// One input raises at most five.
const CAPACITY: usize = 5;
