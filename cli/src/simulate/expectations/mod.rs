//! Holds the run against what the scenario expects: every change is looked at, nothing is sampled.

#[cfg(test)]
mod tests;

use core::fmt;
use std::rc::Rc;

use link_core::Instant;

use super::exchange::{Exchange, Happening};
use crate::scenario::{Expectation, NodeIndex, Scenario, StateName, Time, What, When};

/// What a node is at a moment, as far as it can be expected.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Status {
    /// Of network access; `None` for roles without one.
    pub state: Option<StateName>,
    /// The operational address, for DeviceNeX nodes; 127 is none.
    pub oa: Option<u8>,
    /// The transmit error counter.
    pub tec: u16,
    /// The receive error counter.
    pub rec: u16,
    /// The controller is bus-off.
    pub bus_off: bool,
    /// Connections and data of a slave or a master.
    pub exchange: Rc<Exchange>,
}

/// An expectation that did not hold.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Failure {
    /// The line of the scenario.
    pub line: usize,
    /// Which node it is about.
    pub node: String,
    /// What was expected, in words.
    pub expected: String,
    /// What came instead, in words.
    pub found: String,
}

/// `line 40: valve: expected online by 3s; found waiting_dup_mac at 3s`
impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}: expected {}; found {}", self.line, self.node, self.expected, self.found)
    }
}

/// The outcome of a run.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Verdict {
    /// How many expectations held; one of several nodes counts once for each.
    pub held: usize,
    /// Those that did not.
    pub failures: Vec<Failure>,
    /// How many could not be judged, because the run was ended before their time.
    pub unjudged: usize,
}

/// Follows a run.
#[derive(Debug)]
pub(super) struct Judge {
    nodes: Vec<Watched>,
    cases: Vec<Case>,
    /// The places of the cases of each node.
    of_node: Vec<Vec<usize>>,
    /// When the scenario ends; the run may end otherwise.
    planned_end: Instant,
}

#[derive(Debug)]
struct Watched {
    name: String,
    status: Status,
    since: Instant,
    /// What has happened at the last moment of which something is known. More may happen at it, so that it is judged when
    /// a later one comes.
    news: Vec<(Instant, Happening)>,
}

/// One expectation of one node.
#[derive(Debug)]
struct Case {
    node: usize,
    expectation: Expectation,
    /// When what is expected first was so, inside and after the time of the expectation, and what it was.
    inside: Option<(Instant, Status)>,
    after: Option<Instant>,
    /// When the event last happened inside that time while the rest of what is expected was not so, and what was.
    missed: Option<(Instant, Status)>,
    /// When it first was not so, inside that time, and what was instead.
    broken: Option<(Instant, Status)>,
    /// The last that was seen inside that time.
    last: Option<(Instant, Status)>,
}

impl Judge {
    pub(super) fn new(scenario: &Scenario, initial: impl Fn(NodeIndex) -> Status) -> Self {
        let nodes: Vec<Watched> = (scenario.nodes.iter().enumerate())
            .map(|(index, node)| Watched {
                name: node.name.clone(),
                status: initial(NodeIndex(index)),
                since: Instant::ZERO,
                news: Vec::new(),
            })
            .collect();
        let can_be = |what: &What, node: &NodeIndex| what.fits(&scenario.nodes[node.0].role);
        let mut cases = Vec::new();
        let mut of_node = vec![Vec::new(); nodes.len()];
        for expectation in &scenario.expectations {
            let whom = match expectation.nodes.as_slice() {
                [] => {
                    (0..nodes.len()).map(NodeIndex).filter(|node| can_be(&expectation.what, node)).collect()
                }
                named => named.to_vec(),
            };
            for node in whom {
                of_node[node.0].push(cases.len());
                cases.push(Case::new(node.0, expectation.clone()));
            }
        }
        Self { nodes, cases, of_node, planned_end: Instant::ZERO + scenario.bus.duration }
    }

    /// What a node is now.
    pub(super) fn status(&self, node: NodeIndex) -> Status {
        self.nodes[node.0].status.clone()
    }

    /// A node has changed.
    pub(super) fn changed(&mut self, at: Instant, node: NodeIndex, status: Status) {
        self.settle(node, |when| when < at);
        let watched = &mut self.nodes[node.0];
        if watched.status == status {
            return;
        }
        for &case in &self.of_node[node.0] {
            self.cases[case].held(watched.since, at, false, &watched.status);
        }
        (watched.status, watched.since) = (status, at);
    }

    /// Something has happened to a node.
    pub(super) fn happened(&mut self, at: Instant, node: NodeIndex, event: impl Into<Happening>) {
        self.settle(node, |when| when < at);
        self.nodes[node.0].news.push((at, event.into()));
    }

    /// The run is over.
    pub(super) fn finish(mut self, end: Instant) -> Verdict {
        for node in 0..self.nodes.len() {
            self.settle(NodeIndex(node), |_| true);
            let watched = &self.nodes[node];
            for &case in &self.of_node[node] {
                self.cases[case].held(watched.since, end, true, &watched.status);
            }
        }
        let mut verdict = Verdict::default();
        for case in self.cases {
            match case.verdict(end, self.planned_end) {
                Some(Ok(())) => verdict.held += 1,
                Some(Err(found)) => verdict.failures.push(Failure {
                    line: case.expectation.line,
                    node: self.nodes[case.node].name.clone(),
                    expected: describe(&case.expectation),
                    found,
                }),
                None => verdict.unjudged += 1,
            }
        }
        verdict
    }

    /// Judges the news of a moment that is over, by what the node has become at it.
    fn settle(&mut self, node: NodeIndex, is_over: impl Fn(Instant) -> bool) {
        let watched = &mut self.nodes[node.0];
        if watched.news.first().is_none_or(|(at, _)| !is_over(*at)) {
            return;
        }
        for (at, event) in watched.news.drain(..) {
            for &case in &self.of_node[node.0] {
                self.cases[case].happened(at, event, &watched.status);
            }
        }
    }
}

impl Case {
    fn new(node: usize, expectation: Expectation) -> Self {
        Self { node, expectation, inside: None, after: None, missed: None, broken: None, last: None }
    }

    fn window(&self) -> (Instant, Instant) {
        match self.expectation.when {
            When::At(at) => (at, at),
            When::Within(from, to) | When::Never(from, to) | When::Always(from, to) => {
                (from, to.unwrap_or(Instant::MAX))
            }
        }
    }

    /// The node was `status` from `since` on, until `until` or, at the end of the run, that moment included.
    fn held(&mut self, since: Instant, until: Instant, to_the_end: bool, status: &Status) {
        let (from, to) = self.window();
        // At the first moment of a time the last of several changes counts; after it, each does.
        let overlaps = since <= to && (until > from || (to_the_end && until == from));
        let is = self.expectation.what.event.is_none() && self.expectation.what.holds_of(status);
        if overlaps {
            let first = since.max(from);
            self.last = Some((first, status.clone()));
            if is {
                self.inside.get_or_insert_with(|| (first, status.clone()));
            } else {
                self.broken.get_or_insert_with(|| (first, status.clone()));
            }
        } else if since > to && is {
            self.after.get_or_insert(since);
        }
    }

    fn happened(&mut self, at: Instant, event: Happening, status: &Status) {
        if !event.is(&self.expectation.what) {
            return;
        }
        let (from, to) = self.window();
        match self.expectation.what.holds_of(status) {
            true if at > to => _ = self.after.get_or_insert(at),
            true if at >= from => _ = self.inside.get_or_insert_with(|| (at, status.clone())),
            false if (from..=to).contains(&at) => self.missed = Some((at, status.clone())),
            true | false => {}
        }
    }

    /// `None` when the run was too short; else whether it held, or what was found.
    fn verdict(&self, end: Instant, planned_end: Instant) -> Option<Result<(), String>> {
        let what = &self.expectation.what;
        let last = || match (&self.last, what.event) {
            (_, Some(event)) => match &self.missed {
                Some((at, status)) => format!("{event} at {}, but {}", time(*at), what.show(status)),
                None => format!("no {event}"),
            },
            (Some((since, status)), None) => format!("{} since {}", what.show(status), time(*since)),
            (None, None) => "nothing".to_owned(),
        };
        // What is said of the run to its end is said of the run that was.
        let is_over = |from: Instant, to: Option<Instant>| end >= to.unwrap_or(from);
        match self.expectation.when {
            When::Within(_, to) => match (&self.inside, self.after) {
                (Some(_), _) => Some(Ok(())),
                (None, _) if end < to.unwrap_or(planned_end) => None,
                (None, Some(later)) => Some(Err(format!("{}; it came at {}", last(), time(later)))),
                (None, None) => Some(Err(format!("{}; it never came after", last()))),
            },
            When::At(at) => match &self.inside {
                Some(_) => Some(Ok(())),
                None if end < at => None,
                None => Some(Err(last())),
            },
            When::Never(from, to) => match &self.inside {
                Some((at, _)) if what.event.is_some() => Some(Err(format!("it at {}", time(*at)))),
                Some((at, status)) => Some(Err(format!("{} at {}", what.show(status), time(*at)))),
                None => is_over(from, to).then_some(Ok(())),
            },
            When::Always(from, to) => match &self.broken {
                Some((at, status)) => Some(Err(format!("{} at {}", what.show(status), time(*at)))),
                None => is_over(from, to).then_some(Ok(())),
            },
        }
    }
}

impl What {
    /// Whether a status is all that is expected; events are not part of it.
    fn holds_of(&self, status: &Status) -> bool {
        self.state.is_none_or(|state| status.state == Some(state))
            && self.oa.is_none_or(|oa| status.oa == Some(oa))
            && self.tec.is_none_or(|tec| tec.holds(status.tec))
            && self.rec.is_none_or(|rec| rec.holds(status.rec))
            && self.bus_off.is_none_or(|bus_off| status.bus_off == bus_off)
            && status.exchange.holds(self)
    }

    /// Of a status that which is asked for.
    fn show(&self, status: &Status) -> String {
        let mut words = Vec::new();
        if self.state.is_some() {
            words.push(status.state.map_or("no state", StateName::name).to_owned());
        }
        if self.oa.is_some() {
            words.push(status.oa.map_or_else(|| "no OA".to_owned(), |oa| format!("OA {oa}")));
        }
        if self.tec.is_some() {
            words.push(format!("TEC {}", status.tec));
        }
        if self.rec.is_some() {
            words.push(format!("REC {}", status.rec));
        }
        if self.bus_off.is_some() {
            words.push(if status.bus_off { "bus-off" } else { "not bus-off" }.to_owned());
        }
        words.extend(status.exchange.show(self));
        words.join(", ")
    }
}

/// `online by 3s`, `never bus-off`
fn describe(expectation: &Expectation) -> String {
    let what = &expectation.what;
    let mut words = Vec::new();
    words.extend(what.event.map(|event| event.name().to_owned()));
    words.extend(what.state.map(|state| state.name().to_owned()));
    words.extend(what.oa.map(|oa| format!("OA {oa}")));
    words.extend(what.tec.map(|tec| format!("TEC {tec}")));
    words.extend(what.rec.map(|rec| format!("REC {rec}")));
    words.extend(what.bus_off.map(|off| if off { "bus-off" } else { "not bus-off" }.to_owned()));
    words.extend(exchanged(what));
    let words = words.join(" and ");
    let range = |from: Instant, to: Option<Instant>| match to {
        Some(to) => format!(" from {} to {}", time(from), time(to)),
        None if from == Instant::ZERO => String::new(),
        None => format!(" from {} on", time(from)),
    };
    match expectation.when {
        When::Within(Instant::ZERO, Some(to)) => format!("{words} by {}", time(to)),
        When::Within(from, to) => format!("{words}{}", range(from, to)),
        When::At(at) => format!("{words} at {}", time(at)),
        When::Never(from, to) => format!("never {words}{}", range(from, to)),
        When::Always(from, to) => format!("always {words}{}", range(from, to)),
    }
}

/// What is expected of connections and data.
fn exchanged(what: &What) -> Vec<String> {
    let nex = what.nex_connection.map_or_else(String::new, |name| format!("{name} "));
    let connection = what.connection.map_or(nex, |name| format!("{name} "));
    let of_slave = what.slave.map_or_else(String::new, |mac| format!(" of slave {mac}"));
    let hex = |data: &Vec<u8>| data.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    let mut words = Vec::new();
    words.extend(what.connection_state.map(|state| format!("{connection}{state}")));
    words.extend(what.mode.map(|mode| format!("{connection}{mode}")));
    words.extend(what.input.as_ref().map(|input| format!("{connection}input {}{of_slave}", hex(input))));
    words.extend(what.output.as_ref().map(|output| format!("{connection}output {}", hex(output))));
    words.extend(what.slave_state.map(|state| format!("slave{} {state}", of_slave.replace(" of slave", ""))));
    words.extend(what.device_state.map(|state| match what.device {
        Some(oa) => format!("device {oa} {state}"),
        None => format!("device {state}"),
    }));
    words.extend(what.status.map(|status| format!("status {status}{of_slave}")));
    words
}

fn time(at: Instant) -> Time {
    Time(at.saturating_since(Instant::ZERO))
}
