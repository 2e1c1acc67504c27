//! From a recorded frame to a line of text, a JSON object, or an entry in the summary.

use core::fmt;
use core::time::Duration;

use devicenet_core::MacId;
use devicenet_core::doctor::{Doctor, Severity};
use devicenet_core::monitor::{Detail, Kind, Monitor, MonitorConfig, Reading};
use devicenex_core::OperationalAddress;
use devicenex_core::monitor as nex;
use link_core::{BitRate, Instant};

use super::clock::Clock;
use super::json;
use super::outside::Outside;
use super::protocol::Spoken;
use super::scan_list::{self, ScanLists};
use super::sheets::{Note, Sheets};
use super::summary::Summary;
use crate::args::DecodeArgs;
use crate::health;
use crate::output;
use crate::recording::{Channels, Content, RecordedFrame};
use crate::scenario::{Scenario, Time};
use crate::text::{printable, push_number};
use crate::trace::{Emphasis, Trace};

/// Decodes frame after frame; constant memory.
pub struct Decoder {
    filter: Filter,
    /// One for each channel: every channel is a bus of its own.
    monitors: Vec<Box<Monitor>>,
    /// The same, if DeviceNeX is spoken.
    nex_monitors: Vec<Box<nex::Monitor>>,
    spoken: Spoken,
    /// One for each monitor, if there is to be a summary.
    doctors: Vec<Box<Doctor>>,
    /// What belongs to the network.
    expected: Option<Scenario>,
    sheets: Sheets,
    view: View,
    node: Vec<u8>,
}

/// What becomes of the frames.
enum View {
    Text {
        trace: Trace,
        clock: Clock,
    },
    Json,
    Summary {
        summary: Box<Summary>,
        json: bool,
    },
    ScanLists(ScanLists),
    /// Nothing: standard output gets the frames themselves, or nobody reads it.
    Silent,
}

/// What a frame came to.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Verdict {
    /// The filters leave it out.
    Hidden,
    /// It is in order, as far as can be seen.
    Fine,
    /// It is wrong or suspicious.
    Problem,
}

/// What a frame means.
#[allow(
    clippy::large_enum_variant,
    reason = "there is one at a time, on the stack, and it is nearly always the large one"
)]
pub(super) enum Meaning<'a> {
    /// A classic frame, as the monitor of DeviceNet reads it.
    Read(Reading<'a>),
    /// The same, as that of DeviceNeX does.
    Nex(nex::Reading<'a>),
    /// What no monitor is asked about.
    Outside(Outside),
}

impl Decoder {
    /// As the command line says.
    #[must_use]
    pub fn new(args: &DecodeArgs, json: bool, coloured: bool) -> Self {
        let view = match (args.summary, json) {
            _ if args.is_record_on_stdout() => View::Silent,
            _ if args.scanlist => View::ScanLists(ScanLists::default()),
            (true, json) => {
                View::Summary { summary: Box::new(Summary::new(args.bit_rate.map(BitRate))), json }
            }
            (false, true) => View::Json,
            (false, false) => {
                View::Text { trace: Trace::new(coloured), clock: Clock::new(args.time.unwrap_or_default()) }
            }
        };
        let (filter, sheets) = (Filter::new(args), Sheets::default());
        Self {
            filter,
            monitors: Vec::new(),
            nex_monitors: Vec::new(),
            spoken: Spoken::of(args).unwrap_or_default(),
            doctors: Vec::new(),
            expected: None,
            sheets,
            view,
            node: Vec::new(),
        }
    }

    /// The same, with names from Electronic Data Sheets.
    #[must_use]
    pub fn with_sheets(self, sheets: Sheets) -> Self {
        Self { sheets, ..self }
    }

    /// The same, with scan lists that say what belongs to the network.
    #[must_use]
    pub fn with_expected(self, expected: Option<Scenario>) -> Self {
        Self { expected, ..self }
    }

    /// Frames are of this protocol from now on.
    pub(super) fn speak(&mut self, spoken: Spoken) {
        self.spoken = spoken;
    }

    /// Decodes a frame, and appends its line to `out` unless there is to be a summary.
    #[inline]
    pub fn frame(&mut self, out: &mut Vec<u8>, frame: &RecordedFrame, channels: &Channels) -> Verdict {
        let bus = frame.channel.map_or(0, |channel| channel.index());
        let meaning = match &frame.content {
            Content::Classic(classic) if self.spoken == Spoken::DeviceNex => {
                Meaning::Nex(nex_monitor(&mut self.nex_monitors, bus).observe(frame.at, frame.n, classic))
            }
            Content::Classic(classic) => {
                Meaning::Read(match doctor(&mut self.doctors, bus, &self.view, self.expected.as_ref()) {
                    Some(doctor) => {
                        let monitor = monitor(&mut self.monitors, bus, &self.sheets);
                        doctor.observe(monitor, frame.at, frame.n, classic)
                    }
                    None => {
                        monitor(&mut self.monitors, bus, &self.sheets).observe(frame.at, frame.n, classic)
                    }
                })
            }
            Content::Error(error) => {
                if let Some(doctor) = doctor(&mut self.doctors, bus, &self.view, self.expected.as_ref()) {
                    error.link_events().for_each(|event| doctor.link(frame.at, Some(frame.n), event));
                }
                Meaning::Outside(Outside::Error(*error))
            }
            Content::Fd(_) => {
                if let Some(doctor) = doctor(&mut self.doctors, bus, &self.view, self.expected.as_ref()) {
                    doctor.can_fd(frame.at, frame.n);
                }
                Meaning::Outside(Outside::Fd)
            }
        };
        let identified = meaning.reading().and_then(|reading| self.sheets.identified(reading));
        let allocated = match (&self.view, meaning.reading()) {
            (View::ScanLists(_), Some(reading)) => scan_list::allocated(reading),
            _ => None,
        };
        let note = meaning.reading().and_then(|reading| self.sheets.observe(bus, reading));
        if let View::Text { clock, .. } = &mut self.view {
            clock.see(frame.at);
        }
        let is_within = self.filter.is_within(frame.at);
        if let View::Summary { summary, .. } = &mut self.view
            && is_within
        {
            summary.see_time(bus, frame);
        }
        let verdict = match (is_within && self.filter.accepts(&meaning), meaning.has_problem()) {
            (false, _) => Verdict::Hidden,
            (true, false) => Verdict::Fine,
            (true, true) => Verdict::Problem,
        };
        if verdict != Verdict::Hidden {
            let name = frame.channel.map(|channel| channels.name(channel));
            match &mut self.view {
                View::Text { trace, clock } => {
                    write_node(&mut self.node, &meaning, name.filter(|_| bus > 0));
                    let emphasis = if meaning.has_problem() { Emphasis::Problem } else { Emphasis::Normal };
                    let words = Noted(&meaning, note);
                    trace.entry(out, clock.show(frame.at), &self.node, &frame.content, emphasis, words);
                }
                View::Json => json::object(out, frame, name, &meaning, note.as_ref()),
                View::Summary { summary, .. } => summary.observe(bus, frame, &meaning),
                View::ScanLists(lists) => {
                    if let Some(reading) = meaning.reading() {
                        lists.observe(bus, reading);
                    }
                }
                View::Silent => {}
            }
        }
        if let Some(record) = identified.and_then(|mac| self.monitors.get(bus)?.node(mac)) {
            self.sheets.identify(bus, &record);
        }
        if let View::ScanLists(lists) = &mut self.view
            && let Some(record) = allocated.and_then(|mac| self.monitors.get(bus)?.node(mac))
        {
            lists.allocated(bus, &record);
        }
        verdict
    }

    /// Appends the summary, if that is what is wanted. `file` names a bus that has no name; so many of its lines or records could not be
    /// read.
    pub fn finish(&mut self, out: &mut Vec<u8>, channels: &Channels, file: &str, unread: u64) {
        if let View::ScanLists(lists) = &self.view {
            let start = out.len();
            for (bus, monitor) in self.monitors.iter().enumerate() {
                let name = channels.iter().nth(bus).unwrap_or(file);
                out.extend_from_slice(lists.toml(bus, &printable(name), monitor).as_bytes());
            }
            if out.len() == start && !self.monitors.is_empty() {
                output::note(format_args!(
                    "{file}: no scan list: the recording has no slave whose master is seen, by an allocation or by an answer \
                     to an explicit request"
                ));
            }
            return;
        }
        let View::Summary { summary, json } = &mut self.view else { return };
        for (bus, monitor) in self.monitors.iter().enumerate() {
            summary.learn(bus, monitor);
        }
        for (bus, monitor) in self.nex_monitors.iter().enumerate() {
            summary.learn_nex(bus, monitor);
        }
        for (bus, doctor) in self.doctors.iter().enumerate() {
            summary.diagnose(bus, doctor, self.filter.mac);
        }
        summary.conclude(unread);
        let name = |bus| channels.iter().nth(bus).unwrap_or(file).to_owned();
        let text = if *json { summary.json(name) } else { summary.text(name) };
        out.extend_from_slice(text.as_bytes());
    }

    /// Whether something is or was wrong, as the summary says; `None` without one, and before [`finish`](Self::finish).
    #[must_use]
    pub fn is_bad(&self) -> Option<bool> {
        match &self.view {
            View::Summary { summary, .. } => summary.is_bad(),
            View::Text { .. } | View::Json | View::ScanLists(_) | View::Silent => None,
        }
    }

    /// Says which Electronic Data Sheets were for nothing.
    pub fn note_unused_sheets(&self) {
        self.sheets.finish();
    }

    /// Writes nothing from now on, and says the same of every frame.
    pub fn silence(&mut self) {
        self.view = View::Silent;
    }
}

fn monitor<'a>(monitors: &'a mut Vec<Box<Monitor>>, bus: usize, sheets: &Sheets) -> &'a mut Monitor {
    of_bus(monitors, bus, || {
        let mut monitor = Box::new(Monitor::new(MonitorConfig::default()));
        sheets.prepare(&mut monitor);
        monitor
    })
}

fn nex_monitor(monitors: &mut Vec<Box<nex::Monitor>>, bus: usize) -> &mut nex::Monitor {
    of_bus(monitors, bus, || Box::new(nex::Monitor::new(nex::MonitorConfig::default())))
}

/// The doctor of a bus, where one is wanted.
fn doctor<'a>(
    doctors: &'a mut Vec<Box<Doctor>>,
    bus: usize,
    view: &View,
    expected: Option<&Scenario>,
) -> Option<&'a mut Doctor> {
    let View::Summary { summary, .. } = view else { return None };
    Some(of_bus(doctors, bus, || health::doctor(summary.known_rate(), expected, None)))
}

/// What there is one of for each bus, begun with the first frame of that bus.
fn of_bus<T>(all: &mut Vec<Box<T>>, bus: usize, begin: impl Fn() -> Box<T>) -> &mut T {
    if all.len() <= bus {
        begin_buses(all, bus, begin);
    }
    &mut all[bus]
}

/// Apart from what is done for every frame: a machine is made on the stack, and a function with hundreds of kilobytes there touches
/// each of their pages whenever it is called.
#[cold]
#[inline(never)]
fn begin_buses<T>(all: &mut Vec<Box<T>>, bus: usize, begin: impl Fn() -> Box<T>) {
    while all.len() <= bus {
        all.push(begin());
    }
}

/// The MAC ID of the sender, after the channel in a recording of several buses, all but the first of which are named.
fn write_node(node: &mut Vec<u8>, meaning: &Meaning<'_>, channel: Option<&str>) {
    node.clear();
    if let Some(name) = channel {
        node.extend_from_slice(printable(name).as_bytes());
        node.push(b'/');
    }
    match meaning.source() {
        Some(mac) => push_number(node, mac),
        None => node.push(b'-'),
    }
}

impl Meaning<'_> {
    /// The MAC ID or operational address of the sender, where it is known.
    pub(super) fn source(&self) -> Option<u8> {
        match self {
            Self::Read(reading) => reading.src.map(u8::from),
            Self::Nex(reading) => reading.src.map(u8::from),
            Self::Outside(_) => None,
        }
    }

    fn reading(&self) -> Option<&Reading<'_>> {
        match self {
            Self::Read(reading) => Some(reading),
            Self::Nex(_) | Self::Outside(_) => None,
        }
    }

    fn kind(&self) -> &'static str {
        match self {
            Self::Read(reading) => reading.kind.name(),
            Self::Nex(reading) => reading.kind.name(),
            Self::Outside(_) => Kind::Foreign.name(),
        }
    }

    pub(super) fn has_problem(&self) -> bool {
        match self {
            Self::Read(reading) => reading.problem.is_some(),
            Self::Nex(reading) => reading.problem.is_some(),
            Self::Outside(_) => true,
        }
    }

    /// What its problem says of the network. What stands outside, the rules of the doctor judge.
    pub(super) fn severity(&self) -> Severity {
        match self {
            Self::Read(reading) => reading.problem.as_ref().map_or(Severity::Info, Severity::of),
            Self::Nex(reading) => match reading.problem {
                Some(nex::Problem::Flaw(flaw)) => Severity::of_flaw(&flaw),
                // A device that comes back finds its address given to its spare.
                Some(nex::Problem::AddressTaken { .. }) | None => Severity::Info,
                // No rule judges what becomes of the others.
                Some(_) => Severity::Warning,
            },
            Self::Outside(_) => Severity::Info,
        }
    }

    /// A stable name for the kind of its problem.
    pub(super) fn problem_code(&self) -> Option<&'static str> {
        match self {
            Self::Read(reading) => reading.problem.map(|problem| problem.code()),
            Self::Nex(reading) => reading.problem.map(|problem| problem.code()),
            Self::Outside(outside) => Some(outside.code()),
        }
    }
}

impl fmt::Display for Meaning<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read(reading) => reading.fmt(f),
            Self::Nex(reading) => reading.fmt(f),
            Self::Outside(outside) => outside.fmt(f),
        }
    }
}

/// The words of a frame, and what its values are.
struct Noted<'a>(&'a Meaning<'a>, Option<Note<'a>>);

impl fmt::Display for Noted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)?;
        self.1.as_ref().map_or(Ok(()), |note| note.fmt(f))
    }
}

/// Which frames are shown.
struct Filter {
    /// Since the first frame.
    from: Duration,
    to: Duration,
    first: Option<Instant>,
    mac: Option<u8>,
    kinds: Vec<&'static str>,
}

impl Filter {
    fn new(args: &DecodeArgs) -> Self {
        let from = args.from.map_or(Duration::ZERO, |Time(from)| from);
        let to = args.to.map_or(Duration::MAX, |Time(to)| to);
        Self { from, to, first: None, mac: args.mac, kinds: args.kind.clone() }
    }

    /// Whether the time is right; a frame that is earlier than the first is at 0.
    #[inline]
    fn is_within(&mut self, at: Instant) -> bool {
        let since = at.saturating_since(*self.first.get_or_insert(at));
        (self.from..=self.to).contains(&since)
    }

    #[inline]
    fn accepts(&self, meaning: &Meaning<'_>) -> bool {
        let is_of_node = self.mac.is_none_or(|mac| match meaning {
            Meaning::Read(reading) => concerns(reading, mac),
            Meaning::Nex(reading) => concerns_address(reading, mac),
            Meaning::Outside(_) => false,
        });
        is_of_node && (self.kinds.is_empty() || self.kinds.contains(&meaning.kind()))
    }
}

/// Whether a frame of DeviceNeX is from a node, to it, or to all; or gives it its address.
fn concerns_address(reading: &nex::Reading<'_>, address: u8) -> bool {
    let is_node = |end: Option<OperationalAddress>| end.map(u8::from) == Some(address);
    let is_to_all = reading.kind == nex::Kind::MiniWho;
    let is_new =
        matches!(reading.fields.detail, nex::Detail::Roam { requested } if u8::from(requested) == address);
    is_to_all || is_new || is_node(reading.src) || is_node(reading.dst)
}

/// Whether a frame is from a node, to it, or to all.
fn concerns(reading: &Reading<'_>, mac: u8) -> bool {
    let is_node = |end: Option<MacId>| end.map(u8::from) == Some(mac);
    let is_to_all = match reading.kind {
        Kind::BitStrobeCommand | Kind::MulticastPollCommand => true,
        // Unless it names the one node that it is for, or from.
        Kind::OfflineFaultRequest | Kind::OfflineOwnershipRequest => reading.dst.is_none(),
        Kind::OfflineFaultResponse | Kind::OfflineOwnershipResponse => reading.src.is_none(),
        _ => false,
    };
    let is_new_mac = matches!(reading.fields.detail, Detail::ChangeMacId { mac: new } if new.number() == mac);
    is_to_all || is_new_mac || is_node(reading.src) || is_node(reading.dst)
}
