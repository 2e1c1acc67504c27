//! What happens to a bus and to networks, by hand.

use devicenet_fuzz::input::frame_bytes;
use link_core::Frame;
use link_core::frame::standard_id;

use super::Seeds;

/// Header of three bytes and two for each node, then items of a distance, a head, and a frame or an argument.
pub(super) fn bus_paths() -> Seeds {
    let frame = |distance: u8, node: u8, id: u16, data: &[u8]| {
        let frame = Frame::new(standard_id(id), data).unwrap();
        [&[distance, node][..], &frame_bytes(&frame)].concat()
    };
    let change = |distance: u8, which: u8, argument: u8| vec![distance, 0x80 | which, argument];
    let workload = |bus: u8, nodes: &[[u8; 2]], items: &[Vec<u8>]| {
        [&[1, bus, 120][..], &nodes.concat(), &items.concat()].concat()
    };
    let plain = [[0x02, 0]; 4];
    let traffic = [
        frame(8, 0, 0x100, &[1, 2, 3]),
        frame(0, 1, 0x101, &[0xFF; 8]),
        frame(0, 2, 0x0FF, &[]),
        frame(60, 3, 0x100, &[9]),
    ];
    let with = |change: Vec<u8>| {
        let (first, second) = traffic.split_at(2);
        workload(0x13, &plain, &[first, &[change], second].concat())
    };
    [
        ("uncontended", workload(0x13, &plain, &[frame(8, 0, 0x100, &[1]), frame(60, 1, 0x200, &[2])])),
        ("contended", workload(0x13, &plain, &traffic)),
        ("same-frame-twice", workload(0x12, &plain[..3], &[frame(8, 0, 7, &[7]), frame(0, 1, 7, &[7])])),
        ("same-identifier", workload(0x12, &plain[..3], &[frame(8, 0, 7, &[7]), frame(0, 1, 7, &[8])])),
        ("lone", workload(0x00, &plain[..1], &[frame(8, 0, 0x52F, &[0; 7])])),
        ("given-up", workload(0x13, &plain, &[frame(8, 0, 7, &[7]), vec![0, 0x09, 5, 1, 8, 0]])),
        ("listen-only", workload(0x11, &[[0x01, 0], [0, 0]], &[frame(8, 1, 7, &[7])])),
        ("late-power", workload(0x11, &[[0x00, 0], [0x80, 40]], &[frame(8, 0, 7, &[7])])),
        ("wrong-bit-rate", workload(0x12, &[[0, 0], [0, 0], [0x10, 1]], &traffic)),
        ("slow-clock", workload(0x12, &[[0, 0], [0x0C, 0], [0x08, 0]], &traffic)),
        ("filter-and-reaction", workload(0x12, &[[0x20, 0], [0x40, 0], [0, 0]], &traffic)),
        ("cut", with(change(4, 0, 0))),
        ("power-cycle", with(change(4, 4, 0))),
        ("bit-flips", with(change(0, 8, 40))),
        ("flipped-bit", with(change(0, 9, 60))),
        ("bursts", with(change(0, 10, 0x42))),
        ("babble", with(change(0, 11, 0x80))),
        ("spoilt-end", with(change(0, 12, 0))),
        ("overrun", with(change(0, 13, 1))),
        ("split", with(change(4, 15, 0))),
    ]
    .map(|(name, bytes)| (name.to_owned(), bytes))
    .to_vec()
}

/// What the network is like, then operations: it runs for 5 s, and something happens to it.
pub(super) fn net_dn() -> Seeds {
    let runs = [0, 0xC5];
    // The tool, and the second and the third slave, which may be given MAC ID 13.
    let (claim, who, release) = ([0xF0, 0], [0xF0, 2], [0xF0, 7]);
    let change = |slave: u8| [0xF0, 5 | slave << 3 | 3 << 5];
    let scripts: [(&str, Vec<u8>); 17] = [
        ("two-masters", [&[2][..], &runs, &[5, 7], &[5, 0x87], &runs, &[6, 9], &runs].concat()),
        ("twin", [&[0][..], &runs, &runs].concat()),
        ("master-restarts", [&[2][..], &runs, &[5, 7], &runs, &[3, 0], &runs, &[3, 1], &runs].concat()),
        ("slave-restarts", [&[2][..], &runs, &[3, 2], &runs, &[3, 4], &runs].concat()),
        ("deaf", [&[2][..], &runs, &[4, 0xFA], &runs, &[4, 0x3B], &runs, &[4, 0xF8], &runs].concat()),
        ("strangers", [&[2][..], &runs, &[7, 0], &[7, 2], &[7, 4], &[7, 6], &[7, 14], &runs].concat()),
        ("told-off", [&[2][..], &runs, &[7, 8], &runs, &[3, 2], &runs].concat()),
        ("ucmm", [&[0x13][..], &runs, &[5, 7], &[5, 0x87], &runs, &[3, 5], &runs].concat()),
        // Two nodes at 12 that missed each other's checks, each with a master.
        (
            "twins-on-line",
            vec![
                0x32, 0, 0xC3, 0, 0x84, 4, 0xC5, 4, 0x96, 3, 5, 5, 0x7C, 3, 5, 0, 0xC2, 0, 0xC2, 0, 0x84,
                0xF0, 0x4B,
            ],
        ),
        ("ucmm-alone", [&[0x53][..], &runs, &[3, 0], &runs, &[4, 0xFD], &runs].concat()),
        (
            "ucmm-strangers",
            [&[0x53][..], &runs, &[7, 16], &[7, 18], &[7, 17], &[7, 20], &[7, 21], &[7, 22], &runs].concat(),
        ),
        ("tool-repairs", [&[0x10][..], &runs, &claim, &runs, &who, &runs, &change(2), &runs].concat()),
        (
            "tool-gives-a-taken-one",
            [&[0x11][..], &runs, &claim, &runs, &[0xF0, 5 | 2 << 3], &runs, &change(2), &runs].concat(),
        ),
        (
            "two-tools",
            [&[0x10][..], &runs, &claim, &[7, 26], &runs, &[7, 28], &change(2), &claim, &runs, &release]
                .concat(),
        ),
        ("bus-off-and-back", [&[0x33][..], &runs, &[0xF8, 0], &[0xF8, 2], &runs, &[0xF8, 5], &runs].concat()),
        ("bus-off-for-good", [&[0x13][..], &runs, &[0xF8, 0], &[0xF8, 2], &runs, &[3, 2], &runs].concat()),
        (
            "bus-off-while-checking",
            [&[0x33][..], &[0, 0x41], &[0xF8, 3], &[0, 0x82], &[0xF8, 6], &runs, &[3, 3], &runs].concat(),
        ),
    ];
    scripts.map(|(name, bytes)| (name.to_owned(), bytes)).to_vec()
}

/// What the network is like, then operations: it runs for 12 s, twice until all have connections, and something happens to it.
pub(super) fn net_nx() -> Seeds {
    let runs = [0, 0xCC];
    let runs_twice = [0, 0xCC, 0, 0xCC];
    // To which node the stranger speaks: 5, 67, 109, the manager; and what.
    let says = |what: u8, to: u8| [11, what << 2 | to];
    let (in_step, second, lower, stagger) = (2, 6, 0x0E, 0x82);
    let scripts: [(&str, Vec<u8>); 16] = [
        ("data", [&[in_step][..], &runs_twice, &[10, 7], &runs].concat()),
        ("one-after-the-other", [&[stagger][..], &runs_twice, &runs, &[10, 7], &runs].concat()),
        (
            "spare-takes-over",
            [&[0][..], &runs_twice, &[9, 1], &runs, &[10, 9], &runs, &[9, 1], &runs].concat(),
        ),
        (
            "both-managers",
            [&[second][..], &runs_twice, &[3, 0x80], &runs_twice, &runs, &[3, 0xC0], &runs].concat(),
        ),
        ("lower-manager", [&[lower][..], &runs_twice, &[3, 0], &runs_twice].concat()),
        ("segments", [&[second][..], &[8, 0x12], &runs_twice, &[8, 0], &runs_twice].concat()),
        ("one-address-twice", [&[0x22][..], &[8, 0x42], &runs_twice, &[8, 0], &runs_twice].concat()),
        ("uninvited", [&[0x12][..], &runs_twice, &[3, 6], &runs].concat()),
        ("uninvited-consumer", [&[0x32][..], &[3, 0xC6], &runs_twice].concat()),
        (
            "without-a-connection",
            [&[1][..], &runs_twice, &says(1, 1), &says(2, 0), &says(3, 2), &says(0, 1), &[0, 0xC1]].concat(),
        ),
        (
            "readdressed",
            [&[in_step][..], &runs_twice, &says(4, 2), &[0, 0x41], &says(5, 2), &runs, &says(15, 1), &runs]
                .concat(),
        ),
        ("its-connections", [&[in_step][..], &runs_twice, &says(7, 0), &says(8, 0), &runs].concat()),
        ("contested", [&[in_step][..], &runs_twice, &says(9, 1), &runs, &says(10, 0), &runs].concat()),
        ("gives-addresses", [&[in_step][..], &runs_twice, &says(11, 1), &says(27, 2), &runs].concat()),
        ("another-manager-asks", [&[second][..], &runs_twice, &says(12, 0), &runs_twice, &runs].concat()),
        (
            "faults",
            [
                &[0x42][..],
                &runs_twice,
                &[4, 0x19, 5, 0x3A, 0, 0x82, 6, 0x88, 0, 0x82, 6, 0xC1, 0, 0x82, 7, 0],
                &runs,
            ]
            .concat(),
        ),
    ];
    scripts.map(|(name, bytes)| (name.to_owned(), bytes)).to_vec()
}
