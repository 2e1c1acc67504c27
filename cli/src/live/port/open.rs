//! Opening an endpoint, and what is wrong with one that cannot be opened.

use std::path::Path;

use link_core::Instant;
use transport_mock::{Ignore, NetworkPort, NodeConfig};

use super::{Bus, End, LivePort};
use crate::exit::Failure;
use crate::live::endpoint::Endpoint;
use crate::live::recorded::Recorded;
use crate::output::note;
use crate::recording::Recording;
use crate::scenario::{Scenario, ScenarioError};
use crate::simulate;

impl LivePort {
    /// Opens an endpoint for a machine that has so many frames in flight.
    pub(in crate::live) fn open(endpoint: &Endpoint, max_in_flight: usize) -> Result<Self, Failure> {
        Self::with(endpoint, NodeConfig::named("devicenet"), max_in_flight)
    }

    /// Opens an endpoint to listen to: nothing can be sent, and on the simulated bus nothing is changed by it, not even by an
    /// acknowledge.
    pub(in crate::live) fn open_listen_only(endpoint: &Endpoint) -> Result<Self, Failure> {
        let config = NodeConfig { listen_only: true, ..NodeConfig::named("devicenet") };
        Self::with(endpoint, config, NONE_IN_FLIGHT)
    }

    fn with(endpoint: &Endpoint, config: NodeConfig, max_in_flight: usize) -> Result<Self, Failure> {
        let mut bit_rate = None;
        let bus = match endpoint {
            Endpoint::Interface(name) => interface(name, config.listen_only)?,
            Endpoint::Scenario(path) => {
                let scenario = Scenario::load(path).map_err(|error| no_scenario(path, &error))?;
                if scenario.nodes.iter().any(|node| node.role.nex().is_some()) {
                    note(format_args!(
                        "{} is a network of DeviceNeX, and this command reads DeviceNet: see `simulate`, and `decode \
                         --protocol devicenex` for what it records",
                        path.display()
                    ));
                }
                let network = simulate::network(&scenario);
                let end = Instant::ZERO + scenario.bus.duration;
                bit_rate = Some(scenario.bus.bit_rate);
                Bus::Simulated(Box::new(
                    NetworkPort::attach(network, config, max_in_flight, Ignore).until(end),
                ))
            }
            Endpoint::Recording(path) => Bus::Recorded(Box::new(Recorded::open(path)?)),
        };
        Ok(Self {
            bus,
            bit_rate,
            end: End { at: Instant::MAX, late: None },
            over: None,
            interrupted: None,
            #[cfg(target_os = "linux")]
            refusal: None,
            #[cfg(target_os = "linux")]
            unconfirmed: None,
        })
    }
}

fn no_scenario(path: &Path, error: &ScenarioError) -> Failure {
    // An empty file is anything.
    let is_recording =
        path.metadata().is_ok_and(|file| file.is_file() && file.len() > 0) && Recording::open(path).is_ok();
    Failure::Usage(match is_recording {
        true => format!("{} is a recording: write log:{0} to play it", path.display()),
        false => error.to_string(),
    })
}

#[cfg(target_os = "linux")]
fn interface(name: &str, listen_only: bool) -> Result<Bus, Failure> {
    use transport_socketcan::{Error, SocketCanPort};
    let open = if listen_only { SocketCanPort::open_listen_only } else { SocketCanPort::open };
    let port = open(name).map_err(|error| match error {
        Error::NoInterface { .. } | Error::NotCan { .. } if Path::new(name).is_file() => Failure::Usage(
            format!("{name} is a file: write log:{name} for a recording, sim:{name} for a scenario"),
        ),
        error => Failure::Transport(error.to_string()),
    })?;
    Ok(Bus::Interface(Box::new(port)))
}

#[cfg(not(target_os = "linux"))]
fn interface(name: &str, _: bool) -> Result<Bus, Failure> {
    Err(Failure::Transport(format!("{name}: CAN interfaces are supported on Linux only")))
}

/// How many frames a machine may have in flight when only listening.
const NONE_IN_FLIGHT: usize = 0;
