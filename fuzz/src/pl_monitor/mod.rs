//! A session through the passive decoder of POWERLINK: it stays within bounds, every frame is accounted for, what it counts and which
//! states it tells is what a second, small program says, what it puts together was sent, what it pairs came before, and the time of
//! day makes no difference. The clock may go back.

mod look;
mod model;
mod session;

use core::fmt::Display;

use arbitrary::Unstructured;
use powerlink_core::monitor::{Captured, Kind, Monitor, Reading};
use powerlink_core::wire::Body;
use serde_json::Value;

use crate::passive::{self, MOST_FRAMES, MUCH_LATER, START, contains, is_made_of};
use look::Look;
use model::Model;
use session::Sent;
pub use session::session_bytes;

/// The bytes are a session; its table stands in the private module `session`.
pub fn run(data: &[u8]) {
    let sent = session::read(&mut Unstructured::new(data), MOST_FRAMES);
    let (mut monitor, mut later) = (Box::new(Monitor::new()), Box::new(Monitor::new()));
    let mut model = Model::default();
    let mut pieces: Vec<Piece> = Vec::new();
    for (index, frame) in sent.iter().enumerate() {
        // The numbers of a recording, in which other frames lie between.
        let n = 2 * index as u64 + 1;
        let (at, captured) = (START + frame.at, frame.captured());
        let look = Look::at(captured);
        let expected = model.observe(at, n, captured, &look);
        let reading = monitor.observe(at, n, captured);
        assert_eq!(reading.kind, look.kind, "{reading}");
        let text = judge(&reading, captured);
        expected.check(&reading);
        check_request(&reading, &sent);
        pieces.extend(Piece::of(&reading));
        check_message(&reading, &pieces);
        let same = later.observe(MUCH_LATER + frame.at, n, captured);
        assert_eq!(same.to_string(), text, "at another time of day");
        assert_eq!(
            (same.request, same.message, same.interval),
            (reading.request, reading.message, reading.interval)
        );
    }
    model.check(&monitor);
    let transfers = sent.len() as u64;
    assert!(monitor.lost().transfers <= transfers && monitor.lost() == later.lost());
}

/// The line and the object of a frame. Returns the line.
fn judge(reading: &Reading<'_>, frame: Captured<'_>) -> String {
    assert_eq!(reading.frame, frame);
    let problem = reading.problem.as_ref().map(|problem| (problem as &dyn Display, problem.code()));
    let text = passive::line(reading, &reading.words(), problem, LONGEST_LINE);
    assert!(problem.is_some() || !text.contains(" ! "), "a problem that is none: {text}");
    let is_cut = frame.bytes.len() < frame.length;
    let is_read = reading.body.is_some() || reading.kind == Kind::Foreign;
    assert!(is_read || is_cut || reading.problem.is_some(), "left unread without a reason: {text}");
    if let Some(value) = reading.value() {
        assert!(contains(frame.bytes, value), "{value:02X?} is a piece of {text}");
    }
    let json = serde_json::to_string(reading).expect("a reading always serialises");
    let object = passive::object(&json, &text, reading.kind.name());
    assert_eq!(object["protocol"], if reading.kind == Kind::Foreign { "unknown" } else { "powerlink" });
    assert_eq!(object.get("src").and_then(Value::as_u64), reading.src.map(|node| node.0.into()), "{json}");
    assert_eq!(object.contains_key("problem"), reading.problem.is_some(), "{json}");
    assert_eq!(object.contains_key("nmt_state"), reading.state().is_some(), "{json}");
    assert_eq!(object.contains_key("message"), reading.message.is_some(), "{json}");
    text
}

/// What is answered was seen before, as long ago as the latency says; nothing at all if the clock went back.
fn check_request(reading: &Reading<'_>, sent: &[Sent]) {
    let Some(request) = reading.request else { return };
    assert!(request.n < reading.n, "{reading} answers itself");
    let asked = usize::try_from(request.n / 2).ok().and_then(|index| sent.get(index)).expect("it was seen");
    let now = reading.at.saturating_since(START);
    assert_eq!(request.latency, now.saturating_sub(asked.at), "{reading}");
}

/// The data of an SDO command.
struct Piece {
    ends: [u8; 2],
    data: Vec<u8>,
}

impl Piece {
    fn of(reading: &Reading<'_>) -> Option<Self> {
        let (Some(Body::Sdo(sdo)), Some(from), Some(to)) = (&reading.body, reading.src, reading.dst) else {
            return None;
        };
        Some(Self { ends: [from.0, to.0], data: sdo.command?.data.to_vec() })
    }
}

/// A message consists of what its sender has sent to its receiver, in that order, and ends with this frame. The first piece is sent
/// behind the number of an object.
fn check_message(reading: &Reading<'_>, pieces: &[Piece]) {
    let Some(message) = reading.message else { return };
    assert!(message.data.len() <= LONGEST_MESSAGE, "{} bytes", message.data.len());
    let (last, _) = pieces.split_last().expect("this frame is one");
    let ends = last.ends;
    let of_these_ends = pieces.iter().rev().filter(|piece| piece.ends == ends);
    let data = of_these_ends.map(|piece| [piece.data.get(4..), Some(&*piece.data)].into_iter().flatten());
    assert!(is_made_of(message.data, data), "{:02X?} was never sent: {reading}", message.data);
}

const LONGEST_MESSAGE: usize = 4096;
/// Words; the data are not in the line.
const LONGEST_LINE: usize = 512;

#[cfg(test)]
mod tests {
    use super::*;

    /// Every exchange by itself and after every other.
    #[test]
    fn exchanges_follow_each_other() {
        for first in 0..=31_u8 {
            for second in 0..=31_u8 {
                let item = |number: u8, argument: u8| [0x41, 0x80 | number, 0, argument];
                let session =
                    [item(first, 0), item(second, 0), item(first, 0x47), item(second, 0x81)].concat();
                run(&session);
            }
        }
    }
}
