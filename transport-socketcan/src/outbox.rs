//! Frames on their way out, by urgency, and what became of them.

use std::collections::VecDeque;

use link_core::{Frame, TxOutcome, TxToken};

/// The frames that a machine has in flight: one with the kernel at most, the others in the order of arbitration.
#[derive(Debug, Default)]
pub(crate) struct Outbox {
    /// The most urgent last; of equals, the oldest.
    waiting: Vec<Pending>,
    handed_over: Option<Pending>,
    answers: VecDeque<(TxToken, TxOutcome)>,
}

#[derive(Clone, Copy, Debug)]
struct Pending {
    token: TxToken,
    frame: Frame,
}

impl Outbox {
    pub(crate) fn put(&mut self, token: TxToken, frame: Frame) {
        let key = frame.arbitration_key();
        // Behind those of equal urgency, so that frames of one identifier keep their order.
        let place = self.waiting.partition_point(|other| other.frame.arbitration_key() > key);
        self.waiting.insert(place, Pending { token, frame });
    }

    /// The frame that the kernel is to get next: none while it has one.
    pub(crate) fn next(&self) -> Option<&Frame> {
        if self.handed_over.is_some() { None } else { self.waiting.last().map(|pending| &pending.frame) }
    }

    /// The kernel has taken that frame.
    pub(crate) fn hand_over(&mut self) {
        self.handed_over = self.waiting.pop();
    }

    /// The kernel has taken that frame, and that is all that it will tell.
    pub(crate) fn sent(&mut self) {
        if let Some(pending) = self.waiting.pop() {
            self.answers.push_back((pending.token, TxOutcome::Sent));
        }
    }

    /// That frame can never be sent.
    pub(crate) fn refuse(&mut self) {
        if let Some(pending) = self.waiting.pop() {
            self.answers.push_back((pending.token, TxOutcome::Dropped));
        }
    }

    /// The kernel has marked a frame as sent by this socket. `false` if it is not the one that it was given.
    pub(crate) fn confirm(&mut self, frame: &Frame) -> bool {
        match self.handed_over.take_if(|pending| pending.frame == *frame) {
            Some(pending) => {
                self.answers.push_back((pending.token, TxOutcome::Sent));
                true
            }
            None => false,
        }
    }

    /// The frame that the kernel has.
    pub(crate) fn with_kernel(&self) -> Option<&Frame> {
        self.handed_over.as_ref().map(|pending| &pending.frame)
    }

    /// Takes a frame back, if the kernel has it not yet.
    pub(crate) fn withdraw(&mut self, token: TxToken) {
        if let Some(place) = self.waiting.iter().position(|pending| pending.token == token) {
            self.waiting.remove(place);
            self.answers.push_back((token, TxOutcome::Withdrawn));
        }
    }

    /// Nothing of it will be sent: the controller is off the bus, or begins anew.
    pub(crate) fn drop_all(&mut self) {
        let dropped = self.handed_over.take().into_iter().chain(self.waiting.drain(..).rev());
        self.answers.extend(dropped.map(|pending| (pending.token, TxOutcome::Dropped)));
    }

    /// What became of the frame with the kernel will not be told.
    pub(crate) fn give_up(&mut self) {
        if let Some(pending) = self.handed_over.take() {
            self.answers.push_back((pending.token, TxOutcome::Unknown));
        }
    }

    pub(crate) fn answer(&mut self) -> Option<(TxToken, TxOutcome)> {
        self.answers.pop_front()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use link_core::StandardId;

    fn frame(id: u16, data: u8) -> Frame {
        Frame::new(StandardId::new(id).unwrap(), &[data]).unwrap()
    }

    fn outbox(frames: &[(u16, u16)]) -> Outbox {
        let mut outbox = Outbox::default();
        for &(token, id) in frames {
            outbox.put(TxToken(token), frame(id, token.to_le_bytes()[0]));
        }
        outbox
    }

    fn sent(outbox: &mut Outbox) -> Vec<(TxToken, TxOutcome)> {
        while let Some(&next) = outbox.next() {
            outbox.hand_over();
            assert!(outbox.confirm(&next));
        }
        std::iter::from_fn(|| outbox.answer()).collect()
    }

    #[test]
    fn the_most_urgent_goes_first_and_equals_keep_their_order() {
        let mut outbox = outbox(&[(1, 0x400), (2, 0x100), (3, 0x400), (4, 0x100)]);
        let order: Vec<u16> = sent(&mut outbox).iter().map(|(token, _)| token.0).collect();
        assert_eq!(order, [2, 4, 1, 3]);
    }

    #[test]
    fn the_kernel_has_one_frame_at_a_time() {
        let mut outbox = outbox(&[(1, 0x400), (2, 0x100)]);
        outbox.hand_over();
        assert_eq!(outbox.next(), None);
        assert!(!outbox.confirm(&frame(0x100, 9)), "not the frame that it was given");
        assert!(outbox.confirm(&frame(0x100, 2)));
        assert_eq!(outbox.next(), Some(&frame(0x400, 1)));
    }

    #[test]
    fn what_the_kernel_has_cannot_be_taken_back() {
        let mut outbox = outbox(&[(1, 0x100), (2, 0x400)]);
        outbox.hand_over();
        outbox.withdraw(TxToken(1));
        outbox.withdraw(TxToken(2));
        assert_eq!(outbox.answer(), Some((TxToken(2), TxOutcome::Withdrawn)));
        assert_eq!(outbox.answer(), None, "the answer of the first comes when it is known");
        assert!(outbox.confirm(&frame(0x100, 1)));
        assert_eq!(outbox.answer(), Some((TxToken(1), TxOutcome::Sent)));
    }

    #[test]
    fn what_is_given_up_is_answered_and_makes_room() {
        let mut outbox = outbox(&[(1, 0x100), (2, 0x400)]);
        outbox.hand_over();
        outbox.give_up();
        assert_eq!(outbox.answer(), Some((TxToken(1), TxOutcome::Unknown)));
        assert!(!outbox.confirm(&frame(0x100, 1)), "a late echo answers nothing");
        assert_eq!(outbox.next(), Some(&frame(0x400, 2)));
    }

    #[test]
    fn everything_dropped_is_answered_once() {
        let mut outbox = outbox(&[(1, 0x100), (2, 0x400), (3, 0x200)]);
        outbox.hand_over();
        outbox.drop_all();
        let answers: Vec<_> = std::iter::from_fn(|| outbox.answer()).collect();
        assert_eq!(answers, [1, 3, 2].map(|token| (TxToken(token), TxOutcome::Dropped)));
        assert!(!outbox.confirm(&frame(0x100, 1)), "a late echo answers nothing");
    }
}
