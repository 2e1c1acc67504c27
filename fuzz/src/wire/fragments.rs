//! Fragmentation: any frames through a receiver, and any message through a sender and a receiver.

use cip_core::fragment::{
    EXPLICIT_UNFRAGMENTED_LEN, EmptyMessage, ExplicitFragments, ExplicitOutcome, ExplicitReassembly,
    FragmentByte, IO_MESSAGE_MAX, IoFragments, IoOutcome, IoReassembly, is_fragmented_explicit,
};

/// Takes `data` as a message that is cut, and as a row of frames that arrive.
pub(super) fn check(data: &[u8]) {
    survives_as_explicit(data);
    survives_as_io(data);
    arrives_as_explicit(data);
    arrives_as_io(data);
}

fn survives_as_explicit(message: &[u8]) {
    assert_eq!(is_fragmented_explicit(message), message.len() > EXPLICIT_UNFRAGMENTED_LEN);
    let mut machine = ExplicitReassembly::<LONGEST>::new(LONGEST);
    let mut complete = None;
    for fragment in ExplicitFragments::new(message) {
        assert_eq!(FragmentByte::from(u8::from(fragment.byte)), fragment.byte);
        assert!(complete.is_none(), "a fragment follows the last");
        if let ExplicitOutcome::Complete(body) = machine.fragment(true, fragment.byte, fragment.data) {
            complete = Some(body.to_vec());
        }
    }
    if is_fragmented_explicit(message) && message.len() <= LONGEST {
        assert_eq!(complete.as_deref(), Some(message));
    }
}

fn survives_as_io(message: &[u8]) {
    for empty in [EmptyMessage::NoData, EmptyMessage::FirstAndOnly] {
        let Some(fields) = IoFragments::new(message, empty) else {
            assert!(message.len() > IO_MESSAGE_MAX);
            return;
        };
        let mut machine = IoReassembly::<IO_MESSAGE_MAX>::new(IO_MESSAGE_MAX);
        let mut complete = Vec::new();
        for field in fields {
            if let IoOutcome::Complete(body) = machine.frame(&field) {
                complete.push(body.to_vec());
            }
        }
        assert_eq!(complete, [message]);
    }
}

/// Frames that arrive: a length of 0 to 7, then as many bytes.
fn fields(data: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = data;
    core::iter::from_fn(move || {
        let (&len, after) = rest.split_first()?;
        let (field, after) = after.split_at(usize::from(len & 7).min(after.len()));
        rest = after;
        Some(field)
    })
}

/// What is complete is the fragments taken since the first one, in their order, and not longer than the limit.
fn arrives_as_explicit(data: &[u8]) {
    let mut machine = ExplicitReassembly::<32>::new(LIMIT);
    let mut taken: Vec<u8> = Vec::new();
    for field in fields(data) {
        let [byte, piece @ ..] = field else { continue };
        let (byte, before) = (FragmentByte::from(*byte), machine.received());
        let receiving = machine.is_receiving();
        match machine.fragment(false, byte, piece) {
            ExplicitOutcome::Stored => {
                if byte == FragmentByte::FIRST {
                    taken.clear();
                }
                taken.extend(piece);
                assert_eq!(machine.received(), taken.len());
            }
            ExplicitOutcome::Complete(body) => {
                taken.extend(piece);
                assert_eq!(body, taken);
                assert!(receiving && body.len() <= LIMIT && body.len() == before + piece.len());
                taken.clear();
            }
            ExplicitOutcome::Repeated | ExplicitOutcome::Acknowledge => {
                assert_eq!(machine.received(), before, "{byte} changes nothing");
            }
            ExplicitOutcome::RepeatedLast | ExplicitOutcome::IgnoredNoFirst => assert!(!receiving),
            ExplicitOutcome::TooLong
            | ExplicitOutcome::OutOfSequence { .. }
            | ExplicitOutcome::InvalidFirst { .. } => {
                assert!(!machine.is_receiving());
                taken.clear();
            }
        }
    }
}

fn arrives_as_io(data: &[u8]) {
    let mut machine = IoReassembly::<32>::new(LIMIT);
    let mut taken: Vec<u8> = Vec::new();
    for field in fields(data) {
        let piece = field.get(1..).unwrap_or_default();
        let first = field.first().is_none_or(|byte| byte >> 6 == 0);
        match machine.frame(field) {
            outcome @ (IoOutcome::Stored | IoOutcome::Complete(_)) => {
                if first {
                    taken.clear();
                }
                taken.extend(piece);
                if let IoOutcome::Complete(body) = outcome {
                    assert_eq!(body, taken);
                    assert!(body.len() <= LIMIT);
                    taken.clear();
                }
            }
            IoOutcome::TooLong
            | IoOutcome::OutOfSequence { .. }
            | IoOutcome::InvalidFirst { .. }
            | IoOutcome::UnexpectedAcknowledge
            | IoOutcome::IgnoredNoFirst => {
                assert!(!machine.is_receiving());
                taken.clear();
            }
        }
    }
}

const LONGEST: usize = 4096;
/// Smaller than the capacity, so that both limits are met.
const LIMIT: usize = 20;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_read_from_their_lengths() {
        let fields: Vec<_> = fields(&[2, 0xAA, 0xBB, 0, 7, 1]).collect();
        assert_eq!(fields, [&[0xAA, 0xBB][..], &[], &[1]]);
    }

    #[test]
    fn a_message_in_two_fragments_arrives() {
        // The product name of an Omron GRT1-DRT (Konvolucio.DeviceNet unit-test logs).
        arrives_as_explicit(b"\x07\x00\x8E\x08GRT1\x05\x81-DRT");
        check(b"\x8E\x08GRT1-DRT");
    }
}
