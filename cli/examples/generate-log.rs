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

use std::io::{self, BufWriter};

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
        let mut out = BufWriter::with_capacity(1 << 20, io::stdout().lock());
        return traffic::powerlink::write(&mut out, args.seed, args.frames);
    }
    let format = if args.pcapng { WriteFormat::PcapNg } else { WriteFormat::CandumpLog };
    let mut writer = Writer::new(BufWriter::with_capacity(1 << 20, io::stdout().lock()), format)?;
    for (at, frame) in traffic::Traffic::new(args.seed).take(args.frames) {
        writer.write(at, 6, "can0", &Content::Classic(frame))?;
    }
    writer.finish()
}
