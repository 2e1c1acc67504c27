//! Holds the run against what the scenario expects: every change is looked at, nothing is sampled.

use core::fmt;

use link_core::Instant;

use crate::scenario::{EventName, Expectation, NodeIndex, Scenario, StateName, Time, What, When};

/// What a node is at a moment, as far as it can be expected.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Status {
    /// Of network access; `None` for roles without one.
    pub state: Option<StateName>,
    /// The transmit error counter.
    pub tec: u16,
    /// The receive error counter.
    pub rec: u16,
    /// The controller is bus-off.
    pub bus_off: bool,
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
    news: Vec<(Instant, EventName)>,
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
        let can_be = |what: &What, node: &NodeIndex| scenario.nodes[node.0].role.can_be(what);
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
        self.nodes[node.0].status
    }

    /// A node has changed.
    pub(super) fn changed(&mut self, at: Instant, node: NodeIndex, status: Status) {
        self.settle(node, |when| when < at);
        let watched = &mut self.nodes[node.0];
        if watched.status == status {
            return;
        }
        for &case in &self.of_node[node.0] {
            self.cases[case].held(watched.since, at, false, watched.status);
        }
        (watched.status, watched.since) = (status, at);
    }

    /// Something has happened to a node.
    pub(super) fn happened(&mut self, at: Instant, node: NodeIndex, event: EventName) {
        self.settle(node, |when| when < at);
        self.nodes[node.0].news.push((at, event));
    }

    /// The run is over.
    pub(super) fn finish(mut self, end: Instant) -> Verdict {
        for node in 0..self.nodes.len() {
            self.settle(NodeIndex(node), |_| true);
            let watched = &self.nodes[node];
            for &case in &self.of_node[node] {
                self.cases[case].held(watched.since, end, true, watched.status);
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
                self.cases[case].happened(at, event, watched.status);
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
    fn held(&mut self, since: Instant, until: Instant, to_the_end: bool, status: Status) {
        let (from, to) = self.window();
        // At the first moment of a time the last of several changes counts; after it, each does.
        let overlaps = since <= to && (until > from || (to_the_end && until == from));
        let is = self.expectation.what.event.is_none() && self.expectation.what.holds_of(status);
        if overlaps {
            let first = since.max(from);
            self.last = Some((first, status));
            if is {
                self.inside.get_or_insert((first, status));
            } else {
                self.broken.get_or_insert((first, status));
            }
        } else if since > to && is {
            self.after.get_or_insert(since);
        }
    }

    fn happened(&mut self, at: Instant, event: EventName, status: Status) {
        if self.expectation.what.event != Some(event) {
            return;
        }
        let (from, to) = self.window();
        match self.expectation.what.holds_of(status) {
            true if at > to => _ = self.after.get_or_insert(at),
            true if at >= from => _ = self.inside.get_or_insert((at, status)),
            false if (from..=to).contains(&at) => self.missed = Some((at, status)),
            true | false => {}
        }
    }

    /// `None` when the run was too short; else whether it held, or what was found.
    fn verdict(&self, end: Instant, planned_end: Instant) -> Option<Result<(), String>> {
        let what = &self.expectation.what;
        let last = || match (&self.last, what.event) {
            (_, Some(event)) => match &self.missed {
                Some((at, status)) => format!("{event} at {}, but {}", time(*at), what.show(*status)),
                None => format!("no {event}"),
            },
            (Some((since, status)), None) => format!("{} since {}", what.show(*status), time(*since)),
            (None, None) => "nothing".to_owned(),
        };
        // What is said of the run to its end is said of the run that was.
        let is_over = |from: Instant, to: Option<Instant>| end >= to.unwrap_or(from);
        match self.expectation.when {
            When::Within(_, to) => match (self.inside, self.after) {
                (Some(_), _) => Some(Ok(())),
                (None, _) if end < to.unwrap_or(planned_end) => None,
                (None, Some(later)) => Some(Err(format!("{}; it came at {}", last(), time(later)))),
                (None, None) => Some(Err(format!("{}; it never came after", last()))),
            },
            When::At(at) => match self.inside {
                Some(_) => Some(Ok(())),
                None if end < at => None,
                None => Some(Err(last())),
            },
            When::Never(from, to) => match self.inside {
                Some((at, _)) if what.event.is_some() => Some(Err(format!("it at {}", time(at)))),
                Some((at, status)) => Some(Err(format!("{} at {}", what.show(status), time(at)))),
                None => is_over(from, to).then_some(Ok(())),
            },
            When::Always(from, to) => match self.broken {
                Some((at, status)) => Some(Err(format!("{} at {}", what.show(status), time(at)))),
                None => is_over(from, to).then_some(Ok(())),
            },
        }
    }
}

impl What {
    /// Whether a status is all that is expected; events are not part of it.
    fn holds_of(&self, status: Status) -> bool {
        self.state.is_none_or(|state| status.state == Some(state))
            && self.tec.is_none_or(|tec| tec.holds(status.tec))
            && self.rec.is_none_or(|rec| rec.holds(status.rec))
            && self.bus_off.is_none_or(|bus_off| status.bus_off == bus_off)
    }

    /// Of a status that which is asked for.
    fn show(&self, status: Status) -> String {
        let mut words = Vec::new();
        if self.state.is_some() {
            words.push(status.state.map_or("no state", StateName::name).to_owned());
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
        words.join(", ")
    }
}

/// `online by 3s`, `never bus-off`
fn describe(expectation: &Expectation) -> String {
    let what = &expectation.what;
    let mut words = Vec::new();
    words.extend(what.event.map(|event| event.name().to_owned()));
    words.extend(what.state.map(|state| state.name().to_owned()));
    words.extend(what.tec.map(|tec| format!("TEC {tec}")));
    words.extend(what.rec.map(|rec| format!("REC {rec}")));
    words.extend(what.bus_off.map(|off| if off { "bus-off" } else { "not bus-off" }.to_owned()));
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

fn time(at: Instant) -> Time {
    Time(at.saturating_since(Instant::ZERO))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const NODE: NodeIndex = NodeIndex(0);

    fn status(state: StateName) -> Status {
        Status { state: Some(state), ..Status::default() }
    }

    /// Nonexistent, at 1 s sending, at 2 s waiting for no time and on line, at 5 s bus-off, at 6 s the end.
    #[track_caller]
    fn judge(expectation: &str) -> Result<(), String> {
        judge_of("", expectation)
    }

    #[track_caller]
    fn judge_of(bus: &str, expectation: &str) -> Result<(), String> {
        let bus = if bus.is_empty() { String::new() } else { format!("{bus}\n") };
        let text = format!(
            "[bus]\n{bus}[[node]]\nname = \"valve\"\nprotocol = \"devicenet\"\nrole = \"access\"\nmac = 1\n\
             identity = {{ vendor = 1, serial = 1 }}\n[[expect]]\nnode = \"valve\"\n{expectation}"
        );
        let scenario = Scenario::parse("s.toml", &text, Path::new("")).unwrap();
        let mut judge = Judge::new(&scenario, |_| status(StateName::Nonexistent));
        judge.changed(Instant::from_millis(1_000), NODE, status(StateName::SendingDupMac));
        judge.changed(Instant::from_millis(2_000), NODE, status(StateName::WaitingDupMac));
        judge.happened(Instant::from_millis(2_000), NODE, EventName::Sent);
        judge.changed(Instant::from_millis(2_000), NODE, status(StateName::OnLine));
        let off = Status { tec: 256, bus_off: true, ..status(StateName::CommFault) };
        judge.changed(Instant::from_millis(5_000), NODE, off);
        judge.happened(Instant::from_millis(5_000), NODE, EventName::BusOff);
        let verdict = judge.finish(Instant::from_millis(6_000));
        match (verdict.failures.as_slice(), verdict.held, verdict.unjudged) {
            ([], 1, 0) => Ok(()),
            ([], 0, 1) => Err("unjudged".to_owned()),
            ([failure], 0, 0) => Err(failure.to_string()),
            other => panic!("{other:?}"),
        }
    }

    #[track_caller]
    fn fails(expectation: &str, found: &str) {
        let text = judge(expectation).unwrap_err();
        assert_eq!(text, format!("line 8: valve: expected {found}"));
    }

    #[test]
    fn by_a_time() {
        assert_eq!(judge("by = \"2s\"\nstate = \"online\""), Ok(()));
        fails(
            "by = \"1.9s\"\nstate = \"online\"",
            "online by 1.9s; found sending_dup_mac since 1s; it came at 2s",
        );
        fails(
            "from = \"5.5s\"\nto = \"5.6s\"\nstate = \"online\"",
            "online from 5.5s to 5.6s; found comm_fault since 5.5s; it never came after",
        );
        assert_eq!(judge("by = \"9s\"\nstate = \"online\""), Ok(()));
        assert_eq!(judge("by = \"9s\"\ntec = 7"), Err("unjudged".to_owned()));
    }

    #[test]
    fn what_lasts_no_time_is_seen_too() {
        assert_eq!(judge("by = \"3s\"\nstate = \"waiting_dup_mac\""), Ok(()));
        fails(
            "never = true\nstate = \"waiting_dup_mac\"",
            "never waiting_dup_mac; found waiting_dup_mac at 2s",
        );
    }

    #[test]
    fn at_a_time_the_last_change_counts() {
        assert_eq!(judge("at = \"2s\"\nstate = \"online\""), Ok(()));
        fails("at = \"2s\"\nstate = \"waiting_dup_mac\"", "waiting_dup_mac at 2s; found online since 2s");
        assert_eq!(judge("at = \"6s\"\nbus_off = true"), Ok(()));
        assert_eq!(judge("at = \"7s\"\nbus_off = true"), Err("unjudged".to_owned()));
    }

    #[test]
    fn always_and_never() {
        assert_eq!(judge("always = true\nfrom = \"2s\"\nto = \"4s\"\nstate = \"online\""), Ok(()));
        fails(
            "always = true\nfrom = \"2s\"\nto = \"5s\"\nstate = \"online\"",
            "always online from 2s to 5s; found comm_fault at 5s",
        );
        assert_eq!(judge("never = true\nto = \"4.9s\"\nbus_off = true"), Ok(()));
        fails("never = true\ntec = \">255\"", "never TEC > 255; found TEC 256 at 5s");
    }

    #[test]
    fn all_of_it_at_the_same_moment() {
        fails(
            "by = \"6s\"\nstate = \"online\"\nbus_off = true",
            "online and bus-off by 6s; found comm_fault, bus-off since 5s; it never came after",
        );
    }

    /// It is on line at 2 s, and lasts to the end of the run at 6 s, four seconds before that of the scenario.
    #[test]
    fn without_to_it_is_the_end_of_the_run() {
        assert_eq!(judge("never = true\nevent = \"defended\""), Ok(()));
        assert_eq!(judge("never = true\nfrom = \"6s\"\nstate = \"online\""), Ok(()));
        assert_eq!(judge("never = true\nfrom = \"7s\"\nstate = \"online\""), Err("unjudged".to_owned()));
        assert_eq!(judge("always = true\nfrom = \"5s\"\nbus_off = true"), Ok(()));
        fails(
            "always = true\nfrom = \"2s\"\nstate = \"online\"",
            "always online from 2s on; found comm_fault at 5s",
        );
        assert_eq!(judge("from = \"5s\"\nbus_off = true"), Ok(()));
        assert_eq!(judge("from = \"5s\"\nstate = \"online\""), Err("unjudged".to_owned()));
    }

    /// The run goes on after the end of the scenario, here at 3 s.
    #[test]
    fn a_longer_run_is_looked_at_to_its_end() {
        let judge = |expectation: &str| judge_of("duration = \"3s\"", expectation);
        assert_eq!(
            judge("never = true\nbus_off = true").unwrap_err(),
            "line 9: valve: expected never bus-off; found bus-off at 5s"
        );
        assert_eq!(
            judge("always = true\nfrom = \"2s\"\nstate = \"online\"").unwrap_err(),
            "line 9: valve: expected always online from 2s on; found comm_fault at 5s"
        );
        assert_eq!(judge("from = \"3s\"\nbus_off = true"), Ok(()));
        assert_eq!(
            judge("from = \"3s\"\ntec = 7").unwrap_err(),
            "line 9: valve: expected TEC = 7 from 3s on; found TEC 256 since 5s; it never came after"
        );
        assert_eq!(judge("never = true\nto = \"3s\"\nbus_off = true"), Ok(()));
    }

    /// At 2 s the node sends, and is on line after everything that happens then.
    #[test]
    fn an_event_is_looked_at_with_what_the_node_has_become_at_its_time() {
        assert_eq!(judge("by = \"3s\"\nevent = \"sent\"\nstate = \"online\""), Ok(()));
        fails(
            "by = \"3s\"\nevent = \"sent\"\nstate = \"waiting_dup_mac\"",
            "sent and waiting_dup_mac by 3s; found sent at 2s, but online; it never came after",
        );
        assert_eq!(judge("by = \"6s\"\nevent = \"bus_off\"\nstate = \"comm_fault\"\ntec = 256"), Ok(()));
        fails("never = true\nevent = \"sent\"\nstate = \"online\"", "never sent and online; found it at 2s");
        assert_eq!(judge("never = true\nevent = \"sent\"\nstate = \"comm_fault\""), Ok(()));
    }

    #[test]
    fn events() {
        assert_eq!(judge("by = \"5s\"\nevent = \"bus_off\""), Ok(()));
        fails("by = \"4s\"\nevent = \"bus_off\"", "bus_off by 4s; found no bus_off; it came at 5s");
        fails("never = true\nevent = \"bus_off\"", "never bus_off; found it at 5s");
        assert_eq!(judge("never = true\nto = \"6s\"\nevent = \"defended\""), Ok(()));
    }
}
