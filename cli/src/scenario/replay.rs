//! The frames of a recording, as far as they can be played.

use std::io::Cursor;

use link_core::{Frame, Instant};

use super::model::Recorded;
use crate::recording::{Content, Recording};

/// The classic frames of a recording in the order of time, each with its distance from the first. Error frames cannot
/// be sent and are left out; a line that cannot be read, or a frame of another kind, is an error.
pub(super) fn frames(name: &str, bytes: &[u8]) -> Result<Vec<Recorded>, String> {
    let fail = |error| format!("{name}: {error}");
    let recording =
        Recording::from_reader(Cursor::new(bytes.to_vec())).map_err(|error| fail(error.to_string()))?;
    let mut played = Vec::new();
    for entry in recording {
        let entry = entry.map_err(|error| fail(error.to_string()))?;
        match entry.content {
            Content::Classic(frame) => played.push((entry.at, frame)),
            Content::Error(_) => {}
            Content::Fd(_) => return Err(fail(format!("frame {} is CAN FD; expected classic CAN", entry.n))),
        }
    }
    // A recording need not be in the order of time; what has one time stays as it was.
    played.sort_by_key(|(at, _)| *at);
    let first = played.first().map(|(at, _)| *at).unwrap_or_default();
    let distance = |(at, frame): (Instant, Frame)| Recorded { after: at.saturating_since(first), frame };
    Ok(played.into_iter().map(distance).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::time::Duration;

    #[test]
    fn a_recording_need_not_be_in_the_order_of_time() {
        let log = b"(5.0) can0 103#\n(4.5) can0 101#\n(4.0) can0 100#\n(4.5) can0 102#\n";
        let frames = frames("x.log", log).unwrap();
        let played: Vec<(u64, u32)> = (frames.iter())
            .map(|played| (u64::try_from(played.after.as_millis()).unwrap(), played.frame.raw_id()))
            .collect();
        assert_eq!(played, [(0, 0x100), (500, 0x101), (500, 0x102), (1_000, 0x103)]);
    }

    #[test]
    fn distances_from_the_first_frame() {
        let log = b"(100.000000) can0 20000004#0004000000000000\n(100.5) can0 123#11\n(102.5) can0 124#\n";
        let after: Vec<Duration> = frames("x.log", log).unwrap().iter().map(|frame| frame.after).collect();
        // The error frame is no frame that can be played.
        assert_eq!(after, [Duration::ZERO, Duration::from_secs(2)]);
    }

    #[test]
    fn a_bad_line_is_told() {
        let error = frames("x.log", b"(1.0) can0 123#11\n(1.0) can0 800#11\n").unwrap_err();
        assert_eq!(error, "x.log: 2:12: an 11-bit identifier, 000 to 7FF expected, \"800#11\" found");
        let error = frames("x.log", b"(1.0) can0 123##011\n").unwrap_err();
        assert_eq!(error, "x.log: frame 1 is CAN FD; expected classic CAN");
    }
}
