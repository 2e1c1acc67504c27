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
    pub fn fragment<'b>(
        &mut self,
        buffer: &'b mut [u8],
        xid: bool,
        byte: FragmentByte,
        data: &[u8],
    ) -> ExplicitOutcome<'b> {
        let count = byte.count();
        match (byte.kind, self.state) {
            (FragmentKind::Acknowledge, _) => ExplicitOutcome::Acknowledge,
            (FragmentKind::First, _) if count != 0 => {
                self.discard();
                ExplicitOutcome::InvalidFirst { count }
            }
            (FragmentKind::First, _) => self.store(buffer, 0, data, Then::Expect(1)),
            (FragmentKind::Middle, State::Receiving { expected, received }) if count == expected => {
                self.store(buffer, received, data, Then::Expect(next_count(expected)))
            }
            (FragmentKind::Middle, State::Receiving { expected, .. }) if next_count(count) == expected => {
                ExplicitOutcome::Repeated
            }
            (FragmentKind::Last, State::Receiving { expected, received }) if count == expected => {
                self.store(buffer, received, data, Then::End(Completed { xid, count }))
            }
            (FragmentKind::Middle | FragmentKind::Last, State::Receiving { expected, .. }) => {
                self.discard();
                ExplicitOutcome::OutOfSequence { expected, found: count }
            }
            (FragmentKind::Last, State::Idle { completed })
                if completed == Some(Completed { xid, count }) =>
            {
                ExplicitOutcome::RepeatedLast
            }
            (FragmentKind::Middle | FragmentKind::Last, State::Idle { .. }) => {
                ExplicitOutcome::IgnoredNoFirst
            }
        }
    }

    fn store<'b>(
        &mut self,
        buffer: &'b mut [u8],
        received: u16,
        data: &[u8],
        then: Then,
    ) -> ExplicitOutcome<'b> {
        self.discard();
        let at = usize::from(received);
        let end = at.saturating_add(data.len());
        let Some(received) = u16::try_from(end).ok().filter(|&received| received <= self.limit) else {
            return ExplicitOutcome::TooLong;
        };
        let Some(message) = buffer.get_mut(..end) else { return ExplicitOutcome::TooLong };
        // `end` is as far behind `at` as the data are long.
        if let Some(place) = message.get_mut(at..) {
            place.copy_from_slice(data);
        }
        match then {
            Then::Expect(expected) => {
                self.state = State::Receiving { expected, received };
                ExplicitOutcome::Stored
            }
            Then::End(completed) => {
                self.state = State::Idle { completed: Some(completed) };
                ExplicitOutcome::Complete(message)
            }
        }
    }
}

/// What follows a fragment that was stored.
enum Then {
    Expect(u8),
    End(Completed),
}

const IDLE: State = State::Idle { completed: None };
/// More than that is as good as no limit.
const MOST: usize = 0xFFFF;
