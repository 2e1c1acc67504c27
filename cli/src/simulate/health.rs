//! A doctor beside the bus: what it finds in a run.

use std::cell::RefCell;
use std::rc::Rc;

use devicenet_core::MacId;
use devicenet_core::doctor::Doctor;
use devicenet_core::monitor::{Monitor, MonitorConfig};
use link_core::LinkEvent;
use transport_mock::record::Outcome as Sent;

use super::build::Settings;
use super::level::Level;
use super::run::{Outcome, Run};
use super::sight::{Nodes, Sight, View};
use crate::scenario::{NodeIndex, Scenario};

/// Runs a scenario with a doctor that listens, and is told the controller states of the nodes. While the bus is cut in two, it
/// stays with the others.
#[must_use]
pub fn examine(scenario: &Scenario, settings: Settings, doctor: &mut Doctor) -> Outcome {
    let monitor = Box::new(Monitor::new(MonitorConfig::default()));
    let practice = Rc::new(RefCell::new(Practice { doctor, monitor }));
    let mut run = Run::new(scenario, settings, vec![Box::new(HealthView(Rc::clone(&practice)))], false);
    // Nothing is written, so nothing can fail.
    let _ = run.at_full_speed(|| Ok(()));
    let outcome = run.finish();
    let mut practice = practice.borrow_mut();
    let Practice { doctor, monitor } = &mut *practice;
    doctor.tick(monitor, outcome.end);
    outcome
}

struct Practice<'a> {
    doctor: &'a mut Doctor,
    monitor: Box<Monitor>,
}

struct HealthView<'a>(Rc<RefCell<Practice<'a>>>);

impl View for HealthView<'_> {
    fn see(&mut self, nodes: &Nodes<'_>, sight: &Sight<'_>) {
        let mut practice = self.0.borrow_mut();
        let Practice { doctor, monitor } = &mut *practice;
        match sight {
            Sight::Frame { record, .. } if record.segment == 0 => match record.outcome {
                Sent::Ok => _ = doctor.observe(monitor, record.end, record.number, record.frame),
                Sent::Error(error) => {
                    doctor.link(record.end, Some(record.number), LinkEvent::BusError(error.kind));
                }
                Sent::Abandoned => {}
            },
            Sight::Level { at, node, level, .. } => {
                let event = match level {
                    // Back on the bus, whichever it was before.
                    Level::Active => LinkEvent::Up,
                    Level::Warning => LinkEvent::ErrorWarning,
                    Level::Passive => LinkEvent::ErrorPassive,
                    Level::BusOff => LinkEvent::BusOff,
                };
                if let Some(mac) = mac_of(nodes, *node) {
                    doctor.link_of(Some(mac), *at, None, event);
                }
            }
            Sight::Frame { .. }
            | Sight::Event { .. }
            | Sight::Change { .. }
            | Sight::Broken { .. }
            | Sight::Note { .. } => {}
        }
    }
}

/// The MAC ID on the switches of a node, if it is one that has them.
fn mac_of(nodes: &Nodes<'_>, node: NodeIndex) -> Option<MacId> {
    MacId::new(nodes.scenario.nodes[node.0].role.access()?.mac)
}
