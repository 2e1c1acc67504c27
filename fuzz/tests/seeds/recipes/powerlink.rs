//! Networks of POWERLINK, by hand.

use core::time::Duration;

use devicenet_fuzz::pl_monitor::session_bytes;

use super::{Seeds, controlled_node};

pub(super) fn net_pl() -> Seeds {
    // 2 s, 100 ms, 5 ms.
    let (long, while_, short) = ([0, 0xC2], [0, 0x82], [0, 0x45]);
    // The booted network of three; the same with an optional multiplexed node; with one of the asynchronous phase.
    let (three, multiplexed, asynchronous) = ([0x22], [0x2E], [0x32]);
    let scripts: [(&str, Vec<u8>); 12] = [
        ("boot", [&[0x03][..], &long].concat()),
        ("data", [&three[..], &[7, 0x15], &[7, 0x82], &[8, 0x5A], &while_, &[7, 0x01], &while_].concat()),
        ("power-cycles", [&three[..], &[3, 0], &short, &[3, 1], &long, &[3, 2], &while_].concat()),
        ("cables", [&three[..], &[4, 0], &short, &[4, 0], &while_, &[4, 1], &long, &[4, 1]].concat()),
        ("managing-node", [&three[..], &[5, 0x80], &long, &[5, 0], &while_, &[5, 0], &long].concat()),
        // Nobody for more than 5 s: plain Ethernet, where a stranger writes an object.
        (
            "basic-ethernet",
            [&[0x01][..], &[5, 0x80], &[0, 0xC6], &[10, 0x0A], &[10, 0x4A], &while_, &[10, 0x8A]].concat(),
        ),
        (
            "losses",
            [&three[..], &[6, 0x24], &short, &[6, 0xE4], &while_, &[6, 0xE0], &while_, &[6, 0x65], &short]
                .concat(),
        ),
        (
            "late-twice-corrupt",
            [&multiplexed[..], &[6, 0xE5], &while_, &[6, 0xEB], &short, &[6, 0xE6], &while_].concat(),
        ),
        (
            "commands",
            [&three[..], &[9, 0x09], &while_, &[9, 0x3A], &while_, &[9, 0x38], &while_, &[9, 0x14], &while_]
                .concat(),
        ),
        (
            "resets",
            [&asynchronous[..], &[9, 0x0D], &short, &[9, 0x16], &while_, &[9, 0x3F], &while_].concat(),
        ),
        (
            "strangers",
            [
                &three[..],
                &[10, 0x00],
                &while_,
                &[10, 0x15],
                &[10, 0x28],
                &[10, 0x0D],
                &[10, 0xC3],
                &short,
                &[10, 0x36],
            ]
            .concat(),
        ),
        (
            "objects",
            [&three[..], &[11, 0x09], &long, &[11, 0xF9], &while_, &[11, 0x01], &long, &[11, 0x06], &while_]
                .concat(),
        ),
    ];
    scripts.into_iter().map(|(name, bytes)| (name.into(), bytes)).collect()
}

/// Frames of the recorded start by their numbers, and exchanges: a byte of time (0x41 is 1 ms), a head with the number, nodes, an argument.
pub(super) fn pl_monitor() -> Seeds {
    let recorded = controlled_node::recording();
    let of = |numbers: &[usize]| {
        let frames =
            numbers.iter().map(|&number| (Duration::from_millis(number as u64), &*recorded[number - 1]));
        session_bytes(frames)
    };
    let does = |items: &[[u8; 2]]| -> Vec<u8> {
        items.iter().flat_map(|&[number, argument]| [0x41, 0x80 | number, 0, argument]).collect()
    };
    let cycle: Vec<[u8; 2]> = (1..9).flat_map(|count| [[1, count], [8, 0x20], [9, 0x23], [2, 3]]).collect();
    let unread = |head: u8, bytes: &[u8]| [&[0x41, head, bytes.len() as u8][..], bytes].concat();
    [
        ("recorded-ident", of(&[1, 12, 112, 113])),
        ("recorded-cycle", of(&[489, 491, 512, 513, 515, 518])),
        ("cycle", does(&cycle)),
        ("losses", does(&[[1, 1], [8, 0], [1, 2], [9, 1], [1, 5], [3, 0], [11, 1], [3, 0], [2, 0], [11, 1]])),
        (
            "states",
            does(&[[11, 0], [9, 1], [14, 4], [9, 2], [14, 1], [9, 3], [14, 8], [9, 0], [9, 6], [9, 7]]),
        ),
        (
            "handshake",
            does(&[[4, 0x10], [12, 0], [4, 0x10], [12, 0], [4, 0], [12, 0x08], [4, 0], [13, 0x6B]]),
        ),
        (
            "sdo",
            does(&[[18, 0], [19, 0], [20, 0x04], [21, 0x04], [20, 0x0D], [21, 0x0C], [26, 0x11], [27, 0x10]]),
        ),
        (
            "sdo-in-parts",
            does(&[[22, 0x04], [24, 0x08], [24, 0x0C], [23, 0x08], [25, 0x0C], [22, 0x20], [24, 0x10]]),
        ),
        (
            "many-connections",
            (0..40_u8).flat_map(|node| [0x41, 0x94, node & 0x0F | node << 3 & 0x80, node]).collect(),
        ),
        ("resets", does(&[[11, 0], [15, 8], [3, 0], [2, 0], [16, 0x0A], [4, 0], [2, 0], [9, 0]])),
        (
            "others",
            does(&[
                [28, 0],
                [28, 0x06],
                [28, 0x7A],
                [29, 3],
                [30, 0],
                [30, 6],
                [31, 100],
                [31, 255],
                [10, 3],
            ]),
        ),
        (
            "clock",
            [
                [0x45, 0x81, 0, 1],
                [0x45, 0x81, 0, 2],
                [0x46, 0xA1, 0, 3],
                [0xFF, 0x81, 0, 4],
                [0xFF, 0xA1, 0, 5],
            ]
            .concat(),
        ),
        (
            "cut-tagged-and-astray",
            [
                [0x41, 0x88, 0x40, 0xF8],
                [0x41, 0x89, 0x60, 0xFB],
                [0x41, 0x81, 0x20, 1],
                [0x41, 0x83, 0x90, 0],
            ]
            .concat(),
        ),
        (
            "malformed",
            [
                &unread(0x40, &[]),
                &unread(0x40, &[0x01, 0x11, 0x1E, 0, 0, 1, 2, 0, 0, 0, 0, 1, 0x88, 0xAB, 0x01]),
                &unread(0x50, &[0x01, 0x11, 0x1E, 0, 0, 4, 2, 0, 0, 0, 0, 1, 0x88, 0xAB, 0x06, 1, 240])[..],
                &[0x41, 0x8C, 0, 0, 0x41, 0xC0, 17, 0x01],
            ]
            .concat(),
        ),
    ]
    .map(|(name, bytes)| (name.to_owned(), bytes))
    .to_vec()
}
