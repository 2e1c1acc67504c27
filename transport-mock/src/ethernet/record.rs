//! What happened on a segment.

use std::time::Duration;

use link_core::Instant;
use link_core::ethernet::LinkEvent;

use super::station::StationId;

/// A line of the history of a segment.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Record<E> {
    /// A frame was sent.
    Frame(FrameRecord),
    /// A machine told its application something.
    Event {
        /// When.
        at: Instant,
        /// Which.
        station: StationId,
        /// What.
        event: E,
    },
    /// Something happened at an adapter.
    Link {
        /// When.
        at: Instant,
        /// Whose.
        station: StationId,
        /// What.
        event: LinkEvent,
    },
}

/// A frame that was sent, and is what a recording on the wire would have.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct FrameRecord {
    /// When its first byte was sent.
    pub start: Instant,
    /// When its last byte was, without the propagation delay: what a recorder would take for its time.
    pub end: Instant,
    /// How long it waited for the wire.
    pub waited: Duration,
    /// Who sent it; `None` for one that came from outside.
    pub from: Option<StationId>,
    /// The frame without its CRC.
    pub bytes: Vec<u8>,
}

/// What a segment remembers.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Keep {
    /// Nothing: for long runs.
    Nothing,
    /// Frames only.
    Frames,
    /// Everything.
    #[default]
    All,
}
