//! What each node and the bus have come to.

use std::cell::RefCell;
use std::rc::Rc;

use devicenet_core::master::{ScannerStatus, SlaveCounters};
use devicenet_core::slave;
use link_core::wire::INTERMISSION_BITS;
use link_core::{BitRate, Instant};
use serde::Serialize;
use transport_mock::bus::SenderOutcome;
use transport_mock::record::Outcome;

use super::expectations::Status;
use super::level::Level;
use super::sight::{Nodes, Sight, View, index, length};
use crate::scenario::{NodeIndex, Scenario, SlaveStateName, StateName};
use crate::text::count;

/// The figures of a run.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Summary {
    /// One for each node, in the order of the scenario.
    pub nodes: Vec<NodeSummary>,
    /// The bus.
    pub bus: BusSummary,
}

/// The figures of a node.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct NodeSummary {
    /// Its name.
    pub node: String,
    /// Its role.
    pub role: &'static str,
    /// Its MAC ID at the end, for roles that have one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mac: Option<u8>,
    /// Its operational address at the end, for roles that have one; 127 is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub oa: Option<u8>,
    /// The state of network access at the end, for roles that have one.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "by_name")]
    pub state: Option<StateName>,
    /// Frames that were on the bus, and acknowledged.
    pub sent: u64,
    /// Attempts to send that ended in an error.
    pub failed: u64,
    /// The transmit error counter at the end.
    pub tec: u16,
    /// The receive error counter at the end.
    pub rec: u16,
    /// The greatest value that the transmit error counter had.
    pub max_tec: u16,
    /// How often the controller went bus-off.
    pub bus_offs: u64,
    /// Of a slave or a device: frames that passed the filter that it asked for, since power-up.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub received: Option<u64>,
    /// Of a slave: what it has counted since power-up.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slave: Option<slave::Counters>,
    /// Of a master: its scan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scan: Option<ScanSummary>,
}

/// The figures of a master.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ScanSummary {
    /// How many scans were measured, from the end of one to the end of the next.
    pub scans: u32,
    /// The shortest, in seconds.
    pub min: f64,
    /// The mean, in seconds.
    pub mean: f64,
    /// The longest, in seconds.
    pub max: f64,
    /// Its slaves, in the order of their MAC IDs.
    pub slaves: Vec<SlaveSummary>,
}

/// The figures of a slave as its master sees it.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct SlaveSummary {
    /// Its MAC ID.
    pub mac: u8,
    /// Where the master is with it at the end.
    #[serde(serialize_with = "state_name")]
    pub state: SlaveStateName,
    /// Its scanner status at the end.
    pub status: ScannerStatus,
    /// What the master has counted since power-up.
    #[serde(flatten)]
    pub counters: SlaveCounters,
}

/// The figures of the bus, all segments together.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct BusSummary {
    /// How long it ran, in seconds.
    pub duration: f64,
    /// Frames that got through.
    pub frames: u64,
    /// Attempts that ended in an error frame.
    pub errors: u64,
    /// Attempts that were broken off without one, because all that sent went off the bus.
    pub abandoned: u64,
    /// The part of the time, 0 to 1, in which a frame, an error frame or an attempt that was broken off was on the bus: exact, from
    /// start of frame to the end of the intermission after end of frame or error delimiter.
    pub load: f64,
    /// The part of the time that was taken by what ended in error frames.
    pub error_load: f64,
}

/// Counts.
pub(super) struct Counting {
    figures: Rc<RefCell<Figures>>,
}

/// What is counted.
#[derive(Debug)]
pub(super) struct Figures {
    nodes: Vec<NodeSummary>,
    frames: u64,
    errors: u64,
    abandoned: u64,
    busy: u64,
    destroyed: u64,
    /// Nanoseconds.
    intermission: u64,
}

/// What a node is when the run ends.
pub(super) struct Last {
    pub(super) status: Status,
    pub(super) max_tec: u16,
    pub(super) mac: Option<u8>,
    pub(super) oa: Option<u8>,
    pub(super) received: Option<u64>,
    pub(super) slave: Option<slave::Counters>,
    pub(super) scan: Option<ScanSummary>,
}

impl Counting {
    /// A view, and where its figures can be had after the run.
    pub(super) fn new(scenario: &Scenario) -> (Self, Rc<RefCell<Figures>>) {
        let nodes = scenario.nodes.iter().map(|node| NodeSummary {
            node: node.name.clone(),
            role: node.role.name(),
            mac: None,
            oa: None,
            state: None,
            sent: 0,
            failed: 0,
            tec: 0,
            rec: 0,
            max_tec: 0,
            bus_offs: 0,
            received: None,
            slave: None,
            scan: None,
        });
        let nodes = nodes.collect();
        let bit = scenario.bus.bit_rate.bit_time_nanos().unwrap_or_default();
        let intermission = bit * u64::from(INTERMISSION_BITS);
        let figures =
            Figures { nodes, frames: 0, errors: 0, abandoned: 0, busy: 0, destroyed: 0, intermission };
        let figures = Rc::new(RefCell::new(figures));
        (Self { figures: Rc::clone(&figures) }, figures)
    }
}

impl View for Counting {
    fn see(&mut self, _: &Nodes<'_>, sight: &Sight<'_>) {
        let mut figures = self.figures.borrow_mut();
        match sight {
            Sight::Frame { record, .. } => {
                let with_intermission = length(record) + figures.intermission;
                match record.outcome {
                    Outcome::Ok => {
                        figures.frames += 1;
                        figures.busy += with_intermission;
                    }
                    Outcome::Error(_) => {
                        figures.errors += 1;
                        figures.busy += with_intermission;
                        figures.destroyed += with_intermission;
                    }
                    Outcome::Abandoned => {
                        figures.abandoned += 1;
                        figures.busy += length(record);
                    }
                }
                for sender in record.senders {
                    let node = &mut figures.nodes[index(sender.node).0];
                    match sender.outcome {
                        SenderOutcome::Sent => node.sent += 1,
                        SenderOutcome::Error(_) => node.failed += 1,
                        SenderOutcome::LostArbitration { .. } | SenderOutcome::Abandoned => {}
                    }
                }
            }
            Sight::Level { node, level: Level::BusOff, .. } => figures.nodes[node.0].bus_offs += 1,
            Sight::Level { .. }
            | Sight::Event { .. }
            | Sight::Change { .. }
            | Sight::Note { .. }
            | Sight::Broken { .. } => {}
        }
    }
}

impl Figures {
    /// The summary of a run that has ended.
    pub(super) fn summary(&self, end: Instant, last: impl Fn(NodeIndex) -> Last) -> Summary {
        let finish = |(place, node): (usize, &NodeSummary)| {
            let Last { status: Status { state, tec, rec, .. }, max_tec, mac, oa, received, slave, scan } =
                last(NodeIndex(place));
            NodeSummary { mac, oa, state, tec, rec, max_tec, received, slave, scan, ..node.clone() }
        };
        let part = |nanos: u64| nanos as f64 / end.as_nanos().max(1) as f64;
        Summary {
            nodes: self.nodes.iter().enumerate().map(finish).collect(),
            bus: BusSummary {
                duration: end.as_nanos() as f64 / 1e9,
                frames: self.frames,
                errors: self.errors,
                abandoned: self.abandoned,
                load: part(self.busy),
                error_load: part(self.destroyed),
            },
        }
    }
}

impl Summary {
    /// As a table.
    pub(super) fn table(&self, bit_rate: BitRate) -> String {
        use core::fmt::Write as _;
        let width = self.nodes.iter().map(|node| node.node.chars().count()).max().unwrap_or(0).max(4);
        let address = if self.nodes.iter().any(|node| node.oa.is_some()) { "OA" } else { "MAC" };
        let mut text = format!(
            "{:<width$}  {:<8}  {:>3}  {:<15}  {:>7}  {:>7}  {:>4}  {:>4}  {:>7}  {:>7}\n",
            "node", "role", address, "state", "sent", "failed", "TEC", "REC", "max TEC", "bus-off"
        );
        for node in &self.nodes {
            let _ = writeln!(
                text,
                "{:<width$}  {:<8}  {:>3}  {:<15}  {:>7}  {:>7}  {:>4}  {:>4}  {:>7}  {:>7}",
                node.node,
                node.role,
                match (node.mac, node.oa) {
                    (Some(address), _) | (None, Some(address @ 0..=126)) => address.to_string(),
                    (None, _) => "-".to_owned(),
                },
                node.state.map_or("-", StateName::name),
                node.sent,
                node.failed,
                node.tec,
                node.rec,
                node.max_tec,
                node.bus_offs
            );
        }
        for node in &self.nodes {
            if let Some(scan) = &node.scan {
                scan.push_table(&mut text, &node.node, &self.nodes);
            }
        }
        let bus = &self.bus;
        let broken_off = match bus.abandoned {
            0 => String::new(),
            more => format!(", {more} broken off"),
        };
        let _ = writeln!(
            text,
            "\n{} at {bit_rate}: {} and {}{broken_off}, load {:.3} %: {:.3} % of the time for frames, {:.3} % for what errors destroyed",
            crate::scenario::Time(core::time::Duration::from_nanos((bus.duration * 1e9).round() as u64)),
            count(bus.frames, "frame"),
            count(bus.errors, "error frame"),
            bus.load * 100.0,
            (bus.load - bus.error_load) * 100.0,
            bus.error_load * 100.0
        );
        text
    }
}

impl ScanSummary {
    /// The slaves of a master, and how long its scans took.
    fn push_table(&self, text: &mut String, master: &str, nodes: &[NodeSummary]) {
        use core::fmt::Write as _;
        // The node with that MAC ID at the end, if there is one.
        let name = |mac: u8| {
            let mut own = nodes.iter().filter(|node| node.mac == Some(mac) && node.slave.is_some());
            let online = own.clone().find(|node| node.state == Some(StateName::OnLine));
            online.or_else(|| own.next()).map_or("-", |node| node.node.as_str())
        };
        let names = self.slaves.iter().map(|slave| name(slave.mac).chars().count());
        let width = names.max().unwrap_or(0).max(master.chars().count() + 3);
        let _ = writeln!(
            text,
            "\n{:<width$}  {:>3}  {:<11}  {:>11}  {:>8}  {:>8}  {:>8}  {:>6}  status",
            &format!("of {master}"),
            "MAC",
            "state",
            "established",
            "timeouts",
            "commands",
            "received",
            "missed"
        );
        for slave in &self.slaves {
            let SlaveSummary { mac, state, status, counters } = slave;
            let _ = writeln!(
                text,
                "{:<width$}  {mac:>3}  {:<11}  {:>11}  {:>8}  {:>8}  {:>8}  {:>6}  {status}",
                name(*mac),
                state.name(),
                counters.established,
                counters.timeouts,
                counters.commands,
                counters.received,
                counters.missed
            );
        }
        let millis = |seconds: f64| seconds * 1e3;
        let _ = match self.scans {
            0 => writeln!(text, "{master}: no scan"),
            scans => writeln!(
                text,
                "{master}: {}, min {:.3} ms, mean {:.3} ms, max {:.3} ms",
                count(scans.into(), "scan"),
                millis(self.min),
                millis(self.mean),
                millis(self.max)
            ),
        };
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature is serde's")]
fn state_name<S: serde::Serializer>(state: &SlaveStateName, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(state.name())
}

#[expect(clippy::ref_option, reason = "the signature is serde's")]
fn by_name<S: serde::Serializer>(state: &Option<StateName>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(state.map_or("", StateName::name))
}
