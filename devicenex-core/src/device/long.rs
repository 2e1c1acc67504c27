//! Memory for implicit messages that do not fit into a frame.

use core::fmt::Debug;
use core::hash::Hash;

use cip_core::fragment::{EmptyMessage, IO_UNFRAGMENTED_LEN, IoOutcome, IoReassembly, IoTransmit};
use heapless::Vec;

/// The memory of one connection for long messages: `()` or [`Fragmented`].
pub trait LongMessages: Clone + Eq + Hash + Debug + Default {
    /// The longest message.
    const CAPACITY: usize;

    /// Takes the data field of a frame; `None` if there is no memory for it.
    fn receive(&mut self, _field: &[u8]) -> Option<IoOutcome<'_>> {
        None
    }

    /// Drops what arrived of a message.
    fn discard(&mut self) {}

    /// Begins to send a message.
    fn load(&mut self, _message: &[u8]) {}

    /// The data field of the present frame; `None` if there is none.
    fn field(&self) -> Option<Vec<u8, 8>> {
        None
    }

    /// The present frame was sent; true if another follows.
    fn advance(&mut self) -> bool {
        false
    }

    /// What is being sent is given up.
    fn unload(&mut self) {}
}

/// No message is longer than a frame.
impl LongMessages for () {
    const CAPACITY: usize = IO_UNFRAGMENTED_LEN;
}

/// Messages of up to `N` bytes, at most 448, in both directions. It takes about `2 * N` bytes for each connection.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Fragmented<const N: usize> {
    outgoing: IoTransmit<N>,
    incoming: IoReassembly<N>,
}

impl<const N: usize> Default for Fragmented<N> {
    fn default() -> Self {
        Self { outgoing: IoTransmit::new(), incoming: IoReassembly::new(N) }
    }
}

impl<const N: usize> LongMessages for Fragmented<N> {
    const CAPACITY: usize = if N > IO_UNFRAGMENTED_LEN { N } else { IO_UNFRAGMENTED_LEN };

    fn receive(&mut self, field: &[u8]) -> Option<IoOutcome<'_>> {
        Some(self.incoming.frame(field))
    }

    fn discard(&mut self) {
        self.incoming.discard();
    }

    fn load(&mut self, message: &[u8]) {
        self.outgoing.load(message, EmptyMessage::NoData);
    }

    fn field(&self) -> Option<Vec<u8, 8>> {
        self.outgoing.field()
    }

    fn advance(&mut self) -> bool {
        self.outgoing.advance()
    }

    fn unload(&mut self) {
        self.outgoing.unload();
    }
}
