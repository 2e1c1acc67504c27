//! The summary as JSON, one object a line.

use serde::Serialize;

use super::{Connection, Count, Known, Node, Summary};
use crate::verdict::Verdict;

impl Summary {
    /// As JSON, one object a line: first the bus, then its nodes, its connections, its findings, its problems.
    pub(in crate::decode) fn json(&self, channel: impl Fn(usize) -> String) -> String {
        let mut out = String::new();
        for (index, bus) in self.buses.iter().enumerate() {
            let channel = channel(index);
            let seconds = Some(bus.seconds());
            let record = |summary| Record { summary, channel: &channel, ..Record::default() };
            let mut push = |record: &Record<'_>| out += &line(record);
            let rate = self.rate(bus);
            let load = |count: &Count| bus.load(count, rate);
            let bit_rate = Some(rate.rate().0);
            let bit_rate_source = Some(rate.source());
            let bus_record = Record {
                seconds,
                bit_rate,
                bit_rate_source,
                verdict: bus.verdict,
                error_frames: Some(bus.errors.frames),
                error_load: load(&bus.errors),
                ..record("bus")
            };
            push(&bus_record.with_count(&bus.total, load(&bus.total)));
            for (node, Node { count, known }) in bus.senders() {
                let node = Record { node, ..record("node") }.with_count(count, load(count));
                push(&node.with_identity(known.as_ref()));
            }
            for (key, Connection { count, states }) in &bus.connections {
                let states = Some(states.iter().map(|state| state.name()).collect());
                let connection = Record {
                    node: key.node.mac(),
                    connection: Some(key.name.to_string()),
                    client: key.name.client(),
                    ..record("connection")
                };
                push(&Record { states, ..connection }.with_count(count, load(count)));
            }
            for finding in bus.findings.records(&channel) {
                out += &line(&finding);
            }
            if let Some(forgotten) = bus.findings.forgotten(&channel) {
                out += &line(&forgotten);
            }
            for problem in bus.problems.records(&channel) {
                out += &line(&problem);
            }
        }
        out
    }
}

/// One line of the JSON summary; `response` holds seconds, percentiles with two significant digits.
#[derive(Serialize, Default)]
struct Record<'a> {
    summary: &'static str,
    channel: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    node: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    connection: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    client: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bit_rate: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bit_rate_source: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    verdict: Option<Verdict>,
    frames: u64,
    bytes: u64,
    problems: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    load: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error_frames: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error_load: Option<f64>,
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
    #[serde(skip_serializing_if = "Option::is_none")]
    product_name: Option<&'a str>,
}

#[derive(Serialize)]
struct Response {
    count: u64,
    p50: f64,
    p99: f64,
    max: f64,
}

impl<'a> Record<'a> {
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

    fn with_identity(mut self, known: Option<&'a Known>) -> Self {
        if let Some(known) = known {
            self.access = Some(known.access);
            (self.vendor, self.serial, self.product) = (known.vendor, known.serial, known.product);
            self.product_name = known.product_name.as_deref();
        }
        self
    }
}

/// An object as a line.
fn line(record: &impl Serialize) -> String {
    // Numbers and strings: nothing in it can fail.
    serde_json::to_string(record).unwrap_or_default() + "\n"
}
