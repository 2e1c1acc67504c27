//! The store of messages that are being put together.

use core::time::Duration;

use link_core::Instant;

use super::{Flaw, Remark, Remarks};
use crate::fragment::{
    ExplicitOutcome, ExplicitReassembly, FragmentByte, FragmentKind, IoOutcome, IoReassembly,
};

/// What a fragment is part of: the messages of one sender on one connection, one after the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Stream(u64);

impl Stream {
    /// Explicit messages on an identifier, of or to a peer that the identifier does not name.
    #[must_use]
    pub fn explicit(identifier: impl Into<u32>, peer: u8) -> Self {
        Self(u64::from(identifier.into()) << 8 | u64::from(peer))
    }

    /// The I/O data on an identifier.
    #[must_use]
    pub fn io(identifier: impl Into<u32>) -> Self {
        Self(u64::from(identifier.into()) << 8)
    }
}

/// What became of a fragment.
#[derive(Debug, PartialEq, Eq)]
pub enum Piece<'b> {
    /// Kept; more must follow.
    Kept,
    /// The message is whole.
    Whole(&'b [u8]),
    /// Seen before, not kept again.
    Repeated,
    /// It belongs to a message whose beginning was not seen.
    Headless,
    /// The message is lost, by a mistake on the bus.
    Broken(Flaw),
    /// The message is lost, because it exceeds the store.
    Overflow,
}

impl<'b> Piece<'b> {
    /// The whole message; without one, what has become of the fragment is remarked. `known`: the sender's messages were seen
    /// from where they begin, so that a fragment without a first is wrong.
    pub fn whole(self, reading: &mut impl Remarks, byte: FragmentByte, known: bool) -> Option<&'b [u8]> {
        match self {
            Self::Whole(message) => return Some(message),
            Self::Kept => {}
            Self::Repeated => reading.remark(Remark::Repeated),
            Self::Headless if known => {
                reading.remark(Remark::Flaw(Flaw::NoFirstFragment { found: byte.count() }));
            }
            Self::Headless => reading.remark(Remark::Assumed),
            Self::Broken(flaw) => reading.remark(Remark::Flaw(flaw)),
            Self::Overflow => reading.remark(Remark::NotStored),
        }
        None
    }
}

/// Up to `N` messages of up to `B` bytes in progress.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Slots<const N: usize, const B: usize> {
    /// Kept apart from the buffers, so that a search touches one or two cache lines.
    keys: [Option<Stream>; N],
    slots: [Slot<B>; N],
    /// Messages dropped because every slot was taken.
    pub evicted: u64,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Slot<const B: usize> {
    last: Instant,
    xid: bool,
    machine: Machine<B>,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Machine<const B: usize> {
    Explicit(ExplicitReassembly<B>),
    Io(IoReassembly<B>),
}

impl<const N: usize, const B: usize> Slots<N, B> {
    /// An empty store.
    #[must_use]
    pub const fn new() -> Self {
        Self { keys: [const { None }; N], slots: [const { Slot::new() }; N], evicted: 0 }
    }

    /// Drops the message in progress of a stream.
    pub fn discard(&mut self, stream: Stream) {
        for key in &mut self.keys {
            if *key == Some(stream) {
                *key = None;
            }
        }
    }

    /// True while a message of the stream is being put together.
    #[must_use]
    pub fn is_receiving(&self, stream: Stream) -> bool {
        self.position(stream).and_then(|index| self.slots.get(index)).is_some_and(Slot::is_receiving)
    }

    /// Takes a fragment of an explicit message; `xid` is the transaction ID in its header, false where there is none. The
    /// flaw beside the piece does not cost the message.
    pub fn explicit(
        &mut self,
        stream: Stream,
        at: Instant,
        xid: bool,
        byte: FragmentByte,
        data: &[u8],
    ) -> (Piece<'_>, Option<Flaw>) {
        let Some(slot) = self.slot(stream, at, byte.kind) else {
            return (Piece::Headless, None);
        };
        if !matches!(slot.machine, Machine::Explicit(_)) {
            slot.machine = Machine::Explicit(ExplicitReassembly::new(B));
        }
        if byte.kind == FragmentKind::First {
            slot.xid = xid;
        }
        let changed = (slot.xid != xid && slot.is_receiving()).then_some(Flaw::TransactionChanged);
        slot.last = at;
        let first_xid = slot.xid;
        let Machine::Explicit(machine) = &mut slot.machine else {
            return (Piece::Headless, None);
        };
        let piece = match machine.fragment(first_xid, byte, data) {
            ExplicitOutcome::Stored => Piece::Kept,
            ExplicitOutcome::Complete(body) => Piece::Whole(body),
            ExplicitOutcome::Repeated | ExplicitOutcome::RepeatedLast => Piece::Repeated,
            ExplicitOutcome::TooLong => Piece::Overflow,
            ExplicitOutcome::OutOfSequence { expected, found } => {
                Piece::Broken(out_of_sequence(expected, found))
            }
            ExplicitOutcome::IgnoredNoFirst => Piece::Headless,
            ExplicitOutcome::InvalidFirst { count } => Piece::Broken(Flaw::FirstNotZero { found: count }),
            ExplicitOutcome::Acknowledge => Piece::Headless,
        };
        (piece, changed)
    }

    /// Takes a frame of an I/O connection that fragments; `size` is the connection size, if it is known.
    pub fn io(&mut self, stream: Stream, at: Instant, size: Option<u16>, field: &[u8]) -> Piece<'_> {
        let byte = field.first().copied().map(FragmentByte::from);
        let kind = byte.map_or(FragmentKind::First, |byte| byte.kind);
        let Some(slot) = self.slot(stream, at, kind) else {
            return Piece::Headless;
        };
        slot.last = at;
        let limit = size.map_or(B, usize::from);
        if !slot.is_receiving() {
            slot.machine = Machine::Io(IoReassembly::new(limit));
        }
        let Machine::Io(machine) = &mut slot.machine else {
            return Piece::Headless;
        };
        match machine.frame(field) {
            IoOutcome::Stored => Piece::Kept,
            IoOutcome::Complete(message) => Piece::Whole(message),
            IoOutcome::TooLong => match size {
                Some(limit) if usize::from(limit) <= B => Piece::Broken(Flaw::TooLong { limit }),
                Some(_) | None => Piece::Overflow,
            },
            IoOutcome::OutOfSequence { expected, found } => Piece::Broken(out_of_sequence(expected, found)),
            IoOutcome::IgnoredNoFirst => Piece::Headless,
            IoOutcome::InvalidFirst { count } => Piece::Broken(Flaw::FirstNotZero { found: count }),
            IoOutcome::UnexpectedAcknowledge => {
                let found = byte.map_or(0, u8::from).into();
                Piece::Broken(Flaw::ReservedValue { field: "fragmentation byte", found })
            }
        }
    }

    /// The slot of a stream. A new one is made for a first fragment only.
    fn slot(&mut self, stream: Stream, at: Instant, kind: FragmentKind) -> Option<&mut Slot<B>> {
        if let Some(index) = self.position(stream) {
            let slot = self.slots.get_mut(index)?;
            if at.saturating_since(slot.last) > FRAGMENT_TIMEOUT {
                slot.discard();
            }
            return Some(slot);
        }
        if kind != FragmentKind::First {
            return None;
        }
        let index = self.victim()?;
        *self.keys.get_mut(index)? = Some(stream);
        let slot = self.slots.get_mut(index)?;
        slot.discard();
        Some(slot)
    }

    fn position(&self, stream: Stream) -> Option<usize> {
        self.keys.iter().position(|key| *key == Some(stream))
    }

    /// A free slot, else the one idle for longest, else the one that has waited for longest.
    fn victim(&mut self) -> Option<usize> {
        if let Some(free) = self.keys.iter().position(Option::is_none) {
            return Some(free);
        }
        let oldest = self.slots.iter().enumerate().min_by_key(|(_, slot)| (slot.is_receiving(), slot.last));
        let (index, slot) = oldest?;
        if slot.is_receiving() {
            self.evicted = self.evicted.saturating_add(1);
        }
        Some(index)
    }
}

impl<const N: usize, const B: usize> Default for Slots<N, B> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const B: usize> Slot<B> {
    const fn new() -> Self {
        Self { last: Instant::ZERO, xid: false, machine: Machine::Io(IoReassembly::new(0)) }
    }

    fn is_receiving(&self) -> bool {
        match &self.machine {
            Machine::Explicit(machine) => machine.is_receiving(),
            Machine::Io(machine) => machine.is_receiving(),
        }
    }

    fn discard(&mut self) {
        match &mut self.machine {
            Machine::Explicit(machine) => machine.discard(),
            Machine::Io(machine) => machine.discard(),
        }
    }
}

fn out_of_sequence(expected: u8, found: u8) -> Flaw {
    Flaw::OutOfSequence { after: expected.wrapping_sub(1) & 0x3F, found }
}

/// A message whose next fragment takes longer is given up. A sender gives up after two acknowledge times of one second.
const FRAGMENT_TIMEOUT: Duration = Duration::from_secs(3);
