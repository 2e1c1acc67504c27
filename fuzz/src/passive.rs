//! What the targets of the passive decoders have in common, whatever the protocol.

use core::fmt::Display;

use link_core::Instant;
use serde_json::{Map, Value};

/// The line of a reading, at most so many characters. It begins with its words, and ends with its problem, if it has one: what that
/// says, and its code.
pub(crate) fn line(
    reading: &impl Display,
    words: &impl Display,
    problem: Option<(&dyn Display, &str)>,
    longest: usize,
) -> String {
    let text = reading.to_string();
    assert!(!text.is_empty() && !text.contains(char::is_control), "one line: {text:?}");
    assert!(text.chars().count() <= longest, "{} characters: {text}", text.chars().count());
    assert!(text.starts_with(&words.to_string()), "{text}");
    if let Some((problem, code)) = problem {
        let problem = problem.to_string();
        assert!(!problem.is_empty() && text.ends_with(&problem), "{text} tells {problem}");
        assert!(code.bytes().all(|byte| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'_')), "{code}");
    }
    text
}

/// The object of a reading that has this line and is of this kind, as it was serialised.
pub(crate) fn object(json: &str, text: &str, kind: &str) -> Map<String, Value> {
    let Ok(Value::Object(object)) = serde_json::from_str(json) else { panic!("not an object: {json}") };
    assert_eq!(object["text"], text);
    assert_eq!(object["kind"], kind);
    assert!(object.values().all(|value| !value.is_null()), "absent fields are left out: {json}");
    object
}

/// Whether a message consists of pieces that were sent. `sent` has the frames that may be part of it, the last one first: of each
/// the data without a header, in every way in which they may be read. The first must be part of it.
pub(crate) fn is_made_of<'a, P>(message: &[u8], sent: impl IntoIterator<Item = P>) -> bool
where
    P: IntoIterator<Item = &'a [u8]> + Clone,
{
    // How much of the message, from its front, is still to be explained, by any choice of frames so far.
    let mut left = vec![message.len()];
    for (index, pieces) in sent.into_iter().enumerate() {
        let shorter: Vec<_> = left
            .iter()
            .flat_map(|&length| pieces.clone().into_iter().map(move |piece| (length, piece)))
            .filter_map(|(length, piece)| message[..length].strip_suffix(piece).map(<[u8]>::len))
            .collect();
        if index == 0 {
            left.clear();
        }
        left.extend(shorter);
        left.sort_unstable();
        left.dedup();
        if left.first() == Some(&0) {
            return true;
        }
    }
    false
}

pub(crate) fn contains(data: &[u8], piece: &[u8]) -> bool {
    piece.is_empty() || data.windows(piece.len()).any(|window| window == piece)
}

/// Of a session.
pub(crate) const MOST_FRAMES: usize = 256;
/// Not zero, before which there is no moment.
pub(crate) const START: Instant = Instant::from_millis(1_000);
/// The same session at another time of day begins here.
pub(crate) const MUCH_LATER: Instant = Instant::from_millis(1_700_000_000_000);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_made_of_pieces() {
        let sent = |pieces: &[&'static [u8]]| is_made_of(b"abcd", pieces.iter().map(|&piece| [piece]));
        assert!(sent(&[b"cd", b"x", b"ab"]));
        assert!(!sent(&[b"ab", b"cd"]), "in that order");
        assert!(!sent(&[b"x", b"cd", b"ab"]), "it ends with the last frame");
        assert!(!sent(&[b"cd", b"b"]));
    }

    /// Bytes of a small generator of our own.
    #[test]
    fn any_bytes_are_a_session() {
        let mut state = 1_u32;
        for length in [0, 1, 2, 7, 64, 300, 1000, 3000] {
            let bytes: Vec<u8> = (0..length)
                .map(|_| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (state >> 24) as u8
                })
                .collect();
            for run in [crate::monitor::run, crate::nx_monitor::run, crate::pl_monitor::run] {
                run(&bytes);
            }
        }
    }
}
