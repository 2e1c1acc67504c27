//! The command line.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use devicenet_core::monitor::Kind;

use crate::compare::CompareArgs;
use crate::eds::EdsArgs;
use crate::live::{GetArgs, MonitorArgs, RecordArgs, RecoverArgs, RunArgs, ScanArgs, SetArgs};
use crate::powerlink::PowerlinkArgs;
use crate::scenario::Time;
use crate::simulate::SimulateArgs;
use crate::standard::is_standard;
use crate::text::unsigned;

/// DeviceNet (CIP on CAN) on the command line
#[derive(Parser, Clone, Debug)]
#[command(
    name = "devicenet",
    version,
    after_help = "\
Exit codes:
  0  done, all is well
  1  done, something was found
  2  wrong usage or bad input file
  3  the bus or the interface failed
  4  refused to transmit
130  interrupted (Ctrl-C) before it was done

Examples:
  devicenet decode recording.log
  devicenet eds check valve.eds
  devicenet simulate
  devicenet monitor can0
  devicenet scan can0
  devicenet get can0 10 1/1/7 --allow-tx
  devicenet powerlink cn eth0 --node 1 --allow-tx"
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Print one JSON object a line instead of text
    #[arg(long, global = true)]
    pub json: bool,
}

/// The subcommands.
#[derive(Subcommand, Clone, Debug)]
pub enum Command {
    /// Compare DeviceNeX with DeviceNet on the simulated bus
    Compare(CompareArgs),
    /// Decode a recording: one line a frame
    Decode(DecodeArgs),
    /// Check and show Electronic Data Sheets
    Eds(EdsArgs),
    /// Read an attribute of a node on a live bus
    Get(GetArgs),
    /// Be a master on a live bus
    Master(RunArgs),
    /// Watch a live bus: nodes, load, response times, what is wrong
    Monitor(MonitorArgs),
    /// Be a station of Ethernet POWERLINK
    Powerlink(PowerlinkArgs),
    /// Record a live bus when something happens, with what came before
    Record(RecordArgs),
    /// Give nodes that are silent for a duplicate MAC ID another one
    Recover(RecoverArgs),
    /// List the nodes on a live bus
    Scan(ScanArgs),
    /// Write an attribute of a node on a live bus
    Set(SetArgs),
    /// Be a slave on a live bus
    Slave(RunArgs),
    /// Simulate a network on a bus that is exact to the bit
    Simulate(SimulateArgs),
}

/// `devicenet decode`.
#[derive(Args, Clone, Debug)]
#[command(
    long_about = "\
Decode a recording: one line a frame.

Reads candump logs (`candump -L`) and candump screen output, pcap and pcapng of a SocketCAN interface, and Vector ASC; the \
format is found in the content. What a frame means is learned from those before it: allocations, connections, fragments, the \
request that a response answers. Every channel of the recording is a bus of its own.

pcap and pcapng of an Ethernet interface are read for Ethernet POWERLINK: cycle, polls and their responses, NMT states, SDO.",
    after_long_help = "\
Exit codes:
  0  every line was read, and no frame shown has a problem; also when there is no frame, or none passes the filters,
     which a note on standard error says; with --summary: the verdict is healthy or silent
  1  some frame shown has a problem, or some line could not be read; with --summary: the verdict is another one
  2  wrong usage, not a recording, cut off or damaged; with --strict also a line that could not be read; what was read
     before is shown, summed up and recorded

Examples:
  devicenet decode recording.log
  devicenet decode --mac 10 --kind explicit_request,explicit_response recording.pcapng
  devicenet decode --from 5s --to 5.2s recording.log
  devicenet decode --time delta --kind poll_command recording.asc
  devicenet decode --summary --bit-rate 500k recording.log
  devicenet decode --summary --expect line.toml recording.log
  devicenet decode --json recording.log | jq -r 'select(.problem) | [.n, .text] | @tsv'
  devicenet decode --mac 10 --record only-10.pcapng recording.log
  devicenet decode --eds valve.eds --eds 10=drive.eds recording.log
  devicenet decode --record - recording.asc > recording.log
  candump -L can0 | devicenet decode -
  devicenet decode --mac 1 --kind pres,asnd_sdo powerlink.pcap"
)]
pub struct DecodeArgs {
    /// The recording; `-` is standard input
    pub file: PathBuf,
    /// Which protocol the frames belong to; a frame that cannot is a problem. With `auto` the first frames tell, and it is said
    /// on standard error if they tell of DeviceNeX; captures of Ethernet are read for POWERLINK
    #[arg(long, value_enum, default_value_t = Protocol::Auto)]
    pub protocol: Protocol,
    /// Only frames to or from this node (MAC ID 0 to 63, or 0x00 to 0x3F; in DeviceNeX, operational address 0 to 127), and those
    /// to every node: bit-strobe and multicast poll commands, and messages of the offline connection set that do not name
    /// another node; Mini-who. In POWERLINK, node ID 0 to 255: frames from it and to it, SoA that invite it, NMT commands that
    /// mean it
    #[arg(long, visible_aliases = ["oa", "node"], value_name = "N", value_parser = parse_node)]
    pub mac: Option<u8>,
    /// Only frames of this kind, named as in the JSON output; several with commas, or given more than once
    #[arg(long, value_name = "KIND", value_parser = kind_parser(), value_delimiter = ',')]
    pub kind: Vec<&'static str>,
    /// Only frames from this time on, counted from the first frame of the recording: 300ms, 1.5s; those before are still
    /// learned from
    #[arg(long, value_name = "TIME")]
    pub from: Option<Time>,
    /// Only frames up to this time, counted from the first frame of the recording
    #[arg(long, value_name = "TIME")]
    pub to: Option<Time>,
    /// The times of the lines, absolute unless told otherwise; JSON and copies have those of the recording
    #[arg(long, value_enum)]
    pub time: Option<TimeFormat>,
    /// Instead of the frames, a summary: each node, each connection, what is wrong with the bus and what to check next, each
    /// kind of problem; response times p50 and p99 have two significant digits, the longest is exact. What is wrong is found
    /// in the whole recording, and shown if it is of the node and of the time that is shown
    #[arg(long)]
    pub summary: bool,
    /// Instead of the frames, the scan list of each master, rebuilt from its traffic: [[node.scan]] tables of a scenario.
    /// It is that of the whole recording
    #[arg(long, conflicts_with_all = ["summary", "mac", "kind", "from", "to"])]
    pub scanlist: bool,
    /// For the summary: a scenario whose scan lists say which slaves belong to the bus, which devices they must be, and whose.
    /// Others, and other masters, are told
    #[arg(long, value_name = "FILE", requires = "summary")]
    pub expect: Option<PathBuf>,
    /// The bit rate of the bus, from which the summary computes the bus load; without, the load is the most that it can be, at the
    /// least rate into which the frames fit, and is not judged
    #[arg(long, value_name = "RATE", value_parser = parse_bit_rate)]
    pub bit_rate: Option<u32>,
    /// Name parameters and pieces of I/O data by this Electronic Data Sheet, for every node whose vendor, device type and
    /// product code are seen to be those of the file; with MAC= for that node, whatever it is; may be given more than once
    #[arg(long, value_name = "[MAC=]FILE", value_parser = parse_eds_file)]
    pub eds: Vec<EdsFile>,
    /// Stop at the first line that cannot be read, instead of warning and going on
    #[arg(long)]
    pub strict: bool,
    /// Write the frames shown into a recording as well: pcapng for a name that ends so, else a candump log; `-` writes it
    /// to standard output, and nothing else there, so not with --json or --summary
    #[arg(long, short = 'o', value_name = "FILE")]
    pub record: Option<PathBuf>,
}

impl DecodeArgs {
    /// Whether standard output is for the copy, and not for words.
    pub(crate) fn is_record_on_stdout(&self) -> bool {
        self.record.as_deref().is_some_and(is_standard)
    }
}

/// An Electronic Data Sheet for `decode`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct EdsFile {
    /// The node that it is for; without, the file finds its nodes by their identity.
    pub mac: Option<u8>,
    /// The file.
    pub path: PathBuf,
}

/// The protocols that `decode` knows.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub enum Protocol {
    /// The one that the first frames tell; DeviceNet if they do not
    Auto,
    /// DeviceNet
    Devicenet,
    /// DeviceNeX: DeviceNet over 29-bit identifiers
    Devicenex,
    /// Ethernet POWERLINK
    Powerlink,
}

/// What the times of a trace are counted from.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum TimeFormat {
    /// As recorded
    #[default]
    Absolute,
    /// Since the first frame of the recording
    Relative,
    /// Since the line before; of the first line, since the first frame
    Delta,
}

/// The names of the kinds of all protocols.
fn kind_parser() -> impl TypedValueParser<Value = &'static str> {
    PossibleValuesParser::new(kinds())
        .try_map(|name| kinds().into_iter().find(|kind| *kind == name).ok_or("no such kind"))
}

fn kinds() -> Vec<&'static str> {
    let mut kinds: Vec<_> = Kind::ALL.map(Kind::name).into();
    let of_nex = devicenex_core::monitor::Kind::ALL.map(devicenex_core::monitor::Kind::name);
    let of_powerlink = powerlink_core::monitor::Kind::ALL.map(powerlink_core::monitor::Kind::name);
    for name in of_nex.into_iter().chain(of_powerlink) {
        if !kinds.contains(&name) {
            kinds.push(name);
        }
    }
    kinds
}

/// `10`, `0x0A`.
pub(crate) fn parse_mac_id(text: &str) -> Result<u8, String> {
    number(text).filter(|mac| *mac <= 63).ok_or_else(|| "a MAC ID is 0 to 63".to_owned())
}

/// A MAC ID, an operational address of DeviceNeX, or a node ID of POWERLINK.
fn parse_node(text: &str) -> Result<u8, String> {
    number(text).ok_or_else(|| {
        "a MAC ID is 0 to 63, an operational address of DeviceNeX 0 to 127, a node ID of POWERLINK 0 to 255".to_owned()
    })
}

fn number(text: &str) -> Option<u8> {
    match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(digits) => u8::from_str_radix(digits, 16),
        None => text.parse(),
    }
    .ok()
}

/// `valve.eds`, `10=valve.eds`.
fn parse_eds_file(text: &str) -> Result<EdsFile, String> {
    let is_number = |mac: &str| mac.chars().all(|character| character.is_ascii_alphanumeric());
    let (mac, path) = match text.split_once('=').filter(|(mac, _)| is_number(mac)) {
        Some((mac, path)) => (Some(parse_mac_id(mac)?), path),
        None => (None, text),
    };
    if path.is_empty() {
        return Err("the name of a file expected, such as valve.eds or 10=valve.eds".to_owned());
    }
    Ok(EdsFile { mac, path: path.into() })
}

/// `125k`, `125000`, `125_000`, `1M`.
pub(crate) fn parse_bit_rate(text: &str) -> Result<u32, String> {
    let plain = text.replace('_', "");
    let (digits, scale) = match plain.as_bytes().last() {
        Some(b'k' | b'K') => (&plain[..plain.len() - 1], 1_000),
        Some(b'M') => (&plain[..plain.len() - 1], 1_000_000),
        _ => (&plain[..], 1),
    };
    let rate = digits.parse::<u32>().ok().and_then(|number| number.checked_mul(scale));
    rate.filter(|rate| (1_000..=1_000_000).contains(rate))
        .ok_or_else(|| "a bit rate between 1k and 1M expected, such as 125k, 250k or 500k".to_owned())
}

/// `7`, `0x2A`, `1_000`.
pub(crate) fn parse_seed(text: &str) -> Result<u64, String> {
    let number = unsigned(&text.replace('_', ""));
    number.ok_or_else(|| format!("a number from 0 to {} expected, such as 7 or 0x2A", u64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_is_consistent() {
        use clap::CommandFactory as _;
        Cli::command().debug_assert();
    }

    #[test]
    fn mac_ids_in_decimal_and_hexadecimal() {
        assert_eq!(parse_mac_id("10"), Ok(10));
        assert_eq!(parse_mac_id("0x0A"), Ok(10));
        assert_eq!(parse_mac_id("0X3f"), Ok(63));
        for text in ["", "0x", "64", "0x40", "-1", "abc", "1.5"] {
            assert_eq!(parse_mac_id(text), Err("a MAC ID is 0 to 63".to_owned()), "{text}");
        }
    }

    #[test]
    fn seeds_in_decimal_and_hexadecimal() {
        assert_eq!(parse_seed("7"), Ok(7));
        assert_eq!(parse_seed("0x10"), Ok(16));
        assert_eq!(parse_seed("0XffFFffFF_ffFFffFF"), Ok(u64::MAX));
        for text in ["", "0x", "-1", "+1", "0x+1", "ten", "0x10000000000000000"] {
            let words = "a number from 0 to 18446744073709551615 expected, such as 7 or 0x2A";
            assert_eq!(parse_seed(text), Err(words.to_owned()), "{text}");
        }
    }

    #[test]
    fn eds_files_with_and_without_a_node() {
        let file = |mac, path: &str| Ok(EdsFile { mac, path: path.into() });
        assert_eq!(parse_eds_file("valve.eds"), file(None, "valve.eds"));
        assert!(parse_eds_file("10=").unwrap_err().starts_with("the name of a file expected"));
        assert!(parse_eds_file("").is_err());
        assert_eq!(parse_eds_file("0x0A=a=b.eds"), file(Some(10), "a=b.eds"));
        assert_eq!(parse_eds_file("./10=valve.eds"), file(None, "./10=valve.eds"));
        assert!(parse_eds_file("64=valve.eds").is_err());
    }

    #[test]
    fn bit_rates_as_people_write_them() {
        for text in ["125k", "125000", "125_000"] {
            assert_eq!(parse_bit_rate(text), Ok(125_000));
        }
        assert_eq!(parse_bit_rate("1M"), Ok(1_000_000));
        for text in ["", "k", "0", "2M", "99999999999", "125 kbit/s"] {
            assert!(parse_bit_rate(text).is_err(), "{text}");
        }
    }
}
