//! What a doctor is told of a network beforehand.

use core::time::Duration;
use std::collections::BTreeMap;
use std::path::Path;

use devicenet_core::MacId;
use devicenet_core::doctor::{Doctor, DoctorConfig, ExpectedNode, Intrusion};
use link_core::BitRate;

use crate::exit::Failure;
use crate::scenario::{Role, Scenario};

/// A doctor of a bus with this bit rate; where it is not known, the load is not judged. The scan lists of a scenario, and what is heard in the time of learning, say what
/// belongs to the network; with neither, everything does.
pub(crate) fn doctor(
    bit_rate: Option<BitRate>,
    expected: Option<&Scenario>,
    learning: Option<Duration>,
) -> Box<Doctor> {
    let mut config = DoctorConfig::default();
    config.bit_rate = bit_rate;
    config.intrusion = match (expected, learning) {
        (_, Some(span)) => Intrusion::Learned(span),
        (Some(_), None) => Intrusion::Expected,
        (None, None) => Intrusion::Allowed,
    };
    let mut doctor = Box::new(Doctor::new(config));
    if let Some(scenario) = expected {
        expect(&mut doctor, scenario);
    }
    doctor
}

/// The scenario of `--expect`.
///
/// # Errors
/// When it cannot be read, or no scan list in it says who is expected.
pub(crate) fn expected(path: &Path) -> Result<Scenario, Failure> {
    let scenario = Scenario::load(path).map_err(|error| Failure::Usage(error.to_string()))?;
    let has_scan_list = |role: &Role| matches!(role, Role::Master(master) if !master.scan.is_empty());
    if !scenario.nodes.iter().any(|node| has_scan_list(&node.role)) {
        return Err(Failure::Usage(format!(
            "{}: there is no master with a scan list, which says who belongs to the bus: name a scenario that has one with --expect",
            path.display()
        )));
    }
    Ok(scenario)
}

/// Tells a doctor what the scan lists of a scenario say: which slaves there are, which devices they must be, and whose. The
/// masters themselves are expected, too. A slave in two scan lists may be of either master.
pub fn expect(doctor: &mut Doctor, scenario: &Scenario) {
    let mut nodes: BTreeMap<MacId, ExpectedNode> = BTreeMap::new();
    for node in &scenario.nodes {
        let Role::Master(master) = &node.role else { continue };
        let Some(own) = MacId::new(master.access.mac) else { continue };
        nodes.entry(own).or_default();
        for slave in &master.scan {
            let expected = ExpectedNode { key: slave.entry.key, serial: None, master: Some(own) };
            let held = nodes.entry(slave.entry.mac_id).or_insert(expected);
            if held.master != expected.master {
                held.master = None;
            }
        }
    }
    for (mac, node) in nodes {
        doctor.expect(mac, node);
    }
}
