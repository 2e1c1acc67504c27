#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::indexing_slicing,
    clippy::unwrap_used,
    reason = "a measurement may panic"
)]
//! Frames a second of reading and decoding: `cargo bench -p devicenet-cli --bench decode`.

mod traffic;

use std::sync::LazyLock;

use clap::Parser as _;
use devicenet_cli::args::{Cli, Command};
use devicenet_cli::decode::{Decoder, EthernetDecoder};
use devicenet_cli::recording::{Content, Opened, Recording, WriteFormat, Writer};
use divan::Bencher;
use divan::counter::ItemsCount;

fn main() {
    divan::main();
}

/// Reading alone.
#[divan::bench]
fn read_candump(bencher: Bencher<'_, '_>) {
    read(bencher, &CANDUMP);
}

#[divan::bench]
fn read_pcapng(bencher: Bencher<'_, '_>) {
    read(bencher, &PCAPNG);
}

/// Reading, decoding and writing into a buffer.
#[divan::bench]
fn decode_to_text(bencher: Bencher<'_, '_>) {
    decode(bencher, &[]);
}

#[divan::bench]
fn decode_to_json(bencher: Bencher<'_, '_>) {
    decode(bencher, &["--json"]);
}

#[divan::bench]
fn decode_to_summary(bencher: Bencher<'_, '_>) {
    decode(bencher, &["--summary"]);
}

/// The same of Ethernet POWERLINK.
#[divan::bench(args = [&[][..], &["--json"], &["--summary"]])]
fn decode_powerlink(bencher: Bencher<'_, '_>, options: &[&str]) {
    let cli = Cli::try_parse_from([&["devicenet", "decode", "-"], options].concat()).unwrap();
    let Command::Decode(args) = &cli.command else { unreachable!("the command line says decode") };
    bencher.counter(ItemsCount::new(FRAMES)).bench(|| {
        let Ok(Opened::Ethernet(mut capture)) = Opened::from_reader(&POWERLINK[..], None) else {
            unreachable!("a capture of Ethernet")
        };
        let mut decoder = EthernetDecoder::new(args, cli.json, false);
        let mut out = Vec::new();
        let mut written = 0;
        while let Some(frame) = capture.next() {
            decoder.frame(&mut out, &frame.unwrap(), capture.channels());
            if out.len() > 1 << 16 {
                written += out.len();
                out.clear();
            }
        }
        decoder.finish(&mut out, capture.channels(), "bench", 0);
        written + out.len()
    });
}

fn read(bencher: Bencher<'_, '_>, file: &'static [u8]) {
    bencher
        .counter(ItemsCount::new(FRAMES))
        .bench(|| Recording::from_reader(file).unwrap().map(|frame| frame.unwrap().n).sum::<u64>());
}

fn decode(bencher: Bencher<'_, '_>, options: &[&str]) {
    let command_line = [&["devicenet", "decode", "-"], options].concat();
    let cli = Cli::try_parse_from(command_line).unwrap();
    let Command::Decode(args) = &cli.command else { unreachable!("the command line says decode") };
    bencher.counter(ItemsCount::new(FRAMES)).bench(|| {
        let mut recording = Recording::from_reader(&CANDUMP[..]).unwrap();
        let mut decoder = Decoder::new(args, cli.json, false);
        let mut out = Vec::new();
        let mut written = 0;
        while let Some(frame) = recording.next() {
            decoder.frame(&mut out, &frame.unwrap(), recording.channels());
            if out.len() > 1 << 16 {
                written += out.len();
                out.clear();
            }
        }
        decoder.finish(&mut out, recording.channels(), "bench", 0);
        written + out.len()
    });
}

fn file(format: WriteFormat) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = Writer::new(&mut bytes, format).unwrap();
    for (at, frame) in traffic::Traffic::new(1).take(FRAMES) {
        writer.write(at, 6, "can0", &Content::Classic(frame)).unwrap();
    }
    writer.finish().unwrap();
    bytes
}

static CANDUMP: LazyLock<Vec<u8>> = LazyLock::new(|| file(WriteFormat::CandumpLog));
static POWERLINK: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut bytes = Vec::new();
    traffic::powerlink::write(&mut bytes, 1, FRAMES).unwrap();
    bytes
});
static PCAPNG: LazyLock<Vec<u8>> = LazyLock::new(|| file(WriteFormat::PcapNg));
const FRAMES: usize = 100_000;
