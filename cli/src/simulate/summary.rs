//! What each node and the bus have come to.

use std::cell::RefCell;
use std::rc::Rc;

use link_core::{BitRate, Instant};
use serde::Serialize;
use transport_mock::bus::SenderOutcome;
use transport_mock::record::Outcome;

use super::expectations::Status;
use super::sight::{Level, Nodes, Sight, View, index, length};
use crate::scenario::{NodeIndex, Scenario, StateName};
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
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct NodeSummary {
    /// Its name.
    pub node: String,
    /// Its role.
    pub role: &'static str,
    /// Its MAC ID at the end, for roles that have one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mac: Option<u8>,
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
    /// The share of the time, in percent, in which a frame, an error frame or an attempt that was broken off was on the bus:
    /// exact, from start of frame to end of frame or error delimiter, without the intermission.
    pub load: f64,
    /// The part of the load that ended in error frames, in percent of the time.
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
}

/// What a node is when the run ends.
pub(super) struct Last {
    pub(super) status: Status,
    pub(super) max_tec: u16,
    pub(super) mac: Option<u8>,
}

impl Counting {
    /// A view, and where its figures can be had after the run.
    pub(super) fn new(scenario: &Scenario) -> (Self, Rc<RefCell<Figures>>) {
        let nodes = scenario.nodes.iter().map(|node| NodeSummary {
            node: node.name.clone(),
            role: node.role.name(),
            mac: None,
            state: None,
            sent: 0,
            failed: 0,
            tec: 0,
            rec: 0,
            max_tec: 0,
            bus_offs: 0,
        });
        let nodes = nodes.collect();
        let figures = Figures { nodes, frames: 0, errors: 0, abandoned: 0, busy: 0, destroyed: 0 };
        let figures = Rc::new(RefCell::new(figures));
        (Self { figures: Rc::clone(&figures) }, figures)
    }
}

impl View for Counting {
    fn see(&mut self, _: &Nodes<'_>, sight: &Sight<'_>) {
        let mut figures = self.figures.borrow_mut();
        match sight {
            Sight::Frame { record, .. } => {
                figures.busy += length(record);
                match record.outcome {
                    Outcome::Ok => figures.frames += 1,
                    Outcome::Error(_) => {
                        figures.errors += 1;
                        figures.destroyed += length(record);
                    }
                    Outcome::Abandoned => figures.abandoned += 1,
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
            let Last { status: Status { state, tec, rec, .. }, max_tec, mac } = last(NodeIndex(place));
            NodeSummary { mac, state, tec, rec, max_tec, ..node.clone() }
        };
        let percent = |nanos: u64| nanos as f64 * 100.0 / end.as_nanos().max(1) as f64;
        Summary {
            nodes: self.nodes.iter().enumerate().map(finish).collect(),
            bus: BusSummary {
                duration: end.as_nanos() as f64 / 1e9,
                frames: self.frames,
                errors: self.errors,
                abandoned: self.abandoned,
                load: percent(self.busy),
                error_load: percent(self.destroyed),
            },
        }
    }
}

impl Summary {
    /// As a table.
    pub(super) fn table(&self, bit_rate: BitRate) -> String {
        use core::fmt::Write as _;
        let width = self.nodes.iter().map(|node| node.node.chars().count()).max().unwrap_or(0).max(4);
        let mut text = format!(
            "{:<width$}  {:<8}  {:>3}  {:<15}  {:>7}  {:>7}  {:>4}  {:>4}  {:>7}  {:>7}\n",
            "node", "role", "MAC", "state", "sent", "failed", "TEC", "REC", "max TEC", "bus-off"
        );
        for node in &self.nodes {
            let _ = writeln!(
                text,
                "{:<width$}  {:<8}  {:>3}  {:<15}  {:>7}  {:>7}  {:>4}  {:>4}  {:>7}  {:>7}",
                node.node,
                node.role,
                node.mac.map_or_else(|| "-".to_owned(), |mac| mac.to_string()),
                node.state.map_or("-", StateName::name),
                node.sent,
                node.failed,
                node.tec,
                node.rec,
                node.max_tec,
                node.bus_offs
            );
        }
        let bus = &self.bus;
        let broken_off = match bus.abandoned {
            0 => String::new(),
            more => format!(", {more} broken off"),
        };
        let _ = writeln!(
            text,
            "\n{} at {bit_rate}: {} and {}{broken_off}, load {:.3} %, of which {:.3} % were destroyed by errors",
            crate::scenario::Time(core::time::Duration::from_nanos((bus.duration * 1e9).round() as u64)),
            count(bus.frames, "frame"),
            count(bus.errors, "error frame"),
            bus.load,
            bus.error_load
        );
        text
    }
}

#[expect(clippy::ref_option, reason = "the signature is serde's")]
fn by_name<S: serde::Serializer>(state: &Option<StateName>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(state.map_or("", StateName::name))
}
