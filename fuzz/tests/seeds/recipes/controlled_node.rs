//! Frames of the recorded start of openPOWERLINK's controlled node, and scripts for ours.

use std::fs::File;

use pcap_file::pcap::PcapReader;

use super::Seeds;

/// Frames of the recording by their numbers, and frames that were made to be refused.
pub(super) fn pl_wire() -> Seeds {
    let recorded = recording();
    let named = [
        ("soa-ident-request", 112),
        ("nmt-reset-node", 12),
        ("ident-response", 113),
        ("soc", 491),
        ("preq", 512),
        ("pres", 513),
        ("nmt-enable-ready-to-operate", 515),
        ("soa", 1),
    ];
    let frames = named.map(|(name, number)| (name.to_owned(), recorded[number - 1].clone()));
    let by_kind = [("status-response", 0x02), ("sdo-write", 0x05)].map(|(name, service)| {
        let is_it = |frame: &&Vec<u8>| frame[14] == 0x06 && frame[17] == service && frame[25] <= 1;
        let longest = recorded.iter().filter(is_it).max_by_key(|frame| frame[26]);
        (name.to_owned(), longest.expect("one of that service").clone())
    });
    let made = [
        ("preq-cut-in-size", hex("0200000000010200000000f088ab0301f0000100000001")),
        ("soa-cut-behind-the-target", hex("01111e0000030200000000f088ab05fff01d00000101")),
        ("reserved-bits", hex("01111e0000030200000000f088ab85fff01d00ff0101200100")),
        ("nmt-command-with-a-list", hex("41000400")),
        ("sdo-first-segment", hex("020600000005100114000000640000000020000001020304050607080900")),
        ("error-entries", hex("100000fd00000001000000000000000230458201000000020000000300000000000000")),
    ];
    frames.into_iter().chain(by_kind).chain(made.map(|(name, bytes)| (name.to_owned(), bytes))).collect()
}

/// Three bytes of configuration, then operations: 0 span tick, 1 the next deadline, 2 SoC, 4 SoA, 5 command, 7 SDO, 12 cycles, 13
/// the start.
pub(super) fn pl_cn() -> Seeds {
    const PLAIN: [u8; 3] = [0, 0, 0];
    const OPERATIONAL: u8 = 0x3D;
    const PRE_OPERATIONAL_1: u8 = 0x0D;
    const STATUS: u8 = 0x24;
    const IDENT: u8 = 0x14;
    const INVITE: u8 = 0x64;
    const INVITE_NMT: u8 = 0x34;
    let with = |config: [u8; 3], ops: &[&[u8]]| [&config[..], &ops.concat()].concat();
    let command = |whom: u8, command: u8| [0x05 | whom << 4, command];
    // The opening, and an invitation for each answer.
    let open: &[u8] = &[0x07, INVITE, 0, INVITE, 0];
    let write =
        |object: u8, value: &[u8]| [&[0x27, 2, object, value.len() as u8], value, &[INVITE, 0]].concat();
    let read = |object: u8| vec![0x27, 0, object, INVITE, 0];
    let lost_socs: &[u8] = &[0x04, 0, 0x03, 1, 0, 0, 0, 0x94].repeat(3);
    let recorded = recording();
    let of_mn = |numbers: &[usize]| -> Vec<u8> {
        let frames = numbers.iter().map(|&number| &recorded[number - 1]);
        frames.flat_map(|frame| [&[0x0F, frame.len() as u8][..], frame].concat()).collect()
    };
    [
        ("start", with(PLAIN, &[&[OPERATIONAL, 0xFC]])),
        ("recorded", with(PLAIN, &[&of_mn(&[1, 112, 12, 1, 491, 512, 515, 545])])),
        ("silence", with(PLAIN, &[&[0x00, 0xC4, 1, 0x07, 0x04, 0, OPERATIONAL, 1, 1, 1, 2]])),
        ("lost-socs", with(PLAIN, &[&[OPERATIONAL], lost_socs, &[0x02]])),
        ("lost-preqs", with(PLAIN, &[&[OPERATIONAL], &[0x02, 0x04, 0, 0x00, 0x54].repeat(3)])),
        ("lost-soas", with([0x08, 0, 0], &[&[OPERATIONAL], &[0x02, 0x03, 1, 0, 0].repeat(4)])),
        ("invalid-format", with(PLAIN, &[&[OPERATIONAL, 0x02, 0x83, 1, 0, 0, OPERATIONAL]])),
        (
            "commands",
            with(
                PLAIN,
                &[&[OPERATIONAL], &command(0, 1), &[0xFC], &command(1, 2), &command(3, 0x63), &command(0, 5)],
            ),
        ),
        (
            "errors-and-how-they-are-told",
            with(
                PLAIN,
                &[&[OPERATIONAL, 0x0A, 2, 0x0A, 2, 0x0A, 2, 0x0C, STATUS, 0, 0x0C, 0x0E, 0x0C, 0x0E]],
            ),
        ),
        ("answer-first", with([0x40, 0xE0, 0], &[&[PRE_OPERATIONAL_1, STATUS, 2, STATUS, 0, STATUS, 0]])),
        (
            "sdo",
            with(
                PLAIN,
                &[
                    &[PRE_OPERATIONAL_1, IDENT, 0],
                    open,
                    &write(0, &50_000_u32.to_le_bytes()),
                    &read(3),
                    &write(23, &[0x5A]),
                    &[0x47, INVITE, 0, 0x67],
                ],
            ),
        ),
        ("sdo-reset", with(PLAIN, &[&[PRE_OPERATIONAL_1], open, &write(21, &[0x28]), &[OPERATIONAL]])),
        (
            "sdo-segments",
            with(
                [0, 4, 0],
                &[
                    &[PRE_OPERATIONAL_1],
                    open,
                    &[0x27, 6, 22, 8, 4, 1, 2, 3, 4, 0x27, 0x34, 4, 5, 6, 7, 8, INVITE, 0],
                    &read(22),
                ],
            ),
        ),
        (
            "sdo-times-out",
            with([0, 0, 0x10], &[&[PRE_OPERATIONAL_1], open, &[0x27, 0, 3, INVITE, 0, 1, INVITE, 0, 1, 1]]),
        ),
        ("sdo-without-a-managing-node", with(PLAIN, &[&[0x01], &[0x87, 0xA7, 0, 3, 0x07, 0x27, 0, 3, 0x02]])),
        (
            "mapping",
            with(
                [0, 0, 1],
                &[
                    &[PRE_OPERATIONAL_1],
                    open,
                    &write(8, &[0]),
                    &write(9, &[0x00, 0x62, 1, 0, 0, 0, 8, 0]),
                    &write(8, &[1]),
                    &[OPERATIONAL, 0x0C],
                ],
            ),
        ),
        (
            "values-out-of-range-and-unreadable",
            with(
                PLAIN,
                &[
                    &[OPERATIONAL, 0x02, 0x03, 1, 0, 5, 9, 0xFF, 0xFF, 0xFF, 0xFF, 0x04, 0],
                    &[0x0B, 0xFA, 0x0C, 0x0B, 0x1A, 0x0C],
                ],
            ),
        ),
        (
            "cycle-of-another-node",
            with(
                PLAIN,
                &[
                    &[OPERATIONAL, 0x32, 0x02, 0x39, 9, 0x05, 0xFF, 2, 0xFD, 0, 0, 0x01, 1, 0x20],
                    &[0x04, 0, 0x32, 0x0B, 0x01, 0x32, 0x39, 9, 0x05, 0xFF, 2, 0xFD, 0, 0, 0x01, 1, 0x20],
                ],
            ),
        ),
        ("cross-traffic", with(PLAIN, &[&[OPERATIONAL, 0x02, 0x06, 2, 1, 0, 1, 7]])),
        (
            "multiplexed",
            with([0, 2, 0], &[&[OPERATIONAL, 0x82, 0x04, 0, 0x02, 0x04, 0, 0x02, 0x03, 0x21, 0, 0, 0x82]]),
        ),
        (
            "requests",
            with(
                PLAIN,
                &[&[OPERATIONAL, 0x0B, 0x26, 0x0B, 0x06, 0x0C, INVITE_NMT, 0, INVITE, 0, INVITE_NMT, 0]],
            ),
        ),
        (
            "the-application-takes-its-time",
            with([0, 1, 0], &[&[0x1D], &command(0, 3), &[0x0B, 3, 0x0C, 0x0B, 1]]),
        ),
        ("off-and-on", with(PLAIN, &[&[OPERATIONAL, 0x0B, 2, 0x02, 0x04, 0, 0x0B, 0, OPERATIONAL]])),
    ]
    .map(|(name, bytes)| (name.to_owned(), bytes))
    .to_vec()
}

/// Every frame, as it was recorded.
pub(super) fn recording() -> Vec<Vec<u8>> {
    let path = super::captures().join("powerlink/boot.pcap");
    let mut reader = PcapReader::new(File::open(path).unwrap()).unwrap();
    let mut frames = Vec::new();
    while let Some(packet) = reader.next_packet() {
        frames.push(packet.unwrap().data.into_owned());
    }
    frames
}

fn hex(text: &str) -> Vec<u8> {
    (0..text.len()).step_by(2).map(|at| u8::from_str_radix(&text[at..at + 2], 16).unwrap()).collect()
}
