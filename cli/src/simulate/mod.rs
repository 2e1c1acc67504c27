//! `devicenet simulate`: a scenario on the simulated bus, in words, as JSON, as figures, as a recording, as a picture, or
//! with programs from outside sitting on it.

mod act;
mod args;
mod build;
mod doors;
mod event;
mod exchange;
mod exchanged;
mod expectations;
mod health;
mod json;
mod level;
mod load;
mod machines;
mod picture;
mod polls;
mod record;
mod run;
mod said;
mod selection;
mod shared;
mod sight;
mod socketcand;
mod state;
mod summary;
mod svg;
mod text;
mod timeline;

use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use std::fs;
use std::io::{self, Write as _};
use std::net::{SocketAddr, ToSocketAddrs as _};
use std::path::Path;

pub use args::SimulateArgs;
pub use build::Settings;
pub(crate) use event::NodeEvent;
pub use exchange::Exchange;
pub use expectations::{Failure as FailedExpectation, Status, Verdict};
pub use health::{examine, examine_from};
pub(crate) use json::object;
pub use run::Outcome;
pub use selection::EventKind;
pub use summary::{BusSummary, NodeSummary, ScanSummary, SlaveSummary, Summary};

use crate::exit::{Exit, Failure};
use crate::output::{self, Output};
use crate::scenario::{Node, Role, Scenario, TimeRange};
use devicenet_core::MacId;
use devicenet_core::access::Access;
use devicenet_core::master::ScannerStatus;
use devicenex_core::OperationalAddress;
use json::JsonView;
use link_core::{Instant, Machine};
pub(crate) use machines::release;
pub(crate) use machines::{DeviceMachine, ManagerMachine, MasterMachine, SlaveMachine};
use record::RecordView;
use run::Run;
use selection::{Selected, Selection};
use shared::{FirstError, SharedBuffer};
use sight::View;
use socketcand::Server;
use text::TextView;
use timeline::TimelineView;
use transport_mock::Network;

/// The built-in plant, which `devicenet simulate` runs without an argument.
pub const PLANT: &str = include_str!("../../scenarios/plant.toml");

/// The bus of a scenario with its nodes, and all that will happen to it.
pub(crate) fn network(scenario: &Scenario) -> Network<NodeEvent> {
    build::network(scenario, scenario.bus.seed, false)
}

/// A node that is not on for good.
pub(crate) trait Guest: Machine<Event = NodeEvent> {
    /// It is to be gone soon: it gives back what it holds of others.
    fn leave(&mut self, now: Instant);

    /// The others of whom it still holds something, or may: it has asked them.
    fn held(&self) -> Vec<MacId>;

    /// The others that have given it a connection.
    fn allocated(&self) -> Vec<MacId>;

    /// The others that it should serve and does not, and why.
    fn unserved(&self) -> Vec<(MacId, ScannerStatus)>;

    /// Its network access.
    fn access(&self) -> &Access;
}

/// The machine of a node that speaks DeviceNet.
pub(crate) fn machine(node: &Node) -> Option<Box<dyn Guest>> {
    match &node.role {
        Role::Slave(slave) => Some(Box::new(SlaveMachine::new(slave, node.bit_rate))),
        Role::Master(master) => Some(Box::new(MasterMachine::new(master))),
        _ => None,
    }
}

/// Runs a scenario and tells what it has come to.
#[must_use]
pub fn outcome(scenario: &Scenario, settings: Settings) -> Outcome {
    let mut run = Run::new(scenario, settings, Vec::new(), false);
    // Nothing is written, so nothing can fail.
    let _ = run.at_full_speed(|| Ok(()));
    run.finish()
}

/// Runs a scenario, and tells what happened in the words of the trace and what it has come to.
#[must_use]
pub fn trace(scenario: &Scenario, settings: Settings) -> (String, Outcome) {
    let buffer = SharedBuffer::default();
    let view = TextView::new(buffer.clone(), false, &scenario.nodes);
    let mut run = Run::new(scenario, settings, vec![Box::new(view)], false);
    let _ = run.at_full_speed(|| Ok(()));
    let outcome = run.finish();
    let mut text = Vec::new();
    buffer.drain_into(&mut text);
    (String::from_utf8_lossy(&text).into_owned(), outcome)
}

/// Runs the command.
///
/// # Errors
/// [`Failure`] when the scenario has a defect, or a file or an address cannot be used.
pub fn run(args: &SimulateArgs, json: bool) -> Result<Exit, Failure> {
    if args.print_plant {
        let mut output = Output::new();
        output.buffer.extend_from_slice(PLANT.as_bytes());
        output.flush()?;
        return Ok(Exit::Done);
    }
    for (option, path) in [("--record", &args.record), ("--svg", &args.svg)] {
        if path.as_ref().is_some_and(|path| path.as_os_str() == "-") {
            return Err(Failure::Usage(format!(
                "{option} -: standard output has the trace or the figures; expected the name of a file"
            )));
        }
    }
    let mut scenario = match &args.scenario {
        Some(path) if path.as_os_str() == "-" => Scenario::from_stdin(),
        Some(path) => Scenario::load(path),
        None => Scenario::parse("(built-in plant)", PLANT, Path::new("")),
    }
    .map_err(|error| Failure::Usage(error.to_string()))?;
    let server =
        args.serve.as_deref().map(|address| serve(address, args.allow_remote, &mut scenario)).transpose()?;
    let until = match args.until {
        Some(time) => Some(time.0),
        // Clients come and go: the bus is there until it is interrupted.
        None => server.is_some().then_some(Duration::MAX),
    };
    let settings = Settings { seed: args.seed, until };

    let mut output = Output::new();
    let (buffer, first_error) = (SharedBuffer::default(), FirstError::default());
    let mut views: Vec<Box<dyn View + '_>> = Vec::new();
    let selection = Selection { only: args.event.clone(), without: args.no_event.clone() };
    match (json, args.summary) {
        (_, true) => {}
        (true, false) => {
            views.push(Box::new(Selected::new(JsonView::new(buffer.clone()), selection)));
        }
        (false, false) => {
            let view = TextView::new(buffer.clone(), output.is_coloured(), &scenario.nodes)
                .with_all_frames(args.all_frames)
                .with_all_of(selection.clone());
            views.push(Box::new(Selected::new(view, selection)));
        }
    }
    if let Some(path) = &args.record {
        let view = RecordView::create(path, first_error.clone());
        views.push(Box::new(view.map_err(|error| unwritable(path, &error))?));
    }
    let picture = args.svg.as_ref().map(|path| {
        let (view, picture) = TimelineView::new(&scenario);
        views.push(Box::new(view));
        (path, picture)
    });

    let is_live = args.realtime || server.is_some();
    let mut run = Run::new(&scenario, settings, views, server.is_some());
    let mut write_out = || -> io::Result<()> {
        buffer.drain_into(&mut output.buffer);
        if is_live { output.flush() } else { output.line_done() }
    };
    if is_live {
        run.by_the_clock(server, interruption()?, &mut write_out)?
    } else {
        run.at_full_speed(&mut write_out)?
    }
    // The last views drop here, and tell what they have kept back.
    let outcome = run.finish();
    buffer.drain_into(&mut output.buffer);
    if let Some(path) = &args.record {
        first_error.take().map_err(|error| unwritable(path, &error))?;
    }
    if let Some((path, picture)) = picture {
        let mut picture = picture.borrow_mut();
        picture.end = outcome.end;
        fs::write(path, svg::draw(&picture)).map_err(|error| unwritable(path, &error))?;
    }
    // The built-in plant ends with its figures.
    let with_summary = args.summary || (args.scenario.is_none() && !json);
    if with_summary && !args.summary {
        output.buffer.push(b'\n');
    }
    conclude(&mut output, &outcome, with_summary, json, &scenario);
    output.flush()?;
    Ok(if outcome.verdict.failures.is_empty() { Exit::Done } else { Exit::Findings })
}

/// Is set by Ctrl-C, or by whoever else asks the program to end, from the first call on. The second time ends it at once; what comes
/// right behind the first is the same wish: `timeout` signals the program, and then its whole group.
pub(crate) fn interruption() -> Result<&'static AtomicBool, Failure> {
    static INTERRUPTED: AtomicBool = AtomicBool::new(false);
    static IS_HANDLED: AtomicBool = AtomicBool::new(false);
    if IS_HANDLED.swap(true, Ordering::Relaxed) {
        return Ok(&INTERRUPTED);
    }
    let mut first = None;
    let handle = move || {
        INTERRUPTED.store(true, Ordering::Relaxed);
        if first.get_or_insert_with(std::time::Instant::now).elapsed() > SAME_WISH {
            std::process::exit(i32::from(Exit::Interrupted as u8));
        }
    };
    ctrlc::set_handler(handle)
        .map_err(|error| Failure::Transport(format!("cannot be told of an interruption: {error}")))?;
    Ok(&INTERRUPTED)
}

/// Figures and expectations, at the end.
fn conclude(output: &mut Output, outcome: &Outcome, with_summary: bool, json: bool, scenario: &Scenario) {
    let verdict = &outcome.verdict;
    let out = &mut output.buffer;
    if json {
        json::push_end(out, outcome.end, verdict, &outcome.summary);
        return;
    }
    if with_summary {
        out.extend_from_slice(outcome.summary.table(scenario.bus.bit_rate).as_bytes());
    }
    if let Some(words) = without_manager(scenario, &outcome.summary) {
        let _ = writeln!(out, "\n{words}");
    }
    if verdict.held + verdict.failures.len() + verdict.unjudged == 0 {
        return;
    }
    // Writing to a vector cannot fail.
    let _ = writeln!(out);
    for failure in &verdict.failures {
        let _ = writeln!(out, "expectation failed: {}, {failure}", scenario.file);
    }
    let judged = verdict.held + verdict.failures.len();
    let judged = crate::text::count(judged as u64, "expectation");
    let _ = write!(out, "{} of {judged} held", verdict.held);
    let _ = match verdict.unjudged {
        0 => writeln!(out),
        1 => writeln!(out, ", 1 lies after the end of the run"),
        more => writeln!(out, ", {more} lie after the end of the run"),
    };
}

/// Devices that nobody gives an address.
fn without_manager(scenario: &Scenario, summary: &Summary) -> Option<String> {
    let has_manager = scenario.nodes.iter().any(|node| matches!(node.role, Role::Manager(_)));
    let none = OperationalAddress::NONE.number();
    let waiting: Vec<&str> =
        (summary.nodes.iter().filter(|node| node.oa == Some(none))).map(|node| node.node.as_str()).collect();
    let (who, them) = match waiting.as_slice() {
        [] => return None,
        [one] => (format!("{one} has"), "it"),
        [one, other] => (format!("{one} and {other} have"), "them"),
        [one, others @ ..] => (format!("{one} and {} others have", others.len()), "them"),
    };
    (!has_manager).then(|| format!("no node is a manager: {who} no address, and nobody gives {them} one"))
}

/// Opens the server, and tells where. A scenario without an external node gets one.
fn serve(address: &str, allow_remote: bool, scenario: &mut Scenario) -> Result<Server, Failure> {
    let resolved: Vec<SocketAddr> = (address.to_socket_addrs())
        .map_err(|error| Failure::Usage(format!("--serve {address}: {error}; expected HOST:PORT")))?
        .collect();
    if !allow_remote && resolved.iter().any(|address| !address.ip().is_loopback()) {
        return Err(Failure::Refused(format!(
            "{address} can be reached by other machines, which may then send on the bus; say --allow-remote, or use \
             127.0.0.1"
        )));
    }
    let is_external = |node: &&Node| node.role == Role::External;
    if !scenario.nodes.iter().any(|node| is_external(&node)) {
        scenario.nodes.push(Node {
            name: free_name(scenario),
            role: Role::External,
            power_up: TimeRange::default(),
            reaction: TimeRange::default(),
            bit_rate: scenario.bus.bit_rate,
            clock_ppm: 0,
        });
    }
    let channels: Vec<String> =
        scenario.nodes.iter().filter(is_external).map(|node| node.name.clone()).collect();
    let names = channels.join(", ");
    let server = Server::bind(resolved.as_slice(), channels)
        .map_err(|error| Failure::Transport(format!("cannot serve at {address}: {error}")))?;
    output::note(format_args!("serving {names} at {}", server.address()));
    Ok(server)
}

/// `can0`, or the first of its kind that no node has.
fn free_name(scenario: &Scenario) -> String {
    let is_free = |name: &String| scenario.nodes.iter().all(|node| node.name != *name);
    (0..).map(|number| format!("can{number}")).find(is_free).unwrap_or_default()
}

fn unwritable(path: &Path, error: &io::Error) -> Failure {
    Failure::Usage(format!("{}: {error}", path.display()))
}

/// Nobody presses Ctrl-C twice that fast.
const SAME_WISH: Duration = Duration::from_millis(200);
