//! What is seen of the bus and told by the slave, kept for the exchange to look at, and written as a trace.

use core::fmt::Display;
use core::time::Duration;
use std::collections::VecDeque;

use devicenet_cli::recording::Content;
use devicenet_cli::trace::{Emphasis, Trace};
use devicenet_core::monitor::{Monitor, MonitorConfig};
use devicenet_core::slave::{Event, SlaveEvent};
use link_core::{Frame, Instant, TxOutcome, TxToken};
use transport_mock::bus::{BusError, SenderOutcome};
use transport_mock::record::{FrameRecord, Outcome};
use transport_mock::{ErrorState, NodeId, Record};

use crate::bus::{Sent, Told};

pub(crate) struct Log {
    slave: NodeId,
    names: Vec<String>,
    /// The time between two frames.
    intermission: Duration,
    monitor: Box<Monitor>,
    frames: u64,
    trace: Trace,
    text: Vec<u8>,
    /// What the controllers have to send.
    waiting: Vec<Waiting>,
    /// The attempt that failed last, and how often it was repeated since.
    destroyed: Option<(Frame, u32)>,
    states: Vec<ErrorState>,
    /// The end of the last frame of another node.
    pub(crate) last_heard: Instant,
    /// Frames of the slave that nobody has looked at.
    pub(crate) sent: VecDeque<Sent>,
    pub(crate) told: Vec<String>,
}

struct Waiting {
    node: NodeId,
    token: TxToken,
    frame: Frame,
    since: Instant,
    /// It was on the bus, to its end.
    sent_at: Option<Instant>,
}

impl Log {
    pub(crate) fn new(slave: NodeId, names: Vec<String>, intermission: Duration) -> Self {
        let states = vec![ErrorState::Active; names.len()];
        let width = names.iter().map(String::len).max().unwrap_or(0);
        Self {
            slave,
            names,
            intermission,
            monitor: Box::new(Monitor::new(MonitorConfig::default())),
            frames: 0,
            trace: Trace::new(false).with_node_width(width),
            text: Vec::new(),
            waiting: Vec::new(),
            destroyed: None,
            states,
            last_heard: Instant::ZERO,
            sent: VecDeque::new(),
            told: Vec::new(),
        }
    }

    /// What the slave has to send, if anything.
    pub(crate) fn slave_waits(&self) -> Option<&Frame> {
        self.waiting.iter().find(|one| one.node == self.slave).map(|one| &one.frame)
    }

    pub(crate) fn peers_wait(&self) -> bool {
        self.waiting.iter().any(|one| one.node != self.slave)
    }

    pub(crate) fn record(&mut self, record: &Record<'_, Told>) {
        match record {
            Record::Frame(frame) => self.frame(frame),
            &Record::Request { at, node, token, frame } => {
                self.waiting.push(Waiting { node, token, frame, since: at, sent_at: None });
            }
            &Record::Done { at, node, token, outcome } => self.done(at, node, token, outcome),
            Record::Event { at, event: Told(event), .. } => {
                if !matches!(event, Event::Slave(SlaveEvent::Received(_))) {
                    self.note(*at, event);
                }
                self.told.push(event.to_string());
            }
            &Record::Counters { at, node, counters } => {
                let state = counters.state();
                if core::mem::replace(&mut self.states[node.index()], state) != state {
                    let words = match state {
                        ErrorState::Active => "error-active",
                        ErrorState::Passive => "error-passive",
                        ErrorState::BusOff => "bus-off",
                    };
                    self.line(at, node.index(), words);
                }
            }
            Record::Error(_) | Record::Change { .. } | Record::Violation(_) => {}
        }
    }

    /// Something that happened to the slave.
    pub(crate) fn note(&mut self, at: Instant, words: impl Display) {
        self.line(at, self.slave.index(), words);
    }

    fn line(&mut self, at: Instant, node: usize, words: impl Display) {
        self.flush(at);
        self.trace.event(&mut self.text, at, &self.names[node], Emphasis::Normal, words);
    }

    /// The trace so far.
    pub(crate) fn text(&self) -> String {
        String::from_utf8_lossy(&self.text).lines().map(|line| format!("{}\n", line.trim_end())).collect()
    }

    /// Forgets what was seen.
    pub(crate) fn forget(&mut self) {
        self.text.clear();
        self.told.clear();
    }

    fn frame(&mut self, record: &FrameRecord<'_>) {
        match record.outcome {
            Outcome::Ok => self.sent_to_its_end(record),
            Outcome::Error(error) => self.destroyed(record, Some(&error)),
            Outcome::Abandoned => self.destroyed(record, None),
        }
    }

    fn sent_to_its_end(&mut self, record: &FrameRecord<'_>) {
        self.flush(record.start);
        self.destroyed = None;
        self.frames += 1;
        let mut words = self.monitor.observe(record.end, self.frames, record.frame).to_string();
        let mut who = Vec::new();
        for sender in record.senders {
            let name = &self.names[sender.node.index()];
            match sender.outcome {
                SenderOutcome::Sent => who.push(name.as_str()),
                SenderOutcome::LostArbitration { bit } => {
                    words.push_str(&format!("  [{name} lost arbitration in bit {bit}]"));
                    continue;
                }
                SenderOutcome::Error(kind) => {
                    words.push_str(&format!("  [{name} met a {kind}]"));
                    continue;
                }
                SenderOutcome::Abandoned => {
                    words.push_str(&format!("  [{name} broke off]"));
                    continue;
                }
            }
            let is_it = |one: &&mut Waiting| one.node == sender.node && one.frame == *record.frame;
            let waiting = self.waiting.iter_mut().find(is_it).expect("it was asked for");
            waiting.sent_at = Some(record.end);
            let waited = record.start.saturating_since(waiting.since);
            if waited > self.intermission {
                words.push_str(&format!(
                    "  [waited {}.{:03} ms]",
                    waited.as_millis(),
                    waited.as_micros() % 1000
                ));
            }
        }
        self.trace.frame(&mut self.text, record.end, who.join("+"), record.frame, words);
    }

    fn destroyed(&mut self, record: &FrameRecord<'_>, error: Option<&BusError>) {
        if let Some((frame, times)) = &mut self.destroyed
            && frame == record.frame
        {
            *times += 1;
            return;
        }
        self.flush(record.start);
        let who: Vec<&str> =
            record.senders.iter().map(|sender| self.names[sender.node.index()].as_str()).collect();
        let words = error.map_or("broken off".to_owned(), |error| {
            let (node, kind) = (&self.names[error.node.index()], error.kind);
            match error.place {
                Some((bit, _)) => format!("destroyed: {kind} at {node} in bit {bit}"),
                None => format!("destroyed: {kind} at {node}"),
            }
        });
        let content = Content::Classic(*record.frame);
        self.trace.entry(&mut self.text, record.end, who.join("+"), &content, Emphasis::Problem, words);
        self.destroyed = Some((*record.frame, 0));
    }

    /// How often an attempt was repeated.
    fn flush(&mut self, at: Instant) {
        let Some((_, times)) = &mut self.destroyed else { return };
        let times = core::mem::take(times);
        if times > 0 {
            let words = if times == 1 {
                "destroyed once more".to_owned()
            } else {
                format!("destroyed {times} times more")
            };
            self.trace.event(&mut self.text, at, "", Emphasis::Problem, words);
        }
    }

    /// A machine is told what became of a frame: at the end of it if it was sent.
    fn done(&mut self, at: Instant, node: NodeId, token: TxToken, outcome: TxOutcome) {
        let is_it = |one: &Waiting| one.node == node && one.token == token;
        let place = self.waiting.iter().position(is_it).expect("it was asked for");
        let Waiting { frame, since, sent_at, .. } = self.waiting.remove(place);
        match outcome {
            TxOutcome::Sent => assert_eq!(sent_at, Some(at), "{frame}: told at another time than its end"),
            TxOutcome::Withdrawn => self.given_back(at, node, format!("{frame} withdrawn")),
            TxOutcome::Dropped => self.given_back(at, node, format!("{frame} dropped")),
            TxOutcome::Unknown => panic!("{frame}: a simulated bus knows what became of it"),
        }
        if outcome != TxOutcome::Sent {
            return;
        }
        if node == self.slave {
            self.sent.push_back(Sent { asked: since, end: at, frame });
        } else {
            self.last_heard = at;
        }
    }

    fn given_back(&mut self, at: Instant, node: NodeId, words: String) {
        self.line(at, node.index(), &words);
        if node == self.slave {
            self.told.push(words);
        }
    }
}
