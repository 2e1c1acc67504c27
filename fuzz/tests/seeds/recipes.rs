//! What the seeds are made of: vectors from manuals, captures, and scripts by hand.

use std::path::{Path, PathBuf};

use devicenet_cli::recording::{Content, Recording, WriteFormat, Writer};
use devicenet_core::Identifier;
use devicenet_fuzz::input::frame_bytes;
use devicenet_fuzz::monitor::session_bytes;
use link_core::frame::{extended_id, standard_id};
use link_core::{Frame, Instant};

type Seeds = Vec<(String, Vec<u8>)>;

/// The seeds of a target, by name.
pub(crate) fn of(target: &str) -> Seeds {
    match target {
        "bus_paths" => bus_paths(),
        "dn_access" => dn_access(),
        "dn_slave" => crate::slave::dn_slave(),
        "eds" => eds(),
        "fragment" => crate::slave::fragment(),
        "dn_master" => dn_master(),
        "dn_tool" => dn_tool(),
        "frame_decode" => frame_decode(),
        "monitor" => monitor(),
        "net_dn" => crate::slave::net_dn(),
        "text" => text(),
        "wire" => wire(),
        other => panic!("no recipes for {other}"),
    }
}

/// Data fields and messages as they stand in manuals and captures, which the file `VECTORS` has as frames; and what only
/// other layers carry.
fn wire() -> Seeds {
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

fn frame_decode() -> Seeds {
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

/// Captures from their beginnings, and exchanges put together by number.
fn monitor() -> Seeds {
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

/// Configuration in two bytes, then operations: 8 0 link up, 6 sent, 0 span tick, 4 length head a check message.
fn dn_access() -> Seeds {
    const UP: &[u8] = &[8, 0];
    const SENT: &[u8] = &[6];
    const SECOND: &[u8] = &[0, 0xC1];
    const BUS_OFF: &[u8] = &[8, 4];
    const BACK_OFF: &[u8] = &[0, 0x82];
    const REQUEST: &[u8] = &[4, 7, 0x00];
    const RESPONSE: &[u8] = &[4, 7, 0x80];
    const RESET: &[u8] = &[9, 0, 0];
    let on_line = [UP, SENT, SECOND, SENT, SECOND].concat();
    let with = |config: [u8; 2], rest: &[&[u8]]| [&config[..], &on_line, &rest.concat()].concat();
    [
        ("on-line", with([5, 0], &[])),
        ("alone", [&[5, 0][..], UP, &[8, 9], SECOND, &[8, 9], SENT].concat()),
        ("twins-while-checking", [&[5, 0][..], UP, REQUEST, SENT].concat()),
        ("defended", with([5, 0], &[REQUEST, SENT, REQUEST, REQUEST, SENT])),
        ("segments-joined", with([5, 0], &[RESPONSE])),
        ("bus-off-held", with([5, 0], &[BUS_OFF, UP, RESET, UP, SENT])),
        ("bus-off-restart", with([5, 0x01], &[BUS_OFF, BACK_OFF, UP, SENT, SECOND, SENT, SECOND])),
        ("bus-off-while-checking", [&[5, 0x41][..], UP, BUS_OFF, BACK_OFF, UP, SENT].concat()),
        ("quick-connect", [&[5, 0x02][..], UP, SENT, REQUEST, SENT, SECOND, SENT].concat()),
        ("quick-connect-given-back", [&[5, 0x02][..], UP, SENT, SECOND, &[7], BACK_OFF, SENT].concat()),
        ("given-back", [&[5, 0][..], UP, &[7], BACK_OFF, SENT].concat()),
        ("who", with([5, 0], &[RESPONSE, &[5, 0x30, 0x3F], &[10], SENT, &[5, 0x30, 0x45], &[11, 10]])),
        ("identify", with([5, 0], &[RESPONSE, &[5, 1, 0x3F], SENT, &[5, 2, 0], SENT, &[0, 0xFC]])),
        ("change-mac-id", with([5, 0], &[RESPONSE, &[5, 3, 0x11], SENT, SECOND, SENT, SECOND])),
        ("change-mac-id-switches", with([5, 0x08], &[RESPONSE, &[5, 3, 0x11], SENT])),
        ("power-lost", with([5, 0], &[REQUEST, &[8, 3], &[7], UP, SENT])),
        ("bad-length", with([5, 0x04], &[&[4, 3, 0x80], &[4, 0, 0], &[4, 8, 0x80]])),
        ("late-ticks", with([5, 0], &[REQUEST, &[1, 0xC5], &[2, 0xC3], RESET, SENT, &[1, 0xC5], &[11, 10]])),
    ]
    .map(|(name, bytes)| (name.to_owned(), bytes))
    .to_vec()
}

/// Choices in two bytes, then operations: 9 0 link up, 7 0 sent, 2 the next deadline, 4 an answer of a slave.
fn dn_master() -> Seeds {
    const SENT: &[u8] = &[7, 0];
    let on_line: &[u8] = &[9, 0, 7, 0, 2, 7, 0, 2];
    let round = |how: u8| [SENT, &[4, 0, how], SENT, &[4, 1, how], SENT, &[4, 2, how]].concat();
    let bring_up = round(0).repeat(11);
    // Poll frames of two fragments, a strobe response, a change, a poll response.
    let data: &[u8] = &[5, 0, 0, 9, 5, 0, 0x41, 9, 5, 0, 0x82, 9, 5, 5, 0, 1, 5, 10, 0, 3, 5, 1, 0, 4];
    let polls = [&[10, 0, 0x21][..], data, &SENT.repeat(4), &[2], data, &SENT.repeat(6), &[2]].concat();
    let with = |choices: u8, rest: &[&[u8]]| [&[choices, 0][..], on_line, &rest.concat()].concat();
    [
        ("bring-up", with(0, &[&bring_up])),
        ("configuration", with(0x42, &[&bring_up, &round(0).repeat(4)])),
        ("ucmm", with(0x04, &[&bring_up, &round(0).repeat(3)])),
        ("exchange", with(0, &[&bring_up, &polls, &polls])),
        ("without-pause", with(0x30, &[&bring_up, &polls, &polls])),
        ("lost", with(0, &[&bring_up, &polls, &[0, 0xC1, 0, 0xC1], &bring_up])),
        ("wrong-device", with(0, &[&round(0), &round(8).repeat(3)])),
        ("earlier-life", with(0, &[&round(9), &round(0).repeat(3), &round(9), &round(0).repeat(6)])),
        ("of-another-master", with(0, &[&round(10), &[2], &round(10)])),
        ("given-back", with(0, &[&bring_up, &[8, 0, 8, 1, 2, 8, 0, 8, 0, 2, 8, 0]])),
        ("off-line", with(1, &[&bring_up, &polls, &[9, 3, 7, 0, 7, 0, 7, 0, 0, 0x83, 9, 0], on_line])),
        ("removed", with(0, &[&bring_up, &[12, 1, 0], SENT, &[12, 2, 0], SENT, &[2], &round(0)])),
        ("asked", with(0, &[&bring_up, &[11, 0, 3], &round(0), &[11, 0, 30], &round(0).repeat(6)])),
        ("restarts", with(0, &[&bring_up, &[6, 0x41, 0, 0, 0xC1, 6, 0x41, 0, 0, 0xC1, 2, 2]])),
        ("replacement", with(0x08, &[&[0, 0xC1, 7, 0].repeat(20), &round(0).repeat(3)])),
    ]
    .map(|(name, bytes)| (name.to_owned(), bytes))
    .to_vec()
}

/// Operations: 9 0 link up, 7 0 sent, 2 the next deadline, 10 a command.
fn dn_tool() -> Seeds {
    let on_line: &[u8] = &[9, 0, 7, 0, 2, 7, 0, 2];
    let owner: &[u8] = &[10, 0, 7, 0, 2, 7, 0, 2];
    let with = |rest: &[&[u8]]| [on_line, &rest.concat()].concat();
    [
        ("who", with(&[owner, &[10, 3, 7, 0, 5, 0, 5, 3, 2]])),
        ("identify", with(&[owner, &[10, 4, 7, 0, 5, 1, 2, 10, 5, 7, 0, 2]])),
        ("recovered", with(&[owner, &[10, 6, 7, 0, 6, 0, 0, 0, 0xC1, 6, 0, 0, 2]])),
        ("taken", with(&[owner, &[10, 6, 6, 2, 0x80, 8, 0, 10, 3, 7, 0, 2]])),
        ("own-mac-id", with(&[owner, &[10, 0x86]])),
        ("defended", with(&[&[10, 0, 7, 0, 4, 0, 2, 7, 0, 7, 0, 4, 0, 2, 7, 0, 4, 0, 7, 0]])),
        ("owned-by-another", with(&[&[10, 0, 7, 0, 4, 1, 10, 0, 4, 0, 7, 0, 4, 1], owner, &[4, 1]])),
        ("given-back", with(&[&[10, 0, 8, 0, 2, 8, 0, 2, 7, 0, 2, 8, 0, 2, 7, 0, 2]])),
        ("collision", with(&[&[10, 0, 9, 5, 8, 0, 2, 9, 5, 7, 0, 2, 7, 0, 2]])),
        ("released", with(&[owner, &[10, 3, 10, 2, 10, 0, 7, 0, 2, 7, 0, 2, 7, 0, 2]])),
        ("off-line", with(&[owner, &[10, 3, 6, 1, 0x80, 7, 0, 10, 7, 7, 0, 2, 7, 0, 2]])),
    ]
    .map(|(name, bytes)| (name.to_owned(), bytes))
    .to_vec()
}

/// Header of three bytes and two for each node, then items of a distance, a head, and a frame or an argument.
fn bus_paths() -> Seeds {
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

/// The beginning of each file of `tests/eds`, after the head that they have in common, and characters of every encoding.
fn eds() -> Seeds {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/eds");
    let mut seeds: Seeds = ["syntax", "structure", "device", "io", "params", "assemblies", "old"]
        .map(|name| {
            let bytes = std::fs::read(folder.join(format!("{name}.eds"))).unwrap();
            let head = b"Class1 = DeviceNet;\n";
            let start =
                bytes.windows(head.len()).position(|window| window == head).map_or(0, |at| at + head.len());
            let end = bytes.len().min(start + EDS_SEED);
            (format!("{name}.eds"), bytes[start..end].to_vec())
        })
        .to_vec();
    let short = "[Device]\r\nVendCode = 4660; ProdName = \"°\";\r\n[Params]\nParam1 = 0,,,4,0xC7,2,\"a\",\"b\",\"\",0,9,1,1,10,1,0;\n";
    let wide = |bytes: fn(u16) -> [u8; 2]| {
        [0xFEFF].into_iter().chain(short.encode_utf16()).flat_map(bytes).collect()
    };
    seeds.push(("utf-8.eds".to_owned(), short.as_bytes().to_vec()));
    seeds.push(("utf-16-le.eds".to_owned(), wide(u16::to_le_bytes)));
    seeds.push(("utf-16-be.eds".to_owned(), wide(u16::to_be_bytes)));
    seeds
        .push(("windows-1252.eds".to_owned(), b"[File]\n\x93x\x94 = \x93Maker\x92s\x94, \"\\\"\";".to_vec()));
    seeds
}

/// A few lines of each format; scenarios with everything that they can have.
fn text() -> Seeds {
    let texts: [(&str, &str); 9] = [
        (
            "candump.log",
            "(1700000000.000000) can0 456#014B03010301\n(1700000000.000250) can0 453#01CB00 R\n\
             (1700000000.1) can1 1FFFFFFF#R5\n(1700000000.2) can0 123##3000102030405060708090A0B\n\
             (1700000000.3) can0 20000004#0004000000000000\n(1700000000.4) can0 44C#0102030405060708_9\n",
        ),
        (
            "candump-bad-lines.log",
            "(1700000000.000000) can0 456#014B03010301\n(1700000000.0001) can0 45\nnoise\r\n",
        ),
        (
            "candump-screen.txt",
            " (1700000006.000000)  can0  456   [6]  01 4B 03 01 03 01\n  can0  123   [5]  remote request\n  \
             can0  20000004   [8]  00 04 00 00 00 00 00 00   ERRORFRAME\n  can0  RX - -  453  [12]  00 01 02 03 \
             04 05 06 07 08 09 0A 0B\n",
        ),
        (
            "candump-distances.txt",
            " (000.000000)  can0  456   [0]\n (000.000250)  can0  453   [1]  01\n (000.000100)  can0  453   [1]  02\n",
        ),
        (
            "vector.asc",
            "date Tue Nov 14 22:13:20.000 2023\nbase hex  timestamps absolute\n   0.015991 1  456             Rx   \
             d 6 01 4B 03 01 03 01\n   0.016200 1  18FEF1FEx       Tx   r 8\n   0.017000 1  ErrorFrame\n   0.018 \
             CANFD   1 Rx   453  Name  1 0 9 12 00 01 02 03 04 05 06 07 08 09 0A 0B\n",
        ),
        (
            "plant.toml",
            "[bus]\nbit_rate = 125_000\nseed = 1\nduration = \"3s\"\n[[node]]\nname = \"a\"\nprotocol = \
             \"devicenet\"\nrole = \"access\"\nmac = 10\nidentity = { vendor = 0x1234, serial = 1 }\n[[expect]]\nby = \
             \"2.5s\"\nnode = \"a\"\nstate = \"online\"\n",
        ),
        (
            "faults.toml",
            "[bus]\n[[node]]\nname = \"a\"\nrole = \"listener\"\n[[node]]\nname = \"b\"\nrole = \"babbler\"\nframe = \
             \"7FF#00\"\nperiod = \"75ms\"\n[[fault]]\nkind = \"bit_error\"\nrate = 1e-4\nfrom = \"1s\"\n[[action]]\n\
             at = \"2s\"\nnode = \"a\"\ndo = \"power_cycle\"\n[[note]]\nat = \"2s\"\ntext = \"again\"\n[[expect]]\nnever \
             = true\nbus_off = true\n",
        ),
        ("defect.toml", "[bus]\nbit_rate = 125\n"),
        ("unknown-key.toml", "[bus]\n[[node]]\nname = 'ü'\nrole = 'listener'\nmac = 64\n"),
    ];
    let mut seeds: Seeds = texts.map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec())).to_vec();
    // The header of the file and of the first packets.
    let pcap = std::fs::read(captures().join("socketcan-le-usec.pcap")).unwrap();
    seeds.push(("socketcan.pcap".to_owned(), pcap[..200].to_vec()));
    let mut pcapng = Vec::new();
    let mut writer = Writer::new(&mut pcapng, WriteFormat::PcapNg).unwrap();
    for (index, &(_, id, data)) in VECTORS.iter().take(4).enumerate() {
        let content = Content::Classic(Identifier::new(id).unwrap().frame(data).unwrap());
        writer.write(Instant::from_millis(index as u64), 6, "can0", &content).unwrap();
    }
    writer.finish().unwrap();
    seeds.push(("written.pcapng".to_owned(), pcapng));
    seeds
}

fn capture(name: &str) -> impl Iterator<Item = (Instant, Frame)> + use<> {
    let recording = Recording::open(&captures().join(name)).unwrap();
    recording.map(Result::unwrap).filter_map(|recorded| match recorded.content {
        Content::Classic(frame) => Some((recorded.at, frame)),
        Content::Error(_) | Content::Fd(_) => None,
    })
}

fn captures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/captures")
}

/// A seed is short.
const EDS_SEED: usize = 512;

/// Frames from manuals, captures and fixtures: name, identifier, data field.
const VECTORS: &[(&str, u16, &[u8])] = &[
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
