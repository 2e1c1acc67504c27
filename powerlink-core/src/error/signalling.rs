//! Error signalling: how errors get from a controlled node to the managing node.
//!
//! ```text
//! managing node                          controlled node
//! StatusRequest ER=1  ---------------->  EC=1, the queue is cleared
//! StatusRequest ER=0  ---------------->  EC=0: the signalling runs
//!                     <----------------  an error: into the StatusResponse, EN toggles
//! StatusRequest       ---------------->
//!                     <----------------  StatusResponse with the error
//! EA = EN             ---------------->  the next errors may be told
//! ```

use link_core::Queue;

use crate::wire::{ErrorEntry, Flags, MAX_ENTRIES, MIN_ENTRIES};

/// The node's side of the signalling: EC, EN, and what waits to be told.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Signalling {
    /// EC
    is_cleared: bool,
    /// EN
    is_new: bool,
    /// The last ER.
    reset: bool,
    /// The last EA.
    acknowledged: bool,
    queue: Queue<ErrorEntry, EMERGENCY_QUEUE>,
    /// What the StatusResponse tells.
    told: heapless::Vec<ErrorEntry, MAX_ENTRIES>,
    /// How many it may tell at once.
    capacity: usize,
}

impl Signalling {
    /// After power-on and resets of the whole node: EC is set, nothing is told.
    ///
    /// A StatusResponse tells `capacity` errors at once, at least [`MIN_ENTRIES`] and at most [`MAX_ENTRIES`].
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        Self {
            is_cleared: true,
            is_new: false,
            reset: false,
            acknowledged: false,
            queue: Queue::new(),
            told: heapless::Vec::new(),
            capacity: capacity.clamp(MIN_ENTRIES, MAX_ENTRIES),
        }
    }

    /// EC and EN, for a StatusResponse.
    #[must_use]
    pub fn flags(&self) -> Flags {
        let mut flags = self.exception_new();
        flags.set(Flags::EXCEPTION_CLEAR, self.is_cleared);
        flags
    }

    /// EN, for a PRes.
    #[must_use]
    pub fn exception_new(&self) -> Flags {
        if self.is_new { Flags::EXCEPTION_NEW } else { Flags::empty() }
    }

    /// The entries of the StatusResponse.
    #[must_use]
    pub fn entries(&self) -> &[ErrorEntry] {
        &self.told
    }

    /// Whether the handshake is done, and errors are told.
    #[must_use]
    pub const fn is_running(&self) -> bool {
        !self.is_cleared
    }

    /// ER of a StatusRequest for this node. Only its change counts.
    pub fn exception_reset(&mut self, reset: bool) {
        if core::mem::replace(&mut self.reset, reset) == reset {
            return;
        }
        if reset {
            self.queue.clear();
            self.told.clear();
        }
        self.is_cleared = reset;
        self.is_new = false;
    }

    /// EA of a PReq or SoA for this node.
    #[inline]
    pub fn exception_acknowledge(&mut self, acknowledged: bool) {
        self.acknowledged = acknowledged;
        if !self.told.is_empty() || !self.queue.is_empty() {
            self.tell_next();
        }
    }

    /// What was told may have been acknowledged.
    #[cold]
    fn tell_next(&mut self) {
        if self.is_acknowledged() {
            self.told.clear();
            self.tell();
        }
    }

    /// An error to be told. False if the queue is full and it is lost.
    pub fn report(&mut self, entry: ErrorEntry) -> bool {
        let is_kept = self.queue.push(entry).is_ok();
        self.tell();
        is_kept
    }

    const fn is_acknowledged(&self) -> bool {
        self.is_running() && self.acknowledged == self.is_new
    }

    fn tell(&mut self) {
        if !self.is_acknowledged() || self.queue.is_empty() {
            return;
        }
        self.told.clear();
        while self.told.len() < self.capacity
            && let Some(entry) = self.queue.pop()
        {
            // There is room: the capacity is at most that of the list.
            let _ = self.told.push(entry);
        }
        self.is_new = !self.is_new;
    }
}

/// The errors that wait while the managing node has not read the last ones: as many as a StatusResponse can tell.
const EMERGENCY_QUEUE: usize = MAX_ENTRIES;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::{EntryType, ErrorCode};

    fn error(code: u16) -> ErrorEntry {
        ErrorEntry { kind: EntryType::POWERLINK_EVENT, code: ErrorCode(code), ..ErrorEntry::default() }
    }

    fn running() -> Signalling {
        let mut signalling = Signalling::new(2);
        signalling.exception_reset(true);
        signalling.exception_reset(false);
        signalling
    }

    /// The handshake as openPOWERLINK's managing node does it: ER=1, then ER=0.
    #[test]
    fn the_handshake_clears_ec() {
        let mut signalling = Signalling::new(2);
        assert_eq!(signalling.flags(), Flags::EXCEPTION_CLEAR);
        signalling.exception_reset(false);
        assert_eq!(signalling.flags(), Flags::EXCEPTION_CLEAR, "without a change nothing changes");
        signalling.exception_reset(true);
        assert_eq!(signalling.flags(), Flags::EXCEPTION_CLEAR);
        signalling.exception_reset(false);
        assert_eq!(signalling.flags(), Flags::empty());
        signalling.exception_reset(true);
        assert_eq!(signalling.flags(), Flags::EXCEPTION_CLEAR, "the managing node starts over");
    }

    #[test]
    fn nothing_is_told_before_the_handshake() {
        let mut signalling = Signalling::new(2);
        signalling.report(error(1));
        signalling.exception_acknowledge(false);
        assert_eq!((signalling.flags(), signalling.entries()), (Flags::EXCEPTION_CLEAR, &[][..]));
    }

    #[test]
    fn what_was_told_stays_until_it_is_acknowledged() {
        let mut signalling = running();
        signalling.report(error(1));
        assert_eq!(signalling.flags(), Flags::EXCEPTION_NEW);
        for code in 2..=4 {
            signalling.report(error(code));
            signalling.exception_acknowledge(false);
            assert_eq!((signalling.flags(), signalling.entries()), (Flags::EXCEPTION_NEW, &[error(1)][..]));
        }
        signalling.exception_acknowledge(true);
        assert_eq!((signalling.flags(), signalling.entries()), (Flags::empty(), &[error(2), error(3)][..]));
        signalling.exception_acknowledge(false);
        assert_eq!((signalling.flags(), signalling.entries()), (Flags::EXCEPTION_NEW, &[error(4)][..]));
        signalling.exception_acknowledge(true);
        assert_eq!(
            (signalling.flags(), signalling.entries()),
            (Flags::EXCEPTION_NEW, &[][..]),
            "all is told"
        );
    }

    #[test]
    fn a_full_queue_says_so() {
        let mut signalling = Signalling::new(2);
        let kept = (0..20).filter(|&code| signalling.report(error(code))).count();
        assert_eq!(kept, EMERGENCY_QUEUE);
    }
}
