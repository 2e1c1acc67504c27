//! What holds for every message: cut and put together it is the same, and damage never yields another one.

use super::*;
use proptest::{collection::vec, prelude::*};
use std::vec::Vec;

const EXPLICIT_MAX: usize = 4096;

fn fields(message: &[u8]) -> Vec<Vec<u8>> {
    IoFragments::new(message, EmptyMessage::NoData).unwrap().map(|field| field.to_vec()).collect()
}

/// Every message that the frames deliver.
fn delivered<'a>(frames: impl IntoIterator<Item = &'a Vec<u8>>) -> Vec<Vec<u8>> {
    let mut machine = IoReassembly::<IO_MESSAGE_MAX>::new(IO_MESSAGE_MAX);
    let mut messages = Vec::new();
    for frame in frames {
        if let IoOutcome::Complete(message) = machine.frame(frame) {
            messages.push(message.to_vec());
        }
    }
    messages
}

#[test]
fn every_length_of_an_explicit_body_survives() {
    let body: Vec<u8> = (0..EXPLICIT_MAX).map(|index| u8::try_from(index % 251).unwrap()).collect();
    for len in EXPLICIT_UNFRAGMENTED_LEN..=EXPLICIT_MAX {
        let body = &body[..len];
        let mut machine = ExplicitReassembly::<EXPLICIT_MAX>::new(len);
        let last = body.len().div_ceil(EXPLICIT_FRAGMENT_LEN) - 1;
        for (index, fragment) in ExplicitFragments::new(body).enumerate() {
            let outcome = machine.fragment(true, fragment.byte, fragment.data);
            assert_eq!(outcome.ack(), Some(AckStatus::Success));
            let expected =
                if index == last { ExplicitOutcome::Complete(body) } else { ExplicitOutcome::Stored };
            assert_eq!(outcome, expected, "fragment {index} of {len} bytes");
        }
        assert!(!machine.is_receiving());
    }
}

proptest! {
    #[test]
    fn the_fragmentation_byte_is_total(byte: u8) {
        prop_assert_eq!(u8::from(FragmentByte::from(byte)), byte);
        prop_assert_eq!(u8::from(AckStatus::from(byte)), byte);
    }

    #[test]
    fn an_io_message_survives(message in vec(any::<u8>(), 0..=IO_MESSAGE_MAX)) {
        prop_assert_eq!(delivered(&fields(&message)), [message]);
    }

    /// Repetitions of any explicit fragment, as after a lost acknowledge, change nothing.
    #[test]
    fn repeated_explicit_fragments_change_nothing(
        body in vec(any::<u8>(), 8..=600),
        repeats in vec(1..=2_usize, 100),
    ) {
        let mut machine = ExplicitReassembly::<600>::new(600);
        let mut completed = Vec::new();
        for (fragment, &times) in ExplicitFragments::new(&body).zip(&repeats) {
            for _ in 0..times {
                let outcome = machine.fragment(false, fragment.byte, fragment.data);
                prop_assert_eq!(outcome.ack(), Some(AckStatus::Success));
                if let ExplicitOutcome::Complete(message) = outcome {
                    completed.push(message.to_vec());
                }
            }
        }
        prop_assert_eq!(completed, [body]);
    }

    #[test]
    fn a_lost_io_fragment_never_yields_another_message(
        messages in vec(vec(any::<u8>(), 1..100), 2..4),
        lost: prop::sample::Index,
    ) {
        let mut frames: Vec<_> = messages.iter().flat_map(|message| fields(message)).collect();
        frames.remove(lost.index(frames.len()));
        for message in delivered(&frames) {
            prop_assert!(messages.contains(&message));
        }
    }

    #[test]
    fn a_repeated_io_fragment_never_yields_another_message(
        messages in vec(vec(any::<u8>(), 1..100), 2..4),
        repeated: prop::sample::Index,
    ) {
        let mut frames: Vec<_> = messages.iter().flat_map(|message| fields(message)).collect();
        let at = repeated.index(frames.len());
        frames.insert(at, frames[at].clone());
        for message in delivered(&frames) {
            prop_assert!(messages.contains(&message));
        }
    }

    /// Within one message: frames with one identifier never change places across messages on a CAN bus.
    #[test]
    fn reordered_io_fragments_never_yield_another_message(
        message in vec(any::<u8>(), 8..100),
        from: prop::sample::Index,
        to: prop::sample::Index,
    ) {
        let mut frames = fields(&message);
        let len = frames.len();
        let frame = frames.remove(from.index(len));
        frames.insert(to.index(len), frame);
        for delivered in delivered(&frames) {
            prop_assert_eq!(&delivered, &message);
        }
    }

    /// Any bytes at all: no panic, nothing longer than the limit, nothing delivered that did not arrive.
    #[test]
    fn noise_is_harmless(frames in vec(vec(any::<u8>(), 0..=8), 0..40)) {
        let mut explicit = ExplicitReassembly::<32>::new(20);
        for frame in &frames {
            if let [byte, data @ ..] = frame.as_slice()
                && let ExplicitOutcome::Complete(message) = explicit.fragment(false, (*byte).into(), data)
            {
                prop_assert!(message.len() <= 20);
            }
        }
        let arrived: usize = frames.iter().map(Vec::len).sum();
        prop_assert!(delivered(&frames).iter().map(Vec::len).sum::<usize>() <= arrived);
    }
}
