//! Who may send: each identifier on which the slave sends is a line with at most one frame in flight.

use cip_core::fragment::IO_UNFRAGMENTED_LEN;
use link_core::TxToken;

use super::application::{Application, IoKind};
use super::io::LongMessages;
use super::transfer::Piece;
use crate::access::Access;
use crate::id::{Identifier, MacId};

bitflags::bitflags! {
    /// The lines, in the order of their identifiers: the lowest bit has the highest priority.
    #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
    pub(super) struct Line: u8 {
        /// 0x300 + s
        const MULTICAST_POLL = 1 << 0;
        /// 0x340 + s
        const CHANGE_OF_STATE = 1 << 1;
        /// 0x380 + s
        const BIT_STROBE = 1 << 2;
        /// 0x3C0 + s
        const POLL = 1 << 3;
        /// 0x403 + 8s
        const EXPLICIT = 1 << 4;
        /// 0x740 + s
        const UCMM = 1 << 5;
    }
}

/// The state of all lines.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Lines {
    /// An I/O message is to be sent.
    pub(super) due: Line,
    /// The next fragment of an I/O message is to be sent.
    continued: Line,
    /// A frame is with the controller.
    pub(super) in_flight: Line,
    /// It must be withdrawn.
    unwanted: Line,
    /// It is of a connection that has ended.
    stale: Line,
    /// What is in flight on the explicit line, if it matters.
    pub(super) explicit: Option<Sent>,
    /// The same on the line of the UCMM.
    pub(super) ucmm: Option<Sent>,
    /// What is produced by change of state has changed since it was last sent.
    pub(super) pending: bool,
    /// How often the present change of state or cyclic message was sent again.
    pub(super) retries: u8,
}

/// A frame on the explicit line or that of the UCMM.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Sent {
    /// Of the explicit connection.
    Piece(Piece),
    /// The response of an unconnected port.
    Unconnected,
    /// The heartbeat.
    Heartbeat,
    /// The farewell.
    Shutdown,
}

impl Lines {
    /// The line of the highest priority, of those for the I/O of `A`, that has something to send and is free.
    pub(super) fn ready<A: Application>(&self) -> Option<IoKind> {
        let due = if fragments::<A>() { self.due.union(self.continued) } else { self.due };
        let ready = due.intersection(const { all_of::<A>() }).difference(self.in_flight);
        // Asked first, so that the compiler knows the only line of a device that has one.
        if ready.is_empty() { None } else { io_of::<A>(ready) }
    }

    /// An I/O message is to be sent; false if one is waiting already, with which it goes together.
    pub(super) fn want(&mut self, kind: IoKind) -> bool {
        let line = of(kind);
        let new = !self.due.contains(line);
        self.due.insert(line);
        new
    }

    /// The message of the line goes on with its next fragment.
    pub(super) fn go_on(&mut self, kind: IoKind) {
        self.continued.insert(of(kind));
    }

    /// A frame of the line is handed to the controller.
    pub(super) fn begin<A: Application>(&mut self, kind: IoKind) {
        let line = of(kind);
        if fragments::<A>() && self.continued.contains(line) {
            self.continued.remove(line);
        } else {
            self.due.remove(line);
        }
        self.in_flight.insert(line);
    }

    pub(super) fn is_change_of_state_free(&self) -> bool {
        self.is_free(Line::CHANGE_OF_STATE)
    }

    pub(super) fn is_free(&self, line: Line) -> bool {
        !self.in_flight.contains(line)
    }

    /// The connection is gone: what is waiting is not sent, what is in flight is withdrawn.
    pub(super) fn stop(&mut self, kind: IoKind) {
        let line = of(kind);
        self.due.remove(line);
        self.continued.remove(line);
        let wanted = self.in_flight.intersection(line).difference(self.stale);
        self.unwanted.insert(wanted);
        self.stale.insert(wanted);
    }

    /// The node leaves the network. What is in flight is withdrawn, unless the controller has dropped it by itself.
    pub(super) fn stop_all(&mut self, dropped: bool) {
        self.due = Line::empty();
        self.continued = Line::empty();
        (self.explicit, self.ucmm) = (None, None);
        self.unwanted = if dropped { Line::empty() } else { self.in_flight };
        self.stale = self.in_flight;
    }

    pub(super) fn must_withdraw(&self) -> bool {
        !self.unwanted.is_empty()
    }

    /// The next frame to withdraw: of the line of the highest priority, the lowest bit.
    pub(super) fn withdraw(&mut self) -> Option<TxToken> {
        let others = self.unwanted.bits() & self.unwanted.bits().wrapping_sub(1);
        let line = self.unwanted.difference(Line::from_bits_retain(others));
        self.unwanted.remove(line);
        (!line.is_empty()).then(|| token(line))
    }

    /// A frame of the line is with the controller no longer; `None` if it was not. False if nobody waits for it any more.
    pub(super) fn done(&mut self, line: Line) -> Option<bool> {
        if !self.in_flight.contains(line) {
            return None;
        }
        self.in_flight.remove(line);
        self.unwanted.remove(line);
        let wanted = !self.stale.contains(line);
        self.stale.remove(line);
        Some(wanted)
    }
}

pub(super) const fn of(kind: IoKind) -> Line {
    match kind {
        IoKind::MulticastPoll => Line::MULTICAST_POLL,
        IoKind::ChangeOfState => Line::CHANGE_OF_STATE,
        IoKind::BitStrobe => Line::BIT_STROBE,
        IoKind::Poll => Line::POLL,
    }
}

/// The lines for the I/O of an application.
const fn all_of<A: Application>() -> Line {
    let mut lines = Line::empty();
    let mut kinds = IoKind::all_offered::<A>();
    while let [kind, rest @ ..] = kinds {
        lines = lines.union(of(*kind));
        kinds = rest;
    }
    lines
}

/// Whether an I/O message can take more than a frame.
const fn fragments<A: Application>() -> bool {
    A::Long::CAPACITY > IO_UNFRAGMENTED_LEN
}

/// The identifier of a line.
pub(super) fn identifier<A: Application>(line: Line, mac: MacId) -> Identifier {
    match io_of::<A>(line) {
        Some(IoKind::MulticastPoll) => Identifier::multicast_poll_response(mac),
        Some(IoKind::ChangeOfState) => Identifier::change_of_state(mac),
        Some(IoKind::BitStrobe) => Identifier::bit_strobe_response(mac),
        Some(IoKind::Poll) => Identifier::poll_response(mac),
        None if line == Line::UCMM => Identifier::unconnected_response(mac),
        None => Identifier::explicit_response(mac),
    }
}

/// The I/O connection of the line of the highest priority; `None` if there is no line of I/O.
pub(super) fn io_of<A: Application>(lines: Line) -> Option<IoKind> {
    // Without a loop the compiler sees which of them there cannot be.
    let lines = lines.intersection(const { all_of::<A>() });
    Some(if lines.contains(Line::MULTICAST_POLL) {
        IoKind::MulticastPoll
    } else if lines.contains(Line::CHANGE_OF_STATE) {
        IoKind::ChangeOfState
    } else if lines.contains(Line::BIT_STROBE) {
        IoKind::BitStrobe
    } else if lines.contains(Line::POLL) {
        IoKind::Poll
    } else {
        return None;
    })
}

/// The token of the frames of a line: its bit, which is never that of network access.
pub(super) fn token(line: Line) -> TxToken {
    const { assert!(Access::TOKEN.0 == 0, "lines are told apart by their bits, and 0 is none") };
    TxToken(line.bits().into())
}

/// The line of a token.
pub(super) fn line_of(token: TxToken) -> Option<Line> {
    let line = Line::from_bits_retain(u8::try_from(token.0).ok()?);
    line.bits().is_power_of_two().then_some(line)
}

/// The token of a connection that was opened dynamically.
pub(super) fn dynamic_token(index: u8) -> TxToken {
    TxToken(u16::from(index).saturating_add(FIRST_DYNAMIC))
}

/// The connection of a token.
pub(super) fn dynamic_of(token: TxToken) -> Option<u8> {
    u8::try_from(token.0.checked_sub(FIRST_DYNAMIC)?).ok()
}

/// Above those of the lines.
const FIRST_DYNAMIC: u16 = 0x100;
