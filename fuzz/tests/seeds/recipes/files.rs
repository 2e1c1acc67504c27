//! Files and lines.

use std::path::Path;

use devicenet_cli::recording::{Content, WriteFormat, Writer};
use devicenet_core::Identifier;
use link_core::Instant;

use super::frames::VECTORS;
use super::{Seeds, captures};

/// The beginning of each file of `tests/eds`, after the head that they have in common, and characters of every encoding.
pub(super) fn eds() -> Seeds {
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
pub(super) fn text() -> Seeds {
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

/// A seed is short.
const EDS_SEED: usize = 512;
