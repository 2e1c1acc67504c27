//! The live commands on the command line.

use core::time::Duration;
use std::path::PathBuf;

use clap::Args;

use super::assignment::{Assignment, Device};
use super::attribute::AttributePath;
use super::endpoint::Endpoint;
use super::trigger::Trigger;
use crate::args::{parse_bit_rate, parse_mac_id};
use crate::scenario::Time;

/// Whether a command may send on a bus.
#[derive(Args, Clone, Debug)]
pub struct PermitArgs {
    /// Transmit on a live bus; without it the command says what it would send, and sends nothing
    #[arg(long)]
    pub allow_tx: bool,
    /// How long to listen first: for the bit rate, and for who polls whom
    #[arg(long, value_name = "TIME", default_value = "1s")]
    pub listen: Time,
    /// Transmit although nothing was heard, so that the bit rate of the interface may be wrong
    #[arg(long)]
    pub assume_bit_rate: bool,
}

/// How a command takes part in a bus.
#[derive(Args, Clone, Debug)]
pub struct NodeArgs {
    /// Whether it may send.
    #[command(flatten)]
    pub permit: PermitArgs,
    /// The MAC ID that the command itself takes while it works (0 to 63); it must be free
    #[arg(long, value_name = "N", default_value = "62", value_parser = parse_mac_id)]
    pub own_mac: u8,
}

/// `devicenet monitor`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = "\
Listens, and sends nothing. On a terminal it is a screen: the nodes with their connections, load and response times, what the bus \
is used for, and what is wrong with it; `?` lists the keys. Elsewhere, and with --json or --text, it is lines: what happens when it \
happens, and a summary at every --interval and at the end. On the screen a scenario or a recording is played at its own pace; `+` \
is faster. As lines it is read as fast as possible. Of a silence in a recording that is longer than a minute the rest is passed over.

With --json every line has `event` and `t`, in seconds since the beginning; loads are parts of 1, other times seconds:
  link        state: down, error_active, error_warning, error_passive, bus_off
  access      mac, from, to: states of network access
  connection  mac of the server, client, connection, from, to
  finding     change: begins, escalates, ends; id, rule, severity, mac, since, last, until,
              count, evidence, scanner_status, facts, first_cause, text, advice
  lost        frames, 0 if they were not counted
  summary     verdict: state (healthy, silent, wrong, was_wrong, unread) and its counts; bit_rate and
              bit_rate_source (known; least: loads are the most that they can be), link, tec, rec,
              frames, error_frames, lost, problems, problems_by_kind, span; load of the span and
              load_total, by purpose; nodes with connections, loads, response times and their limit;
              findings; in the end last: true

Exit codes:
  0  the verdict is healthy, until --for, Ctrl-C, or the end; or silent: there was no frame
  1  something is or was wrong, or some line of a recording could not be read; infos are nothing
     wrong
  2  wrong usage or bad file
  3  the interface failed, is down, or is bus-off

Examples:
  devicenet monitor can0
  devicenet monitor sim:plant.toml
  devicenet monitor log:recording.log
  devicenet monitor can0 --expect line.toml
  devicenet monitor can0 --learn 5min --for 1h --interval 1min > shift.txt
  devicenet monitor can0 --json | jq -c 'select(.event == \"finding\")'")]
pub struct MonitorArgs {
    /// A CAN interface such as can0, sim:FILE for a scenario, log:FILE for a recording, log:- for one on standard input
    pub endpoint: Endpoint,
    /// How often to sum up, as lines
    #[arg(long, value_name = "TIME", default_value = "10s", value_parser = parse_interval)]
    pub interval: Time,
    /// How long to listen; without, until Ctrl-C, or until the scenario or the recording ends
    #[arg(long = "for", value_name = "TIME", value_parser = parse_span)]
    pub span: Option<Time>,
    /// The bit rate of the bus, from which the load is computed, where neither a scenario nor a controller tells it; without, the
    /// load is the most that it can be, at the least rate into which the frames fit, and is not judged
    #[arg(long, value_name = "RATE", value_parser = parse_bit_rate)]
    pub bit_rate: Option<u32>,
    /// A scenario whose scan lists say which slaves belong to the bus, which devices they must be, and whose. Others, and other
    /// masters, are told
    #[arg(long, value_name = "FILE", conflicts_with = "learn")]
    pub expect: Option<PathBuf>,
    /// How long to learn who belongs to the bus, and whose the slaves are. Others, and other masters, are told after that
    #[arg(long, value_name = "TIME")]
    pub learn: Option<Time>,
    /// Lines instead of the screen, on a terminal too
    #[arg(long, conflicts_with = "json")]
    pub text: bool,
}

fn parse_interval(text: &str) -> Result<Time, String> {
    let time: Time = text.parse().map_err(|error: crate::scenario::TimeError| error.to_string())?;
    if time.0 < SHORTEST_INTERVAL { Err("at least 10ms".to_owned()) } else { Ok(time) }
}

/// For `--for`.
pub(crate) fn parse_span(text: &str) -> Result<Time, String> {
    let time: Time = text.parse().map_err(|error: crate::scenario::TimeError| error.to_string())?;
    if time.0.is_zero() { Err("longer than 0s".to_owned()) } else { Ok(time) }
}

/// `devicenet record`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = "\
Listens, and sends nothing. The last seconds are kept in memory; when something happens they are written, and so is what follows. \
TRIGGER is one of

  timeout, timeout=MAC   a node leaves polls unanswered until its peer gives up, which is after four times
                         the expected packet rate or what attribute 18 makes of it, or a connection
                         times out
  duplicate              a second device wants a MAC ID, or answers for it
  error, bus-off         an error on the bus; the interface is bus-off
  problem                a frame is wrong or suspicious, as `devicenet decode` says it
  silence=TIME           nothing was heard for so long
  kind=KIND,mac=N,id=N,data=HEX
                         a frame to which all apply; KIND as in `decode`, ?? in HEX is any byte

Without a trigger: timeout, duplicate, error, bus-off.

A recording has what a listener sees, and that of `simulate --record` what the bus does, each error frame once: their counts of error \
frames differ.

Exit codes:
  0  nothing happened until --for or Ctrl-C
  1  something was recorded
  2  wrong usage, or the file exists already, or cannot be created or written
  3  the interface failed

Examples:
  devicenet record can0
  devicenet record can0 --trigger timeout=10 --before 5s --after 5s -o drop.pcapng
  devicenet record can0 --trigger kind=explicit_response,data=??94 --count 3
  devicenet record can0 --trigger duplicate -o - | devicenet decode -
  devicenet record sim:line.toml --trigger silence=2s")]
pub struct RecordArgs {
    /// A CAN interface such as can0, sim:FILE for a scenario, log:FILE for a recording, log:- for one on standard input
    pub endpoint: Endpoint,
    /// What starts a recording; may be given more than once
    #[arg(long, value_name = "TRIGGER")]
    pub trigger: Vec<Trigger>,
    /// How much is written of what came before
    #[arg(long, value_name = "TIME", default_value = "5s")]
    pub before: Time,
    /// How long recording goes on
    #[arg(long, value_name = "TIME", default_value = "5s")]
    pub after: Time,
    /// How many recordings to make; with several the files are numbered
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub count: u32,
    /// Where to: pcapng for a name that ends so, else a candump log; `-` is standard output
    #[arg(long, short = 'o', value_name = "FILE", default_value = "record.log")]
    pub output: PathBuf,
    /// How long to listen; without, until all is recorded or Ctrl-C
    #[arg(long = "for", value_name = "TIME", value_parser = parse_span)]
    pub span: Option<Time>,
}

/// `devicenet recover`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = "\
A node whose MAC ID is in use by another falls silent, and only hears the offline connection set. This claims the set, asks who is \
there, and gives each such node, by vendor and serial number, the MAC ID that it is told. It needs no power cycle, and does not \
disturb nodes that run.

Exit codes:
  0  done; also when nobody is faulted
  1  some node did not get its MAC ID, or one that is to flash did not answer
  2  wrong usage or bad file, or the scenario ended too early
  3  the interface failed, or nobody acknowledged
  4  refused to transmit: no --allow-tx, listen-only, no confirmed bit rate, --own-mac is taken, or
     another tool is at it
130  interrupted before all was done; a node that was told its MAC ID was waited for

Examples:
  devicenet recover can0 --allow-tx
  devicenet recover can0 --identify 0x1234:0x00002345 --allow-tx
  devicenet recover can0 --assign 0x1234:0x00002345=12 --allow-tx
  devicenet recover sim:line.toml --listen 6s --assign-free")]
pub struct RecoverArgs {
    /// A CAN interface such as can0, or sim:FILE for a scenario
    pub endpoint: Endpoint,
    /// Make a device flash red and green; may be given more than once
    #[arg(long, value_name = "VENDOR:SERIAL")]
    pub identify: Vec<Device>,
    /// Give a device a MAC ID; may be given more than once
    #[arg(long, value_name = "VENDOR:SERIAL=MAC")]
    pub assign: Vec<Assignment>,
    /// Give each faulted node the lowest MAC ID from 1 to 62 that was not heard
    #[arg(long, conflicts_with = "assign")]
    pub assign_free: bool,
    /// How to take part in the bus.
    #[command(flatten)]
    pub node: NodeArgs,
}

/// `devicenet slave` and `devicenet master`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = "\
FILE is a scenario, and the node is the one of that role in it; with several, --node names one. What else the scenario has, other \
nodes, actions and faults, is left out. What the node tells is printed, one line each, until Ctrl-C or --for. At its end a master has \
its slaves release their connections, for three seconds at most, so that another may have them at once; a slave just ends. A second \
Ctrl-C ends at once.

Exit codes:
  0  the node ran, until --for, Ctrl-C or the end of the scenario
  1  it did, but was faulted in the end (MAC ID in use, bus-off), or had no I/O with a slave
  2  wrong usage or bad file, or the scenario ended before it began
  3  the interface failed
  4  refused to transmit: no --allow-tx, listen-only, no confirmed bit rate, or another's slave
130  interrupted before it sent anything, or a second time

Examples:
  devicenet slave can0 valve.toml --allow-tx
  devicenet master can0 line.toml --allow-tx --for 10s --json
  devicenet slave sim:line.toml extra.toml --for 5s")]
pub struct RunArgs {
    /// A CAN interface such as can0, or sim:FILE for a scenario
    pub endpoint: Endpoint,
    /// The scenario that the node is in
    pub file: PathBuf,
    /// Which node, by its name
    #[arg(long, value_name = "NAME")]
    pub node: Option<String>,
    /// How long to run; without, until Ctrl-C, or on the simulated bus until its scenario ends
    #[arg(long = "for", value_name = "TIME", value_parser = parse_span)]
    pub span: Option<Time>,
    /// Whether it may send.
    #[command(flatten)]
    pub permit: PermitArgs,
}

/// `devicenet scan`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = "\
Listens, and tells who was heard. With --allow-tx (on the simulated bus always) it then goes on line itself, reads the Identity \
object of every node over an explicit connection, and releases that again. Nodes that another master owns are left alone. Ctrl-C \
ends listening, and what was heard is told; it ends asking when the open connections are released; a second one ends at once.

Exit codes:
  0  done
  1  done, but some node refused, or did not answer all, or some line of a recording could not be
     read
  2  wrong usage or bad file, or the scenario ended too early; those that had answered are told
  3  the interface failed, or nobody acknowledged
  4  refused to transmit: listen-only, no confirmed bit rate, or --own-mac is taken
130  interrupted before every node was asked

Examples:
  devicenet scan can0
  devicenet scan can0 --allow-tx
  devicenet scan log:recording.log --json | jq -c '[.mac, .vendor, .product_name]'
  devicenet scan sim:plant.toml --listen 6s")]
pub struct ScanArgs {
    /// A CAN interface such as can0, sim:FILE for a scenario, log:FILE for a recording, log:- for one on standard input
    pub endpoint: Endpoint,
    /// How to take part in the bus.
    #[command(flatten)]
    pub node: NodeArgs,
}

/// What `get` and `set` ask.
#[derive(Args, Clone, Debug)]
pub struct AskArgs {
    /// A CAN interface such as can0, or sim:FILE for a scenario
    pub endpoint: Endpoint,
    /// The MAC ID of the node (0 to 63)
    #[arg(value_name = "MAC", value_parser = parse_mac_id)]
    pub mac: u8,
    /// CLASS/INSTANCE/ATTRIBUTE, decimal or hexadecimal: 1/1/7 is the product name
    pub attribute: AttributePath,
    /// How to take part in the bus.
    #[command(flatten)]
    pub node: NodeArgs,
}

/// `devicenet get`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = "\
Goes on line, opens an explicit connection to the node, asks, and releases the connection. A node that another master owns is left \
alone. Ctrl-C waits for an answer that is on its way, for three seconds at most, and releases the connection; a second one ends at once.

Exit codes:
  0  the value is printed
  1  the node answered with an error, or did not answer
  2  wrong usage or bad file, or the scenario ended too early
  3  the interface failed, or nobody acknowledged
  4  refused to transmit: no --allow-tx, listen-only, no confirmed bit rate, another's node, or
     --own-mac is taken
130  interrupted before the node had answered

Examples:
  devicenet get can0 10 1/1/7 --allow-tx
  devicenet get can0 10 0x05/2/9 --allow-tx --json
  devicenet get sim:plant.toml 10 3/1/1 --listen 6s")]
pub struct GetArgs {
    /// What is asked.
    #[command(flatten)]
    pub ask: AskArgs,
}

/// `devicenet set`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = "\
As `get`, but writes. VALUE is a number for attributes whose type the command knows, and must be one that the attribute may have; \
bytes (hex:C800) are sent as they are.

A MAC ID (3/1/1) at which somebody was heard or answers is refused: the node would fall silent. Else the node checks it, and comes \
back with it.

Exit codes: those of `get`; 0 says that the node has taken the value, 4 also that its new MAC ID is in use.

Examples:
  devicenet set can0 10 4/100/3 hex:0102 --allow-tx
  devicenet set sim:plant.toml 10 3/1/1 12 --listen 6s")]
pub struct SetArgs {
    /// What is asked.
    #[command(flatten)]
    pub ask: AskArgs,
    /// A number (12, 0x0C, -3), or the bytes as they are on the wire (hex:0C00)
    #[arg(allow_hyphen_values = true)]
    pub value: String,
}

/// Of two summaries.
const SHORTEST_INTERVAL: Duration = Duration::from_millis(10);
