//! How the nodes of the plant answer.

use devicenex_core::id::{Framing, Identifier, Layout, Route};
use link_core::Frame;

use crate::plant::device;

/// The answer of a node to a request: well, refused, with nothing, or with anything.
pub(super) fn answer(request: &Frame, how: u8) -> Option<Frame> {
    let id = Identifier::of_frame(request);
    let back = |route: Route| Route {
        destination: route.source,
        direction: devicenex_core::id::Direction::Response,
        source: route.destination,
    };
    let data = request.data();
    let body: Vec<u8> = match (how % 4, data) {
        (1, _) => vec![0x94, how, 0xFF],
        (2, _) => vec![data.first()? | 0x80],
        (3, _) => [&[data.first()? | 0x80], &[how; 4][..usize::from(how >> 4) % 5]].concat(),
        (_, [0x4B, byte]) => vec![0x4B, *byte, 0, 128, 0],
        (_, [0x4B, byte, _, _, low, high, _]) => vec![0x4B, *byte, 0, *low, *high],
        (_, [0x0E, 1, 1, attribute]) => identity_value(*attribute, how >> 2),
        (_, [0x0E, 5, _, 1]) => vec![0x8E, if how & 0x40 == 0 { 3 } else { 4 }],
        (_, [0x0E, 5, _, 4 | 5]) => vec![0x8E, 7, 0, 0x86, 0x80],
        (_, [0x0E, 5, _, 9]) => vec![0x8E, 100, 0],
        (_, [service, ..]) => vec![service | 0x80, 3],
        (_, []) => return None,
    };
    let body = &body[..body.len().min(8)];
    match id.layout() {
        Layout::Connection { route, transaction } => {
            Identifier::connection(back(route), transaction).frame(body)
        }
        Layout::Connectionless { route, framing: Framing::Complete { transaction } } => {
            Identifier::connectionless(back(route), Framing::Complete { transaction }).frame(body)
        }
        Layout::Explicit { message, route, framing: Framing::Complete { transaction } } => {
            Identifier::explicit(message, back(route), Framing::Complete { transaction })?.frame(body)
        }
        _ => None,
    }
}

fn identity_value(attribute: u8, which: u8) -> Vec<u8> {
    let device = device(which);
    let value = match attribute {
        1 => device.vendor.0.to_le_bytes().to_vec(),
        3 => device.product_code.to_le_bytes().to_vec(),
        4 => vec![device.major_revision, 7],
        6 => device.serial.to_le_bytes().to_vec(),
        _ => vec![2, 0x41, 0x42],
    };
    [&[0x8E], &value[..]].concat()
}
