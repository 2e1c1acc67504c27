//! A session through the passive decoder of DeviceNeX: it stays within bounds, every line and object is sound, what it puts together was
//! sent, what it pairs came before, and the time of day makes no difference.

use core::fmt::Display;
use std::collections::HashMap;

use arbitrary::Unstructured;
use cip_core::code::InstanceId;
use devicenex_core::id::{Direction, Framing, Group, MessageId, Route};
use devicenex_core::monitor::{FragmentationGuess, Kind, Monitor, MonitorConfig, Reading};
use devicenex_core::{Identifier, OperationalAddress};
use link_core::Frame;

use crate::monitor::session::{self, Sent};
use crate::passive::{self, MOST_FRAMES, MUCH_LATER, START, contains};

/// Byte 0: bit 0 fragmented I/O is not guessed, bit 1 the sizes of a connection are told. Then a [session](crate::monitor), whose
/// exchanges are those of DeviceNeX.
pub fn run(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let Ok(options) = input.arbitrary::<u8>() else { return };
    let (mut monitor, mut later) = (new_monitor(options), new_monitor(options));
    let sent = session::read(&mut input, MOST_FRAMES, exchange);
    let mut numbers = HashMap::new();
    for (index, Sent { at, frame }) in sent.iter().enumerate() {
        // The numbers of a recording, in which other frames lie between.
        let n = 2 * index as u64 + 1;
        numbers.insert(n, *at);
        let reading = monitor.observe(START + *at, n, frame);
        let text = judge(&reading, frame);
        if let Some(request) = reading.request {
            assert!(request.n < reading.n, "{reading} answers itself");
            assert_eq!(request.latency, *at - numbers[&request.n], "{reading}");
        }
        let same = later.observe(MUCH_LATER + *at, n, frame);
        assert_eq!(same.to_string(), text, "at another time of day");
        assert_eq!(same.message.map(|message| message.data), reading.message.map(|message| message.data));
        assert_eq!((same.request, same.assumed), (reading.request, reading.assumed));
    }
    check_summary(&monitor, &sent);
}

fn new_monitor(options: u8) -> Box<Monitor> {
    let mut config = MonitorConfig::default();
    if options & 1 != 0 {
        config.fragmentation = FragmentationGuess::Off;
    }
    let mut monitor = Box::new(Monitor::new(config));
    if options & 2 != 0 {
        monitor.set_io_sizes(address(10), InstanceId(7), Some(12), Some(u16::from(options >> 2)));
    }
    monitor
}

/// The line and the object of a frame. Returns the line.
fn judge(reading: &Reading<'_>, frame: &Frame) -> String {
    assert_eq!(reading.frame, *frame);
    let problem = reading.problem.as_ref().map(|problem| (problem as &dyn Display, problem.code()));
    let text = passive::line(reading, &reading.words(), problem, LONGEST_LINE);
    if let Some(value) = reading.value() {
        assert!(contains(frame.data(), value), "{value:02X?} is a piece of {frame}");
    }
    if let Some(message) = reading.message {
        assert!(message.data.len() <= LONGEST_MESSAGE, "{} bytes", message.data.len());
        assert!(message.value().is_none_or(|value| contains(message.data, value)), "{text}");
    }
    let is_foreign = reading.kind == Kind::Foreign;
    assert!(!is_foreign || reading.problem.is_some(), "foreign without a reason: {text}");
    let json = serde_json::to_string(reading).expect("a reading always serialises");
    let object = passive::object(&json, &text, reading.kind.name());
    assert_eq!(object["protocol"], if is_foreign { "unknown" } else { "devicenex" });
    assert_eq!(object.contains_key("problem"), reading.problem.is_some(), "{json}");
    assert_eq!(object.contains_key("message"), reading.message.is_some(), "{json}");
    text
}

/// The records agree with what was sent.
fn check_summary(monitor: &Monitor, sent: &[Sent]) {
    let frames = sent.len() as u64;
    let bytes: u64 = sent.iter().map(|sent| sent.frame.data().len() as u64).sum();
    let nodes: Vec<_> = monitor.nodes().collect();
    let addressed = nodes.iter().filter(|node| !node.address.is_none());
    assert!(addressed.map(|node| node.address).is_sorted_by(|one, next| one < next), "each address once");
    assert!(nodes.iter().map(|node| node.traffic.frames).sum::<u64>() <= frames);
    assert!(nodes.iter().map(|node| node.traffic.bytes).sum::<u64>() <= bytes);
    for node in &nodes {
        let traffic = node.traffic;
        assert!(traffic.problems <= traffic.frames && traffic.error_responses <= traffic.frames, "{node:?}");
        assert!(
            traffic.responses <= traffic.frames && traffic.first_seen() <= traffic.last_seen(),
            "{node:?}"
        );
    }
    for connection in monitor.connections() {
        assert!(connection.frames <= frames && connection.bytes <= bytes, "{connection:?}");
        assert!(!connection.name.to_string().is_empty());
        assert!(connection.states().count() > 0 || connection.frames > 0, "{connection:?}");
    }
}

/// The frames of which exchanges consist, with a server and a client from `nodes`: bits 3-0 the server, bits 6-4 the client.
fn exchange(number: u8, nodes: u8, argument: u8) -> Frame {
    let (server, client) = (address(10 + (nodes & 0x0F)), address(nodes >> 4 & 7));
    let request = Route { destination: server, direction: Direction::Request, source: client };
    let response = Route { destination: client, direction: Direction::Response, source: server };
    let complete = Framing::Complete { transaction: argument & 3 };
    let fragment = Framing::Fragment(argument.into());
    let message = MessageId::from_low_bits(argument);
    let low = MessageId::from_low_bits(argument & 1);
    let instance = InstanceId(u16::from(argument & 0x0F));
    let long = [argument & 3, 0x8E, argument, 1, 2, 3, 4, 5];
    let explicit =
        |route, framing| Identifier::explicit(MessageId::default(), route, framing).expect("0 is at most 7");
    let serial = u16::from(argument & 3);
    let device = [0, 0, 0x34, 0x12, 1, 0, 1, argument & 0x80];
    let (id, data): (Identifier, &[u8]) = match number {
        0 => (Identifier::hello(OperationalAddress::NONE, Direction::Request, serial), &device),
        1 => (Identifier::hello(server, Direction::Request, serial), &device),
        2 => (Identifier::hello(server, Direction::Response, serial), &device),
        3 => (Identifier::roam(serial), &[0, 0, 0x34, 0x12, 1, 0, 1, server.number()]),
        4 => (
            Identifier::connection(request, argument & 3),
            &[0x4B, 0x80 | argument & 0x70, argument & 0x0F, 0, 100, 0, argument >> 6],
        ),
        5 => (Identifier::connection(response, argument & 3), &[0x4B, 0x80 | argument & 0x70, 0, 100, 0]),
        6 => (Identifier::connection(request, argument & 3), &[0x4B, argument & 0x7F]),
        7 => (
            Identifier::connection(response, argument & 3),
            &[0x4B, argument & 0x70, argument & 3, 0x80 | argument, 0],
        ),
        8 => (Identifier::connection(response, argument & 3), &[0x94, argument, 0xFF]),
        9 => (Identifier::connectionless(request, complete), &[0x0E, 1, 1, argument >> 2]),
        10 => (Identifier::connectionless(response, complete), &[0x8E, argument, 0]),
        11 => (Identifier::connectionless(response, fragment), &long),
        12 => (Identifier::connectionless(request, fragment), &long[..1]),
        13 => (explicit(request, complete), &[0x0E, 5, argument & 0x0F, argument >> 4]),
        14 => (explicit(request, complete), &[0x10, 5, argument & 0x0F, 5, 7, 0, server.number() << 1, 0x82]),
        15 => (explicit(response, complete), &[0x90]),
        16 => (explicit(response, complete), &[0x8E, 7, 0, 0x86, 0x82]),
        17 => (explicit(request, fragment), &long),
        18 => (explicit(response, fragment), &long),
        19 => (explicit(response, fragment), &long[..1]),
        20 => (Identifier::implicit(message, server, instance), &long[..usize::from(argument & 7)]),
        21 => (Identifier::implicit(message, server, instance), &long),
        22 => {
            let target = devicenex_core::connection::requester_instance(server, instance);
            (Identifier::implicit(message, client, target), &long[..2])
        }
        23 => {
            let target = devicenex_core::connection::requester_instance(server, instance);
            (Identifier::implicit_acknowledge(message, client, target), &[])
        }
        24 => (Identifier::implicit_acknowledge(message, server, instance), &[]),
        25 => (Identifier::standard(Group::Group1, low, server).expect("0 or 1"), &long[..3]),
        26 => (Identifier::standard(Group::Group2, low, client).expect("0 or 1"), &long),
        27 => (explicit(request, complete), &[0x05, argument & 7, argument >> 4]),
        28 => (explicit(response, complete), &[0x94, argument, 0xFF]),
        29 => {
            let id = Identifier::hello(OperationalAddress::NONE, Direction::Request, serial);
            return Frame::remote(id.id(), 8).expect("eight");
        }
        _ => (explicit(request, complete), &[0x10, 5, argument & 0x0F, 9, argument, 0]),
    };
    id.frame(data).expect("at most eight bytes")
}

fn address(number: u8) -> OperationalAddress {
    OperationalAddress::from_low_bits(number)
}

const LONGEST_MESSAGE: usize = 512;
/// A message of 512 bytes in hexadecimal, and words around it.
const LONGEST_LINE: usize = 4096;

#[cfg(test)]
mod tests {
    use super::*;

    /// Every exchange by itself and after every other.
    #[test]
    fn exchanges_follow_each_other() {
        for first in 0..=30_u8 {
            for second in 0..=30_u8 {
                let item = |number: u8, argument: u8| [0x41, 0x80 | number, 0x10, argument];
                let session =
                    [&[2][..], &item(first, 0), &item(second, 0), &item(first, 0x47), &item(second, 0x81)]
                        .concat();
                run(&session);
            }
        }
    }
}
