//! `decode --summary`: what each node and each connection did, and which problems there were, in constant memory.

mod connection;
mod histogram;
mod problems;
mod table;

use core::time::Duration;

use devicenet_core::monitor::{ConnectionState, Kind, Monitor, NodeRecord};
use link_core::Instant;
use serde::Serialize;

use super::decoder::Meaning;
use crate::recording::{Content, RecordedFrame};
use connection::ConnectionKey;
use histogram::Histogram;
use problems::Problems;
use table::{Cell, Table};

/// The counts of a recording.
#[derive(Debug)]
pub(super) struct Summary {
    bit_rate: u32,
    buses: Vec<Bus>,
}

#[derive(Debug)]
struct Bus {
    span: Option<(Instant, Instant)>,
    /// Of the first frame, which end before the span begins.
    first_bits: u32,
    total: Count,
    /// By MAC ID, and one more for frames whose sender is not known.
    nodes: Vec<Node>,
    /// Sorted.
    connections: Vec<(ConnectionKey, Connection)>,
    problems: Problems,
}

#[derive(Debug, Default)]
struct Node {
    count: Count,
    record: Option<NodeRecord>,
}

#[derive(Debug, Default)]
struct Count {
    frames: u64,
    bytes: u64,
    bits: u64,
    problems: u64,
    responses: Histogram,
}

/// What is counted of a frame.
struct Seen {
    /// Bits on the wire with stuff bits and intermission, 0 where they are not known.
    bits: u32,
    bytes: usize,
    has_problem: bool,
    /// On a response, the time since the request.
    latency: Option<Duration>,
}

#[derive(Debug, Default)]
struct Connection {
    count: Count,
    states: Vec<ConnectionState>,
}

impl Summary {
    pub(super) fn new(bit_rate: u32) -> Self {
        // A recording without frames is still a bus.
        Self { bit_rate, buses: vec![Bus::new()] }
    }

    /// Takes note of when a frame was on a bus, whether it is counted or not: a load is a part of the whole recording.
    pub(super) fn see_time(&mut self, bus: usize, frame: &RecordedFrame) {
        let bus = self.bus(bus);
        if let Some((first, last)) = bus.span {
            bus.span = Some((first.min(frame.at), last.max(frame.at)));
        } else {
            bus.first_bits = bits_of(&frame.content);
            bus.span = Some((frame.at, frame.at));
        }
    }

    /// Counts a frame of a bus.
    pub(super) fn observe(&mut self, bus: usize, frame: &RecordedFrame, meaning: &Meaning<'_>) {
        let bus = self.bus(bus);
        let seen = Seen::new(frame, meaning);
        bus.total.add(&seen);
        bus.problems.observe(frame, meaning);
        bus.nodes[meaning.source().map_or(NODES, usize::from)].count.add(&seen);
        if let Meaning::Read(reading) = meaning
            && let Some(key) = ConnectionKey::of(reading)
        {
            bus.connection(key).count.add(&seen);
        }
    }

    /// Takes over what the monitor of a bus has learned.
    pub(super) fn learn(&mut self, bus: usize, monitor: &Monitor) {
        let bus = self.bus(bus);
        for record in monitor.nodes() {
            let mac = usize::from(record.mac.number());
            bus.nodes[mac].record = Some(record);
        }
        for record in monitor.connections() {
            let key =
                ConnectionKey { node: Some(record.server.number()), name: connection::name(record.name) };
            // Only connections that had a frame among those shown.
            if let Ok(index) = bus.connections.binary_search_by_key(&key, |(key, _)| *key) {
                let states = &mut bus.connections[index].1.states;
                states.extend(record.states().filter(|state| !states.contains(state)).collect::<Vec<_>>());
            }
        }
    }

    fn bus(&mut self, index: usize) -> &mut Bus {
        if self.buses.len() <= index {
            self.buses.resize_with(index + 1, Bus::new);
        }
        &mut self.buses[index]
    }

    /// As tables for people.
    pub(super) fn text(&self, channel: impl Fn(usize) -> String) -> String {
        let mut out = String::new();
        for (index, bus) in self.buses.iter().enumerate() {
            if index > 0 {
                out.push('\n');
            }
            out += &format!(
                "{}: {} frames in {:.3} s, {} with a problem\n\
                 bus load {} at {} kbit/s, stuff bits and intermission included\n",
                channel(index),
                bus.total.frames,
                bus.seconds(),
                bus.total.problems,
                percent(bus.load(&bus.total, self.bit_rate)),
                f64::from(self.bit_rate) / 1000.0,
            );
            if bus.total.frames > 0 {
                out += &format!("\n{}\n{}", self.node_table(bus), self.connection_table(bus));
            }
            if !bus.problems.is_empty() {
                out += &format!("\n{}", bus.problems.table());
            }
        }
        out
    }

    fn node_table(&self, bus: &Bus) -> Table {
        let mut table = Table::new(&[&["node"][..], &COUNT_COLUMNS, &["access", "device"]].concat());
        for (mac, Node { count, record }) in bus.senders() {
            let node = vec![Cell::right(mac.map_or_else(|| "-".to_owned(), |mac| mac.to_string()))];
            let known = match record {
                Some(record) => vec![Cell::left(record.access.to_string()), Cell::left(device(record))],
                None => vec![Cell::left(""), Cell::left("")],
            };
            table.row([node, count.cells(bus.load(count, self.bit_rate)), known].concat());
        }
        table
    }

    fn connection_table(&self, bus: &Bus) -> Table {
        let mut table = Table::new(&[&["node", "connection"][..], &COUNT_COLUMNS, &["states seen"]].concat());
        for (key, Connection { count, states }) in &bus.connections {
            let node = key.node.map_or_else(|| "all".to_owned(), |mac| mac.to_string());
            let names = vec![Cell::right(node), Cell::left(key.name)];
            let states = states.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
            table
                .row([names, count.cells(bus.load(count, self.bit_rate)), vec![Cell::left(states)]].concat());
        }
        table
    }

    /// As JSON, one object a line: first the bus, then its nodes, its connections, its problems.
    pub(super) fn json(&self, channel: impl Fn(usize) -> String) -> String {
        let mut out = String::new();
        for (index, bus) in self.buses.iter().enumerate() {
            let channel = channel(index);
            let seconds = Some(bus.seconds());
            let record = |summary| Record { summary, channel: &channel, ..Record::default() };
            let mut push = |record: &Record<'_>| out += &line(record);
            let load = |count: &Count| bus.load(count, self.bit_rate);
            let bus_record = Record { seconds, bit_rate: Some(self.bit_rate), ..record("bus") };
            push(&bus_record.with_count(&bus.total, load(&bus.total)));
            for (node, Node { count, record: known }) in bus.senders() {
                let node = Record { node, ..record("node") }.with_count(count, load(count));
                push(&node.with_identity(known.as_ref()));
            }
            for (key, Connection { count, states }) in &bus.connections {
                let states = Some(states.iter().map(|state| state.name()).collect());
                let connection =
                    Record { node: key.node, connection: Some(key.name), ..record("connection") };
                push(&Record { states, ..connection }.with_count(count, load(count)));
            }
            for problem in bus.problems.records(&channel) {
                out += &line(&problem);
            }
        }
        out
    }
}

impl Bus {
    fn new() -> Self {
        let nodes = core::iter::repeat_with(Node::default).take(NODES + 1).collect();
        Self {
            span: None,
            first_bits: 0,
            total: Count::default(),
            nodes,
            connections: Vec::new(),
            problems: Problems::default(),
        }
    }

    fn connection(&mut self, key: ConnectionKey) -> &mut Connection {
        let index = self.connections.binary_search_by_key(&key, |(key, _)| *key).unwrap_or_else(|index| {
            self.connections.insert(index, (key, Connection::default()));
            index
        });
        &mut self.connections[index].1
    }

    /// The nodes that sent something; those not known last.
    fn senders(&self) -> impl Iterator<Item = (Option<u8>, &Node)> {
        let numbered =
            (0u8..).zip(&self.nodes).map(|(mac, node)| ((usize::from(mac) < NODES).then_some(mac), node));
        numbered.filter(|(_, node)| node.count.frames > 0)
    }

    /// The time between the first and the last frame.
    fn seconds(&self) -> f64 {
        self.span.map_or(0.0, |(first, last)| last.saturating_since(first).as_secs_f64())
    }

    /// The part of the time from the begin of the first frame to the end of the last that frames took, 0 to 1. The time
    /// of a frame is its end, so the first one's own length comes before the first time.
    fn load(&self, count: &Count, bit_rate: u32) -> Option<f64> {
        let bits = self.seconds() * f64::from(bit_rate) + f64::from(self.first_bits);
        (bits > 0.0).then(|| count.bits as f64 / bits)
    }
}

/// The bits that an entry took on the bus, with the intermission; those of error and CAN FD frames are not known.
fn bits_of(content: &Content) -> u32 {
    match content {
        Content::Classic(frame) => frame.bit_len() + INTERMISSION,
        Content::Error(_) | Content::Fd(_) => 0,
    }
}

impl Seen {
    fn new(frame: &RecordedFrame, meaning: &Meaning<'_>) -> Self {
        let bytes = match &frame.content {
            Content::Classic(frame) => frame.data().len(),
            Content::Error(_) => 0,
            Content::Fd(frame) => frame.data().len(),
        };
        let bits = bits_of(&frame.content);
        let latency = match meaning {
            // An acknowledge answers a fragment, but is no response.
            Meaning::Read(reading) if reading.kind == Kind::FragmentAck => None,
            Meaning::Read(reading) => reading.request.map(|request| request.latency),
            Meaning::Outside(_) => None,
        };
        Self { bits, bytes, has_problem: meaning.has_problem(), latency }
    }
}

impl Count {
    fn add(&mut self, seen: &Seen) {
        self.frames += 1;
        self.bytes += seen.bytes as u64;
        self.bits += u64::from(seen.bits);
        self.problems += u64::from(seen.has_problem);
        if let Some(latency) = seen.latency {
            self.responses.record(latency);
        }
    }

    /// The cells below [`COUNT_COLUMNS`].
    fn cells(&self, load: Option<f64>) -> Vec<Cell> {
        let milliseconds = |span: Duration| match self.responses.count() {
            0 => "-".to_owned(),
            _ => format!("{:.3} ms", span.as_secs_f64() * 1000.0),
        };
        let responses = &self.responses;
        vec![
            Cell::right(self.frames.to_string()),
            Cell::right(self.bytes.to_string()),
            Cell::right(self.problems.to_string()),
            Cell::right(percent(load)),
            Cell::right(milliseconds(responses.percentile(50))),
            Cell::right(milliseconds(responses.percentile(99))),
            Cell::right(milliseconds(responses.max())),
        ]
    }
}

/// One line of the JSON summary; `response` holds seconds.
#[derive(Serialize, Default)]
struct Record<'a> {
    summary: &'static str,
    channel: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    node: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    connection: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bit_rate: Option<u32>,
    frames: u64,
    bytes: u64,
    problems: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    load: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    response: Option<Response>,
    #[serde(skip_serializing_if = "Option::is_none")]
    states: Option<Vec<&'static str>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    access: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    vendor: Option<u16>,
    #[serde(skip_serializing_if = "Option::is_none")]
    serial: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    product: Option<u16>,
}

#[derive(Serialize)]
struct Response {
    count: u64,
    p50: f64,
    p99: f64,
    max: f64,
}

impl Record<'_> {
    fn with_count(mut self, count: &Count, load: Option<f64>) -> Self {
        let responses = &count.responses;
        (self.frames, self.bytes, self.problems) = (count.frames, count.bytes, count.problems);
        self.load = load;
        self.response = (responses.count() > 0).then(|| Response {
            count: responses.count(),
            p50: responses.percentile(50).as_secs_f64(),
            p99: responses.percentile(99).as_secs_f64(),
            max: responses.max().as_secs_f64(),
        });
        self
    }

    fn with_identity(mut self, known: Option<&NodeRecord>) -> Self {
        if let Some(record) = known {
            self.access = Some(record.access.name());
            (self.vendor, self.serial) = (record.vendor.map(|vendor| vendor.0), record.serial);
            self.product = record.product;
        }
        self
    }
}

/// An object as a line.
fn line(record: &impl Serialize) -> String {
    // Numbers and strings: nothing in it can fail.
    serde_json::to_string(record).unwrap_or_default() + "\n"
}

/// `Pressure gauge, vendor 4660, serial 0x00002345`, as far as it is known.
fn device(record: &NodeRecord) -> String {
    let name = record.product_name.iter().map(|&byte| char::from(byte)).collect::<String>();
    let name = Some(name.trim().to_owned()).filter(|name| !name.is_empty());
    let vendor = record.vendor.map(|vendor| format!("vendor {}", vendor.0));
    let serial = record.serial.map(|serial| format!("serial 0x{serial:08X}"));
    [name, vendor, serial].into_iter().flatten().collect::<Vec<_>>().join(", ")
}

fn percent(load: Option<f64>) -> String {
    load.map_or_else(|| "-".to_owned(), |load| format!("{:.2} %", load * 100.0))
}

/// Bits between two frames.
const INTERMISSION: u32 = 3;
/// MAC IDs 0 to 63.
const NODES: usize = 64;
const COUNT_COLUMNS: [&str; 7] = ["frames", "bytes", "problems", "load", "response p50", "p99", "max"];
