//! Scripts for a DeviceNeX device, operation by operation.

use super::Seeds;

/// Each begins on line with OA 67, but those that say otherwise; node 0 is the manager, OA 1.
pub(super) fn nx_node() -> Seeds {
    let short = [2, 1, 0];
    let long = [16, 10, 0];
    let scripts: Vec<(&str, [u8; 3], Vec<u8>)> = vec![
        (
            "polled",
            short,
            join(&[&EXPLICIT, &SENT, &connect(3, 100, 0), &SENT, &implicit(1, &[0xA5]), &SENT]),
        ),
        (
            "polled-times-out",
            short,
            join(&[
                &connect(3, 100, 0),
                &SENT,
                &implicit(0, &[1]),
                &SENT,
                &AT_DEADLINE,
                &connect(3, 100, 1),
                &SENT,
                &AT_DEADLINE,
                &connect(3, 100, 2),
                &AT_DEADLINE,
            ]),
        ),
        (
            "the-producer-of-the-paper",
            short,
            join(&[&connect(7, 500, 0), &SENT, &SENT, &AT_DEADLINE, &SENT, &[12, 7], &SENT, &AT_DEADLINE]),
        ),
        (
            "the-consumer-of-the-paper",
            short,
            join(&[
                &EXPLICIT,
                &SENT,
                &connect(13, 0, 0),
                &SENT,
                // Attribute 5: what OA 2 produces on instance 7.
                &[6, 0, 0x45],
                &SENT,
                &implicit(1, &[0x55]),
                &[0, 0xFF],
                &implicit(1, &[0x56]),
            ]),
        ),
        (
            "change-of-state",
            short,
            join(&[
                &connect(9, 100, 0),
                &SENT,
                &SENT,
                &AT_DEADLINE,
                &SENT,
                &implicit(0, &[]),
                &[12, 9],
                &SENT,
                &AT_DEADLINE,
            ]),
        ),
        (
            "cyclic-11-bits",
            short,
            join(&[&connect(10, 50, 0), &SENT, &SENT, &AT_DEADLINE, &SENT, &AT_DEADLINE]),
        ),
        ("without-acknowledges", [2, 1, 1], join(&[&connect(9, 100, 0), &SENT, &SENT, &AT_DEADLINE, &SENT])),
        (
            "dynamic",
            short,
            join(&[
                &EXPLICIT,
                &SENT,
                &[5, 0, 14, 0x40],
                &SENT,
                // Attribute 3, the rate.
                &[6, 0, 0x54, 0x92],
                &SENT,
                &[6, 0, 0x50, 100, 0],
                &SENT,
                &implicit(1, &[3]),
                &SENT,
                &AT_DEADLINE,
            ]),
        ),
        ("nobody-configures", short, join(&[&[5, 0, 14, 0x40], &SENT, &AT_DEADLINE])),
        (
            "long-messages",
            long,
            join(&[
                &connect(3, 0, 0),
                &SENT,
                &implicit(0, &[0x00, 1, 2, 3, 4, 5, 6, 7]),
                &implicit(0, &[0x81, 8, 9, 10]),
                &SENT,
                &SENT,
                &SENT,
            ]),
        ),
        (
            "a-response-in-fragments",
            short,
            join(&[&EXPLICIT, &SENT, &NAME, &SENT, &[8, 0, 0, 0], &SENT, &AT_DEADLINE, &SENT, &AT_DEADLINE]),
        ),
        (
            "a-request-in-fragments",
            short,
            join(&[&EXPLICIT, &SENT, &[15, 0, 0x0B, 12, 0x10, 5, 1, 14, 0x20, 4, 0x24, 1, 0x30, 3, 0, 0]]),
        ),
        (
            "connectionless",
            short,
            join(&[
                &[13, 0, 0x06, 1],
                &SENT,
                &[13, 5, 0x89],
                &SENT,
                &[0x88, 5, 0, 0],
                &SENT,
                &[13, 0, 0x07, 1, 1, 5],
            ]),
        ),
        (
            "from-nobody",
            short,
            join(&[&[5, 6, 7, 0, 0, 0], &[13, 6, 6, 1], &[5, 7, 7, 0, 0, 0], &[13, 7, 6, 1]]),
        ),
        (
            "another-address",
            short,
            join(&[
                &EXPLICIT,
                &SENT,
                &connect(13, 0, 0),
                &SENT,
                &[6, 0, 0x07, 1, 1, 68],
                &SENT,
                &SENT,
                &AT_DEADLINE,
                &SENT,
                &AT_DEADLINE,
            ]),
        ),
        ("reset", short, join(&[&EXPLICIT, &SENT, &[6, 0, 0x0A, 0], &SENT, &[0x4E, 1], &[0x4E, 1], &SENT])),
        (
            "the-address-is-taken",
            short,
            join(&[&connect(7, 10, 0), &[0x8E, 9], &SENT, &SENT, &AT_DEADLINE, &SENT]),
        ),
        (
            "bus-off-and-back",
            [2, 1, 0x20],
            join(&[&connect(7, 10, 0), &[11, 3], &SENT, &SENT, &AT_DEADLINE, &[0x4E, 1], &[0x4E, 1], &SENT]),
        ),
        (
            "from-power-up",
            [2, 1, 0x40],
            join(&[
                &[11, 0],
                &[0x4E, 1],
                &[0x4E, 1],
                &SENT,
                &AT_DEADLINE,
                &SENT,
                &AT_DEADLINE,
                &[0x2E, 67],
                &SENT,
            ]),
        ),
        ("no-bit-rate", [2, 1, 0x80], join(&[&[11, 0], &[0x4E, 1], &[0x2E, 67], &connect(7, 0, 0)])),
        (
            "the-other-kind",
            short,
            join(&[
                &EXPLICIT,
                &SENT,
                &[5, 0, 14, 0x40],
                &SENT,
                &[5, 0, 15, 0x51, 0, 0, 1],
                &SENT,
                &[5, 0, 15, 0x40, 0, 0, 0],
            ]),
        ),
    ];
    let seed =
        |(name, config, script): (&str, [u8; 3], Vec<u8>)| (name.to_owned(), [&config[..], &script].concat());
    scripts.into_iter().map(seed).collect()
}

fn join(ops: &[&[u8]]) -> Vec<u8> {
    ops.concat()
}

/// A predefined connection, Message ID 0.
fn connect(instance: u8, rate: u16, action: u8) -> [u8; 6] {
    let [low, high] = rate.to_le_bytes();
    [5, 0, instance, low, high, action]
}

/// A message as a connection consumes it, counted from 0.
fn implicit(which: u8, data: &[u8]) -> Vec<u8> {
    [&[9, which, data.len() as u8], data].concat()
}

/// Explicit connection 1, EPR 0, action 1; its places are before those of later ones.
const EXPLICIT: [u8; 6] = [5, 0, 1, 0, 0, 1];
/// The product name.
const NAME: [u8; 3] = [6, 0, 0x89];
const SENT: [u8; 1] = [10];
const AT_DEADLINE: [u8; 1] = [3];
