//! `devicenet powerlink mn`: a managing node.

mod config;
mod raw;

use std::collections::BTreeMap;
use std::io;

use link_core::Instant;
use link_core::ethernet::Port as _;
use powerlink_core::NodeId;
use powerlink_core::dictionary::ObjectAddress;
use powerlink_core::managing::{ManagingNode, MnEvent, MnState, NodePhase, NodePlan};
use powerlink_core::wire::NmtCommandId;

use super::args::MnArgs;
use super::log::Log;
use super::session::{News, Session};
use crate::exit::{Exit, Failure};
use crate::output;
use config::Network;

/// Is the managing node.
pub(super) fn run(args: &MnArgs, json: bool) -> Result<Exit, Failure> {
    let mut network = Network::load(&args.file).map_err(|error| Failure::Usage(error.to_string()))?;
    // With an address of nobody, to see whether there can be such a network before anything is opened.
    machine(args, &network, &network.plans(&network.writes()))?;
    let list = network.nodes.iter().map(|node| node.id().0.to_string()).collect::<Vec<_>>().join(", ");
    let nodes =
        if network.nodes.len() == 1 { format!("node {list}") } else { format!("each of nodes {list}") };
    let cycle = crate::scenario::Time(network.config.cycle);
    let what = format!(
        "as managing node 240: NMTResetNode to every node, a cycle of {cycle}, and to {nodes} its configuration and \
         process data"
    );
    let mut session = Session::open(&args.station, None, &what)?;
    network.config.mac = session.interface().mac();
    let writes = network.writes();
    let plans = network.plans(&writes);
    let mut machine = machine(args, &network, &plans)?;
    let mut log = Log::new(NodeId::MANAGING_NODE, json);
    let mut inputs = Inputs::default();
    log.start(session.now(), session.zero())?;
    machine.start(session.now());
    let ran = session.run(
        &mut *machine,
        |machine, now, news| tell(machine, now, news, &mut inputs, &mut log),
        |_| false,
    );
    if ran.as_ref().is_err_and(|failure| !matches!(failure, Failure::Transport(_))) {
        silence(&mut session, &mut log);
    }
    let is_complete = machine.is_complete();
    let missing: Vec<String> = missing(&machine);
    let left = leave(&mut session, &mut machine, &mut inputs, &mut log);
    ran.and(left)?;
    session.finish()?;
    if is_complete {
        return Ok(Exit::Done);
    }
    output::error(format_args!("not operational in the end: {}", missing.join(", ")));
    Ok(Exit::Findings)
}

/// The managing node of a network, with its first outputs.
fn machine<'p>(
    args: &MnArgs,
    network: &Network,
    plans: &'p [NodePlan<'p>],
) -> Result<Box<Machine<'p>>, Failure> {
    let usage = |error: &dyn core::fmt::Display| Failure::Usage(format!("{}: {error}", args.file.display()));
    let refused = |error| Failure::Usage(network.places.refuse(&error).to_string());
    let mut machine: Box<Machine<'_>> = Box::new(ManagingNode::new(network.config, plans).map_err(refused)?);
    for node in network.nodes.iter().filter(|node| !node.outputs.is_empty()) {
        machine.set_outputs(node.id(), &node.outputs).map_err(|error| usage(&error))?;
    }
    Ok(machine)
}

/// Room for every node, with as much process data as there can be.
type Machine<'p> = ManagingNode<'p, 239, 1490>;

/// Resets every node, so that none goes on alone, and falls silent; whether that can be told or not.
fn leave(
    session: &mut Session,
    machine: &mut Machine<'_>,
    inputs: &mut Inputs,
    log: &mut Log,
) -> Result<(), Failure> {
    let left = reset_all(session, machine, inputs, log);
    if left.is_err() {
        silence(session, log);
        // The first failure is the one that is told.
        let _ = reset_all(session, machine, inputs, log);
    }
    left
}

/// The pipe is closed, or the disk is full: what is done from now on is not told.
fn silence(session: &mut Session, log: &mut Log) {
    log.mute();
    session.stop_recording();
}

fn reset_all(
    session: &mut Session,
    machine: &mut Machine<'_>,
    inputs: &mut Inputs,
    log: &mut Log,
) -> Result<(), Failure> {
    let is_alone = |machine: &Machine<'_>| {
        machine.plans().iter().all(|plan| machine.phase(plan.node) == Some(NodePhase::Absent))
    };
    let mut ran = Ok(());
    if !is_alone(machine) {
        session.end_soon();
        // It is a command for nodes.
        let _ = machine.command_all(NmtCommandId::RESET_NODE);
        ran = session.run(machine, |machine, now, news| tell(machine, now, news, inputs, log), is_alone);
        match is_alone(machine) {
            _ if ran.is_err() => {}
            true => output::note("told every node NMTResetNode"),
            false => output::warn("the nodes could not be told NMTResetNode: they notice the loss of SoC"),
        }
    }
    let (state, counters) = (machine.state(), *machine.counters());
    machine.stop(session.now());
    let ended = log.end(session.now(), &state, &counters);
    // The first failure is the one that is told.
    ran.and(ended.map_err(Failure::from))
}

fn tell(
    machine: &mut Machine<'_>,
    now: Instant,
    news: News<MnEvent>,
    inputs: &mut Inputs,
    log: &mut Log,
) -> io::Result<()> {
    match news {
        News::Event(MnEvent::Inputs { node, .. }) => inputs.tell(node, machine.inputs(node), now, log),
        News::Event(event) => {
            if let MnEvent::ConfigurationAborted { node, at, .. } = event
                && let Some(origin) = origin(machine, node, at)
            {
                output::note(origin);
            }
            log.event(now, &event)
        }
        News::Link(event) => log.link(now, event),
        News::Time => log.time(now),
    }
}

/// What in the network file an object comes from that the file does not name itself.
fn origin(machine: &Machine<'_>, node: NodeId, at: ObjectAddress) -> Option<String> {
    let plan = machine.plans().iter().find(|plan| plan.node == node)?;
    let (key, mapping) = match (at.index, at.sub) {
        (0x1600, _) => ("map_outputs", plan.outputs),
        (0x1A00, _) => ("map_inputs", plan.inputs),
        (0x1F98, 4) => return Some(format!("{node}: {at} is its `preq_limit` of {}", plan.preq_limit)),
        (0x1F98, 5) => return Some(format!("{node}: {at} is its `pres_limit` of {}", plan.pres_limit)),
        _ => return None,
    };
    let entries = match at.sub.checked_sub(1) {
        Some(entry) => mapping.get(usize::from(entry)..=usize::from(entry))?,
        None => mapping,
    };
    let objects: Vec<String> =
        entries.iter().map(|entry| format!("{} of {} bits", entry.object, entry.length)).collect();
    Some(format!("{node}: {at} is its `{key}`: {}", objects.join(", ")))
}

/// What is not as it should be.
fn missing(machine: &Machine<'_>) -> Vec<String> {
    let nodes = machine.plans().iter().filter_map(|plan| Some((plan.node, machine.phase(plan.node)?)));
    let mut missing: Vec<String> = nodes
        .filter(|(_, phase)| *phase != NodePhase::Operational)
        .map(|(node, phase)| format!("{node} ({phase})"))
        .collect();
    if machine.state() != MnState::Operational {
        missing.push(format!("the managing node ({})", machine.state()));
    }
    missing
}

/// Inputs are told when they change, and when there are none any more, not in every cycle.
#[derive(Default)]
struct Inputs {
    told: BTreeMap<u8, Option<Vec<u8>>>,
}

impl Inputs {
    fn tell(&mut self, node: NodeId, data: Option<&[u8]>, now: Instant, log: &mut Log) -> io::Result<()> {
        if self.told.get(&node.0).is_some_and(|told| told.as_deref() == data) {
            return Ok(());
        }
        self.told.insert(node.0, data.map(<[u8]>::to_vec));
        log.inputs(now, node, data)
    }
}
