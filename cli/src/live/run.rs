//! `devicenet slave` and `devicenet master`: a node of a scenario on a live bus.

use core::ops::ControlFlow;
use std::collections::BTreeSet;
use std::io;

use devicenet_core::MacId;
use devicenet_core::access::Fault;
use devicenet_core::master::ScannerStatus;
use link_core::{Input, Instant, LinkEvent, Port as _, drive};

use super::args::RunArgs;
use super::ask::mac_id;
use super::permit;
use super::port::{LivePort, PortError};
use crate::exit::{Exit, Failure};
use crate::output::{self, Output};
use crate::scenario::{Node, Role, Scenario};
use crate::simulate::{self, Guest, NodeEvent};

/// Is a slave on a live bus.
///
/// # Errors
/// [`Failure`] when the command line, the file, the endpoint or the bus does not allow it.
pub fn slave(args: &RunArgs, json: bool) -> Result<Exit, Failure> {
    run(args, "slave", |node| matches!(node.role, Role::Slave(_)), json)
}

/// Is a master on a live bus.
///
/// # Errors
/// [`Failure`] when the command line, the file, the endpoint or the bus does not allow it.
pub fn master(args: &RunArgs, json: bool) -> Result<Exit, Failure> {
    run(args, "master", |node| matches!(node.role, Role::Master(_)), json)
}

fn run(args: &RunArgs, role: &str, is_of_role: impl Fn(&Node) -> bool, json: bool) -> Result<Exit, Failure> {
    let RunArgs { endpoint, permit, .. } = args;
    let scenario = Scenario::load(&args.file).map_err(|error| Failure::Usage(error.to_string()))?;
    let node = choose(args, &scenario, role, is_of_role)?;
    let Some(mut machine) = simulate::machine(node) else {
        return Err(Failure::Usage(format!("{} is no {role}", node.name)));
    };
    let (own, slaves) = addresses(node);
    let what = match &slaves[..] {
        [] => "its answers to a master".to_owned(),
        slaves => format!("to each of MAC ID {} Allocate, its configuration, and I/O commands", list(slaves)),
    };
    let (mut port, heard) = permit::enter(endpoint, permit, own, &what, machine.max_in_flight())?;
    slaves.iter().try_for_each(|slave| permit::ownership(*slave, &heard))?;

    let now = port.now();
    port.set_end(args.span.map_or(Instant::MAX, |span| now + span.0));
    machine.input(now, Input::Link(LinkEvent::Up));
    let mut log = Log { output: Output::new(), name: &node.name, json };
    let ended = drive(&mut machine.as_mut(), &mut port, |_, now, event| match log.event(now, &event) {
        Ok(()) => ControlFlow::Continue(()),
        Err(error) => ControlFlow::Break(error),
    });
    match ended {
        Ok(error) => Err(error.into()),
        Err(PortError::Failed(failure)) => Err(failure),
        Err(PortError::Over) => {
            port.note_early_end(endpoint, args.span);
            let fault = machine.access().fault();
            let unserved = machine.unserved();
            // After the end of a scenario there is no time in which a slave could answer.
            if port.over().is_none() {
                leave(machine.as_mut(), &mut port, &mut log)?;
            }
            match fault {
                Some(fault) => output::error(faulted(machine.access().mac_id(), fault, args)),
                None if unserved.is_empty() => return Ok(Exit::Done),
                None => output::error(not_running(&unserved, args)),
            }
            Ok(Exit::Findings)
        }
    }
}

/// Why the node was of no use in the end, and what to do.
fn faulted(own: MacId, fault: Fault, args: &RunArgs) -> String {
    let (endpoint, file) = (&args.endpoint, args.file.display());
    match fault {
        Fault::DuplicateMacId => format!(
            "node {own} is faulted, another node on {endpoint} has MAC ID {own}: give this one another in {file}, or take that one off"
        ),
        Fault::BusOff => format!(
            "node {own} is faulted, its controller went bus-off on {endpoint}: check the bit rate, the cable and its terminators"
        ),
    }
}

/// Which slaves a master does not serve in the end, and what to do.
fn not_running(slaves: &[(MacId, ScannerStatus)], args: &RunArgs) -> String {
    let slaves: Vec<String> = slaves.iter().map(|(mac, status)| format!("{mac} (status {status})")).collect();
    format!(
        "in the end there was no I/O with {}: devicenet monitor {} says why, and what to check",
        slaves.join(", "),
        args.endpoint
    )
}

/// Goes off the bus. A master releases its slaves first, as far as they let it.
fn leave(mut machine: &mut dyn Guest, port: &mut LivePort, log: &mut Log<'_>) -> Result<(), Failure> {
    let mut allocated: BTreeSet<MacId> = machine.allocated().into_iter().collect();
    port.end_soon();
    machine.leave(port.now());
    if !machine.held().is_empty() {
        let ended = drive(&mut machine, port, |machine, now, event| {
            allocated.extend(machine.allocated());
            match log.event(now, &event) {
                Ok(()) if machine.held().is_empty() => ControlFlow::Break(Ok(())),
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => ControlFlow::Break(Err(error)),
            }
        });
        match ended {
            Ok(done) => done?,
            Err(PortError::Failed(failure)) => return Err(failure),
            Err(PortError::Over) => {}
        }
    }
    let held = machine.held();
    let (kept, released): (Vec<MacId>, Vec<MacId>) = allocated.iter().partition(|slave| held.contains(slave));
    if !released.is_empty() {
        output::note(format_args!("released the connections of {}", list(&released)));
    }
    if !kept.is_empty() {
        output::warn(format_args!(
            "{} did not answer the release: their connections time out by themselves",
            list(&kept)
        ));
    }
    Ok(())
}

fn choose<'a>(
    args: &RunArgs,
    scenario: &'a Scenario,
    role: &str,
    is_of_role: impl Fn(&Node) -> bool,
) -> Result<&'a Node, Failure> {
    let file = args.file.display();
    let nodes: Vec<&Node> = scenario.nodes.iter().filter(|node| is_of_role(node)).collect();
    let names = || nodes.iter().map(|node| node.name.as_str()).collect::<Vec<_>>().join(", ");
    match (&nodes[..], &args.node) {
        ([], _) => Err(Failure::Usage(format!("{file}: there is no node of the role {role}"))),
        ([node], None) => Ok(node),
        (_, None) => Err(Failure::Usage(format!(
            "{file}: there are several of the role {role}, choose one with --node: {}",
            names()
        ))),
        (_, Some(name)) => (nodes.iter().find(|node| node.name == *name).copied()).ok_or_else(|| {
            Failure::Usage(format!("{file}: there is no {role} named {name}; there is {}", names()))
        }),
    }
}

/// The MAC ID of a node, and of the slaves that it will talk to.
fn addresses(node: &Node) -> (MacId, Vec<MacId>) {
    match &node.role {
        Role::Slave(slave) => (mac_id(slave.access.mac), Vec::new()),
        Role::Master(master) => {
            (mac_id(master.access.mac), master.scan.iter().map(|slave| slave.entry.mac_id).collect())
        }
        _ => (MacId::DEFAULT, Vec::new()),
    }
}

fn list(macs: &[MacId]) -> String {
    macs.iter().map(MacId::to_string).collect::<Vec<_>>().join(", ")
}

/// What the node tells, line by line, at once.
struct Log<'a> {
    output: Output,
    name: &'a str,
    json: bool,
}

impl Log<'_> {
    fn event(&mut self, now: Instant, event: &NodeEvent) -> io::Result<()> {
        // Data, which frames tell in a trace, as well.
        if !event.is_news() && !matches!(event, NodeEvent::Output { .. } | NodeEvent::Input { .. }) {
            return Ok(());
        }
        let words = event.words();
        let line = match self.json {
            true => {
                let mut object = simulate::object(now, self.name, event);
                if event.is_problem() {
                    object["problem"] = words.as_str().into();
                }
                object["text"] = words.into();
                object.to_string()
            }
            false => format!("{now:.6}  {}  {words}", self.name),
        };
        self.output.buffer.extend_from_slice(line.as_bytes());
        self.output.buffer.push(b'\n');
        self.output.flush()
    }
}
