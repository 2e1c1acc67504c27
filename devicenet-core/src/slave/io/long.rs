//! Memory for I/O messages that do not fit into a frame.

use core::fmt::Debug;
use core::hash::Hash;

use cip_core::fragment::{EmptyMessage, IO_UNFRAGMENTED_LEN, IoOutcome, IoReassembly, IoTransmit};
use heapless::Vec;

use super::slots::{EverySlot, PollSlot, Slots};
use crate::slave::IoKind;

/// The memory for I/O: [`PollOnly`], `()` or [`Fragmented`].
pub trait LongMessages: Clone + Eq + Hash + Debug + Default {
    /// The longest message.
    const CAPACITY: usize;

    /// The connections that there is room for.
    type Slots: Slots;

    /// Takes the data field of a frame; `None` if the connection has no memory for it.
    fn receive(&mut self, _connection: IoKind, _field: &[u8]) -> Option<IoOutcome<'_>> {
        None
    }

    /// Drops what arrived of a message.
    fn discard(&mut self, _connection: IoKind) {}

    /// Begins to send a message.
    fn load(&mut self, _connection: IoKind, _message: &[u8], _empty: EmptyMessage) {}

    /// The data field of the present frame; `None` if there is none.
    fn field(&self, _connection: IoKind) -> Option<Vec<u8, 8>> {
        None
    }

    /// The present frame was sent; true if another follows.
    fn advance(&mut self, _connection: IoKind) -> bool {
        false
    }

    /// What is being sent is given up.
    fn unload(&mut self, _connection: IoKind) {}
}

/// No message is longer than a frame.
impl LongMessages for () {
    const CAPACITY: usize = IO_UNFRAGMENTED_LEN;
    type Slots = EverySlot;
}

/// The same, for a device whose only I/O connection is poll: it needs less memory for connections and their time-outs.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct PollOnly;

impl LongMessages for PollOnly {
    const CAPACITY: usize = IO_UNFRAGMENTED_LEN;
    type Slots = PollSlot;
}

/// Messages of up to `N` bytes, at most 448, on all connections but bit-strobe.
///
/// It takes about `5 * N` bytes: two connections consume, three produce.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Fragmented<const N: usize> {
    poll: IoTransmit<N>,
    change_of_state: IoTransmit<N>,
    multicast: IoTransmit<N>,
    poll_command: IoReassembly<N>,
    multicast_command: IoReassembly<N>,
}

impl<const N: usize> Default for Fragmented<N> {
    fn default() -> Self {
        Self {
            poll: IoTransmit::new(),
            change_of_state: IoTransmit::new(),
            multicast: IoTransmit::new(),
            poll_command: IoReassembly::new(N),
            multicast_command: IoReassembly::new(N),
        }
    }
}

impl<const N: usize> Fragmented<N> {
    const fn outgoing(&self, connection: IoKind) -> Option<&IoTransmit<N>> {
        match connection {
            IoKind::Poll => Some(&self.poll),
            IoKind::ChangeOfState => Some(&self.change_of_state),
            IoKind::MulticastPoll => Some(&self.multicast),
            IoKind::BitStrobe => None,
        }
    }

    const fn outgoing_mut(&mut self, connection: IoKind) -> Option<&mut IoTransmit<N>> {
        match connection {
            IoKind::Poll => Some(&mut self.poll),
            IoKind::ChangeOfState => Some(&mut self.change_of_state),
            IoKind::MulticastPoll => Some(&mut self.multicast),
            IoKind::BitStrobe => None,
        }
    }

    const fn incoming(&mut self, connection: IoKind) -> Option<&mut IoReassembly<N>> {
        match connection {
            IoKind::Poll => Some(&mut self.poll_command),
            IoKind::MulticastPoll => Some(&mut self.multicast_command),
            IoKind::BitStrobe | IoKind::ChangeOfState => None,
        }
    }
}

impl<const N: usize> LongMessages for Fragmented<N> {
    const CAPACITY: usize = if N > IO_UNFRAGMENTED_LEN { N } else { IO_UNFRAGMENTED_LEN };
    type Slots = EverySlot;

    fn receive(&mut self, connection: IoKind, field: &[u8]) -> Option<IoOutcome<'_>> {
        Some(self.incoming(connection)?.frame(field))
    }

    fn discard(&mut self, connection: IoKind) {
        if let Some(incoming) = self.incoming(connection) {
            incoming.discard();
        }
    }

    fn load(&mut self, connection: IoKind, message: &[u8], empty: EmptyMessage) {
        if let Some(outgoing) = self.outgoing_mut(connection) {
            // The sizes were checked when the slave was made.
            outgoing.load(message, empty);
        }
    }

    fn field(&self, connection: IoKind) -> Option<Vec<u8, 8>> {
        self.outgoing(connection)?.field()
    }

    fn advance(&mut self, connection: IoKind) -> bool {
        self.outgoing_mut(connection).is_some_and(IoTransmit::advance)
    }

    fn unload(&mut self, connection: IoKind) {
        if let Some(outgoing) = self.outgoing_mut(connection) {
            outgoing.unload();
        }
    }
}
