//! `decode --summary`: what each node and each connection did, in constant memory.

mod histogram;
mod table;

use core::time::Duration;

use link_core::Instant;
use serde::Serialize;

use histogram::Histogram;
use table::{Cell, Table};

/// What the summary takes from one frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Observation<'a> {
    /// Which bus: the index of the channel.
    pub(super) bus: usize,
    pub(super) at: Instant,
    /// Bits on the wire with stuff bits and intermission, 0 where they are not known.
    pub(super) bits: u32,
    pub(super) bytes: usize,
    /// The node that sent it.
    pub(super) source: Option<u8>,
    /// What it belongs to.
    pub(super) connection: Option<ConnectionKey>,
    /// The state of that connection after the frame.
    pub(super) state: Option<&'a str>,
    /// On a response, the time since the request.
    pub(super) latency: Option<Duration>,
    pub(super) has_problem: bool,
}

/// A connection of a node, or another exchange that belongs together.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) struct ConnectionKey {
    /// The node it belongs to: the slave of a master/slave connection; none for a command to all.
    pub(super) node: Option<u8>,
    pub(super) name: &'static str,
}

/// The counts of a recording.
#[derive(Debug)]
pub(super) struct Summary {
    bit_rate: u32,
    buses: Vec<Bus>,
}

#[derive(Debug, Default)]
struct Bus {
    span: Option<(Instant, Instant)>,
    total: Count,
    /// By MAC ID, and one more for frames whose sender is not known.
    nodes: Vec<Count>,
    connections: Vec<(ConnectionKey, Connection)>,
}

#[derive(Debug, Default)]
struct Count {
    frames: u64,
    bytes: u64,
    bits: u64,
    problems: u64,
    responses: Histogram,
}

#[derive(Debug, Default)]
struct Connection {
    count: Count,
    states: Vec<Box<str>>,
}

impl Summary {
    pub(super) fn new(bit_rate: u32) -> Self {
        Self { bit_rate, buses: Vec::new() }
    }

    pub(super) fn observe(&mut self, seen: &Observation<'_>) {
        if self.buses.len() <= seen.bus {
            self.buses.resize_with(seen.bus + 1, Bus::default);
        }
        let bus = &mut self.buses[seen.bus];
        let (first, last) = bus.span.unwrap_or((seen.at, seen.at));
        bus.span = Some((first.min(seen.at), last.max(seen.at)));
        bus.total.add(seen);
        if bus.nodes.is_empty() {
            bus.nodes.resize_with(NODES + 1, Count::default);
        }
        bus.nodes[seen.source.map_or(NODES, |mac| usize::from(mac).min(NODES))].add(seen);
        let Some(key) = seen.connection else { return };
        let index = bus.connections.binary_search_by_key(&key, |(key, _)| *key).unwrap_or_else(|index| {
            bus.connections.insert(index, (key, Connection::default()));
            index
        });
        let connection = &mut bus.connections[index].1;
        connection.count.add(seen);
        if let Some(state) = seen.state
            && !connection.states.iter().any(|known| **known == *state)
        {
            connection.states.push(state.into());
        }
    }

    /// As tables for people.
    pub(super) fn text(&self, channel: impl Fn(usize) -> String) -> String {
        let mut out = String::new();
        for (index, bus) in self.buses.iter().enumerate() {
            let Some((first, last)) = bus.span else { continue };
            let seconds = last.saturating_since(first).as_secs_f64();
            out += &format!(
                "{}: {} frames in {seconds:.3} s, {} with a problem\n\
                 bus load {} at {} kbit/s, stuff bits and intermission included\n\n",
                channel(index),
                bus.total.frames,
                bus.total.problems,
                percent(bus.load(&bus.total, self.bit_rate)),
                f64::from(self.bit_rate) / 1000.0,
            );
            out += &self.node_table(bus).to_string();
            out.push('\n');
            out += &self.connection_table(bus).to_string();
        }
        out
    }

    fn node_table(&self, bus: &Bus) -> Table {
        let mut table = Table::new(&[&["node"][..], &COUNT_COLUMNS].concat());
        for (mac, count) in bus.nodes.iter().enumerate().filter(|(_, count)| count.frames > 0) {
            let node = if mac < NODES { mac.to_string() } else { "-".to_owned() };
            table.row([vec![Cell::right(node)], count.cells(bus.load(count, self.bit_rate))].concat());
        }
        table
    }

    fn connection_table(&self, bus: &Bus) -> Table {
        let mut table = Table::new(&[&["node", "connection"][..], &COUNT_COLUMNS, &["states seen"]].concat());
        for (key, Connection { count, states }) in &bus.connections {
            let node = key.node.map_or_else(|| "all".to_owned(), |mac| mac.to_string());
            let names = vec![Cell::right(node), Cell::left(key.name)];
            let states = vec![Cell::left(states.join(", "))];
            table.row([names, count.cells(bus.load(count, self.bit_rate)), states].concat());
        }
        table
    }

    /// As JSON, one object a line: first the bus, then its nodes, then its connections.
    pub(super) fn json(&self, channel: impl Fn(usize) -> String) -> String {
        let mut out = String::new();
        for (index, bus) in self.buses.iter().enumerate() {
            let Some((first, last)) = bus.span else { continue };
            let channel = channel(index);
            let seconds = Some(last.saturating_since(first).as_secs_f64());
            let record = |summary| Record { summary, channel: &channel, ..Record::default() };
            let mut push = |record: &Record<'_>| {
                // Numbers and strings: nothing in it can fail.
                out += &serde_json::to_string(record).unwrap_or_default();
                out.push('\n');
            };
            let load = |count: &Count| bus.load(count, self.bit_rate);
            let bus_record = Record { seconds, bit_rate: Some(self.bit_rate), ..record("bus") };
            push(&bus_record.with_count(&bus.total, load(&bus.total)));
            for (mac, count) in bus.nodes.iter().enumerate().filter(|(_, count)| count.frames > 0) {
                let node = (mac < NODES).then_some(mac as u8);
                push(&Record { node, ..record("node") }.with_count(count, load(count)));
            }
            for (key, Connection { count, states }) in &bus.connections {
                let connection =
                    Record { node: key.node, connection: Some(key.name), ..record("connection") };
                push(&Record { states: Some(states), ..connection }.with_count(count, load(count)));
            }
        }
        out
    }
}

impl Bus {
    /// The part of the time between the first and the last frame that frames took, 0 to 1.
    fn load(&self, count: &Count, bit_rate: u32) -> Option<f64> {
        let (first, last) = self.span?;
        let bits = last.saturating_since(first).as_secs_f64() * f64::from(bit_rate);
        (bits > 0.0).then(|| count.bits as f64 / bits)
    }
}

impl Count {
    fn add(&mut self, seen: &Observation<'_>) {
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
    states: Option<&'a [Box<str>]>,
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
}

fn percent(load: Option<f64>) -> String {
    load.map_or_else(|| "-".to_owned(), |load| format!("{:.2} %", load * 100.0))
}

/// MAC IDs 0 to 63.
const NODES: usize = 64;
const COUNT_COLUMNS: [&str; 7] = ["frames", "bytes", "problems", "load", "response p50", "p99", "max"];

#[cfg(test)]
mod tests {
    use super::*;

    const POLL: ConnectionKey = ConnectionKey { node: Some(10), name: "poll" };

    fn summary() -> Summary {
        let mut summary = Summary::new(125_000);
        for n in 0..101 {
            let is_response = n % 2 == 1;
            summary.observe(&Observation {
                bus: 0,
                at: Instant::from_millis(n * 10),
                bits: 100,
                bytes: 2,
                source: Some(if is_response { 10 } else { 1 }),
                connection: Some(POLL),
                state: Some(if n < 50 { "configuring" } else { "established" }),
                latency: is_response.then_some(Duration::from_micros(300)),
                has_problem: n == 7,
            });
        }
        summary
    }

    #[test]
    fn counts_and_computes_the_load() {
        let text = summary().text(|_| "can0".to_owned());
        let expected = "\
can0: 101 frames in 1.000 s, 1 with a problem
bus load 8.08 % at 125 kbit/s, stuff bits and intermission included

node  frames  bytes  problems    load  response p50       p99       max
   1      51    102         0  4.08 %             -         -         -
  10      50    100         1  4.00 %      0.299 ms  0.299 ms  0.300 ms

node  connection  frames  bytes  problems    load  response p50       p99       max  states seen
  10  poll           101    202         1  8.08 %      0.299 ms  0.299 ms  0.300 ms  configuring, established
";
        assert_eq!(text, expected);
    }

    #[test]
    fn json_has_a_line_for_each_row() {
        let json = summary().json(|_| "can0".to_owned());
        let lines: Vec<serde_json::Value> =
            json.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let kinds: Vec<_> = lines.iter().map(|line| line["summary"].as_str().unwrap()).collect();
        assert_eq!(kinds, ["bus", "node", "node", "connection"]);
        assert_eq!(lines[0]["load"], 0.0808);
        assert_eq!((&lines[3]["node"], &lines[3]["connection"]), (&10.into(), &"poll".into()));
        assert_eq!(lines[3]["response"]["max"], 0.0003);
    }
}
