//! The slaves as their master should find them: what each is, and what it answers.

use cip_core::code::VendorId;
use devicenet_core::master::{
    BitStrobeConnection, ChangeOfStateConnection, ElectronicKey, PollConnection, ScanEntry,
};
use devicenet_core::{Identifier, MacId};
use link_core::Frame;

/// Slave 10 is polled with long data both ways, 20 strobed and polled, 63 sends changes.
pub(super) fn entry(number: u8) -> ScanEntry {
    let poll = |produce, consume| Some(PollConnection { produce, consume, expected_packet_rate: 75 });
    let vendor = VendorId(u16::from_le_bytes([VENDOR.0, VENDOR.1]));
    let key = ElectronicKey { vendor: Some(vendor), ..ElectronicKey::default() };
    let base = ScanEntry { key, replaceable: true, ..ScanEntry::explicit_only(mac(number)) };
    match number {
        10 => ScanEntry { poll: poll(16, 16), ..base },
        20 => ScanEntry {
            poll: poll(1, 1),
            bit_strobe: Some(BitStrobeConnection { produce: 1, expected_packet_rate: 0 }),
            multicast_poll: poll(1, 1),
            ..base
        },
        _ => {
            let change = ChangeOfStateConnection {
                cyclic: false,
                acknowledged: true,
                produce: 2,
                consume: 16,
                expected_packet_rate: 0,
                inhibit: 0,
            };
            ScanEntry { change_of_state: Some(change), ..base }
        }
    }
}

/// What a slave answers: `how` 0 to 7 well, then other numbers, errors and other headers.
pub(super) fn answer(request: &Frame, number: u8, how: u8) -> Frame {
    let data = request.data();
    let (header, body) = data.split_first().map_or((0, &[][..]), |(header, body)| (*header, body));
    let ucmm = request.raw_id() >= 0x780;
    let node = mac(number);
    let id = match request.raw_id() {
        0x780.. => Identifier::unconnected_response(node),
        0x600.. => Identifier::group3(4, node).expect("Message ID 4"),
        _ => Identifier::explicit_response(node),
    };
    // On Group 3 the request's header names the slave.
    let client = if request.raw_id() >= 0x600 { request.raw_id() as u8 & 0x3F } else { header & 0x3F };
    let header = header & 0xC0 | client;
    if header & 0x80 != 0 {
        // A fragment: its acknowledge, or after the last one a response.
        let byte = body.first().copied().unwrap_or(0);
        let acknowledge = [header, 0xC0 | byte & 0x3F, u8::from(how == 0xFF)];
        return id.frame(&acknowledge).expect("three bytes");
    }
    let service = body.first().copied().unwrap_or(0) | 0x80;
    let number = |good: u8, high: u8| vec![if how % 16 == 8 { 0x77 } else { good }, high];
    let consume = entry(node.number()).output_len() as u8;
    let connection = |instance: u8, produce: bool| {
        let size = match (node.number(), instance, produce) {
            (10, 2, _) => 16,
            (20, ..) => 1,
            (_, 2, false) => consume,
            _ => 2,
        };
        number(size, 0)
    };
    let wide = body.len() > 5 && body.get(2) == Some(&0);
    let fields: Vec<u8> = if wide {
        body.iter()
            .copied()
            .enumerate()
            .filter(|(at, _)| ![2, 4].contains(at))
            .map(|(_, byte)| byte)
            .collect()
    } else {
        body.to_vec()
    };
    let value = match fields[..] {
        [0x4B, ..] if ucmm => vec![how & 2, 0x04, 6, 0],
        [0x4B, ..] => vec![0],
        [0x0E, 1, 1, 1] => number(VENDOR.0, VENDOR.1),
        [0x0E, 5, instance, 7] => connection(instance, true),
        [0x0E, 5, instance, 8] => connection(instance, false),
        [0x10, 5, _, 9, low, high] => vec![low, high],
        [0x0E, ..] => vec![1, 0],
        _ => Vec::new(),
    };
    let bytes = match how % 16 {
        9 => vec![header, 0x94, 0x0B, 0x02],
        10 => vec![header, 0x94, 0x0C, 0x01],
        11 => vec![header, 0x94, 0x08, 0xFF],
        12 => vec![header ^ 0x40, service],
        13 => vec![header | 0x80, how, 0x8E, 1, 2, 3, 4, 5],
        _ => [vec![header, service], value].concat(),
    };
    id.frame(&bytes).expect("at most eight bytes")
}

/// A frame of I/O data: bits 1-0 of `which` the slave, bits 3-2 the connection, bits 6-4 the length if bit 7 is set.
pub(super) fn io(which: u8, head: u8, value: u8) -> Frame {
    let node = mac(SLAVES[usize::from(which & 3) % SLAVES.len()]);
    let (id, size) = match which >> 2 & 3 {
        0 => (Identifier::poll_response(node), 1),
        1 => (Identifier::bit_strobe_response(node), 1),
        2 => (Identifier::change_of_state(node), 2),
        _ => (Identifier::multicast_poll_response(node), 1),
    };
    let fragmented = node.number() == 10;
    let len = match (which >> 7, fragmented) {
        (0, true) => 8,
        (0, false) => size,
        _ => usize::from(which >> 4 & 7),
    };
    let mut data = vec![value; len];
    if fragmented && let Some(first) = data.first_mut() {
        *first = head;
    }
    id.frame(&data).expect("at most eight bytes")
}

pub(super) fn mac(number: u8) -> MacId {
    MacId::new(number & 0x3F).expect("six bits")
}

pub(super) const OWN: u8 = 4;
pub(super) const SLAVES: [u8; 3] = [10, 20, 63];
pub(super) const VENDOR: (u8, u8) = (0xE7, 0x03);
