//! Networks of POWERLINK, by hand.

use super::Seeds;

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
