//! Which events of a run are told.

use clap::ValueEnum;
use devicenet_core::access::AccessEvent;
use devicenet_core::master::{self, MasterEvent};
use devicenet_core::slave::SlaveEvent;
use devicenex_core::access as nex;
use devicenex_core::device::DeviceEvent;
use devicenex_core::manager::{ManagerEvent, PlannedEvent};
use transport_mock::record::Outcome;

use super::event::NodeEvent;
use super::sight::{Nodes, Sight, View};

/// The events by their names in JSON. Failed expectations and the summary are told whatever is selected.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
#[value(rename_all = "snake_case")]
pub enum EventKind {
    /// A frame
    Frame,
    /// An attempt to send that failed
    ErrorFrame,
    /// An attempt to send that was broken off
    Abandoned,
    /// Network access of a node
    State,
    /// The state of a connection of a slave
    Connection,
    /// The output data of a slave
    Output,
    /// Where a master is with a slave
    Slave,
    /// What a manager knows of a planned device
    Planned,
    /// The scanner status
    Status,
    /// Input data that a master has received
    Input,
    /// The end of a scan
    Scan,
    /// What else a node tells
    Node,
    /// The error state of a controller
    ErrorState,
    /// What is done to a node or the bus
    Change,
    /// A rule of the bus that was broken
    Violation,
    /// A heading
    Note,
}

/// A choice of events.
#[derive(Clone, Default, Debug)]
pub(super) struct Selection {
    /// Only these; all if there are none.
    pub(super) only: Vec<EventKind>,
    /// Not these.
    pub(super) without: Vec<EventKind>,
}

impl Selection {
    fn has(&self, kind: EventKind) -> bool {
        (self.only.is_empty() || self.only.contains(&kind)) && !self.without.contains(&kind)
    }

    /// Whether it is asked for by name.
    pub(super) fn names(&self, kind: EventKind) -> bool {
        self.only.contains(&kind)
    }
}

/// A view that sees a choice only.
pub(super) struct Selected<V> {
    view: V,
    selection: Selection,
}

impl<V> Selected<V> {
    pub(super) const fn new(view: V, selection: Selection) -> Self {
        Self { view, selection }
    }
}

impl<V: View> View for Selected<V> {
    fn see(&mut self, nodes: &Nodes<'_>, sight: &Sight<'_>) {
        if self.selection.has(kind_of(sight)) {
            self.view.see(nodes, sight);
        }
    }
}

fn kind_of(sight: &Sight<'_>) -> EventKind {
    match sight {
        Sight::Frame { record, .. } => match record.outcome {
            Outcome::Ok => EventKind::Frame,
            Outcome::Error(_) => EventKind::ErrorFrame,
            Outcome::Abandoned => EventKind::Abandoned,
        },
        Sight::Event { event, .. } => kind_of_event(event),
        Sight::Level { .. } => EventKind::ErrorState,
        Sight::Change { .. } => EventKind::Change,
        Sight::Broken { .. } => EventKind::Violation,
        Sight::Note { .. } => EventKind::Note,
    }
}

/// What a node tells.
pub(super) fn kind_of_event(event: &NodeEvent) -> EventKind {
    match event {
        NodeEvent::Access(AccessEvent::StateChanged { .. })
        | NodeEvent::NexAccess(nex::AccessEvent::StateChanged { .. }) => EventKind::State,
        NodeEvent::Slave(SlaveEvent::Io { .. } | SlaveEvent::Explicit { .. }) => EventKind::Connection,
        NodeEvent::Device(DeviceEvent::Io { .. } | DeviceEvent::Explicit { .. }) => EventKind::Connection,
        NodeEvent::Manager(event)
            if matches!(**event, ManagerEvent::Planned(_, PlannedEvent::StateChanged { .. })) =>
        {
            EventKind::Planned
        }
        NodeEvent::Output { .. } | NodeEvent::DeviceOutput { .. } => EventKind::Output,
        NodeEvent::Input { .. } => EventKind::Input,
        NodeEvent::Master(MasterEvent::ScanDone { .. }) => EventKind::Scan,
        NodeEvent::Master(MasterEvent::Slave { event: master::SlaveEvent::StateChanged { .. }, .. }) => {
            EventKind::Slave
        }
        NodeEvent::Master(MasterEvent::Slave { event: master::SlaveEvent::Status(_), .. })
        | NodeEvent::ScannerStatus(_) => EventKind::Status,
        NodeEvent::Access(_)
        | NodeEvent::NexAccess(_)
        | NodeEvent::Address(_)
        | NodeEvent::Device(_)
        | NodeEvent::Manager(_)
        | NodeEvent::Slave(_)
        | NodeEvent::Master(_)
        | NodeEvent::Tool(_)
        | NodeEvent::Action(..) => EventKind::Node,
    }
}
