//! Receiving of explicit messages in fragments, every one of which is acknowledged.

use super::{ExplicitOutcome, FragmentByte, FragmentKind, next_count};

/// The receive side of an explicit connection: which fragment is expected, and how much has arrived.
///
/// It holds neither the message nor the time. Its owner passes the same buffer to every call of one message, and calls
/// [`discard`](Self::discard) when an unfragmented message arrives, when the connection ends, or when its receive timer
/// expires, and [`forget_completed`](Self::forget_completed) one second after a completed message.
///
/// | State | Fragment | Outcome | Next |
/// |---|---|---|---|
/// | any | first, count 0 | [`Stored`](ExplicitOutcome::Stored) or [`TooLong`](ExplicitOutcome::TooLong) | receiving 1, or idle |
/// | any | first, other count | [`InvalidFirst`](ExplicitOutcome::InvalidFirst) | idle |
/// | idle | the last fragment of the completed message again | [`RepeatedLast`](ExplicitOutcome::RepeatedLast) | idle |
/// | idle | middle or last | [`IgnoredNoFirst`](ExplicitOutcome::IgnoredNoFirst) | idle |
/// | receiving e | middle, count e | [`Stored`](ExplicitOutcome::Stored) or [`TooLong`](ExplicitOutcome::TooLong) | receiving e+1, or idle |
/// | receiving e | middle, count e-1 | [`Repeated`](ExplicitOutcome::Repeated) | receiving e |
/// | receiving e | last, count e | [`Complete`](ExplicitOutcome::Complete) or [`TooLong`](ExplicitOutcome::TooLong) | idle |
/// | receiving e | middle or last, other count | [`OutOfSequence`](ExplicitOutcome::OutOfSequence) | idle |
/// | any | acknowledge | [`Acknowledge`](ExplicitOutcome::Acknowledge) | same |
///
/// Counts are modulo 64. Only fragments that are stored are written to the buffer.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ExplicitReceive {
    limit: u16,
    state: State,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum State {
    Idle { completed: Option<Completed> },
    Receiving { expected: u8, received: u16 },
}

/// Enough of a completed message to know its last fragment again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Completed {
    xid: bool,
    count: u8,
}

impl ExplicitReceive {
    /// An idle machine. `limit` is the consumed connection size, counted from the service byte; the buffer limits as
    /// well.
    pub const fn new(limit: usize) -> Self {
        let [low, high, ..] = limit.to_le_bytes();
        Self { limit: if limit > MOST { u16::MAX } else { u16::from_le_bytes([low, high]) }, state: IDLE }
    }

    /// True if no message is being received, and none is remembered.
    pub const fn is_idle(&self) -> bool {
        matches!(self.state, State::Idle { completed: None })
    }

    /// True while a message is being received.
    pub const fn is_receiving(&self) -> bool {
        matches!(self.state, State::Receiving { .. })
    }

    /// True while the last fragment of the completed message would be known again.
    pub const fn remembers_completed(&self) -> bool {
        matches!(self.state, State::Idle { completed: Some(_) })
    }

    /// The number of bytes received of the message in progress.
    pub const fn received(&self) -> u16 {
        match self.state {
            State::Receiving { received, .. } => received,
            State::Idle { .. } => 0,
        }
    }

    /// Drops a message in progress and forgets the completed one.
    pub const fn discard(&mut self) {
        self.state = IDLE;
    }

    /// Forgets the completed message, so that a repetition of its last fragment is no longer acknowledged. A message
    /// in progress is not touched.
    pub const fn forget_completed(&mut self) {
        if self.remembers_completed() {
            self.discard();
        }
    }

    /// Takes a fragment: the transaction ID of its header, the fragmentation byte, and the bytes after it.
    // It is called from one place: in line, what becomes of a fragment is not put together and taken apart again.
    #[inline]
    pub fn fragment<'b>(
        &mut self,
        buffer: &'b mut [u8],
        xid: bool,
        byte: FragmentByte,
        data: &[u8],
    ) -> ExplicitOutcome<'b> {
        let count = byte.count();
        let at = match (byte.kind, self.state) {
            (FragmentKind::Acknowledge, _) => return ExplicitOutcome::Acknowledge,
            (FragmentKind::First, _) if count == 0 => 0,
            (FragmentKind::First, _) => {
                self.discard();
                return ExplicitOutcome::InvalidFirst { count };
            }
            (kind, State::Idle { completed }) => {
                let again = kind == FragmentKind::Last && completed == Some(Completed { xid, count });
                return if again { ExplicitOutcome::RepeatedLast } else { ExplicitOutcome::IgnoredNoFirst };
            }
            (_, State::Receiving { expected, received }) if count == expected => received,
            (kind, State::Receiving { expected, .. }) => {
                if kind == FragmentKind::Middle && next_count(count) == expected {
                    return ExplicitOutcome::Repeated;
                }
                self.discard();
                return ExplicitOutcome::OutOfSequence { expected, found: count };
            }
        };
        self.discard();
        let Some((message, received)) = self.store(buffer, at, data) else { return ExplicitOutcome::TooLong };
        if byte.kind == FragmentKind::Last {
            self.state = State::Idle { completed: Some(Completed { xid, count }) };
            return ExplicitOutcome::Complete(message);
        }
        self.state = State::Receiving { expected: next_count(count), received };
        ExplicitOutcome::Stored
    }

    /// What there is of the message now, and how long it is; `None` if it is too long.
    fn store<'b>(&self, buffer: &'b mut [u8], at: u16, data: &[u8]) -> Option<(&'b [u8], u16)> {
        let at = usize::from(at);
        let end = at.saturating_add(data.len());
        let received = u16::try_from(end).ok().filter(|&received| received <= self.limit)?;
        let message = buffer.get_mut(..end)?;
        // `end` is as far behind `at` as the data are long.
        if let Some(place) = message.get_mut(at..) {
            place.copy_from_slice(data);
        }
        Some((message, received))
    }
}

const IDLE: State = State::Idle { completed: None };
/// More than that is as good as no limit.
const MOST: usize = 0xFFFF;
