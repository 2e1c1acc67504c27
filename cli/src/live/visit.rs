//! Explicit connections to nodes: opened, used, released.

use core::ops::ControlFlow;
use core::time::Duration;
use std::collections::{BTreeMap, VecDeque};

use cip_core::code::{AdditionalCode, AttributeId, ClassId, DeviceType, GeneralStatus, InstanceId};
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use cip_core::message::{AllocationChoice, AttributeRequest, Response};
use devicenet_core::MacId;
use devicenet_core::access::Access;
use devicenet_core::client::Failure as NoResponse;
use devicenet_core::master::{
    Cause, CommandError, Config, Master, MasterEvent, ScanEntry, SlaveEvent, SlaveState,
};
use devicenet_core::message;
use link_core::{Action, Deadline, Input, Instant, Machine};

use super::attribute::AttributePath;
use super::endpoint::Endpoint;
use super::errand::{self, End, Errand};
use super::port::LivePort;
use crate::exit::Failure;
use crate::simulate;

/// One request.
#[derive(Clone, Debug)]
pub(super) struct Question {
    pub(super) path: AttributePath,
    /// The value to be set; without, it is read.
    pub(super) value: Option<Vec<u8>>,
}

/// What came of a request.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Answer {
    /// It was done, with these data.
    Done(Vec<u8>),
    /// The node refused.
    Refused(GeneralStatus, AdditionalCode),
    /// The node did not answer it.
    Silent(NoResponse),
    /// It could not be put to the node, in its message format.
    Unsent(CommandError),
}

/// What came of a visit.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Report {
    pub(super) mac: MacId,
    /// As many as were asked, unless there was trouble.
    pub(super) answers: Vec<Answer>,
    /// Why there was no connection, or why it ended.
    pub(super) trouble: Option<Cause>,
    /// What has ended the command before all was asked.
    pub(super) cut: Option<Cut>,
}

/// What ends a visit before its time.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Cut {
    /// Somebody has interrupted the command; no connection is left.
    Interrupted,
    /// The scenario has ended.
    ScenarioOver(Instant),
}

impl Cut {
    /// How the command ends, before `what`.
    pub(super) fn failure(self, endpoint: &Endpoint, what: &str) -> Failure {
        match self {
            Self::Interrupted => {
                Failure::Interrupted(format!("interrupted before {what}; no connection is left"))
            }
            Self::ScenarioOver(at) => endpoint.ended_before(at, what),
        }
    }
}

impl Report {
    /// Of a node that is not visited, because another master has it.
    pub(super) const fn owned(mac: MacId) -> Self {
        Self { mac, answers: Vec::new(), trouble: Some(Cause::OwnedByAnother), cut: None }
    }
}

/// A master that keeps no I/O. It tells of each visit when that is over.
pub(super) struct Visitor {
    master: Box<Master<63, MESSAGE>>,
    visits: BTreeMap<MacId, Visit>,
    /// Begins when this node has not answered.
    next: Option<(MacId, (MacId, Vec<Question>))>,
    /// Is to begin now.
    due: Option<(MacId, Vec<Question>)>,
    reports: VecDeque<Report>,
}

struct Visit {
    /// In this order.
    questions: Vec<Question>,
    answers: Vec<Answer>,
    stage: Stage,
    /// If something has: nothing more is asked.
    cut: Option<Cut>,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Stage {
    /// Until there is a connection.
    Coming,
    /// The next question is to be asked; all are, the connection is to be released.
    Due,
    /// A question waits for its answer.
    Asking,
    /// The release does.
    Leaving,
}

impl Visitor {
    /// With nobody to visit yet.
    pub(super) fn new(endpoint: &Endpoint, own: MacId) -> Self {
        let config = Config { tries: 2, deferred_delete: false, ..Config::new(device(endpoint), own) };
        Self {
            master: Box::new(Master::new(config)),
            visits: BTreeMap::new(),
            next: None,
            due: None,
            reports: VecDeque::new(),
        }
    }

    /// Visits a node too: at most 63 of them, and not itself.
    pub(super) fn visit(&mut self, mac: MacId, questions: Vec<Question>) {
        self.begin(Instant::ZERO, mac, questions);
    }

    /// Visits a node if nobody answers at another MAC ID; else that one is reported, and this one is left alone.
    pub(super) fn visit_if_absent(&mut self, absent: MacId, mac: MacId, questions: Vec<Question>) {
        // Its vendor, which every node has.
        let path =
            AttributePath { class: ClassId::IDENTITY, instance: InstanceId(1), attribute: AttributeId(1) };
        self.visit(absent, vec![Question { path, value: None }]);
        self.next = Some((absent, (mac, questions)));
    }

    fn begin(&mut self, now: Instant, mac: MacId, questions: Vec<Question>) {
        let entry = ScanEntry::explicit_only(mac);
        if self.master.add_slave(now, entry).is_ok() {
            self.visits
                .insert(mac, Visit { questions, answers: Vec::new(), stage: Stage::Coming, cut: None });
        }
    }

    /// Makes the visits, on a port whose link was up until now. Those that are still under way when the time is over have come
    /// to nothing; when the command is interrupted they are cut short, and their connections are released.
    pub(super) fn run(mut self, endpoint: &Endpoint, port: &mut LivePort) -> Result<Vec<Report>, Failure> {
        let mut reports = Vec::new();
        let mut left = self.visits.len();
        let end = errand::run(&mut self, endpoint, port, LONGEST, |report| {
            reports.push(report);
            left -= 1;
            if left == 0 { ControlFlow::Break(Ok(())) } else { ControlFlow::Continue(()) }
        })?;
        for (mac, mut visit) in self.visits {
            visit.cut = match end {
                End::Interrupted => Some(Cut::Interrupted),
                End::ScenarioOver(at) => Some(Cut::ScenarioOver(at)),
                End::Done | End::TooLate => visit.cut,
            };
            reports.push(visit.report(mac, Some(Cause::NoAnswer)));
        }
        reports.sort_by_key(|report| report.mac);
        Ok(reports)
    }

    fn follow(&mut self, mac: MacId, event: SlaveEvent) {
        let Some(visit) = self.visits.get_mut(&mac) else { return };
        match event {
            SlaveEvent::StateChanged { to: SlaveState::Running, .. } => visit.stage = Stage::Due,
            SlaveEvent::StateChanged { from, to: SlaveState::Waiting, cause }
                if from != SlaveState::Offline =>
            {
                self.end(mac, Some(cause));
            }
            SlaveEvent::Response | SlaveEvent::RequestFailed(_) if visit.stage == Stage::Leaving => {
                self.end(mac, None);
            }
            SlaveEvent::Response => {
                visit.answers.push(match self.master.response(mac) {
                    Some(Response::Success { data, .. }) => Answer::Done(data.to_vec()),
                    Some(Response::Error { status, additional }) => Answer::Refused(status, additional),
                    None => Answer::Silent(NoResponse::Malformed),
                });
                visit.stage = Stage::Due;
            }
            SlaveEvent::RequestFailed(failure) => {
                visit.answers.push(Answer::Silent(failure));
                visit.stage = Stage::Due;
            }
            SlaveEvent::StateChanged { .. }
            | SlaveEvent::Status(_)
            | SlaveEvent::Differs(_)
            | SlaveEvent::Refused { .. }
            | SlaveEvent::Input(_)
            | SlaveEvent::Heartbeat(_)
            | SlaveEvent::Shutdown(_) => {}
        }
    }

    /// Asks what is due; whether anything was. A connection that is being closed after the last question has to be waited for.
    fn ask(&mut self, now: Instant) -> bool {
        let (mut has_asked, mut ended) = (false, Vec::new());
        for (mac, visit) in self.visits.iter_mut().filter(|(_, visit)| visit.stage == Stage::Due) {
            let question = visit.questions.get(visit.answers.len()).filter(|_| visit.cut.is_none());
            match put(&mut self.master, now, *mac, question) {
                Ok(()) => {
                    visit.stage = if question.is_some() { Stage::Asking } else { Stage::Leaving };
                    has_asked = true;
                }
                Err(CommandError::Busy) => {}
                // The connection is released next, unless there is another question.
                Err(error @ (CommandError::Request(_) | CommandError::NoObject)) if question.is_some() => {
                    visit.answers.push(Answer::Unsent(error));
                    has_asked = true;
                }
                Err(_) => ended.push(*mac),
            }
        }
        has_asked |= !ended.is_empty();
        for mac in ended {
            self.end(mac, None);
        }
        has_asked
    }

    fn end(&mut self, mac: MacId, trouble: Option<Cause>) {
        let Some(visit) = self.visits.remove(&mac) else { return };
        // It is in the list.
        let _ = self.master.remove_slave(mac);
        if trouble == Some(Cause::NoAnswer)
            && visit.stage == Stage::Coming
            && visit.cut.is_none()
            && let Some((_, next)) = self.next.take_if(|(absent, _)| *absent == mac)
        {
            self.due = Some(next);
            return;
        }
        self.reports.push_back(visit.report(mac, trouble));
    }
}

impl Visit {
    fn report(self, mac: MacId, trouble: Option<Cause>) -> Report {
        let is_complete = self.answers.len() == self.questions.len();
        let cut = self.cut.filter(|_| !is_complete);
        let is_well = is_complete || cut.is_some();
        let trouble = if is_well { None } else { Some(trouble.unwrap_or(Cause::NoAnswer)) };
        Report { mac, answers: self.answers, trouble, cut }
    }
}

/// Sends a question, or the release when there is none left.
fn put(
    master: &mut Master<63, MESSAGE>,
    now: Instant,
    mac: MacId,
    question: Option<&Question>,
) -> Result<(), CommandError> {
    let Some(Question { path: AttributePath { class, instance, attribute }, value }) = question else {
        return simulate::release(master, now, mac, AllocationChoice::EXPLICIT);
    };
    // To read twice does no harm; to write may.
    match value {
        None => {
            let get = AttributeRequest::get(*class, *instance, *attribute);
            master.request_attribute(now, mac, &get, 2)
        }
        Some(value) => {
            let set = AttributeRequest::set(*class, *instance, *attribute, value);
            master.request_attribute(now, mac, &set, 1)
        }
    }
}

impl Errand for Visitor {
    fn access(&self) -> &Access {
        self.master.access()
    }

    fn why_not_online(&self) -> String {
        self.master.own_status().to_string()
    }

    fn leave(&mut self) {
        self.visits.values_mut().for_each(|visit| visit.cut = Some(Cut::Interrupted));
        // There is no connection, and none was asked for. The others are released when they have answered what they were asked.
        let is_idle =
            |mac: &MacId| matches!(self.master.state(*mac), Some(SlaveState::Offline | SlaveState::Waiting));
        let idle: Vec<MacId> = self.visits.keys().copied().filter(is_idle).collect();
        for mac in idle {
            self.end(mac, None);
        }
    }

    fn unfinished(&self) -> Option<String> {
        let held = self.visits.iter().filter(|(_, visit)| visit.stage != Stage::Coming);
        let held: Vec<String> = held.map(|(mac, _)| mac.to_string()).collect();
        (!held.is_empty()).then(|| {
            format!("node {} has not answered, and may keep a connection for ten seconds", held.join(", "))
        })
    }
}

impl Machine for Visitor {
    type Event = Report;

    fn input(&mut self, now: Instant, input: Input) {
        self.master.input(now, input);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<Report>> {
        loop {
            if let Some(report) = self.reports.pop_front() {
                return Some(Action::Event(report));
            }
            if let Some((mac, questions)) = self.due.take() {
                self.begin(now, mac, questions);
            }
            match self.master.poll(now).map(Action::without_event) {
                Some(Err(MasterEvent::Slave { mac_id, event })) => self.follow(mac_id, event),
                Some(Err(_)) => {}
                Some(Ok(action)) => return Some(action),
                None if self.ask(now) => {}
                None => return None,
            }
        }
    }

    fn deadline(&self) -> Option<Deadline> {
        self.master.deadline()
    }

    fn max_in_flight(&self) -> usize {
        self.master.max_in_flight()
    }
}

/// Who the command is, with everything that the Identity object tells.
fn device(endpoint: &Endpoint) -> DeviceIdentity {
    let message::DeviceIdentity { vendor, serial } = errand::identity(endpoint);
    DeviceIdentity {
        vendor,
        device_type: DeviceType::COMMUNICATIONS_ADAPTER,
        product_code: 0,
        revision: Revision { major: 1, minor: 1 },
        serial,
        name: ProductName::new("devicenet command").unwrap_or_default(),
    }
}

/// The longest message that it takes.
const MESSAGE: usize = 512;
/// How long a visit may take, network access included. An absent node has been called absent long before.
const LONGEST: Duration = Duration::from_secs(60);
