//! Frames and messages as they stand in manuals and captures, and exchanges put together by number.

use devicenet_fuzz::input::frame_bytes;
use devicenet_fuzz::monitor::session_bytes;
use link_core::frame::{extended_id, standard_id};
use link_core::{Frame, Instant};

use super::{Seeds, capture};

/// Data fields and messages as they stand in manuals and captures, which [`VECTORS`] has as frames; and what only
/// other layers carry.
pub(super) fn wire() -> Seeds {
    let fields = VECTORS.iter().map(|&(name, _, data)| (name, data));
    // After the header byte stands what CIP knows.
    let bodies =
        VECTORS.iter().filter(|(_, _, data)| data.len() > 2).map(|&(name, _, data)| (name, &data[1..]));
    let other: [(&str, &[u8]); 8] = [
        // CIP Vol. 1, appendix C: class, instance, attribute.
        ("path-packed", &[0x20, 0x04, 0x24, 0x65, 0x30, 0x03]),
        ("path-padded-wide", &[0x21, 0x00, 0x00, 0x03, 0x25, 0x00, 0x01, 0x01]),
        ("path-key", &[0x34, 0x04, 0x34, 0x12, 0x0C, 0x00, 0x01, 0x00, 0x81, 0x02]),
        ("path-symbol-port", b"\x91\x05motor\x00\x12\x03\x01\x02\x03\x80\x01\xAA\xBB"),
        ("multiple-service-packet", &[2, 0, 6, 0, 8, 0, 0x8E, 0x01, 0x8E, 0x02, 0x03]),
        ("attribute-list", &[3, 0, 1, 0, 2, 0, 7, 0]),
        (
            "identity-all",
            b"\x34\x12\x0C\x00\x01\x00\x01\x02\x00\x00\x45\x23\x00\x00\x05valve\x03\x00\x00\x0A",
        ),
        ("frame-extended-long-runs", &[0x28, 0xFF, 0xFF, 0xFF, 0x1F, 0, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF]),
    ];
    let bodies = bodies.map(|(name, body)| (format!("body-{name}"), body.to_vec()));
    let rest = fields.chain(other).map(|(name, bytes)| (name.to_owned(), bytes.to_vec()));
    bodies.chain(rest).collect()
}

pub(super) fn frame_decode() -> Seeds {
    let other = [
        ("remote", Frame::remote(standard_id(0x3C5), 3)),
        ("extended", Frame::new(extended_id(0x1234_5678), &[1, 2])),
        ("dlc-15", Frame::with_dlc(standard_id(0x44C), 15, [0x0A, 0x10, 5, 4, 9, 0x0A, 0x0E, 0])),
        ("invalid-identifier", Frame::new(standard_id(0x7F3), &[])),
        ("reserved-identifier", Frame::new(standard_id(0x7C0), &[1])),
        ("heartbeat", Frame::new(standard_id(0x74A), &[0x0A, 0xCD, 1, 0, 3, 0, 0, 0])),
    ];
    let vectors = VECTORS.iter().map(|&(name, id, data)| (name, Frame::new(standard_id(id), data)));
    vectors.chain(other).map(|(name, frame)| (name.to_owned(), frame_bytes(&frame.unwrap()))).collect()
}

/// A recording by hand, and exchanges put together by number: each, and its answer after it.
pub(super) fn nx_monitor() -> Seeds {
    let recording = capture("../../cli/tests/decode/nex.log");
    let item = |number: u8, argument: u8| [0x41, 0x80 | number, 0x10, argument];
    let exchanges = |numbers: &[u8]| numbers.iter().flat_map(|&number| item(number, 0)).collect::<Vec<_>>();
    [
        ("recording", session_bytes(recording)),
        ("address", exchanges(&[0, 0, 29, 0, 3, 1, 1, 1, 2])),
        ("connections", exchanges(&[4, 5, 20, 22, 20, 23, 13, 16, 14, 15, 20])),
        ("fragments", exchanges(&[9, 11, 12, 11, 17, 18, 19, 21, 21])),
    ]
    .into_iter()
    .map(|(name, session)| (name.to_owned(), [&[2][..], &session].concat()))
    .collect()
}

/// Captures from their beginnings, and exchanges put together by number.
pub(super) fn monitor() -> Seeds {
    let mut seeds: Seeds = [
        "bei-mhk5-cos.log",
        "icpdas-can8124-poll.log",
        "icpdas-i7242d-cyclic.log",
        "inficon-get-set-assembly-path.log",
        "mks-baratron-explicit.log",
        "session-two-slaves-on-vcan.log",
        "slave-01-startup-poll.log",
        "slave-04-fragmented-response.log",
    ]
    .into_iter()
    .map(|name| {
        let frames = capture(name).take(40);
        (name.trim_end_matches(".log").to_owned(), [&[0][..], &session_bytes(frames)].concat())
    })
    .collect();
    let vectors = VECTORS.iter().enumerate().map(|(index, &(_, id, data))| {
        (Instant::from_millis(index as u64), Frame::new(standard_id(id), data).unwrap())
    });
    seeds.push(("vectors".to_owned(), [&[2 | 13 << 2][..], &session_bytes(vectors)].concat()));
    // Span, number of the exchange with bit 7, nodes, argument.
    let scripts: [(&str, &[[u8; 4]]); 5] = [
        (
            "ucmm-open-get-close",
            &[
                [0x41, 0x80 | 27, 0, 0x02],
                [0x41, 0x80 | 28, 0, 0x02],
                [0x41, 0x80 | 31, 0, 0x01],
                [0x41, 0x80 | 32, 0, 0x01],
                [0x41, 0x80 | 29, 0, 0x02],
                [0x41, 0x80 | 30, 0, 0x00],
            ],
        ),
        (
            "fragmented-poll",
            &[
                [0x41, 0x80 | 1, 0x10, 0x03],
                [0x41, 0x80 | 2, 0x10, 0x00],
                [0x41, 0x80 | 15, 0x10, 0x00],
                [0x41, 0x80 | 15, 0x10, 0x01],
                [0x41, 0x80 | 15, 0x10, 0x82],
                [0x41, 0x80 | 16, 0x10, 0x00],
                [0x41, 0x80 | 16, 0x10, 0x81],
            ],
        ),
        (
            "fragments-after-a-silence",
            &[[0x41, 0x80 | 24, 0x10, 0x00], [0xC4, 0x80 | 24, 0x10, 0x01], [0x41, 0x80 | 24, 0x10, 0x82]],
        ),
        (
            "repeated-and-changed",
            &[
                [0x41, 0x80 | 6, 0x10, 0x07],
                [0x41, 0x80 | 8, 0x10, 0x34],
                [0x41, 0xC1, 0x00, 0x40],
                [0x41, 0xC1, 0x09, 0x00],
                [0xC1, 0xC0, 0x01, 0x80],
            ],
        ),
        (
            "offline-set",
            &[
                [0x41, 0x80 | 40, 0, 0x01],
                [0x41, 0x80 | 41, 0, 0x01],
                [0x41, 0x80 | 37, 0, 0x3F],
                [0x41, 0x80 | 38, 0, 0x01],
                [0x41, 0x80 | 39, 0, 0x0B],
            ],
        ),
    ];
    seeds.extend(scripts.map(|(name, items)| (name.to_owned(), [&[0][..], &items.concat()].concat())));
    seeds
}

/// Frames from manuals, captures and fixtures: name, identifier, data field.
pub(super) const VECTORS: &[(&str, u16, &[u8])] = &[
    // ICP DAS CAN-8124/8224/8424 User Manual v2.0, p. 112 and 113.
    ("allocate", 0x44E, &[0x0A, 0x4B, 0x03, 0x01, 0x07, 0x0A]),
    ("set-epr-response", 0x44B, &[0x0A, 0x90, 0x10, 0x0E]),
    // ICP DAS I-7242D User Manual v1.1, p. 83, 93 and 95.
    ("set-epr", 0x44C, &[0x0A, 0x10, 0x05, 0x04, 0x09, 0x0A, 0x0E]),
    ("who-request", 0x7ED, &[0x3F, 0x4B, 0x02]),
    ("poll-last-fragment", 0x44D, &[0x81, 0x08, 0x09, 0x0A]),
    // BEI Ideacod/POSITAL MHK5 UME-OCD-D2, p. 10 and 15.
    ("release-with-bit-6", 0x41E, &[0x0A, 0x4C, 0x03, 0x01, 0x51]),
    ("fragment-acknowledge", 0x41B, &[0x8A, 0xC1, 0x00]),
    // Rockwell 1760-UM003A-EN-P, p. 4-11.
    ("first-fragment", 0x41C, &[0x80, 0x00, 0x32, 0x64, 0x01, 0x93, 0x05, 0x00]),
    // Konvolucio.DeviceNet unit-test logs (Omron GRT1-DRT).
    ("product-name-last-fragment", 0x413, &[0x80, 0x81, 0x2D, 0x44, 0x52, 0x54]),
    // Jasic NBM-500R DeviceNet protocol V100, section 3.
    ("dup-mac-request", 0x40F, &[0x00, 0x08, 0x00, 0x06, 0xF5, 0x89, 0x12]),
    ("poll-first-fragment", 0x3C2, &[0x00, 0x40, 0x00, 0x00, 0x08, 0x00, 0x00, 0x00]),
    // IAI controller capture in a public ROS DeviceNet master.
    ("ucmm-open", 0x780, &[0x3F, 0x4B, 0x02, 0x34]),
    ("get-vendor-16-16", 0x700, &[0x3F, 0x0E, 0x01, 0x00, 0x01, 0x00, 0x01]),
    ("ucmm-close-response", 0x77F, &[0x00, 0xCC]),
    // Tests of AnlangA/devicenet-identifier-analyzer.
    ("ownership-request", 0x7EF, &[0x01, 0x4B, 0x06, 0x00, 0x08, 0x07, 0x06, 0x05]),
    ("change-mac-id", 0x7ED, &[0x03, 0x4D, 0x06, 0x00, 0x08, 0x07, 0x06, 0x05]),
    ("who-response", 0x7EC, &[0x00, 0x06, 0x00, 0x08, 0x07, 0x06, 0x05]),
    ("shutdown", 0x41B, &[0x03, 0xCE, 0x04, 0x00, 0x02, 0x00, 0x01, 0x02]),
    ("error-response", 0x41B, &[0x0A, 0x94, 0x02, 0x03]),
    ("ucmm-close", 0x780, &[0x05, 0x4C, 0x02, 0x00]),
];
