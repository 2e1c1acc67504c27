//! `devicenet recover`: nodes that are silent because of a duplicate MAC ID are found, told apart, and given another one.

use core::fmt;
use core::ops::ControlFlow;
use core::time::Duration;
use std::collections::VecDeque;

use devicenet_core::MacId;
use devicenet_core::access::{self, Access};
use devicenet_core::message::{DelayOffset, DeviceIdentity, PortNumber};
use devicenet_core::tool::{Cause, CommandError, Config, OfflineTool, Refusal, ToolEvent, ToolState};
use link_core::{Action, Deadline, Input, Instant, Machine};
use serde_json::{Value, json};

use super::args::RecoverArgs;
use super::ask::mac_id;
use super::assignment::{Assignment, Device};
use super::errand::{self, End, Errand};
use super::permit;
use crate::exit::{Exit, Failure};
use crate::output::{self, Output};
use crate::text::count;

/// Finds faulted nodes, and gives them MAC IDs.
///
/// # Errors
/// [`Failure`] when the command line, the endpoint or the bus does not allow it.
pub fn recover(args: &RecoverArgs, json: bool) -> Result<Exit, Failure> {
    let RecoverArgs { endpoint, node, .. } = args;
    let own = mac_id(node.own_mac);
    if let Some(assignment) = args.assign.iter().find(|assignment| assignment.mac == own) {
        return Err(Failure::Usage(format!(
            "MAC ID {} is this command's own while it works: give the device another, or choose one with --own-mac",
            assignment.mac
        )));
    }
    for (place, one) in args.assign.iter().enumerate() {
        let others = &args.assign[..place];
        if others.iter().any(|other| other.device == one.device) {
            return Err(Failure::Usage(format!("{} is given two MAC IDs: give each device one", one.device)));
        }
        if others.iter().any(|other| other.mac == one.mac) {
            return Err(Failure::Usage(format!(
                "MAC ID {} is given to two devices: give each its own",
                one.mac
            )));
        }
    }
    let mut recovery = Recovery::new(errand::identity(endpoint), own);
    recovery.tasks.extend(args.identify.iter().map(|device| Task::Identify(device.0)));
    recovery
        .tasks
        .extend(args.assign.iter().map(|assignment| Task::Assign(assignment.device.0, assignment.mac)));
    let (mut port, heard) =
        permit::enter(endpoint, &node.permit, own, &what(args), recovery.max_in_flight())?;
    if args.assign_free {
        let is_free = |mac: &MacId| *mac != own && heard.node(*mac).is_none();
        // 63 is where devices come from, and the lowest IDs have the most urgent frames: those are for masters.
        recovery.free =
            Some(MacId::all().filter(is_free).filter(|mac| (1..63).contains(&mac.number())).collect());
    }
    let mut report = Report { output: Output::new(), json, found: 0, failed: 0 };
    let end = errand::run(&mut recovery, endpoint, &mut port, LONGEST, |news| match news {
        News::Over => ControlFlow::Break(Ok(())),
        News::OwnedByAnother => ControlFlow::Break(Err(Failure::Refused(format!(
            "another tool works with the faulted nodes on {endpoint}: wait until it is done"
        )))),
        News::Result(result) => match report.tell(result) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => ControlFlow::Break(Err(error.into())),
        },
    })?;
    match end {
        End::Done => {}
        End::TooLate => {
            return Err(Failure::Transport(format!("{endpoint}: the time was over before all was done")));
        }
        End::ScenarioOver(at) => return Err(endpoint.ended_before(at, "all was done")),
        End::Interrupted => {
            return Err(Failure::Interrupted("interrupted; no node is left with half a MAC ID".into()));
        }
    }
    if report.found == 0 {
        output::note(format_args!(
            "{endpoint}: no node waits for a MAC ID, or none answered: one without the offline connection set cannot be found so"
        ));
    } else if args.assign.is_empty() && !args.assign_free {
        output::note(format_args!(
            "{}; --identify VENDOR:SERIAL makes one flash, --assign VENDOR:SERIAL=MAC gives it a MAC ID, --assign-free gives each \
             the next that is free",
            count(report.found, "faulted node")
        ));
    }
    Ok(if report.failed > 0 { Exit::Findings } else { Exit::Done })
}

fn what(args: &RecoverArgs) -> String {
    let mut what = "the ownership of the offline connection set, Who".to_owned();
    for device in &args.identify {
        what += &format!(", Identify to {device}");
    }
    for Assignment { device, mac } in &args.assign {
        what += &format!(", Change_MAC_ID to {mac} for {device}");
    }
    if args.assign_free {
        what += ", Change_MAC_ID for each node that answers";
    }
    what
}

/// Something that is found or done.
#[derive(Debug)]
enum Outcome {
    Found(DeviceIdentity),
    /// It was asked to flash, and has or has not answered.
    Identified(DeviceIdentity, bool),
    Recovered(DeviceIdentity, MacId),
    NotRecovered(DeviceIdentity, MacId, Refusal),
    /// It is not among those that answered to Who.
    NotIdentified(DeviceIdentity),
    /// There is no MAC ID left for it.
    NoneFree(DeviceIdentity),
}

#[derive(Debug)]
enum News {
    Result(Outcome),
    Over,
    OwnedByAnother,
}

#[derive(Clone, Copy, Debug)]
enum Task {
    Claim,
    Who,
    Identify(DeviceIdentity),
    Assign(DeviceIdentity, MacId),
}

/// A tool with a list of what is to be done, one after the other.
struct Recovery {
    tool: OfflineTool,
    /// After Claim and Who; at the end the set is released.
    tasks: VecDeque<Task>,
    /// What it does now.
    current: Option<Task>,
    /// Those that answer to Who are given one of these, if it is so wished.
    free: Option<VecDeque<MacId>>,
    /// Those that have answered to Who.
    found: Vec<DeviceIdentity>,
    is_over: bool,
    ready: VecDeque<News>,
}

impl Recovery {
    fn new(device: DeviceIdentity, own: MacId) -> Self {
        let access = access::Config::new(device, PortNumber::ZERO, own);
        Self {
            tool: OfflineTool::new(Config::new(access)),
            tasks: VecDeque::from([Task::Claim, Task::Who]),
            current: None,
            free: None,
            found: Vec::new(),
            is_over: false,
            ready: VecDeque::new(),
        }
    }

    /// Begins what is next, or gives it up; false if it has to wait.
    fn work(&mut self, now: Instant) -> bool {
        if self.current.is_some() || self.is_over {
            return false;
        }
        let Some(task) = self.tasks.pop_front() else {
            self.tool.release(now);
            self.is_over = true;
            self.ready.push_back(News::Over);
            return true;
        };
        // It need not answer to Identify, but to Who.
        if let Task::Identify(device) = task
            && !self.found.contains(&device)
        {
            self.tell(Outcome::NotIdentified(device));
            return true;
        }
        let begun = match task {
            Task::Claim => self.tool.claim(now),
            Task::Who => self.tool.who(now, DelayOffset::SERIAL),
            Task::Identify(device) => self.tool.identify_device(now, device),
            Task::Assign(device, mac) => self.tool.change_mac_id(now, device, mac),
        };
        match begun {
            Ok(()) => self.current = Some(task),
            // It will be on line, or have its answers.
            Err(CommandError::NotOnLine | CommandError::Busy) => {
                self.tasks.push_front(task);
                return false;
            }
            Err(CommandError::NotOwner | CommandError::OwnMacId(_) | CommandError::Access(_)) => {}
        }
        true
    }

    fn follow(&mut self, event: ToolEvent) {
        match event {
            ToolEvent::StateChanged { to: ToolState::Owner, .. } => self.current = None,
            ToolEvent::StateChanged { to: ToolState::Idle, cause: Cause::OwnedByAnother, .. } => {
                self.ready.push_back(News::OwnedByAnother);
            }
            ToolEvent::Found(answer) => {
                self.found.push(answer.device);
                self.tell(Outcome::Found(answer.device));
                match self.free.as_mut().map(VecDeque::pop_front) {
                    Some(Some(mac)) => self.tasks.push_back(Task::Assign(answer.device, mac)),
                    Some(None) => self.tell(Outcome::NoneFree(answer.device)),
                    None => {}
                }
            }
            ToolEvent::WhoDone { .. } => self.current = None,
            ToolEvent::IdentifyDone { answered } => {
                if let Some(Task::Identify(device)) = self.current.take() {
                    self.tell(Outcome::Identified(device, answered));
                }
            }
            ToolEvent::Recovered { device, mac } => {
                self.current = None;
                self.tell(Outcome::Recovered(device, mac));
            }
            ToolEvent::NotRecovered { device, mac, why } => {
                self.current = None;
                self.tell(Outcome::NotRecovered(device, mac, why));
            }
            _ => {}
        }
    }

    fn tell(&mut self, outcome: Outcome) {
        self.ready.push_back(News::Result(outcome));
    }
}

impl Errand for Recovery {
    fn access(&self) -> &Access {
        self.tool.access()
    }

    fn why_not_online(&self) -> String {
        "it is not let on line".into()
    }

    fn leave(&mut self) {
        self.tasks.clear();
        self.free = None;
        // A device that was told its MAC ID is waited for; nothing else leaves a trace.
        self.current.take_if(|task| !matches!(task, Task::Assign(..)));
    }

    fn unfinished(&self) -> Option<String> {
        match self.current {
            Some(Task::Assign(device, mac)) => Some(format!(
                "whether {} is on line as node {mac} is not known: `devicenet scan` lists who is there",
                Device(device)
            )),
            _ => None,
        }
    }
}

impl Machine for Recovery {
    type Event = News;

    fn input(&mut self, now: Instant, input: Input) {
        self.tool.input(now, input);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<News>> {
        loop {
            if let Some(news) = self.ready.pop_front() {
                return Some(Action::Event(news));
            }
            match self.tool.poll(now).map(Action::without_event) {
                Some(Err(event)) => self.follow(event),
                Some(Ok(action)) => return Some(action),
                None if self.work(now) => {}
                None => return None,
            }
        }
    }

    fn deadline(&self) -> Option<Deadline> {
        self.tool.deadline()
    }

    fn max_in_flight(&self) -> usize {
        self.tool.max_in_flight()
    }
}

/// Tells each outcome at once.
struct Report {
    output: Output,
    json: bool,
    found: u64,
    failed: u64,
}

impl Report {
    fn tell(&mut self, outcome: Outcome) -> std::io::Result<()> {
        match &outcome {
            Outcome::Found(_) => self.found += 1,
            Outcome::NotRecovered(..) | Outcome::NotIdentified(_) | Outcome::NoneFree(_) => self.failed += 1,
            Outcome::Identified(..) | Outcome::Recovered(..) => {}
        }
        let line = if self.json { outcome.json().to_string() } else { outcome.to_string() };
        self.output.buffer.extend_from_slice(line.as_bytes());
        self.output.buffer.push(b'\n');
        self.output.flush()
    }
}

impl Outcome {
    fn json(&self) -> Value {
        let (event, device) = match self {
            Self::Found(device) => ("found", device),
            Self::Identified(device, _) => ("identify", device),
            Self::Recovered(device, _) => ("recovered", device),
            Self::NotIdentified(device) => ("not_identified", device),
            Self::NotRecovered(device, ..) | Self::NoneFree(device) => ("not_recovered", device),
        };
        let mut object = json!({ "event": event, "vendor": device.vendor.0, "serial": device.serial });
        if let Self::Recovered(_, mac) | Self::NotRecovered(_, mac, _) = self {
            object["mac"] = mac.number().into();
        }
        match self {
            Self::NotRecovered(_, _, why) => object["problem"] = why.to_string().into(),
            Self::NotIdentified(_) => object["problem"] = NOT_THERE.into(),
            Self::NoneFree(_) => object["problem"] = NONE_FREE.into(),
            Self::Identified(_, answered) => object["answered"] = (*answered).into(),
            Self::Found(_) | Self::Recovered(..) => {}
        }
        object["text"] = self.to_string().into();
        object
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Found(device) => write!(f, "faulted  {}", Device(*device)),
            Self::Identified(device, true) => write!(f, "flashing  {}", Device(*device)),
            Self::Identified(device, false) => {
                write!(f, "asked to flash  {}: it has not answered, and need not", Device(*device))
            }
            Self::Recovered(device, mac) => {
                write!(f, "recovered  {}  is on line as node {mac}", Device(*device))
            }
            Self::NotRecovered(device, mac, why) => {
                write!(f, "not recovered  {}  as node {mac}: {why}", Device(*device))
            }
            Self::NotIdentified(device) => {
                write!(f, "not asked to flash  {}: {NOT_THERE}", Device(*device))
            }
            Self::NoneFree(device) => write!(f, "not recovered  {}: {NONE_FREE}", Device(*device)),
        }
    }
}

const NOT_THERE: &str = "no such node answered to Who";
const NONE_FREE: &str = "no MAC ID is free";
/// Claiming takes two seconds, Who three, a new MAC ID about five.
const LONGEST: Duration = Duration::from_secs(600);
