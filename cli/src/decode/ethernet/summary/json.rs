//! The summary as JSON, one object a line.

use powerlink_core::NodeId;
use powerlink_core::monitor::{Cycle, Monitor, NodeRecord};
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::{Abort, Count, Network, Summary, Transfers};
use crate::histogram::Histogram;
use crate::text::seconds_number;

impl Summary {
    /// As JSON, one object a line: first the network, then its nodes, its SDO connections, what was refused, which errors nodes report, its
    /// problems.
    pub(in crate::decode::ethernet) fn json(
        &self,
        monitors: &[Box<Monitor>],
        channel: impl Fn(usize) -> String,
    ) -> String {
        let mut out = String::new();
        for (index, network) in self.networks.iter().enumerate() {
            let channel = channel(index);
            let monitor = monitors.get(index).map(AsRef::as_ref);
            let mut push = |summary, fields| out += &line(&Row { summary, channel: &channel, fields });
            push("network", network.record(monitor));
            for (node, count) in network.senders() {
                let known = node.and_then(|node| monitor?.node(NodeId(node)));
                push("node", network.node_record(node, count, known));
            }
            for (pair, transfers) in network.transfers() {
                let Transfers { reads, writes, others, aborts, responses } = transfers;
                let mut record = json!({
                    "reads": reads, "writes": writes, "others": others, "aborts": aborts, "response": times(responses),
                });
                put(&mut record, "client", pair.map(|(client, _)| client));
                put(&mut record, "server", pair.map(|(_, server)| server));
                push("sdo", record);
            }
            for (abort, count) in network.aborts() {
                let mut record = json!({ "count": count });
                if let Some(Abort { client, server, object, code }) = abort {
                    put(&mut record, "client", Some(client));
                    put(&mut record, "server", Some(server));
                    put(&mut record, "abort", Some(code));
                    put(&mut record, "abort_name", code.name());
                    put(&mut record, "index", object.map(|(index, _)| index));
                    put(&mut record, "subindex", object.map(|(_, sub)| sub));
                }
                push("sdo_abort", record);
            }
            network.reports.records().for_each(|record| push("error", record));
            for problem in network.problems.records(&channel) {
                out += &line(&problem);
            }
        }
        out
    }
}

impl Network {
    fn record(&self, monitor: Option<&Monitor>) -> Value {
        let kinds: Map<_, _> =
            self.kinds().map(|(kind, frames)| (kind.name().to_owned(), frames.into())).collect();
        let Count { frames, bytes, problems, .. } = &self.total;
        let mut record = json!({
            "seconds": self.seconds(), "verdict": self.verdict,
            "frames": frames, "bytes": bytes, "problems": problems, "kinds": kinds,
        });
        let lost = monitor.map(Monitor::lost).unwrap_or_default();
        put(&mut record, "sdo_given_up", Some(lost.connections).filter(|count| *count > 0));
        put(&mut record, "sdo_not_stored", Some(lost.transfers).filter(|count| *count > 0));
        put(&mut record, "clock_back", Some(self.clock_back).filter(|count| *count > 0));
        put(&mut record, "cycle", monitor.and_then(|monitor| self.cycle_record(monitor.cycle())));
        record
    }

    fn cycle_record(&self, cycle: &Cycle) -> Option<Value> {
        let mut record = json!({
            "socs": cycle.socs, "missing": cycle.missing,
            "mean": cycle.mean()?.as_secs_f64(), "min": cycle.min.as_secs_f64(), "max": cycle.max.as_secs_f64(),
            "jitter": cycle.jitter()?.as_secs_f64(),
        });
        put(&mut record, "nominal", cycle.nominal().map(|nominal| nominal.as_secs_f64()));
        let is_timed = self.cycle.count() > 0;
        put(&mut record, "p99", is_timed.then(|| self.cycle.percentile(99).as_secs_f64()));
        Some(record)
    }

    fn node_record(&self, node: Option<u8>, count: &Count, known: Option<&NodeRecord>) -> Value {
        let Count { frames, bytes, problems, pres } = count;
        let mut record = json!({
            "frames": frames, "bytes": bytes, "problems": problems,
        });
        put(&mut record, "node", node);
        put(&mut record, "pres", times(pres));
        let Some(known) = known else { return record };
        put(&mut record, "mac_address", known.mac.map(|mac| mac.to_string()));
        put(&mut record, "nmt_state", known.state.map(|state| state.to_string()));
        let history = known.history.iter().map(|change| {
            json!({ "t": seconds_number(change.at, self.digits), "n": change.n, "nmt_state": change.state.to_string() })
        });
        put(&mut record, "states", Some(history.collect::<Vec<_>>()));
        put(&mut record, "states_forgotten", Some(known.forgotten).filter(|forgotten| *forgotten > 0));
        let losses = json!({
            "polls": known.polls, "pres_missing": known.pres_missing, "pres_late": known.pres_late,
            "answers_missing": known.answers_missing,
        });
        put(&mut record, "losses", Some(losses));
        put(&mut record, "identity", known.ident.as_ref().map(powerlink_core::monitor::IdentityFields));
        record
    }
}

/// One line.
#[derive(Serialize)]
struct Row<'a> {
    summary: &'static str,
    channel: &'a str,
    #[serde(flatten)]
    fields: Value,
}

/// Seconds, percentiles with two significant digits.
fn times(histogram: &Histogram) -> Option<Value> {
    (histogram.count() > 0).then(|| {
        json!({
            "count": histogram.count(),
            "p50": histogram.percentile(50).as_secs_f64(),
            "p99": histogram.percentile(99).as_secs_f64(),
            "max": histogram.max().as_secs_f64(),
        })
    })
}

/// Adds a field that is there.
fn put(record: &mut Value, key: &str, value: Option<impl Serialize>) {
    if let Some(value) = value {
        record[key] = json!(value);
    }
}

/// An object as a line.
fn line(record: &impl Serialize) -> String {
    // Numbers and strings: nothing in it can fail.
    serde_json::to_string(record).unwrap_or_default() + "\n"
}
