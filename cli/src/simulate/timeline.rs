//! Gathers what the picture shows.

use std::cell::RefCell;
use std::rc::Rc;

use link_core::Instant;
use transport_mock::record::Outcome;

use super::picture::{Picture, Row, Shade};
use super::sight::{Nodes, Sight, View};
use crate::scenario::{NodeIndex, Scenario, StateName};

/// Follows the states of the nodes and the load of the bus.
pub(super) struct TimelineView {
    picture: Rc<RefCell<Picture>>,
}

impl TimelineView {
    /// A view, and the picture that it makes.
    pub(super) fn new(scenario: &Scenario) -> (Self, Rc<RefCell<Picture>>) {
        let row = |node: &crate::scenario::Node| {
            let detail = match (node.role.access(), node.role.nex()) {
                (Some(access), _) => format!("MAC {}", access.mac),
                (None, Some(nex)) if !nex.oa.is_none() => format!("OA {}", nex.oa),
                (None, _) => node.role.name().to_owned(),
            };
            Row::new(node.name.clone(), detail)
        };
        let picture = Picture {
            title: scenario.title.clone().unwrap_or_else(|| scenario.file.clone()),
            rows: scenario.nodes.iter().map(row).collect(),
            ..Picture::default()
        };
        let picture = Rc::new(RefCell::new(picture));
        (Self { picture: Rc::clone(&picture) }, picture)
    }
}

impl View for TimelineView {
    fn see(&mut self, nodes: &Nodes<'_>, sight: &Sight<'_>) {
        let mut picture = self.picture.borrow_mut();
        let mut shade = |at: Instant, node: NodeIndex| picture.rows[node.0].enter(at, shade_of(nodes, node));
        match sight {
            Sight::Frame { record, .. } => {
                let is_error = match record.outcome {
                    Outcome::Error(_) => true,
                    Outcome::Ok | Outcome::Abandoned => false,
                };
                picture.load.add(record.start, record.end, is_error);
            }
            Sight::Event { at, node, .. }
            | Sight::Level { at, node, .. }
            | Sight::Change { at, node: Some(node), .. } => shade(*at, *node),
            Sight::Change { node: None, .. } | Sight::Broken { .. } => {}
            Sight::Note { at, text } => picture.notes.push((*at, (*text).to_owned())),
        }
    }
}

/// What a node is now.
fn shade_of(nodes: &Nodes<'_>, node: NodeIndex) -> Shade {
    let status = nodes.status(node);
    if !nodes.has_power(node) {
        return Shade::Off;
    }
    if !nodes.is_attached(node) {
        return Shade::Cut;
    }
    if status.bus_off {
        return Shade::BusOff;
    }
    match status.state {
        None => Shade::Present,
        // It starts at this moment.
        Some(StateName::Nonexistent) => Shade::Off,
        Some(StateName::SendingDupMac) => Shade::Sending,
        Some(StateName::WaitingDupMac) => Shade::Waiting,
        Some(StateName::OnLine) if status.exchange.has_timed_out() => Shade::TimedOut,
        Some(StateName::OnLine) if status.exchange.has_io() => Shade::Exchanging,
        Some(StateName::OnLine) => Shade::OnLine,
        Some(StateName::CommFault | StateName::Faulted) => Shade::Fault,
        Some(StateName::DetectingBitRate) => Shade::Detecting,
        Some(StateName::Hello1 | StateName::Hello2) => Shade::Hello,
        Some(StateName::Standby) => Shade::Standby,
        Some(StateName::BusOff) => Shade::BusOff,
    }
}
