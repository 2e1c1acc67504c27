//! The frames of a recording, as far as they can be played.

use std::io::Cursor;

use super::model::Recorded;
use crate::recording::{Content, Recording};

/// The classic frames of a recording, each with its distance from the first. Error frames cannot be sent and are left
/// out; a line that cannot be read, or a frame of another kind, is an error.
pub(super) fn frames(name: &str, bytes: &[u8]) -> Result<Vec<Recorded>, String> {
    let fail = |error| format!("{name}: {error}");
    let recording =
        Recording::from_reader(Cursor::new(bytes.to_vec())).map_err(|error| fail(error.to_string()))?;
    let mut frames = Vec::new();
    let mut first = None;
    for entry in recording {
        let entry = entry.map_err(|error| fail(error.to_string()))?;
        let begin = *first.get_or_insert(entry.at);
        match entry.content {
            Content::Classic(frame) => {
                frames.push(Recorded { after: entry.at.saturating_since(begin), frame });
            }
            Content::Error(_) => {}
            Content::Fd(_) => return Err(fail(format!("frame {} is CAN FD; expected classic CAN", entry.n))),
        }
    }
    // A recording need not be in order of time.
    frames.sort_by_key(|recorded| recorded.after);
    Ok(frames)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::time::Duration;

    #[test]
    fn distances_from_the_first_frame() {
        let log = b"(100.000000) can0 20000004#0004000000000000\n(100.5) can0 123#11\n(102.5) can0 124#\n";
        let after: Vec<Duration> = frames("x.log", log).unwrap().iter().map(|frame| frame.after).collect();
        assert_eq!(after, [Duration::from_millis(500), Duration::from_millis(2_500)]);
    }

    #[test]
    fn a_bad_line_is_told() {
        let error = frames("x.log", b"(1.0) can0 123#11\n(1.0) can0 800#11\n").unwrap_err();
        assert_eq!(error, "x.log: 2:12: an 11-bit identifier, 000 to 7FF expected, \"800#11\" found");
        let error = frames("x.log", b"(1.0) can0 123##011\n").unwrap_err();
        assert_eq!(error, "x.log: frame 1 is CAN FD; expected classic CAN");
    }
}
