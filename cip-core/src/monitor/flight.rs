//! Fragments of explicit messages, and their acknowledges.

use core::time::Duration;

use link_core::Instant;

use super::{Flaw, Flow, Frag, Remark, Remarks, Seen};
use crate::fragment::{AckStatus, FragmentByte, FragmentKind};

/// What is under way in both directions of an explicit connection: the fragments that want an acknowledge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Flights {
    consumed: Lane,
    produced: Lane,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
struct Lane {
    /// The fragment that was sent last.
    flight: Option<Flight>,
    /// Where a message begins is known: what does not belong to one is wrong.
    known: bool,
}

/// A fragment that wants an acknowledge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Flight {
    seen: Seen,
    count: u8,
    xid: bool,
    acknowledged: bool,
}

impl Flights {
    /// Nothing was seen.
    pub const NEW: Self =
        Self { consumed: Lane { flight: None, known: false }, produced: Lane { flight: None, known: false } };

    /// A complete message was seen: where messages begin is known from now on.
    pub fn know(&mut self) {
        self.consumed.known = true;
        self.produced.known = true;
    }

    /// Whether what belongs to no message of a direction is wrong.
    #[must_use]
    pub fn is_known(&self, flow: Flow) -> bool {
        match flow {
            Flow::Consumed => self.consumed.known,
            Flow::Produced => self.produced.known,
        }
    }

    /// Takes note that a fragment of a direction was seen.
    pub fn learn(&mut self, flow: Flow, kind: FragmentKind) {
        self.lane(flow).known |= kind != FragmentKind::Middle;
    }

    /// A fragment was sent; a flaw if the one before it was not acknowledged.
    pub fn send(&mut self, flow: Flow, seen: Seen, byte: FragmentByte, xid: bool) -> Option<Flaw> {
        let flight = Flight { seen, count: byte.count(), xid, acknowledged: false };
        let before = self.lane(flow).flight.replace(flight)?;
        (!before.acknowledged).then_some(Flaw::FragmentUnacknowledged { count: before.count })
    }

    /// Forgets the fragment that was sent last; a flaw if its acknowledge is overdue.
    pub fn give_up(&mut self, flow: Flow, at: Instant) -> Option<Flaw> {
        let flight = self.lane(flow).flight.take().filter(|flight| !flight.acknowledged)?;
        let overdue = at.saturating_since(flight.seen.at) > ACK_TIME;
        overdue.then_some(Flaw::FragmentUnacknowledged { count: flight.count })
    }

    /// The same in both directions, as a complete message does.
    pub fn give_up_all(&mut self, at: Instant) -> Option<Flaw> {
        let consumed = self.give_up(Flow::Consumed, at);
        consumed.or(self.give_up(Flow::Produced, at))
    }

    /// A fragment that went in that direction is acknowledged. Returns true if its receiver has refused the message.
    pub fn acknowledge(
        &mut self,
        reading: &mut impl Remarks,
        flow: Flow,
        at: Instant,
        frag: Frag,
        xid: bool,
    ) -> bool {
        let count = frag.byte.count();
        let unknown = Remark::Flaw(Flaw::UnknownAcknowledge { count });
        let Lane { flight, known } = self.lane(flow);
        let Some(flight) = flight else {
            // The fragment could have been sent before the recording began.
            reading.remark(if *known { unknown } else { Remark::Assumed });
            return false;
        };
        if flight.count != count {
            let is_before = count == flight.count.wrapping_sub(1) & COUNT_MASK && flight.count != 0;
            reading.remark(if is_before { Remark::Repeated } else { unknown });
            return false;
        }
        if flight.acknowledged {
            reading.remark(Remark::Repeated);
            return false;
        }
        flight.acknowledged = true;
        let answered = flight.seen.answered(at);
        reading.remark(Remark::Answers(answered));
        let is_refused = frag.status.map(AckStatus::from) == Some(AckStatus::TooMuchData);
        if is_refused {
            reading.remark(Remark::Flaw(Flaw::FragmentRefused));
        }
        if flight.xid != xid {
            reading.remark(Remark::Flaw(Flaw::TransactionMismatch));
        } else if answered.latency > ACK_TIME {
            reading.remark(Remark::Flaw(Flaw::LateAcknowledge { count }));
        }
        is_refused
    }

    fn lane(&mut self, flow: Flow) -> &mut Lane {
        match flow {
            Flow::Consumed => &mut self.consumed,
            Flow::Produced => &mut self.produced,
        }
    }
}

const COUNT_MASK: u8 = 0x3F;
/// A sender repeats a fragment that was not acknowledged within this time.
const ACK_TIME: Duration = Duration::from_secs(1);
