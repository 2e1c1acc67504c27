//! I/O messages: poll, bit-strobe, change of state, cyclic, multicast poll.
//!
//! | Identifier | Needs | Is |
//! |---|---|---|
//! | 0x400 + 8m | instance 3 established | bit-strobe command of the master |
//! | 0x401 + 8g | instance 5 established | multicast poll command of the group |
//! | 0x402 + 8s | instance 4 established, with acknowledges | acknowledge of change of state or cyclic |
//! | 0x405 + 8s | instance 2 established | poll command, or the master's change of state or cyclic message |
//!
//! Everything else is ignored without an error. A command of a full length is run, an empty one idle; any other length
//! is ignored, and the watchdog goes on. Every command that is accepted is answered once, with the data as they are when
//! the answer is handed to the controller; commands that come while an answer still waits for its turn share it.

mod change_of_state;
mod long;
mod slots;

pub use long::{Fragmented, LongMessages, PollOnly};
pub(super) use slots::Slots;

use cip_core::connection::{IoState, PredefinedConnection};
use cip_core::fragment::{EmptyMessage, IO_UNFRAGMENTED_LEN, IoOutcome};
use cip_core::message::AllocationChoice;
use link_core::Frame;

use super::application::{Application, IoKind, IoMode};
use super::config::Options;
use super::event::{Ignored, SlaveEvent, count, count_wide};
use super::machine::{Slave, changes};
use crate::id::{Identifier, MacId};

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Slave<A, MESSAGE, DYNAMIC> {
    /// Poll, multicast poll, or a message of the master by change of state or cyclic.
    pub(super) fn command(&mut self, id: Identifier, kind: IoKind, field: &[u8]) {
        match self.consume(kind, field) {
            Ok(true) => self.answer(kind),
            Ok(false) => {}
            Err(why) => self.node.ignored(id, why),
        }
    }

    pub(super) fn strobe(&mut self, id: Identifier, field: &[u8]) {
        let bit = match field.len() {
            0 => None,
            8 => Some(bit_of(field, self.node.access.mac_id())),
            _ => return self.node.ignored(id, Ignored::Length),
        };
        if self.node.io(IoKind::BitStrobe).state() != IoState::Established {
            return self.not_established(id, IoKind::BitStrobe);
        }
        match bit {
            Some(bit) => self.run(IoKind::BitStrobe, &[bit.into()]),
            None => self.node.set_mode(IoKind::BitStrobe, IoMode::Idle),
        }
        self.alive(IoKind::BitStrobe);
        self.answer(IoKind::BitStrobe);
    }

    /// Whether the frame ended a message that is to be answered.
    fn consume(&mut self, kind: IoKind, field: &[u8]) -> Result<bool, Ignored> {
        if self.node.io(kind).state() != IoState::Established {
            // The table has a row for it; nothing changes.
            self.node.io_message(kind);
            return Err(Ignored::NoConnection);
        }
        let size = self.node.application.consumed(kind).len();
        if size <= IO_UNFRAGMENTED_LEN {
            return self.message(kind, size, field).map(|()| true);
        }
        let message: &[u8] = match self.long.receive(kind, field) {
            Some(IoOutcome::Complete(message)) => message,
            Some(IoOutcome::Stored) => return Ok(false),
            Some(IoOutcome::TooLong) | None => return Err(Ignored::Length),
            Some(
                IoOutcome::OutOfSequence { .. }
                | IoOutcome::IgnoredNoFirst
                | IoOutcome::InvalidFirst { .. }
                | IoOutcome::UnexpectedAcknowledge,
            ) => return Err(Ignored::FragmentOrder),
        };
        let shorter = self.node.options.contains(Options::ACCEPT_SHORTER_IO);
        match message.len() {
            0 => self.node.set_mode(kind, IoMode::Idle),
            len if len == size || (shorter && len < size) => {
                copy(self.node.application.consumed(kind), message);
                self.ran(kind);
            }
            _ => return Err(Ignored::Length),
        }
        self.alive(kind);
        Ok(true)
    }

    /// A complete message in one frame.
    fn message(&mut self, kind: IoKind, size: usize, data: &[u8]) -> Result<(), Ignored> {
        if data.len() == size && size > 0 {
            self.run(kind, data);
        } else {
            self.unusual_message(kind, size, data)?;
        }
        self.alive(kind);
        Ok(())
    }

    #[inline(never)]
    fn unusual_message(&mut self, kind: IoKind, size: usize, data: &[u8]) -> Result<(), Ignored> {
        if data.is_empty() {
            // Where no data are expected, none are no sign of idleness.
            self.node.set_mode(kind, if size == 0 { IoMode::Run } else { IoMode::Idle });
        } else if data.len() < size && self.node.options.contains(Options::ACCEPT_SHORTER_IO) {
            self.run(kind, data);
        } else {
            return Err(Ignored::Length);
        }
        Ok(())
    }

    fn run(&mut self, kind: IoKind, data: &[u8]) {
        copy(self.node.application.consumed(kind), data);
        self.ran(kind);
    }

    fn ran(&mut self, kind: IoKind) {
        self.node.set_mode(kind, IoMode::Run);
        self.node.received.insert::<A>(kind);
    }

    /// A message was consumed: the watchdog runs anew.
    fn alive(&mut self, kind: IoKind) {
        count_wide::<A>(&mut self.node.events.counters.consumed);
        self.node.io_message(kind);
    }

    fn not_established(&mut self, id: Identifier, kind: IoKind) {
        self.node.io_message(kind);
        self.node.ignored(id, Ignored::NoConnection);
    }

    /// The command is to be answered, unless it is not acknowledged.
    fn answer(&mut self, kind: IoKind) {
        if changes::<A>() && self.node.io(kind).kind() == PredefinedConnection::ConsumeOnly {
            return;
        }
        if !self.node.lines.want(kind) {
            count::<A>(&mut self.node.events.counters.merged);
        }
    }

    /// The next frame of an I/O connection.
    pub(super) fn produce(&mut self, kind: IoKind, id: Identifier) -> Option<Frame> {
        if let Some(field) = self.long.field(kind) {
            return id.frame(&field);
        }
        if changes::<A>() && kind == IoKind::Poll && !self.node.held.contains(AllocationChoice::POLL) {
            // It only acknowledges messages of the master.
            return id.frame(&[]);
        }
        let data = self.node.application.produced(kind);
        if A::Long::CAPACITY <= IO_UNFRAGMENTED_LEN
            || usize::from(self.node.application.produced_size(kind)) <= IO_UNFRAGMENTED_LEN
        {
            // What has no room goes out empty, as in fragments: there are no valid data.
            let data = if data.len() > IO_UNFRAGMENTED_LEN { &[] } else { data };
            return id.frame(data);
        }
        let empty = if self.node.options.contains(Options::EMPTY_AS_3F) {
            EmptyMessage::FirstAndOnly
        } else {
            EmptyMessage::NoData
        };
        self.long.load(kind, data, empty);
        id.frame(&self.long.field(kind)?)
    }

    /// A frame of an I/O connection is with the controller no longer.
    pub(super) fn produced(&mut self, kind: IoKind, sent: bool) {
        // The rest of a message whose beginning is lost is of no use.
        if sent && self.long.advance(kind) {
            return self.node.lines.go_on(kind);
        }
        self.long.unload(kind);
        if sent {
            count_wide::<A>(&mut self.node.events.counters.produced);
        }
        if changes::<A>() && kind == IoKind::ChangeOfState {
            self.change_of_state_sent();
        }
    }

    /// Puts outputs to rest, and tells of every mode that has changed.
    pub(super) fn follow_modes(&mut self) {
        IoKind::each::<A>(|kind| {
            let bit = super::node::mode_bit(kind);
            if !self.node.changed.contains(bit) {
                return;
            }
            let mode = self.node.mode(kind);
            match mode {
                IoMode::Idle | IoMode::Fault => self.node.application.rest(kind, mode),
                IoMode::Inactive | IoMode::Run => {}
            }
            if mode == IoMode::Fault || self.node.io(kind).state() != IoState::Established {
                self.long.discard(kind);
            }
            if self.node.io(kind).state() != IoState::Established {
                self.long.unload(kind);
            }
            self.node.events.raise::<A>(SlaveEvent::Mode(kind, mode));
        });
    }
}

/// The bit of a node in a bit-strobe command: bit n % 8 of byte n / 8.
fn bit_of(field: &[u8], node: MacId) -> bool {
    let number = node.number();
    field.get(usize::from(number / 8)).is_some_and(|byte| byte & (1 << (number % 8)) != 0)
}

/// The data, as far as both are long.
fn copy(to: &mut [u8], from: &[u8]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
}
