//! The trace in words. What repeats itself is told once and counted.

use core::fmt::Write as _;

use devicenet_core::master::{MasterEvent, SlaveEvent, SlaveState};
use devicenex_core::manager::{DeviceState, ManagerEvent, PlannedEvent};
use link_core::wire::Field;
use link_core::{Frame, Instant};
use transport_mock::Flag;
use transport_mock::bus::{BusError, Sender, SenderOutcome};
use transport_mock::record::{FrameRecord, Outcome};

use super::event::NodeEvent;
use super::exchanged::Exchanged;
use super::level::Level;
use super::polls::{Held, Poll, Polls};
use super::said::Said;
use super::selection::{Selection, kind_of_event};
use super::shared::SharedBuffer;
use super::sight::{Nodes, Sight, View, index};
use crate::scenario::NodeIndex;
use crate::text::{count, printable};
use crate::trace::{Emphasis, Trace};

/// Prints the trace.
pub(super) struct TextView {
    out: SharedBuffer,
    trace: Trace,
    /// The attempts that failed since a frame got through, or something was changed, on each segment.
    storms: Vec<Option<Storm>>,
    exchanged: Exchanged,
    polls: Polls,
    /// What is named here is told, whether it is news or not.
    selection: Selection,
    /// When something was last seen.
    last: Instant,
    is_first: bool,
}

/// Attempts that fail one after the other. Each is told if it fails otherwise than the one before, up to a limit; the
/// others are counted.
struct Storm {
    frame: Frame,
    who: String,
    /// What was wrong, in words.
    words: String,
    /// How many were told.
    told: usize,
    /// How many were not told since the last line.
    silent: u64,
    /// Whether all these were like the last that was told.
    alike: bool,
    last: Instant,
    /// What the counters of the senders have come to.
    counters: String,
}

impl TextView {
    pub(super) fn new(out: SharedBuffer, coloured: bool, nodes: &[crate::scenario::Node]) -> Self {
        let trace = Trace::new(coloured).with_node_width(node_width(nodes));
        Self {
            out,
            trace,
            storms: Vec::new(),
            exchanged: Exchanged::default(),
            polls: Polls::default(),
            selection: Selection::default(),
            last: Instant::ZERO,
            is_first: true,
        }
    }

    /// With every I/O frame, also those that say nothing new.
    pub(super) fn with_all_frames(mut self, all: bool) -> Self {
        self.exchanged.all = all;
        self
    }

    /// With every event of the kinds that are asked for by name.
    pub(super) fn with_all_of(mut self, selection: Selection) -> Self {
        self.selection = selection;
        self
    }

    fn frame(&mut self, nodes: &Nodes<'_>, record: &FrameRecord<'_>, words: Option<String>) {
        if self.storms.len() <= record.segment {
            self.storms.resize_with(record.segment + 1, || None);
        }
        let problem = match record.outcome {
            Outcome::Ok => {
                self.flush();
                self.storms[record.segment] = None;
                self.line(nodes, record, Emphasis::Normal, &words.unwrap_or_default());
                return;
            }
            Outcome::Abandoned => "broken off".to_owned(),
            Outcome::Error(error) => describe(nodes, &error, record.senders),
        };
        let counters = counters(nodes, record.senders);
        let who = senders(nodes, record.senders);
        let mut told = 0;
        if let Some(storm) = &mut self.storms[record.segment] {
            let again = storm.frame == *record.frame && storm.who == who && storm.words == problem;
            if again || storm.told == MOST_TOLD {
                storm.alike = again && (storm.alike || storm.silent == 0);
                storm.silent += 1;
                (storm.last, storm.counters) = (record.end, counters);
                return;
            }
            told = storm.told;
        }
        self.flush();
        self.line(nodes, record, Emphasis::Problem, &format!("{problem}; {counters}"));
        let (frame, last) = (*record.frame, record.end);
        let storm =
            Storm { frame, who, words: problem, told: told + 1, silent: 0, alike: true, last, counters };
        self.storms[record.segment] = Some(storm);
    }

    /// Whether it is a request, or an answer, that was heard before and need not be told now.
    fn is_poll(&mut self, nodes: &Nodes<'_>, record: &FrameRecord<'_>, said: &Said<'_>) -> bool {
        let Said::DeviceNex(reading) = said else { return false };
        if self.exchanged.all {
            return false;
        }
        match self.polls.look(record.segment, reading) {
            Poll::News => return false,
            Poll::Again => self.polls.hold(Held {
                at: record.end,
                who: senders(nodes, record.senders),
                frame: *record.frame,
                words: reading.to_string(),
            }),
            Poll::Same => self.exchanged.silent_polls += 1,
        }
        true
    }

    /// Tells the requests that are held back, before anything that is later.
    fn tell_held(&mut self) {
        for Held { at, who, frame, words } in self.polls.take_held() {
            let content = crate::recording::Content::Classic(frame);
            self.out.write(|out| self.trace.entry(out, at, &who, &content, Emphasis::Normal, &words));
        }
    }

    fn line(&mut self, nodes: &Nodes<'_>, record: &FrameRecord<'_>, emphasis: Emphasis, words: &str) {
        self.tell_held();
        let who = senders(nodes, record.senders);
        let content = crate::recording::Content::Classic(*record.frame);
        self.out.write(|out| self.trace.entry(out, record.end, &who, &content, emphasis, words));
    }

    /// Tells how many failures were not told.
    fn flush(&mut self) {
        let silent = self.storms.iter_mut().flatten().filter(|storm| storm.silent > 0);
        let mut silent: Vec<&mut Storm> = silent.collect();
        silent.sort_by_key(|storm| storm.last);
        for storm in silent {
            let times = if storm.silent == 1 { "once".to_owned() } else { format!("{} times", storm.silent) };
            let what = if storm.alike { "the same" } else { "an error" };
            let words = format!("{what} {times} more; {}", storm.counters);
            (storm.silent, storm.alike) = (0, true);
            self.out.write(|out| self.trace.event(out, storm.last, &storm.who, Emphasis::Problem, &words));
        }
    }

    /// Tells how many I/O frames were not told.
    fn told_nothing(&mut self, at: Instant) {
        let silent = core::mem::take(&mut self.exchanged.silent);
        let polls = core::mem::take(&mut self.exchanged.silent_polls);
        for (silent, what, how) in [
            (silent, "more I/O frame", "with the same data as before"),
            (polls, "more connectionless request", "with the same answer as before"),
        ] {
            if silent > 0 {
                let words = format!("{} {how}", count(silent, what));
                self.out.write(|out| self.trace.event(out, at, "-", Emphasis::Normal, &words));
            }
        }
    }

    fn event(
        &mut self,
        nodes: &Nodes<'_>,
        at: Instant,
        node: Option<NodeIndex>,
        emphasis: Emphasis,
        words: &str,
    ) {
        self.tell_held();
        self.flush();
        let name = node.map_or("-", |node| nodes.name(node));
        self.out.write(|out| self.trace.event(out, at, name, emphasis, words));
    }
}

impl View for TextView {
    fn see(&mut self, nodes: &Nodes<'_>, sight: &Sight<'_>) {
        match sight {
            Sight::Broken { at, node, rule } => {
                self.event(nodes, *at, Some(*node), Emphasis::Problem, rule);
            }
            Sight::Frame { record, reading } => {
                let is_known = reading.is_some_and(|reading| {
                    self.exchanged.is_known(record, reading) || self.is_poll(nodes, record, reading)
                });
                if is_known {
                    // Whatever failed before it is over.
                    self.flush();
                    self.storms.iter_mut().skip(record.segment).take(1).for_each(|storm| *storm = None);
                } else {
                    self.frame(nodes, record, reading.map(ToString::to_string));
                }
            }
            Sight::Event { at, node, event } => {
                if let Some(whose) = begins_to_run(event) {
                    self.exchanged.forget(whose);
                    self.polls.forget(whose);
                }
                if begins_anew(event) {
                    self.polls.forget_all();
                }
                let is_asked_for = self.selection.names(kind_of_event(event));
                if is_asked_for || event.is_news() {
                    let words = event.words();
                    let emphasis = if event.is_problem() { Emphasis::Problem } else { Emphasis::Normal };
                    self.event(nodes, *at, Some(*node), emphasis, &words);
                }
            }
            Sight::Level { at, node, level, counters } => {
                let words = format!("{}: TEC {}, REC {}", level.name(), counters.tec, counters.rec);
                let emphasis = if *level == Level::Active { Emphasis::Normal } else { Emphasis::Problem };
                self.event(nodes, *at, Some(*node), emphasis, &words);
            }
            Sight::Change { at, node, what, problem } => {
                let emphasis = if *problem { Emphasis::Problem } else { Emphasis::Normal };
                self.event(nodes, *at, *node, emphasis, what);
                self.storms.clear();
            }
            Sight::Note { at, text } => {
                self.tell_held();
                self.flush();
                self.told_nothing(*at);
                self.storms.clear();
                let blank = if self.is_first { "" } else { "\n" };
                let text = printable(text);
                self.out.write(|out| out.extend_from_slice(format!("{blank}{text}\n").as_bytes()));
            }
        }
        self.is_first = false;
        self.last = match sight {
            Sight::Frame { record, .. } => record.end,
            Sight::Event { at, .. }
            | Sight::Level { at, .. }
            | Sight::Change { at, .. }
            | Sight::Broken { at, .. }
            | Sight::Note { at, .. } => *at,
        };
    }
}

impl Drop for TextView {
    fn drop(&mut self) {
        self.tell_held();
        self.flush();
        self.told_nothing(self.last);
    }
}

/// The slave, or the planned device, whose I/O begins.
fn begins_to_run(event: &NodeEvent) -> Option<u8> {
    match event {
        NodeEvent::Master(MasterEvent::Slave {
            mac_id,
            event: SlaveEvent::StateChanged { to: SlaveState::Running, .. },
        }) => Some(mac_id.number()),
        NodeEvent::Manager(event) => match **event {
            ManagerEvent::Planned(oa, PlannedEvent::StateChanged { to: DeviceState::Running, .. }) => {
                Some(oa.number())
            }
            _ => None,
        },
        _ => None,
    }
}

/// A manager looks at its plant for the first time, or once more.
fn begins_anew(event: &NodeEvent) -> bool {
    matches!(event, NodeEvent::Manager(event) if **event == ManagerEvent::Started)
}

/// The width of the node column: room for every name, and for two that send together unless their names are long. It is
/// known before the run, so that the column does not move in the middle of it.
fn node_width(nodes: &[crate::scenario::Node]) -> usize {
    let mut lengths: Vec<usize> = nodes.iter().map(|node| node.name.chars().count()).collect();
    lengths.sort_unstable_by(|one, other| other.cmp(one));
    match lengths.as_slice() {
        [] => 0,
        [one] => *one,
        [one, other, ..] => (one + "+".len() + other).min(WIDEST_PAIR).max(*one),
    }
}

/// `left`, `left+right`, `twin-01+62`; of those that lost arbitration nobody speaks, unless all did.
fn senders(nodes: &Nodes<'_>, senders: &[Sender]) -> String {
    let has_lost = |sender: &&Sender| matches!(sender.outcome, SenderOutcome::LostArbitration { .. });
    let all_have = senders.iter().all(|sender| has_lost(&sender));
    let names: Vec<&str> = (senders.iter())
        .filter(|sender| all_have || !has_lost(sender))
        .map(|sender| nodes.name(index(sender.node)))
        .collect();
    match names.as_slice() {
        [] => "-".to_owned(),
        [one] => (*one).to_owned(),
        [one, other] => format!("{one}+{other}"),
        [one, others @ ..] => format!("{one}+{}", others.len()),
    }
}

/// `TEC 8`, `TEC left 8, right 8`
fn counters(nodes: &Nodes<'_>, senders: &[Sender]) -> String {
    let tec = |sender: &Sender| nodes.status(index(sender.node)).tec;
    if let [sender] = senders {
        return format!("TEC {}", tec(sender));
    }
    let named = |sender: &Sender| format!("{} {}", nodes.name(index(sender.node)), tec(sender));
    let named: Vec<String> = senders.iter().take(MOST_COUNTERS).map(named).collect();
    match senders.len().saturating_sub(MOST_COUNTERS) {
        0 => format!("TEC {}", named.join(", ")),
        more => format!("TEC {} and {more} more", named.join(", ")),
    }
}

/// `collision: bit error in bit 52 (data)`
fn describe(nodes: &Nodes<'_>, error: &BusError, senders: &[Sender]) -> String {
    let mut words = String::new();
    let colliding = senders.iter().filter(|sender| matches!(sender.outcome, SenderOutcome::Error(_))).count();
    if colliding > 1 {
        words.push_str("collision: ");
    }
    let _ = write!(words, "{}", error.kind);
    if let Some((bit, field)) = error.place {
        let _ = write!(words, " in bit {bit} ({})", field_name(field));
    }
    if !error.sender {
        let _ = write!(words, " at {}", nodes.name(index(error.node)));
    }
    words.push_str(match error.flag {
        Flag::Active => "",
        Flag::Passive => ", passive flag",
        Flag::None => ", no flag",
    });
    words
}

pub(super) const fn field_name(field: Field) -> &'static str {
    match field {
        Field::StartOfFrame => "start of frame",
        Field::Arbitration => "arbitration",
        Field::Control => "control",
        Field::Data => "data",
        Field::Crc => "CRC",
        Field::CrcDelimiter => "CRC delimiter",
        Field::AckSlot => "ACK slot",
        Field::AckDelimiter => "ACK delimiter",
        Field::EndOfFrame => "end of frame",
    }
}

const WIDEST_PAIR: usize = 20;
const MOST_COUNTERS: usize = 4;
/// Failures that are told between two frames that get through, or two changes.
const MOST_TOLD: usize = 12;
