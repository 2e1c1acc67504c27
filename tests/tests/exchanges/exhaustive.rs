//! Exchanges of which there are too many to write: each is made by the rule that the specification gives, and played.

use crate::script::Exchange;

/// Every choice that a byte can hold, by the order of checks of CIP Vol. 3.
#[test]
fn every_allocation_choice() {
    for (device, supported) in [("block", 0x03), ("full", 0x7F)] {
        let mut lines = vec![format!("device: {device}")];
        for choice in 0..=0xFF_u8 {
            let refused = refusal(choice, supported);
            lines.push(format!("> 5FE: 04 4B 03 01 {choice:02X} 04"));
            match refused {
                Some(status) => lines.push(format!("< 5FB: 04 94 {status:02X} 02")),
                None => {
                    lines.push("< 5FB: 04 CB 00".to_owned());
                    lines.push("! allocated to 4".to_owned());
                    lines.push(format!("> 5FE: 04 4C 03 01 {choice:02X}"));
                    lines.push("< 5FB: 04 CC".to_owned());
                }
            }
        }
        play("every allocation choice", lines);
    }
}

/// The general status that a free slave refuses a choice with; the additional code is always 0x02.
fn refusal(choice: u8, supported: u8) -> Option<u8> {
    let has = |bits: u8| choice & bits != 0;
    if choice == 0 || has(SUPPRESSION) && !has(CHANGE_OF_STATE | CYCLIC) {
        return Some(INVALID_VALUE);
    }
    if has(!supported & IO) {
        return Some(RESOURCE);
    }
    let invalid = !has(EXPLICIT) || has(CHANGE_OF_STATE) && has(CYCLIC) || has(RESERVED);
    invalid.then_some(INVALID_VALUE)
}

/// Requests in fragments, from the first that does not fit into a frame to three bytes more than there is room for: to a
/// class that does not exist, so that the answer is the same.
#[test]
fn a_request_of_every_length() {
    let mut lines = vec!["start: allocated 01".to_owned()];
    for length in 8..=ROOM + 3 {
        let mut body = vec![0x10, 0x77, 0x01, 0x01];
        body.resize(length, 0xEE);
        let last = body.len().div_ceil(6) - 1;
        let mut taken = true;
        for (count, piece) in body.chunks(6).enumerate() {
            let kind = match count {
                0 => 0x00,
                _ if count == last => 0x80,
                _ => 0x40,
            };
            let bytes: Vec<String> = piece.iter().map(|byte| format!("{byte:02X}")).collect();
            lines.push(format!("> 5FC: 84 {:02X} {}", kind | count, bytes.join(" ")));
            let fits = count * 6 + piece.len() <= ROOM;
            if taken {
                lines.push(format!("< 5FB: 84 {:02X} {:02X}", 0xC0 | count, u8::from(!fits)));
            } else {
                lines.push("! fragment out of order".to_owned());
            }
            taken &= fits;
        }
        if taken {
            lines.push("< 5FB: 04 94 16 FF".to_owned());
        }
    }
    play("a request of every length", lines);
}

fn play(name: &str, lines: Vec<String>) {
    let (file, name) = (file!().to_owned(), name.to_owned());
    Exchange { file, name, fault: None, lines }.play();
}

/// The bits of the choice.
const EXPLICIT: u8 = 0x01;
const CHANGE_OF_STATE: u8 = 0x10;
const CYCLIC: u8 = 0x20;
const SUPPRESSION: u8 = 0x40;
const RESERVED: u8 = 0x80;
/// Those of connections for I/O.
const IO: u8 = 0x3E;
const RESOURCE: u8 = 0x02;
const INVALID_VALUE: u8 = 0x09;
/// What a slave takes of an explicit message.
const ROOM: usize = 64;
