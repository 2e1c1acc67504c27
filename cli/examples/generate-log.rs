#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::indexing_slicing,
    clippy::unwrap_used,
    reason = "a development tool"
)]
//! Writes a long DeviceNet recording to standard output, or a capture of Ethernet POWERLINK, for measurements:
//! `cargo run --release -p devicenet-cli --example generate-log -- --frames 1000000 --seed 1 > big.log`

#[path = "../benches/traffic/mod.rs"]
mod traffic;

use std::io::{self, BufWriter, Write};

use clap::Parser;
use devicenet_cli::recording::{Content, WriteFormat, Writer};

/// Write a long recording to standard output
#[derive(Parser)]
struct Args {
    /// How many frames
    #[arg(long, default_value_t = 1_000_000)]
    frames: usize,
    /// The same seed gives the same recording
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// pcapng instead of a candump log
    #[arg(long)]
    pcapng: bool,
    /// Ethernet POWERLINK, in a pcap file
    #[arg(long, conflicts_with = "pcapng")]
    powerlink: bool,
}

fn main() -> io::Result<()> {
    let args = Args::parse();
    if args.powerlink {
        return powerlink(&args);
    }
    let format = if args.pcapng { WriteFormat::PcapNg } else { WriteFormat::CandumpLog };
    let mut writer = Writer::new(BufWriter::with_capacity(1 << 20, io::stdout().lock()), format)?;
    for (at, frame) in traffic::Traffic::new(args.seed).take(args.frames) {
        writer.write(at, 6, "can0", &Content::Classic(frame))?;
    }
    writer.finish()
}

/// Microseconds, little-endian, link type 1.
fn powerlink(args: &Args) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 20, io::stdout().lock());
    let header = [0xA1B2_C3D4, 0x0004_0002, 0, 0, 0x0004_0000, 1_u32];
    out.write_all(&header.map(u32::to_le_bytes).concat())?;
    for (at, frame) in traffic::powerlink::Powerlink::new(args.seed).take(args.frames) {
        let (nanos, length) = (at.as_nanos(), frame.len() as u32);
        let (seconds, micros) = (nanos / 1_000_000_000, nanos % 1_000_000_000 / 1000);
        out.write_all(&[seconds as u32, micros as u32, length, length].map(u32::to_le_bytes).concat())?;
        out.write_all(&frame)?;
    }
    out.flush()
}
