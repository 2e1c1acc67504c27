//! Scripts for a slave, operation by operation, and rows of fragments.

use super::Seeds;

/// Each begins on line, with MAC ID 10; 0 allocates, polls and asks as master 4.
pub(super) fn dn_slave() -> Seeds {
    let short = [10, 0, 0];
    let long = [10, 0, 0x0F];
    let all = [&allocate(0x03)[..], &SENT, &rate(2, 75), &SENT, &poll(&[0xA5]), &SENT].concat();
    let change =
        |choice: u8| [&allocate(choice)[..], &SENT, &rate(2, 75), &SENT, &rate(4, 75), &SENT, &SENT].concat();
    let all_but_change = [&allocate(0x0F)[..], &SENT, &rate(2, 75), &SENT, &rate(3, 75), &SENT, &rate(5, 75)];
    let scripts: Vec<(&str, [u8; 3], u8, Vec<u8>)> = vec![
        ("poll-and-release", short, 0, [&all[..], &release(3), &SENT, &poll(&[1])].concat()),
        ("poll-times-out", short, 0, [&all[..], &TICK_320_MS, &reset(2), &SENT, &TICK_10_S].concat()),
        (
            "watchdog-actions",
            short,
            0,
            [
                &set(2, 12, &[2])[..],
                &all,
                &set(2, 12, &[2]),
                &SENT,
                &AT_DEADLINE,
                &set(2, 12, &[1]),
                &SENT,
                &AT_DEADLINE,
            ]
            .concat(),
        ),
        (
            "deferred-delete",
            short,
            0,
            [&all[..], &set(1, 12, &[3]), &SENT, &rate(2, 0xFF00), &SENT, &TICK_10_S, &release(2)].concat(),
        ),
        (
            "second-master",
            short,
            0,
            [&all[..], &[5, 5, 0, 0x01, 1], &SENT, &[5, 5, 3, 0x01], &SENT, &TICK_10_S, &[5, 5, 0, 0x01, 1]]
                .concat(),
        ),
        (
            "strobe-and-multicast",
            short,
            0,
            [
                &all_but_change.concat()[..],
                &SENT,
                &[0x19, 0, 8, 0, 4, 0, 0, 0, 0, 0, 0],
                &[0x39, 0, 1, 7],
                &SENT,
                &SENT,
                &[0x19, 0, 0],
            ]
            .concat(),
        ),
        (
            "change-of-state",
            short,
            0,
            [
                &change(0x11)[..],
                &[12, 9],
                &SENT,
                &[0x29, 0, 0],
                &[12, 8],
                &SENT,
                &AT_DEADLINE,
                &SENT,
                &AT_DEADLINE,
            ]
            .concat(),
        ),
        (
            "cyclic-suppressed",
            short,
            0,
            [&change(0x61)[..], &AT_DEADLINE, &SENT, &poll(&[1]), &AT_DEADLINE].concat(),
        ),
        (
            "change-of-state-inhibited",
            short,
            0,
            [&change(0x13)[..], &set(4, 17, &[50, 0]), &SENT, &[12, 9], &SENT, &[12, 8], &AT_DEADLINE, &SENT]
                .concat(),
        ),
        (
            "io-in-fragments",
            long,
            0,
            [
                &all[..],
                &[9, 0, 8, 0x00, 1, 2, 3, 4, 5, 6, 7],
                &[9, 0, 4, 0x81, 8, 9, 10],
                &SENT,
                &SENT,
                &SENT,
            ]
            .concat(),
        ),
        (
            "name-in-fragments",
            short,
            0,
            [
                &all[..],
                &[6, 0, 0x8B],
                &SENT,
                &ACKNOWLEDGE,
                &SENT,
                &AT_DEADLINE,
                &SENT,
                &ACKNOWLEDGE,
                &SENT,
                &AT_DEADLINE,
                &SENT,
                &AT_DEADLINE,
            ]
            .concat(),
        ),
        (
            "request-in-fragments",
            short,
            0,
            [&all[..], &[15, 0, 4, 80, 0], &[7, 0, 0x81, 1, 0], &SENT].concat(),
        ),
        (
            "reset",
            short,
            0,
            [&all[..], &[6, 0, 12, 0], &SENT, &SENT, &TICK_1_S, &SENT, &TICK_1_S, &allocate(1)].concat(),
        ),
        (
            "new-mac-id",
            short,
            0,
            [&all[..], &[6, 0, 9, 1, 1, 20], &SENT, &SENT, &TICK_1_S, &SENT, &TICK_1_S, &allocate(1)]
                .concat(),
        ),
        (
            "bus-off",
            short,
            0,
            [
                &all[..],
                &poll(&[1]),
                &[11, 4],
                &SENT,
                &[11, 0],
                &SENT,
                &TICK_1_S,
                &SENT,
                &TICK_1_S,
                &allocate(1),
            ]
            .concat(),
        ),
        (
            "ucmm-allocates",
            short,
            1,
            [
                &OPEN[..],
                &SENT,
                &[14, 0, 0, 0x02, 0],
                &SENT,
                &[14, 0, 0x24, 75, 0],
                &SENT,
                &poll(&[1]),
                &SENT,
                &[13, 0, 0x4C, 6, 0],
                &SENT,
                &poll(&[1]),
            ]
            .concat(),
        ),
        (
            "ucmm-is-full",
            short,
            1,
            [
                &OPEN[..],
                &[13, 5, 0x4B, 0, 0x10],
                &[13, 6, 0x4B, 0, 0x00],
                &SENT,
                &SENT,
                &SENT,
                &[13, 6, 0x4C, 7, 0],
            ]
            .concat(),
        ),
    ];
    scripts
        .into_iter()
        .map(|(name, config, ucmm, ops)| (name.to_owned(), [&config[..], &[ucmm], &ops].concat()))
        .collect()
}

/// The limit of the receivers, then frames and what else happens.
pub(super) fn fragment() -> Seeds {
    let first = [0x60, 0x00, 1, 2, 3, 4, 5, 6];
    let middle = [0x63, 1, 2, 3, 4, 5, 6];
    let last = [0x93, 7];
    let io = |byte: u8| [0x70, byte, 1, 2, 3, 4, 5, 6, 7];
    let wraps = core::iter::repeat_n([0x03], 66).collect::<Vec<_>>().concat();
    let sixty_four: Vec<u8> =
        (0..=64_u8).flat_map(|count| [0x00, if count == 0 { 0 } else { 0x40 | count }]).collect();
    let scripts: [(&str, Vec<u8>); 9] = [
        ("complete", [&[40][..], &first, &middle, &last].concat()),
        ("multiple-of-six", [&[12][..], &first, &[0xE3, 1, 2, 3, 4, 5, 6]].concat()),
        ("over-the-limit", [&[12][..], &first, &middle, &last].concat()),
        (
            "repeated",
            [&[40][..], &first, &middle, &[0x60, 0x41, 1, 2, 3, 4, 5, 6], &last, &[0x10, 0x82, 7]].concat(),
        ),
        ("count-wraps", [&[40][..], &wraps, &last].concat()),
        ("io", [&[40][..], &io(0x00), &io(0x41), &io(0x82)].concat()),
        ("io-sixty-four", [&[255][..], &sixty_four].concat()),
        ("sent", vec![0, 5, 13, 0, 0x86, 0, 0, 6, 0, 0, 0x86, 0, 0, 0x86, 0, 0]),
        ("given-up", vec![0, 5, 13, 0, 7, 0x86, 0, 0, 7, 7, 5, 8, 0, 0x86, 0, 1]),
    ];
    scripts.map(|(name, bytes)| (name.to_owned(), bytes)).to_vec()
}

fn allocate(choice: u8) -> [u8; 5] {
    [5, 0, 0, choice, 0]
}

fn release(choice: u8) -> [u8; 4] {
    [6, 0, 3, choice]
}

fn rate(instance: u8, millis: u16) -> [u8; 5] {
    let [low, high] = millis.to_le_bytes();
    [6, 0, instance << 4 | 4, low, high]
}

fn set(instance: u8, attribute: u8, value: &[u8]) -> Vec<u8> {
    [&[6, 0, instance << 4 | 5, attribute, value.len() as u8], value].concat()
}

fn reset(instance: u8) -> [u8; 4] {
    [6, 0, instance << 4 | 7, 0]
}

fn poll(data: &[u8]) -> Vec<u8> {
    [&[9, 0, data.len() as u8], data].concat()
}

/// The frame that is in flight for the longest was sent.
const SENT: [u8; 1] = [10];
const ACKNOWLEDGE: [u8; 4] = [0x88, 0, 0, 0];
const AT_DEADLINE: [u8; 1] = [3];
const TICK_320_MS: [u8; 4] = [0, 0x86, 0, 0x54];
const TICK_1_S: [u8; 2] = [0, 0xC1];
const TICK_10_S: [u8; 2] = [0, 0xCA];
/// In 8/8, in group 3, with Message ID 1.
const OPEN: [u8; 5] = [13, 0, 0x4B, 0, 0x31];
