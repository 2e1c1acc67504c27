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
    examine_from(scenario, settings, [(0, doctor)])
}

/// The same with several doctors, each of which begins to listen with the frame of a number: what was before it has not heard.
#[must_use]
pub fn examine_from<'a>(
    scenario: &Scenario,
    settings: Settings,
    doctors: impl IntoIterator<Item = (u64, &'a mut Doctor)>,
) -> Outcome {
    let practice = |(from, doctor)| {
        let monitor = Box::new(Monitor::new(MonitorConfig::default()));
        Practice { from, listens: false, doctor, monitor }
    };
    let practices: Rc<RefCell<Vec<Practice<'a>>>> =
        Rc::new(RefCell::new(doctors.into_iter().map(practice).collect()));
    let mut run = Run::new(scenario, settings, vec![Box::new(HealthView(Rc::clone(&practices)))], false);
    // Nothing is written, so nothing can fail.
    let _ = run.at_full_speed(|| Ok(()));
    let outcome = run.finish();
    for Practice { doctor, monitor, .. } in &mut *practices.borrow_mut() {
        doctor.tick(monitor, outcome.end);
    }
    outcome
}

struct Practice<'a> {
    /// The number of the first frame that is heard.
    from: u64,
    listens: bool,
    doctor: &'a mut Doctor,
    monitor: Box<Monitor>,
}

struct HealthView<'a>(Rc<RefCell<Vec<Practice<'a>>>>);

impl View for HealthView<'_> {
    fn see(&mut self, nodes: &Nodes<'_>, sight: &Sight<'_>) {
        for practice in &mut *self.0.borrow_mut() {
            practice.see(nodes, sight);
        }
    }
}

impl Practice<'_> {
    fn see(&mut self, nodes: &Nodes<'_>, sight: &Sight<'_>) {
        self.listens |= self.from == 0;
        if let Sight::Frame { record, .. } = sight {
            self.listens |= record.number >= self.from;
        }
        if !self.listens {
            return;
        }
        let Self { doctor, monitor, .. } = self;
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
