//! The POWERLINK commands on the command line.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use crate::live::parse_span;
use crate::scenario::{Time, TimeError};
use crate::text::{hex_bytes, unsigned};

/// `devicenet powerlink`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Examples:
  devicenet powerlink cn eth0 --node 1 --allow-tx
  devicenet powerlink mn eth0 network.toml --allow-tx
  devicenet decode --summary powerlink.pcap

`cn --help` has more of them, `mn --help` all of a network file.")]
pub struct PowerlinkArgs {
    /// What to be.
    #[command(subcommand)]
    pub role: PowerlinkRole,
}

/// What to be on the network.
#[derive(Subcommand, Clone, Debug)]
pub enum PowerlinkRole {
    /// Be a controlled node
    Cn(CnArgs),
    /// Be the managing node
    Mn(MnArgs),
}

/// How a command takes part in a network.
#[derive(Args, Clone, Debug)]
pub struct StationArgs {
    /// An Ethernet interface such as eth0, for POWERLINK alone
    #[arg(value_name = "IFACE")]
    pub interface: String,
    /// Transmit; without it the command says what it would send, and sends nothing
    #[arg(long)]
    pub allow_tx: bool,
    /// How long to run; without, until Ctrl-C
    #[arg(long = "for", value_name = "TIME", value_parser = parse_span)]
    pub span: Option<Time>,
    /// Write what is sent and received into a pcap file
    #[arg(long, short = 'o', value_name = "FILE")]
    pub record: Option<PathBuf>,
}

/// `devicenet powerlink cn`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = "\
A node with inputs and outputs after CiA 401: digital ones of 8 bits, 0x6000 and 0x6200, and analog ones of 16 bits, 0x6401 and \
0x6411. The first --digital and --analog of each are mapped, in this order, until the managing node maps others. What happens is \
printed, one line each, until Ctrl-C or --for; process data when they change, and what comes again and again, such as bad frames and \
errors, once a second with its number. Times are seconds since the first line, which says when that was.

It sends only what a managing node asks for. An answer that would come later than --answer-within, or after the managing node has \
gone on, is withheld, and counted as not sent. An interface that goes down, or is unplugged, is waited for.

Raw Ethernet frames need the right cap_net_raw: run it as root, or, as root: setcap cap_net_raw+ep devicenet

Exit codes:
  0  the node ran, until --for or Ctrl-C
  1  it did, but its error LED was on in the end
  2  wrong usage, or a file that cannot be written
  3  there is no such interface, no right to use it, or it failed
  4  refused to transmit: no --allow-tx
130  interrupted a second time

Examples:
  devicenet powerlink cn eth0 --node 1 --allow-tx
  devicenet powerlink cn eth0 --node 32 --digital 2 --analog 4 --inputs 0100 --mirror --allow-tx
  devicenet powerlink cn eth0 --node 1 --allow-tx --for 1min --record node.pcap --json")]
pub struct CnArgs {
    /// How to take part.
    #[command(flatten)]
    pub station: StationArgs,
    /// The node ID, 1 to 239
    #[arg(long, value_name = "N", value_parser = parse_node)]
    pub node: u8,
    /// How many bytes of digital inputs, and of outputs, are mapped at first
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u8).range(0..=16))]
    pub digital: u8,
    /// How many analog inputs, and outputs, are mapped at first
    #[arg(long, value_name = "N", default_value = "0", value_parser = clap::value_parser!(u8).range(0..=8))]
    pub analog: u8,
    /// The inputs: a byte for each 8 digital ones, then two for each analog one, the low byte first; what is missing is 0
    #[arg(long, value_name = "HEX", default_value = "", value_parser = parse_hex)]
    pub inputs: Hex,
    /// Inputs have the values of the outputs of the same number, as soon as there are any, until a reset
    #[arg(long)]
    pub mirror: bool,
    /// The vendor ID (0x1018/1); 0 is no vendor's
    #[arg(long, value_name = "ID", default_value = "0", value_parser = parse_u32)]
    pub vendor: u32,
    /// The product code (0x1018/2)
    #[arg(long, value_name = "ID", default_value = "0", value_parser = parse_u32)]
    pub product: u32,
    /// The revision (0x1018/3)
    #[arg(long, value_name = "ID", default_value = "0", value_parser = parse_u32)]
    pub revision: u32,
    /// The serial number (0x1018/4)
    #[arg(long, value_name = "ID", default_value = "0", value_parser = parse_u32)]
    pub serial: u32,
    /// How long an answer may take: told to the managing node (0x1F98/3 and /6), and kept
    #[arg(long, value_name = "TIME", default_value = "5ms", value_parser = parse_object_time)]
    pub answer_within: Time,
    /// How late a SoC may be until it counts as lost (0x1C14), unless the managing node writes another time
    #[arg(long, value_name = "TIME", default_value = "50ms", value_parser = parse_object_time)]
    pub loss_of_soc_tolerance: Time,
}

/// `devicenet powerlink mn`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = concat!(
    "\
It listens for another managing node first, then resets, identifies, configures and starts every node, and brings back those that are \
lost. What happens is printed, one line each, until Ctrl-C or --for; process data when they change, and what comes again and again, such \
as bad frames and errors, once a second with its number. Times are seconds since the first line, which says when that was. At its \
end it resets every node, so that none goes on alone. It is a small managing node, for tests and demonstrations.

FILE is a network file in TOML. Times have a unit, numbers may be hexadecimal; only [[node]] with its number is required. What is \
given here are the defaults, unless it says otherwise:
",
    include_str!("mn/network-file.txt"),
    "
Raw Ethernet frames need the right cap_net_raw: run it as root, or, as root: setcap cap_net_raw+ep devicenet

Exit codes:
  0  every node was operational in the end
  1  some node was not
  2  wrong usage or bad file
  3  there is no such interface, no right to use it, or it failed
  4  refused to transmit: no --allow-tx
130  interrupted a second time

Examples:
  devicenet powerlink mn eth0 network.toml --allow-tx
  devicenet powerlink mn eth0 network.toml --allow-tx --for 10s --json --record network.pcap"
))]
pub struct MnArgs {
    /// How to take part.
    #[command(flatten)]
    pub station: StationArgs,
    /// The network; - reads standard input
    pub file: PathBuf,
}

/// Bytes.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Hex(pub Vec<u8>);

fn parse_hex(text: &str) -> Result<Hex, String> {
    hex_bytes(text)
        .map(Hex)
        .ok_or_else(|| "an even number of hexadecimal digits expected, such as 01ff".to_owned())
}

fn parse_node(text: &str) -> Result<u8, String> {
    let node = unsigned(text).and_then(|node| u8::try_from(node).ok());
    node.filter(|node| (1..=239).contains(node)).ok_or_else(|| {
        "a controlled node is 1 to 239; the managing node, 240, is `devicenet powerlink mn`".to_owned()
    })
}

fn parse_u32(text: &str) -> Result<u32, String> {
    unsigned(text)
        .and_then(|number| u32::try_from(number).ok())
        .ok_or_else(|| "a number of 32 bits expected, such as 12 or 0x0000000C".to_owned())
}

/// The object that tells it counts nanoseconds in 32 bits.
/// Of an object of 32 bits in nanoseconds, in which 0 is no time.
fn parse_object_time(text: &str) -> Result<Time, String> {
    let time: Time = text.parse().map_err(|error: TimeError| error.to_string())?;
    let fits = !time.0.is_zero() && u32::try_from(time.0.as_nanos()).is_ok();
    if fits { Ok(time) } else { Err("longer than 0s and at most 4.2s".to_owned()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn node_ids_in_decimal_and_hexadecimal() {
        assert_eq!((parse_node("1"), parse_node("0xEF")), (Ok(1), Ok(239)));
        for text in ["", "0", "240", "256", "-1", "x"] {
            assert!(parse_node(text).is_err(), "{text}");
        }
    }

    #[test]
    fn an_answer_takes_time_and_fits_its_object() {
        assert!(parse_object_time("5ms").is_ok());
        for text in ["0s", "5s", "5"] {
            assert!(parse_object_time(text).is_err(), "{text}");
        }
    }
}
