//! Sending of I/O messages that take more than a frame.

use heapless::Vec;

use super::{EmptyMessage, IoFragments};

/// An I/O message of up to `N` bytes on its way. It is a copy: the data of the application may change before its last
/// fragment is sent.
///
/// ```
/// use cip_core::fragment::{EmptyMessage, IoTransmit};
///
/// let mut message = IoTransmit::<16>::new();
/// message.load(&[1, 2, 3, 4, 5, 6, 7, 8], EmptyMessage::NoData);
/// assert_eq!(message.field().unwrap(), [0x00, 1, 2, 3, 4, 5, 6, 7]);
/// assert!(message.advance());
/// assert_eq!(message.field().unwrap(), [0x81, 8]);
/// assert!(!message.advance());
/// assert_eq!(message.field(), None);
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct IoTransmit<const N: usize> {
    message: Vec<u8, N>,
    empty: EmptyMessage,
    /// The frame to send, counted from 0; `None` if nothing is being sent.
    index: Option<u8>,
}

impl<const N: usize> IoTransmit<N> {
    /// Nothing is being sent.
    pub const fn new() -> Self {
        Self { message: Vec::new(), empty: EmptyMessage::NoData, index: None }
    }

    /// Begins with a message. One that has no room goes out empty, which says that there are no valid data.
    pub fn load(&mut self, message: &[u8], empty: EmptyMessage) {
        self.message.clear();
        // A length without room leaves it empty.
        let _ = self.message.extend_from_slice(message);
        (self.empty, self.index) = (empty, Some(0));
    }

    /// The data field of the present frame; `None` if there is none.
    pub fn field(&self) -> Option<Vec<u8, 8>> {
        IoFragments::new(self.message.as_slice(), self.empty)?.nth(self.index?.into())
    }

    /// The present frame was sent; true if another follows.
    pub fn advance(&mut self) -> bool {
        self.index = self.index.map(|index| index.saturating_add(1));
        let more = self.field().is_some();
        if !more {
            self.unload();
        }
        more
    }

    /// What is being sent is given up.
    pub fn unload(&mut self) {
        self.message.clear();
        self.index = None;
    }
}
