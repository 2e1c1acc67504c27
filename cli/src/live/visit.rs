//! Explicit connections to nodes: opened, used, released.

use core::ops::ControlFlow;
use core::time::Duration;
use std::collections::{BTreeMap, VecDeque};
use std::hash::{BuildHasher as _, RandomState};

use cip_core::code::{AdditionalCode, ClassId, DeviceType, GeneralStatus, InstanceId, ServiceCode};
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use cip_core::message::{AllocationChoice, AttributeRequest, Request, Response, Target};
use devicenet_core::MacId;
use devicenet_core::access::{Access, Fault, StateKind};
use devicenet_core::client::Failure as NoResponse;
use devicenet_core::master::{
    Cause, CommandError, Config, Master, MasterEvent, ScanEntry, SlaveEvent, SlaveState,
};
use devicenet_core::message;
use link_core::{Action, Deadline, Input, Instant, LinkEvent, Machine, Port as _, drive};

use super::attribute::AttributePath;
use super::endpoint::Endpoint;
use super::permit;
use super::port::{LivePort, PortError};
use crate::exit::Failure;

/// What is asked of one node, in this order.
pub(super) type Questions = Vec<Question>;

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
}

/// What came of a visit.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Report {
    pub(super) mac: MacId,
    /// As many as were asked, unless there was trouble.
    pub(super) answers: Vec<Answer>,
    /// Why there was no connection, or why it ended.
    pub(super) trouble: Option<Cause>,
}

/// A master that keeps no I/O: it visits nodes, and is gone again. It tells of each visit when that is over.
pub(super) struct Visitor {
    master: Box<Master<63, MESSAGE>>,
    visits: BTreeMap<MacId, Visit>,
    reports: VecDeque<Report>,
    /// What has taken the link, and is not told yet.
    lost: Option<LinkEvent>,
}

struct Visit {
    questions: Questions,
    answers: Vec<Answer>,
    stage: Stage,
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
    /// For these nodes, at most 63 of them.
    pub(super) fn new(endpoint: &Endpoint, own: MacId, visits: Vec<(MacId, Questions)>) -> Self {
        let config = Config { tries: 2, deferred_delete: false, ..Config::new(device(endpoint), own) };
        let mut master = Box::new(Master::new(config));
        for (mac, _) in &visits {
            // They are as many as it holds, and none of them is its own.
            let _ = master.add_slave(Instant::ZERO, ScanEntry::explicit_only(*mac));
        }
        let visit = |questions| Visit { questions, answers: Vec::new(), stage: Stage::Coming };
        let visits = visits.into_iter().map(|(mac, questions)| (mac, visit(questions))).collect();
        Self { master, visits, reports: VecDeque::new(), lost: None }
    }

    /// Makes the visits, on a port whose link was up until now.
    pub(super) fn run(
        mut self,
        endpoint: &Endpoint,
        own: MacId,
        port: &mut LivePort,
    ) -> Result<Vec<Report>, Failure> {
        let begin = port.now();
        self.input(begin, Input::Link(LinkEvent::Up));
        let mut reports = Vec::new();
        let mut left = self.visits.len();
        let mut follow = |_: &mut Self, _, news| {
            match news {
                News::Report(report) => reports.push(report),
                News::Taken => return ControlFlow::Break(Err(taken(endpoint, own))),
                News::Lost(event) => return ControlFlow::Break(Err(lost(endpoint, event))),
            }
            left -= 1;
            if left == 0 { ControlFlow::Break(Ok(())) } else { ControlFlow::Continue(()) }
        };
        port.set_end(begin + LONGEST_WAY);
        let mut result = drive(&mut self, port, &mut follow);
        if matches!(result, Err(PortError::Over)) && self.master.access().is_online() {
            port.set_end(begin + LONGEST);
            result = drive(&mut self, port, &mut follow);
        }
        match result {
            Ok(done) => done?,
            Err(PortError::Failed(failure)) => return Err(failure),
            Err(PortError::Over) => reports.extend(self.give_up(endpoint)?),
        }
        reports.sort_by_key(|report| report.mac);
        Ok(reports)
    }

    /// The time is over: visits that are still under way have come to nothing.
    fn give_up(&mut self, endpoint: &Endpoint) -> Result<impl Iterator<Item = Report> + use<>, Failure> {
        if !self.master.access().is_online() {
            let status = self.master.own_status().to_string();
            return Err(no_way(endpoint, self.master.access(), &status));
        }
        let visits = core::mem::take(&mut self.visits);
        Ok(visits.into_iter().map(|(mac, visit)| visit.report(mac, Some(Cause::NoAnswer))))
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
            | SlaveEvent::Input(_)
            | SlaveEvent::Heartbeat(_)
            | SlaveEvent::Shutdown(_) => {}
        }
    }

    /// Asks what is due. A connection that is being closed after the last question has to be waited for.
    fn ask(&mut self, now: Instant) {
        let mut ended = Vec::new();
        for (mac, visit) in self.visits.iter_mut().filter(|(_, visit)| visit.stage == Stage::Due) {
            let question = visit.questions.get(visit.answers.len());
            match put(&mut self.master, now, *mac, question) {
                Ok(()) => visit.stage = if question.is_some() { Stage::Asking } else { Stage::Leaving },
                Err(CommandError::Busy) => {}
                Err(_) => ended.push(*mac),
            }
        }
        for mac in ended {
            self.end(mac, None);
        }
    }

    fn end(&mut self, mac: MacId, trouble: Option<Cause>) {
        let Some(visit) = self.visits.remove(&mac) else { return };
        // It is in the list.
        let _ = self.master.remove_slave(mac);
        self.reports.push_back(visit.report(mac, trouble));
    }
}

impl Visit {
    fn report(self, mac: MacId, trouble: Option<Cause>) -> Report {
        let is_complete = self.answers.len() == self.questions.len();
        let trouble = if is_complete { None } else { Some(trouble.unwrap_or(Cause::NoAnswer)) };
        Report { mac, answers: self.answers, trouble }
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
        let target = Target::Object { class: ClassId::DEVICENET, instance: InstanceId(1) };
        let data = &[AllocationChoice::EXPLICIT.bits()];
        return master.request(now, mac, &Request { service: ServiceCode::RELEASE, target, data }, 1);
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

/// What a visitor tells.
#[derive(Debug)]
pub(super) enum News {
    /// A visit is over.
    Report(Report),
    /// Another node has its MAC ID.
    Taken,
    /// The link is down, or off the bus.
    Lost(LinkEvent),
}

impl Machine for Visitor {
    type Event = News;

    fn input(&mut self, now: Instant, input: Input) {
        if let Input::Link(event @ (LinkEvent::Down | LinkEvent::BusOff)) = input {
            self.lost = Some(event);
        }
        self.master.input(now, input);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<News>> {
        loop {
            if let Some(event) = self.lost.take() {
                return Some(Action::Event(News::Lost(event)));
            }
            if let Some(report) = self.reports.pop_front() {
                return Some(Action::Event(News::Report(report)));
            }
            match self.master.poll(now) {
                Some(Action::Event(MasterEvent::Slave { mac_id, event })) => self.follow(mac_id, event),
                Some(Action::Event(_)) if self.master.access().fault() == Some(Fault::DuplicateMacId) => {
                    return Some(Action::Event(News::Taken));
                }
                Some(Action::Event(_)) => {}
                Some(Action::Transmit(token, frame)) => return Some(Action::Transmit(token, frame)),
                Some(Action::Withdraw(token)) => return Some(Action::Withdraw(token)),
                Some(Action::Link(command)) => return Some(Action::Link(command)),
                None => {
                    let before: Vec<Stage> = self.visits.values().map(|visit| visit.stage).collect();
                    self.ask(now);
                    if self.visits.values().map(|visit| visit.stage).eq(before) {
                        return None;
                    }
                }
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

pub(super) fn taken(endpoint: &Endpoint, own: MacId) -> Failure {
    Failure::Transport(format!(
        "MAC ID {own} is taken on {endpoint}: choose another one for this command with --own-mac"
    ))
}

/// Why the command is not on line.
pub(super) fn no_way(endpoint: &Endpoint, access: &Access, why: &str) -> Failure {
    Failure::Transport(match access.state().kind() {
        // Its first frame is not sent. Few drivers say why.
        StateKind::SendingDupMac => format!(
            "nobody on {endpoint} acknowledges what is sent: no other node is on, the cable is open, the bit rate is wrong, \
             or the interface is listen-only"
        ),
        _ => format!("no way on line on {endpoint}: {why}"),
    })
}

/// The link was lost while the command was at work.
pub(super) fn lost(endpoint: &Endpoint, event: LinkEvent) -> Failure {
    match event {
        LinkEvent::BusOff => permit::bus_off(endpoint),
        _ => Failure::Transport(format!("{endpoint} went down before everything was asked")),
    }
}

/// Who the command is on the bus. No vendor has the number 0, and two of these at once should differ in their serial number.
pub(super) fn identity(endpoint: &Endpoint) -> message::DeviceIdentity {
    let serial = match endpoint {
        Endpoint::Scenario(_) | Endpoint::Recording(_) => 1,
        Endpoint::Interface(_) => RandomState::new().hash_one(std::process::id()) as u32,
    };
    message::DeviceIdentity { vendor: 0.into(), serial }
}

/// The same with everything that the Identity object tells.
fn device(endpoint: &Endpoint) -> DeviceIdentity {
    let message::DeviceIdentity { vendor, serial } = identity(endpoint);
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
/// How long the way on line may take. Two duplicate MAC ID checks take two seconds, and more where others begin at the same time.
pub(super) const LONGEST_WAY: Duration = Duration::from_secs(10);
/// How long a visit may take, network access included. An absent node has been called absent long before.
const LONGEST: Duration = Duration::from_secs(60);
