//! The run as JSON, one object a line.
//!
//! Every object has `event` and `t` (seconds). By `event`:
//!
//! | `event` | other fields |
//! |---|---|
//! | `frame` | `nodes` (who sent it), `segment` (1 on the part of a cut bus that is apart, else absent) and the fields of `devicenet decode --json`: `n`, `id`, `ext`, `rtr`, `dlc`, `data`, `protocol`, `kind` and so on |
//! | `error_frame` | `nodes` (who tried to send), `segment`, `id`, `ext`, `rtr`, `dlc`, `data`, `error` (`bit`, `stuff`, `crc`, `form`, `ack`), `bit`, `field`, `by` (who saw it first), `flag` (`active`, `passive`, `none`) |
//! | `abandoned` | `nodes`, `segment`, `id`, `ext`, `rtr`, `dlc`, `data`: an attempt was broken off without an error frame, because all that sent went off the bus |
//! | `state` | `node`, `from`, `to`, `cause`: network access changed its state |
//! | `connection` | `node`, `connection` (instance of the Connection object), `from`, `to`, `cause`: a slave's connection changed its state |
//! | `output` | `node`, `connection`, `data`: a slave has other outputs |
//! | `slave` | `node` (the master), `slave` (MAC ID), `from`, `to`, `cause`: the master is elsewhere with a slave |
//! | `planned` | `node` (the manager), `device` (operational address), `from`, `to`, `cause`: a planned device has another state |
//! | `status` | `node` (the master), `slave` (absent for the scanner itself), `status`, `text`: another scanner status |
//! | `input` | `node` (the master), `slave`, `connection`, `data`: other input data of a slave |
//! | `scan` | `node` (the master), `missing`: a scan is over, and so many responses are missing |
//! | `node` | `node`, `text`: something else that a node tells |
//! | `error_state` | `node`, `state` (`error-active`, `error warning`, `error-passive`, `bus-off`), `tec`, `rec` |
//! | `change` | `node` (absent for the bus), `text`: what was done to it, or what went wrong with a client of the server that sits on it |
//! | `violation` | `node`, `text`: a rule of the bus was broken |
//! | `note` | `text`: a heading of the scenario |
//! | `expectation` | `line`, `node`, `expected`, `found`: it failed |
//! | `summary` | `nodes`, `bus`, `held`, `failed`, `unjudged`: comes last |

mod attempt;

use devicenet_core::access::AccessEvent;
use devicenet_core::master::{self, MasterEvent};
use devicenet_core::slave::SlaveEvent;
use devicenex_core::access as nex;
use devicenex_core::device::DeviceEvent;
use devicenex_core::manager::{ManagerEvent, PlannedEvent};
use link_core::Instant;
use serde::Serialize;
use transport_mock::record::Outcome;

use super::event::NodeEvent;
use super::exchange::{device_state, explicit_state, io_state, slave_state};
use super::expectations::Verdict;
use super::said::Said;
use super::shared::SharedBuffer;
use super::sight::{Nodes, Sight, View};
use super::state::{nex_state_name, state_name};
use super::summary::Summary;
use attempt::{Attempt, ErrorFields, attempt, error_fields};

/// Writes the objects.
pub(super) struct JsonView {
    out: SharedBuffer,
}

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
enum Line<'a> {
    Frame {
        #[serde(flatten)]
        attempt: Attempt<'a>,
        #[serde(flatten)]
        reading: Option<&'a Said<'a>>,
    },
    ErrorFrame {
        #[serde(flatten)]
        attempt: Attempt<'a>,
        #[serde(flatten)]
        error: ErrorFields<'a>,
    },
    Abandoned {
        #[serde(flatten)]
        attempt: Attempt<'a>,
    },
    State {
        t: f64,
        node: &'a str,
        from: &'static str,
        to: &'static str,
        cause: &'static str,
    },
    Connection {
        t: f64,
        node: &'a str,
        connection: u16,
        from: &'static str,
        to: &'static str,
        cause: String,
    },
    Output {
        t: f64,
        node: &'a str,
        connection: u16,
        data: String,
    },
    Slave {
        t: f64,
        node: &'a str,
        slave: u8,
        from: &'static str,
        to: &'static str,
        cause: String,
    },
    Planned {
        t: f64,
        node: &'a str,
        device: u8,
        from: &'static str,
        to: &'static str,
        cause: &'static str,
    },
    Status {
        t: f64,
        node: &'a str,
        #[serde(skip_serializing_if = "Option::is_none")]
        slave: Option<u8>,
        status: u8,
        #[serde(skip_serializing_if = "Option::is_none")]
        text: Option<&'static str>,
    },
    Input {
        t: f64,
        node: &'a str,
        slave: u8,
        connection: u16,
        data: String,
    },
    Scan {
        t: f64,
        node: &'a str,
        missing: u8,
    },
    Node {
        t: f64,
        node: &'a str,
        text: String,
    },
    ErrorState {
        t: f64,
        node: &'a str,
        state: &'static str,
        tec: u16,
        rec: u16,
    },
    Change {
        t: f64,
        #[serde(skip_serializing_if = "Option::is_none")]
        node: Option<&'a str>,
        text: &'a str,
    },
    Violation {
        t: f64,
        node: &'a str,
        text: &'a str,
    },
    Note {
        t: f64,
        text: &'a str,
    },
    Expectation {
        t: f64,
        line: usize,
        node: &'a str,
        expected: &'a str,
        found: &'a str,
    },
    Summary {
        t: f64,
        #[serde(flatten)]
        summary: &'a Summary,
        held: usize,
        failed: usize,
        unjudged: usize,
    },
}

impl JsonView {
    pub(super) const fn new(out: SharedBuffer) -> Self {
        Self { out }
    }
}

impl View for JsonView {
    fn see(&mut self, nodes: &Nodes<'_>, sight: &Sight<'_>) {
        let line = match sight {
            Sight::Frame { record, reading } => {
                let attempt = attempt(nodes, record, reading.as_ref().map(|said| said.n()));
                match record.outcome {
                    Outcome::Ok => Line::Frame { attempt, reading: *reading },
                    Outcome::Error(error) => Line::ErrorFrame { attempt, error: error_fields(nodes, &error) },
                    Outcome::Abandoned => Line::Abandoned { attempt },
                }
            }
            Sight::Event { at, node, event } => node_event(seconds(*at), nodes.name(*node), event),
            Sight::Level { at, node, level, counters } => Line::ErrorState {
                t: seconds(*at),
                node: nodes.name(*node),
                state: level.name(),
                tec: counters.tec,
                rec: counters.rec,
            },
            Sight::Change { at, node, what, .. } => {
                Line::Change { t: seconds(*at), node: node.map(|node| nodes.name(node)), text: what }
            }
            Sight::Broken { at, node, rule } => {
                Line::Violation { t: seconds(*at), node: nodes.name(*node), text: rule }
            }
            Sight::Note { at, text } => Line::Note { t: seconds(*at), text },
        };
        self.out.write(|out| push(out, &line));
    }
}

/// What comes at the end: the expectations that failed, and the summary.
pub(super) fn push_end(out: &mut Vec<u8>, end: Instant, verdict: &Verdict, summary: &Summary) {
    let t = seconds(end);
    for failure in &verdict.failures {
        let (node, expected, found) = (&failure.node, &failure.expected, &failure.found);
        push(out, &Line::Expectation { t, line: failure.line, node, expected, found });
    }
    let (held, failed, unjudged) = (verdict.held, verdict.failures.len(), verdict.unjudged);
    push(out, &Line::Summary { t, summary, held, failed, unjudged });
}

/// What a node tells, as an object with its fields.
pub(crate) fn object(at: Instant, node: &str, event: &NodeEvent) -> serde_json::Value {
    // Neither these types nor keys of text can fail.
    serde_json::to_value(node_event(seconds(at), node, event)).unwrap_or_default()
}

fn push(out: &mut Vec<u8>, line: &Line<'_>) {
    // Neither writing to a vector nor these types can fail.
    let _ = serde_json::to_writer(&mut *out, line);
    out.push(b'\n');
}

/// Who tells what, and when; the rest is one for all.
fn node_event<'a>(t: f64, node: &'a str, event: &'a NodeEvent) -> Line<'a> {
    match event {
        NodeEvent::Access(AccessEvent::StateChanged { from, to, cause }) => Line::State {
            t,
            node,
            from: state_name(*from).name(),
            to: state_name(*to).name(),
            cause: cause.name(),
        },
        NodeEvent::NexAccess(nex::AccessEvent::StateChanged { from, to, cause }) => Line::State {
            t,
            node,
            from: nex_state_name(*from).name(),
            to: nex_state_name(*to).name(),
            cause: cause.name(),
        },
        NodeEvent::Device(DeviceEvent::Io { connection, from, to, cause }) => Line::Connection {
            t,
            node,
            connection: connection.number().0,
            from: io_state(*from).name(),
            to: io_state(*to).name(),
            cause: cause.to_string(),
        },
        NodeEvent::Device(DeviceEvent::Explicit { connection, from, to, cause }) => Line::Connection {
            t,
            node,
            connection: connection.number().0,
            from: explicit_state(*from).name(),
            to: explicit_state(*to).name(),
            cause: cause.to_string(),
        },
        NodeEvent::Device(event) => Line::Node { t, node, text: event.to_string() },
        NodeEvent::DeviceOutput { connection, data } => {
            Line::Output { t, node, connection: connection.number().0, data: hex(data) }
        }
        NodeEvent::Manager(event) => manager_event(t, node, event),
        NodeEvent::Address(address) => Line::Node { t, node, text: format!("OA {address}") },
        NodeEvent::NexAccess(event) => Line::Node { t, node, text: event.to_string() },
        NodeEvent::Access(event) => Line::Node { t, node, text: event.to_string() },
        NodeEvent::Slave(SlaveEvent::Io { connection, from, to, cause }) => Line::Connection {
            t,
            node,
            connection: connection.instance().0,
            from: io_state(*from).name(),
            to: io_state(*to).name(),
            cause: cause.to_string(),
        },
        NodeEvent::Slave(SlaveEvent::Explicit { instance, from, to, cause }) => Line::Connection {
            t,
            node,
            connection: (*instance).into(),
            from: explicit_state(*from).name(),
            to: explicit_state(*to).name(),
            cause: cause.to_string(),
        },
        NodeEvent::Slave(event) => Line::Node { t, node, text: event.to_string() },
        NodeEvent::Output { connection, data } => {
            Line::Output { t, node, connection: connection.instance().0, data: hex(data) }
        }
        NodeEvent::Master(event) => master_event(t, node, event),
        NodeEvent::Input { slave, connection, data } => Line::Input {
            t,
            node,
            slave: slave.number(),
            connection: connection.instance().0,
            data: hex(data),
        },
        NodeEvent::ScannerStatus(status) => {
            Line::Status { t, node, slave: None, status: status.0, text: status.name() }
        }
        NodeEvent::Tool(event) => Line::Node { t, node, text: event.to_string() },
        NodeEvent::Action(..) => Line::Node { t, node, text: event.words() },
    }
}

fn manager_event<'a>(t: f64, node: &'a str, event: &ManagerEvent) -> Line<'a> {
    match event {
        ManagerEvent::Planned(oa, PlannedEvent::StateChanged { from, to, cause }) => Line::Planned {
            t,
            node,
            device: oa.number(),
            from: device_state(*from).name(),
            to: device_state(*to).name(),
            cause: cause.name(),
        },
        event => Line::Node { t, node, text: event.to_string() },
    }
}

fn master_event<'a>(t: f64, node: &'a str, event: &MasterEvent) -> Line<'a> {
    match event {
        MasterEvent::ScanDone { missing } => Line::Scan { t, node, missing: *missing },
        MasterEvent::Slave { mac_id, event: master::SlaveEvent::StateChanged { from, to, cause } } => {
            Line::Slave {
                t,
                node,
                slave: mac_id.number(),
                from: slave_state(*from).name(),
                to: slave_state(*to).name(),
                cause: cause.to_string(),
            }
        }
        MasterEvent::Slave { mac_id, event: master::SlaveEvent::Status(status) } => {
            Line::Status { t, node, slave: Some(mac_id.number()), status: status.0, text: status.name() }
        }
        event => Line::Node { t, node, text: event.to_string() },
    }
}

fn hex(bytes: &[u8]) -> String {
    let mut text = Vec::new();
    crate::text::push_hex(&mut text, bytes, crate::text::LOWER);
    String::from_utf8(text).unwrap_or_default()
}

fn seconds(at: Instant) -> f64 {
    at.as_nanos() as f64 / 1e9
}
