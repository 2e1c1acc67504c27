//! Gathers what the picture shows.

use std::cell::RefCell;
use std::rc::Rc;

use link_core::Instant;
use transport_mock::record::Outcome;

use super::sight::{Level, Nodes, Sight, View};
use super::svg::{Busy, Picture, Row, Shade};
use crate::scenario::{NodeIndex, Role, Scenario, StateName};

/// Follows the states of the nodes and the load of the bus.
pub(super) struct TimelineView {
    picture: Rc<RefCell<Picture>>,
}

impl TimelineView {
    /// A view, and the picture that it makes.
    pub(super) fn new(scenario: &Scenario, end: Instant) -> (Self, Rc<RefCell<Picture>>) {
        let rows = scenario.nodes.iter().map(|node| Row {
            name: node.name.clone(),
            detail: match &node.role {
                Role::Access(access) => format!("MAC {}", access.mac),
                Role::Replay(_) | Role::Listener | Role::Babbler { .. } | Role::External => {
                    node.role.name().to_owned()
                }
            },
            states: vec![(Instant::ZERO, Shade::Off)],
        });
        let picture = Picture {
            title: scenario.title.clone().unwrap_or_else(|| scenario.file.clone()),
            end,
            rows: rows.collect(),
            notes: Vec::new(),
            busy: Vec::new(),
        };
        let picture = Rc::new(RefCell::new(picture));
        (Self { picture: Rc::clone(&picture) }, picture)
    }
}

impl View for TimelineView {
    fn see(&mut self, nodes: &Nodes<'_>, sight: &Sight<'_>) {
        let mut picture = self.picture.borrow_mut();
        match sight {
            Sight::Frame { record, .. } => picture.busy(Busy {
                from: record.start,
                to: record.end,
                error: !matches!(record.outcome, Outcome::Ok),
            }),
            Sight::Event { at, node, .. } => picture.shade(*at, *node, nodes),
            Sight::Level { at, node, level: Level::BusOff, .. } => picture.enter(*at, *node, Shade::BusOff),
            Sight::Level { at, node, .. } => picture.shade(*at, *node, nodes),
            Sight::Change { at, node: Some(node), .. } => picture.shade(*at, *node, nodes),
            Sight::Change { node: None, .. } | Sight::Broken { .. } => {}
            Sight::Note { at, text } => picture.notes.push((*at, (*text).to_owned())),
        }
    }
}

impl Picture {
    /// The row of a node takes the colour of what it is now.
    fn shade(&mut self, at: Instant, node: NodeIndex, nodes: &Nodes<'_>) {
        let status = nodes.status(node);
        let shade = match (status.bus_off, nodes.is_attached(node), status.state) {
            (true, _, _) => Shade::BusOff,
            (false, false, _) | (false, true, Some(StateName::Nonexistent)) => Shade::Off,
            (false, true, None) => Shade::Present,
            (false, true, Some(StateName::SendingDupMac)) => Shade::Sending,
            (false, true, Some(StateName::WaitingDupMac)) => Shade::Waiting,
            (false, true, Some(StateName::OnLine)) => Shade::OnLine,
            (false, true, Some(StateName::CommFault)) => Shade::Fault,
        };
        self.enter(at, node, shade);
    }

    fn enter(&mut self, at: Instant, node: NodeIndex, shade: Shade) {
        let states = &mut self.rows[node.0].states;
        if states.last().is_none_or(|(_, last)| *last != shade) {
            states.push((at, shade));
        }
    }

    /// What follows closely is one with what was before, so that a lone node, which tries for ever, costs no memory.
    fn busy(&mut self, busy: Busy) {
        match self.busy.last_mut() {
            Some(last) if last.error == busy.error && last.to == busy.from => last.to = busy.to,
            _ => self.busy.push(busy),
        }
    }
}
