//! From a recorded frame to a line of text, a JSON object, or an entry in the summary.

use devicenet_core::doctor::Doctor;
use devicenet_core::monitor::{Monitor, MonitorConfig};
use devicenex_core::monitor as nex;
use link_core::BitRate;

use super::buses::of_bus;
use super::clock::Clock;
use super::filter::Filter;
use super::json;
use super::meaning::{Meaning, Noted};
use super::outside::Outside;
use super::protocol::Spoken;
use super::scan_list::{self, ScanLists};
use super::sheets::Sheets;
use super::summary::Summary;
use crate::args::DecodeArgs;
use crate::exit::Failure;
use crate::health;
use crate::output;
use crate::recording::{Channels, Content, RecordedFrame};
use crate::scenario::Scenario;
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
            && summary.see_time(bus, frame)
            && let Some(doctor) = self.doctors.get_mut(bus)
        {
            doctor.set_bit_rate(None);
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

    /// Tells what there is against the bit rate that the user has said.
    ///
    /// # Errors
    /// It cannot be, so there can be no summary.
    pub(super) fn doubt_bit_rate(&self, channels: &Channels, file: &str) -> Result<(), Failure> {
        let View::Summary { summary, .. } = &self.view else { return Ok(()) };
        summary.doubts().try_for_each(|(bus, said, doubt)| {
            let bus = printable(channels.iter().nth(bus).unwrap_or("the bus"));
            doubt.tell(file, said, &bus)
        })
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
