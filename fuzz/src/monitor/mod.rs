//! A session through the passive decoder: it stays within bounds, every line and object is sound, what it puts together
//! was sent, what it pairs came before, and the time of day makes no difference. A doctor looks at it all the while: what it finds
//! is sound, and told once.

mod findings;
pub(crate) mod session;

use std::collections::HashMap;

use core::time::Duration;

use arbitrary::Unstructured;
use devicenet_core::MacId;
use devicenet_core::monitor::{FragmentationGuess, Monitor, MonitorConfig, Predefined, Reading};

use crate::passive::{MOST_FRAMES, MUCH_LATER, START, is_made_of};
use crate::readings;
use findings::Practice;
use session::Sent;
pub use session::session_bytes;

/// Byte 0: bit 0 fragmented I/O is not guessed, bit 1 the sizes of a connection are told, bits 2-3 which nodes belong to the
/// network. Then a session.
pub fn run(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let Ok(options) = input.arbitrary::<u8>() else { return };
    let (mut monitor, mut later) = (new_monitor(options), new_monitor(options));
    let (mut practice, mut same_practice) = (Practice::new(options), Practice::new(options));
    let sent = session::read(&mut input, MOST_FRAMES, session::exchange);
    let mut numbers = HashMap::new();
    for (index, Sent { at, frame }) in sent.iter().enumerate() {
        // The numbers of a recording, in which other frames lie between.
        let n = 2 * index as u64 + 1;
        numbers.insert(n, *at);
        let reading = practice.observe(&mut monitor, START + *at, n, frame);
        let text = readings::judge(&reading, frame);
        check_request(&reading, &numbers, *at);
        check_message(&reading, &sent[..=index]);
        let same = same_practice.observe(&mut later, MUCH_LATER + *at, n, frame);
        assert_eq!(same.to_string(), text, "at another time of day");
        assert_eq!(same.message.map(|message| message.data), reading.message.map(|message| message.data));
        assert_eq!(same.request, reading.request);
    }
    check_summary(&monitor, &sent);
    practice.finish(&monitor, START, &numbers);
    same_practice.finish(&later, MUCH_LATER, &numbers);
    practice.finds_the_same(&same_practice);
}

fn new_monitor(options: u8) -> Box<Monitor> {
    let mut config = MonitorConfig::default();
    if options & 1 != 0 {
        config.fragmentation = FragmentationGuess::Off;
    }
    let mut monitor = Box::new(Monitor::new(config));
    if options & 2 != 0 {
        let slave = MacId::new(10).expect("at most 63");
        monitor.set_io_sizes(slave, Predefined::Poll, Some(12), Some(u16::from(options >> 2)));
    }
    monitor
}

/// What is answered was seen before, as long ago as the latency says.
fn check_request(reading: &Reading<'_>, numbers: &HashMap<u64, Duration>, at: Duration) {
    let Some(request) = reading.request else { return };
    assert!(request.n < reading.n, "{reading} answers itself");
    let asked = numbers.get(&request.n).unwrap_or_else(|| panic!("{reading} answers {}", request.n));
    assert_eq!(request.latency, at - *asked, "{reading}");
}

/// A message consists of pieces of frames with the identifier of the last one, in the order of sending, none of them
/// longer ago than a sender waits.
fn check_message(reading: &Reading<'_>, sent: &[Sent]) {
    let Some(message) = reading.message else { return };
    assert!(message.data.len() <= LONGEST_MESSAGE, "{} bytes", message.data.len());
    if message.data.is_empty() {
        return;
    }
    let mut after = reading.at.saturating_since(START);
    let on_this_identifier = sent.iter().rev().filter(|sent| sent.frame.id() == reading.frame.id());
    let in_time = on_this_identifier.map_while(|Sent { at, frame }| {
        let is_in_time = after - *at <= FRAGMENT_TIMEOUT;
        after = *at;
        is_in_time.then(|| (1..=2).filter_map(move |skip| frame.data().get(skip..)))
    });
    assert!(is_made_of(message.data, in_time), "{:02X?} was never sent: {reading}", message.data);
}

/// The records agree with what was sent.
fn check_summary(monitor: &Monitor, sent: &[Sent]) {
    let frames = sent.len() as u64;
    let bytes: u64 = sent.iter().map(|sent| sent.frame.data().len() as u64).sum();
    let nodes: Vec<_> = monitor.nodes().collect();
    assert!(nodes.iter().map(|node| node.mac).is_sorted_by(|one, next| one < next), "each MAC ID once");
    assert!(nodes.iter().map(|node| node.traffic.frames).sum::<u64>() <= frames);
    assert!(nodes.iter().map(|node| node.traffic.bytes).sum::<u64>() <= bytes);
    for node in &nodes {
        let traffic = node.traffic;
        assert!(traffic.problems <= traffic.frames && traffic.error_responses <= traffic.frames, "{node:?}");
        assert!(traffic.responses <= traffic.frames, "{node:?}");
        assert!(traffic.first_seen() <= traffic.last_seen(), "{node:?}");
    }
    for connection in monitor.connections() {
        assert!(connection.frames <= frames && connection.bytes <= bytes, "{connection:?}");
        assert!(!connection.name.to_string().is_empty());
        let known = connection.states().count();
        assert!(known > 0 || connection.frames > 0, "{connection:?}");
    }
}

const LONGEST_MESSAGE: usize = 512;
const FRAGMENT_TIMEOUT: Duration = Duration::from_secs(3);

#[cfg(test)]
mod tests {
    use super::*;
    use devicenet_core::Identifier;
    use link_core::{Frame, Instant};

    fn session(frames: &[(u16, &[u8])]) -> Vec<u8> {
        let frames = frames.iter().enumerate().map(|(index, &(id, data))| {
            let frame: Frame = Identifier::new(id).unwrap().frame(data).unwrap();
            (Instant::from_millis(index as u64), frame)
        });
        [&[0][..], &session_bytes(frames)].concat()
    }

    #[test]
    fn a_fragmented_response_is_put_together() {
        // The product name of an Omron GRT1-DRT (Konvolucio.DeviceNet unit-test logs).
        run(&session(&[
            (0x414, &[0x00, 0x0E, 0x01, 0x01, 0x07]),
            (0x413, &[0x80, 0x00, 0x8E, 0x08, 0x47, 0x52, 0x54, 0x31]),
            (0x414, &[0x80, 0xC0, 0x00]),
            (0x413, &[0x80, 0x81, 0x2D, 0x44, 0x52, 0x54]),
            (0x414, &[0x80, 0xC1, 0x00]),
        ]));
    }
}
