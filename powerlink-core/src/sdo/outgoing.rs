//! A response on its way to the client, in as many frames as it needs.

use core::ops::Range;

use crate::wire::{SdoCommand, SdoCommandId, Segmentation, TOTAL_SIZE};

/// A response whose data are in the buffer of its connection. Each frame follows from its place alone, so that frames are sent
/// again without a copy of them.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Outgoing {
    pub(super) transaction: u8,
    pub(super) command: SdoCommandId,
    pub(super) is_abort: bool,
    /// All data.
    len: usize,
    /// The most data of a frame.
    segment: usize,
    /// The sequence number of the first frame.
    first: u8,
    /// The frames that were acknowledged.
    acknowledged: usize,
    /// The frame that is sent next.
    next: usize,
    /// The frames that were sent at least once.
    sent: usize,
    /// The next frame is sent once more, and is to be acknowledged.
    is_repeated: bool,
}

impl Outgoing {
    /// A response of `len` bytes, at most `segment` in a frame, whose first frame has the number `first`.
    pub(super) const fn new(
        command: &SdoCommand<'_>,
        is_abort: bool,
        len: usize,
        segment: usize,
        first: u8,
    ) -> Self {
        Self {
            transaction: command.transaction,
            command: command.command,
            is_abort,
            len,
            segment,
            first,
            acknowledged: 0,
            next: 0,
            sent: 0,
            is_repeated: false,
        }
    }

    /// How many frames it has.
    pub(super) fn frames(&self) -> usize {
        if self.len <= self.segment {
            return 1;
        }
        let rest = self.len.saturating_sub(self.first_part());
        rest.div_ceil(self.segment.max(1)).saturating_add(1)
    }

    /// How many frames can be sent now.
    pub(super) fn ready(&self) -> usize {
        let window = self.acknowledged.saturating_add(WINDOW).min(self.frames());
        window.saturating_sub(self.next)
    }

    /// Whether a frame was never sent.
    pub(super) fn is_unsent(&self) -> bool {
        self.sent < self.frames()
    }

    /// Whether a frame was sent that the client has not acknowledged.
    pub(super) const fn is_unacknowledged(&self) -> bool {
        self.next > self.acknowledged
    }

    /// The number of the frame that is to be acknowledged next, if all that can be sent before is sent.
    pub(super) fn awaited(&self) -> Option<u8> {
        let place = u8::try_from(self.acknowledged & usize::from(NUMBER)).unwrap_or(0);
        let number = self.first.wrapping_add(place) & NUMBER;
        (self.is_unacknowledged() && self.ready() == 0).then_some(number)
    }

    /// Whether everything arrived.
    pub(super) fn is_done(&self) -> bool {
        self.acknowledged >= self.frames()
    }

    /// The client has everything up to a sequence number. Returns whether that is news.
    pub(super) fn acknowledge(&mut self, number: u8) -> bool {
        let count = usize::from(number.wrapping_add(1).wrapping_sub(self.first) & NUMBER);
        // A number of frames that were not sent, or from before this response, acknowledges nothing.
        let (window, acknowledged) = (usize::from(NUMBER).saturating_add(1), self.acknowledged);
        let turns = acknowledged.saturating_sub(count).div_ceil(window);
        let count = count.saturating_add(turns.saturating_mul(window));
        if count <= acknowledged || count > self.sent {
            return false;
        }
        self.acknowledged = count;
        // Of what is to be sent again, this part has arrived after all.
        self.next = self.next.max(count);
        true
    }

    /// Sends everything again that was not acknowledged.
    pub(super) const fn repeat(&mut self, is_timeout: bool) {
        self.next = self.acknowledged;
        self.is_repeated = is_timeout;
    }

    /// The next frame: its sequence number, whether it is to be acknowledged at once, its segmentation and its data.
    pub(super) fn take(&mut self) -> (u8, bool, Segmentation, Range<usize>) {
        let (place, frames) = (self.next, self.frames());
        let segmentation = match place {
            _ if frames == 1 => Segmentation::Expedited,
            0 => Segmentation::Initiate { total: u32::try_from(self.len).unwrap_or(u32::MAX) },
            _ if place.saturating_add(1) == frames => Segmentation::Complete,
            _ => Segmentation::Segment,
        };
        let data = if frames == 1 { 0..self.len } else { self.part(place) };
        self.next = place.saturating_add(1);
        self.sent = self.next.max(self.sent);
        let is_last_of_window = self.next.saturating_sub(self.acknowledged) >= WINDOW && self.next < frames;
        let wants_acknowledge = is_last_of_window || core::mem::take(&mut self.is_repeated);
        let place = u8::try_from(place & usize::from(NUMBER)).unwrap_or(0);
        (self.first.wrapping_add(place) & NUMBER, wants_acknowledge, segmentation, data)
    }

    fn part(&self, place: usize) -> Range<usize> {
        let Some(after_first) = place.checked_sub(1) else { return 0..self.first_part() };
        let start = self.first_part().saturating_add(after_first.saturating_mul(self.segment));
        start..start.saturating_add(self.segment).min(self.len)
    }

    /// The first frame of several has the size of all data as well.
    const fn first_part(&self) -> usize {
        self.segment.saturating_sub(TOTAL_SIZE)
    }
}

/// Frames under way without an acknowledge.
const WINDOW: usize = 4;
const NUMBER: u8 = 0x3F;
