//! What on a bus starts a recording.

use core::fmt;
use core::time::Duration;
use std::collections::BTreeMap;

use devicenet_core::MacId;
use devicenet_core::monitor::{
    ConnectionName, ConnectionState, Kind, Monitor, MonitorConfig, Problem, Reading,
};
use link_core::{Input, Instant, LinkEvent};

use super::trigger::Trigger;
use crate::scenario::Time;

/// Watches a bus for what starts a recording.
pub(super) struct Watch {
    triggers: Vec<Trigger>,
    monitor: Box<Monitor>,
    frames: u64,
    last_frame: Option<Instant>,
    is_silent: bool,
    /// Since when a node does not answer polls, and whether that was told.
    unanswered: BTreeMap<MacId, (Instant, bool)>,
    timed_out: Vec<(MacId, ConnectionName)>,
    look_at: Instant,
}

impl Watch {
    pub(super) fn new(triggers: Vec<Trigger>) -> Self {
        Self {
            triggers,
            monitor: Box::new(Monitor::new(MonitorConfig::default())),
            frames: 0,
            last_frame: None,
            is_silent: false,
            unanswered: BTreeMap::new(),
            timed_out: Vec::new(),
            look_at: Instant::ZERO,
        }
    }

    /// Why a recording is to start, if it is.
    pub(super) fn see(&mut self, at: Instant, input: Input) -> Option<Cause> {
        let by_itself = match input {
            Input::Frame(frame) => {
                self.frames += 1;
                (self.last_frame, self.is_silent) = (Some(at), false);
                let reading = self.monitor.observe(at, self.frames, &frame);
                match (reading.kind, reading.src, reading.dst) {
                    (Kind::PollCommand, _, Some(slave)) => {
                        _ = self.unanswered.entry(slave).or_insert((at, false))
                    }
                    (Kind::PollResponse, Some(slave), _) => _ = self.unanswered.remove(&slave),
                    _ => {}
                }
                self.triggers.iter().find_map(|trigger| of_frame(trigger, &reading))
            }
            Input::Link(event) => self.triggers.iter().find_map(|trigger| of_link(trigger, event)),
            Input::Tick | Input::TxDone(..) => None,
        };
        by_itself.or_else(|| self.by_time(at))
    }

    /// What comes of time alone.
    fn by_time(&mut self, now: Instant) -> Option<Cause> {
        if now < self.look_at {
            return None;
        }
        self.look_at = now + LOOK_EVERY;
        let timed_out = self.timed_out();
        for trigger in &self.triggers {
            match trigger {
                Trigger::TimeOut(wanted) => {
                    let is_wanted = |mac: &MacId| wanted.is_none_or(|wanted| wanted == *mac);
                    let connection = timed_out.iter().find(|(mac, _)| is_wanted(mac));
                    if let Some((mac, name)) = connection {
                        return Some(Cause(format!("the {name} connection of node {mac} timed out")));
                    }
                    let monitor = &self.monitor;
                    let silent = self.unanswered.iter_mut().find(|(mac, (since, is_told))| {
                        !*is_told
                            && is_wanted(mac)
                            && now.saturating_since(*since) >= patience(monitor, **mac)
                    });
                    if let Some((mac, (since, is_told))) = silent {
                        *is_told = true;
                        let span = now.saturating_since(*since);
                        return Some(Cause(format!(
                            "node {mac} has not answered polls for {} ms",
                            span.as_millis()
                        )));
                    }
                }
                Trigger::Silence(span) => {
                    let silence = self.last_frame.map(|last| now.saturating_since(last));
                    if !self.is_silent && silence.is_some_and(|silence| silence >= *span) {
                        self.is_silent = true;
                        return Some(Cause(format!("nothing was heard for {}", Time(*span))));
                    }
                }
                _ => {}
            }
        }
        None
    }

    /// Connections that have timed out since the last look.
    fn timed_out(&mut self) -> Vec<(MacId, ConnectionName)> {
        let now: Vec<(MacId, ConnectionName)> = (self.monitor.connections())
            .filter(|connection| connection.state == ConnectionState::TimedOut)
            .map(|connection| (connection.server, connection.name))
            .collect();
        let new = now.iter().filter(|connection| !self.timed_out.contains(connection)).copied().collect();
        self.timed_out = now;
        new
    }
}

/// How long its polls may go unanswered.
fn patience(monitor: &Monitor, slave: MacId) -> Duration {
    let times =
        monitor.connections().filter(|connection| connection.server == slave).filter_map(|connection| {
            let is_poll = matches!(
                connection.name,
                ConnectionName::Predefined(devicenet_core::monitor::Predefined::Poll)
            );
            connection.time_out.filter(|_| is_poll)
        });
    times.min().unwrap_or(UNKNOWN_RATE)
}

fn of_frame(trigger: &Trigger, reading: &Reading<'_>) -> Option<Cause> {
    match trigger {
        Trigger::Problem => Some(Cause(reading.problem.as_ref()?.to_string())),
        Trigger::Duplicate => matches!(reading.kind, Kind::DupMacResponse)
            .then(|| Cause(format!("duplicate MAC ID: {reading}")))
            .or_else(|| is_duplicate(reading.problem.as_ref()?).then(|| Cause(reading.to_string()))),
        Trigger::Frame(filter) => filter.accepts(reading).then(|| Cause(reading.to_string())),
        Trigger::TimeOut(_) | Trigger::BusError | Trigger::BusOff | Trigger::Silence(_) => None,
    }
}

const fn is_duplicate(problem: &Problem) -> bool {
    matches!(problem, Problem::DuplicateMacId { .. } | Problem::TwoIdentities { .. })
}

fn of_link(trigger: &Trigger, event: LinkEvent) -> Option<Cause> {
    match (trigger, event) {
        (Trigger::BusError, LinkEvent::BusError(kind)) => Some(Cause(kind.to_string())),
        (Trigger::BusOff, LinkEvent::BusOff) => Some(Cause("bus-off".into())),
        _ => None,
    }
}

/// Why a recording was started.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Cause(String);

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// How often the connections are looked at.
pub(super) const LOOK_EVERY: Duration = Duration::from_millis(10);
/// For a node whose expected packet rate was not heard.
const UNKNOWN_RATE: Duration = Duration::from_secs(1);

#[cfg(test)]
mod tests {
    use link_core::Frame;
    use link_core::frame::standard_id;

    use super::*;

    /// Slave 10 of master 1, polled at an expected packet rate of so many milliseconds, with a code of attribute 18: when and
    /// why a recording starts after a poll that it does not answer.
    fn unanswered(rate: u8, multiplier: u8) -> Option<(u64, String)> {
        let mut watch = Watch::new(vec![Trigger::TimeOut(None)]);
        let setup: [(u16, &[u8]); 7] = [
            (0x456, &[1, 0x4B, 3, 1, 3, 1]),
            (0x453, &[1, 0xCB, 0]),
            (0x454, &[1, 0x10, 5, 2, 9, rate, 0]),
            (0x453, &[1, 0x90, rate, 0]),
            (0x454, &[1, 0x10, 5, 2, 18, multiplier]),
            (0x453, &[1, 0x90]),
            (0x455, &[1]),
        ];
        for (id, data) in setup {
            let frame = Frame::new(standard_id(id), data).unwrap();
            assert_eq!(watch.see(Instant::ZERO, Input::Frame(frame)), None);
        }
        (1..10_000).find_map(|millis| {
            let cause = watch.see(Instant::from_millis(millis), Input::Tick)?;
            Some((millis, cause.to_string()))
        })
    }

    /// Without a rate it is a second, as where it was not heard.
    #[test]
    fn a_poll_is_waited_for_as_long_as_its_time_out() {
        for (rate, multiplier, millis) in [(100, 0, 400), (100, 1, 800), (20, 7, 10_240), (0, 1, 1_000)] {
            let words = format!("node 10 has not answered polls for {millis} ms");
            let expected = (millis < 10_000).then_some((millis, words));
            assert_eq!(unanswered(rate, multiplier), expected, "{rate} {multiplier}");
        }
    }
}
