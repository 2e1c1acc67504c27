//! `devicenet record`: the last seconds are kept, and written when something happens.

mod ring;
mod told;

use core::time::Duration;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use link_core::machine::Deadline;
use link_core::{Input, Instant, LinkEvent, Port as _};

use super::args::RecordArgs;
use super::endpoint::Endpoint;
use super::permit;
use super::port::{LivePort, PortError};
use super::trigger::Trigger;
use super::watch::{Cause, LOOK_EVERY, Watch};
use crate::exit::{Exit, Failure};
use crate::recording::{Content, ErrorFrame, WriteFormat, Writer};
use crate::simulate;
use crate::standard::is_standard;
use ring::Ring;
use told::{End, MOST_FRAMES, Teller, Written};

/// Records what leads to an event and what follows from it.
///
/// # Errors
/// [`Failure`] when the endpoint cannot be used, or a file cannot be written.
pub fn record(args: &RecordArgs, json: bool) -> Result<Exit, Failure> {
    if json && is_standard(&args.output) {
        return Err(Failure::Usage(
            "--json and `--output -` both want standard output: record into a file, or leave --json out"
                .into(),
        ));
    }
    check_folder(&args.output)?;
    let mut files = (1..=args.count).map(|n| args.file_name(n)).filter(|path| !is_standard(path));
    if let Some(path) = files.find(|path| path.exists()) {
        return Err(Failure::Usage(format!(
            "{} exists already: name another file with --output",
            path.display()
        )));
    }
    check_right(&args.file_name(1))?;
    let interrupted = simulate::interruption()?;
    let mut port = LivePort::open_listen_only(&args.endpoint)?;
    port.set_interruption(interrupted);
    let now = port.now();
    if let Some(span) = args.span {
        port.set_end(now + span.0);
    }
    let triggers = if args.trigger.is_empty() { DEFAULT.to_vec() } else { args.trigger.clone() };
    port.set_patience(longest_silence(&triggers).saturating_add(LOOK_EVERY));
    let mut recorder = Recorder {
        args,
        teller: Teller::new(json),
        ring: Ring::new(args.before.0, MOST_FRAMES),
        controller: if port.is_down() { Controller::Down } else { Controller::Up },
        begin: now,
        zero: zero(&args.endpoint, now),
        capture: None,
        captured: 0,
        written: 0,
        watch: Watch::new(triggers.clone()),
    };
    recorder.teller.start(args, &triggers)?;
    if recorder.controller == Controller::Down {
        recorder.teller.link(Duration::ZERO, &args.endpoint, true)?;
    }
    let ended = recorder.run(&mut port);
    let finished = recorder.finish(port.now());
    port.tell_the_rest();
    port.note_early_end(&args.endpoint, args.span);
    let end = match &ended {
        _ if finished.is_err() => End::Failed,
        Ok(()) => End::Complete,
        Err(PortError::Failed(_)) => End::Failed,
        Err(PortError::Over) if port.is_interrupted() => End::Interrupted,
        Err(PortError::Over) if port.over().is_some() => End::EndpointOver,
        Err(PortError::Over) => End::TimeOver,
    };
    let t = recorder.since_begin(port.now());
    recorder.teller.end(t, args, recorder.written, end)?;
    match ended {
        Err(PortError::Failed(failure)) => return Err(failure),
        Ok(()) | Err(PortError::Over) => finished?,
    }
    if port.is_down() {
        return Err(permit::down(&args.endpoint));
    }
    Ok(if recorder.captured > 0 { Exit::Findings } else { Exit::Done })
}

/// Hours may pass before a file is created: whether it can be is told before.
fn check_folder(output: &Path) -> Result<(), Failure> {
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
    match folder {
        Some(folder) if !folder.is_dir() => Err(Failure::Usage(format!(
            "{}: there is no folder {}: create it, or name another file with --output",
            output.display(),
            folder.display()
        ))),
        _ => Ok(()),
    }
}

/// The file is created, and gone again: nothing else knows all that may be in the way.
fn check_right(path: &Path) -> Result<(), Failure> {
    if is_standard(path) {
        return Ok(());
    }
    let tried = File::create_new(path).and_then(|_| fs::remove_file(path));
    tried.map_err(|error| {
        Failure::Usage(format!(
            "{} cannot be created: {error}; name another file with --output",
            path.display()
        ))
    })
}

fn longest_silence(triggers: &[Trigger]) -> Duration {
    let silences = triggers.iter().filter_map(|trigger| match trigger {
        Trigger::Silence(span) => Some(*span),
        _ => None,
    });
    silences.max().unwrap_or_default()
}

impl RecordArgs {
    /// The file of the n-th recording, from 1: with its number if there may be several.
    fn file_name(&self, n: u32) -> PathBuf {
        if self.count == 1 || is_standard(&self.output) {
            return self.output.clone();
        }
        let stem = self.output.file_stem().unwrap_or_default().to_string_lossy();
        let name = match self.output.extension() {
            Some(extension) => format!("{stem}-{n}.{}", extension.to_string_lossy()),
            None => format!("{stem}-{n}"),
        };
        self.output.with_file_name(name)
    }
}

struct Recorder<'a> {
    args: &'a RecordArgs,
    watch: Watch,
    teller: Teller,
    /// What came last, for as long as it may be wanted.
    ring: Ring<Entry>,
    controller: Controller,
    /// When listening began.
    begin: Instant,
    /// What to add to a moment of the port for the time of day.
    zero: Duration,
    capture: Option<Capture>,
    /// How many were begun.
    captured: u32,
    /// How many of them are complete.
    written: u32,
}

/// What a recording holds.
struct Entry {
    content: Content,
    /// How many frames are missing before it, at least.
    lost: u64,
}

/// What the interface does, as far as it was told.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Controller {
    Up,
    Down,
    BusOff,
}

struct Capture {
    path: PathBuf,
    writer: Writer<BufWriter<Box<dyn Write>>>,
    until: Instant,
    frames: u64,
    /// The times of the first and the last.
    span: Option<(Instant, Instant)>,
    /// There was no room for so many.
    dropped: u64,
    /// So many were lost before they were read, at least.
    lost: u64,
}

impl Recorder<'_> {
    fn run(&mut self, port: &mut LivePort) -> Result<(), PortError> {
        let mut at = port.now();
        loop {
            let look = Deadline { at: at + LOOK_EVERY, why: "a look at the connections" };
            let input;
            (at, input) = port.wait(Some(look))?;
            self.see(at, input).map_err(PortError::Failed)?;
            if self.captured == self.args.count && self.capture.is_none() {
                return Ok(());
            }
        }
    }

    fn see(&mut self, at: Instant, input: Input) -> Result<(), Failure> {
        if self.capture.as_ref().is_some_and(|capture| capture.until < at) {
            self.finish(at)?;
        }
        if let Some(entry) = self.entry(at, input)? {
            self.keep(at, entry)?;
        }
        match self.watch.see(at, input) {
            // What happens while it is recorded is recorded.
            Some(cause) if self.capture.is_none() && self.captured < self.args.count => {
                self.capture(at, &cause)
            }
            _ => Ok(()),
        }
    }

    /// What a recording holds of an input. An interface that goes down or comes back has no place in one, and is told.
    fn entry(&mut self, at: Instant, input: Input) -> Result<Option<Entry>, Failure> {
        let event = match input {
            Input::Frame(frame) => return Ok(Some(Entry { content: Content::Classic(frame), lost: 0 })),
            Input::Link(event) => event,
            Input::TxDone(..) | Input::Tick => return Ok(None),
        };
        let before = self.controller;
        self.controller = match event {
            LinkEvent::Up => Controller::Up,
            LinkEvent::Down => Controller::Down,
            LinkEvent::BusOff => Controller::BusOff,
            _ => before,
        };
        let is_down = self.controller == Controller::Down;
        if is_down != (before == Controller::Down) {
            self.teller.link(self.since_begin(at), &self.args.endpoint, is_down)?;
        }
        // Only a controller that was bus-off has restarted.
        if event == LinkEvent::Up && before != Controller::BusOff {
            return Ok(None);
        }
        let lost = match event {
            // One that does not count has lost one at least.
            LinkEvent::Overrun { lost } => lost.max(1).into(),
            _ => 0,
        };
        Ok(ErrorFrame::of_event(event).map(|error| Entry { content: Content::Error(error), lost }))
    }

    fn keep(&mut self, at: Instant, entry: Entry) -> Result<(), Failure> {
        if let Some(capture) = &mut self.capture {
            return capture.write(self.zero, at, &entry, &self.args.endpoint);
        }
        self.ring.push(at, entry);
        Ok(())
    }

    fn capture(&mut self, at: Instant, cause: &Cause) -> Result<(), Failure> {
        self.captured += 1;
        let path = self.args.file_name(self.captured);
        self.teller.trigger(self.since_begin(at), self.captured, &path, cause)?;
        let writer = create(&path).map_err(|error| unwritable(&path, error))?;
        let (before, dropped) = self.ring.take(at);
        let mut capture =
            Capture { path, writer, until: at + self.args.after.0, frames: 0, span: None, dropped, lost: 0 };
        for (at, entry) in before {
            capture.write(self.zero, at, &entry, &self.args.endpoint)?;
        }
        self.capture = Some(capture);
        Ok(())
    }

    /// Ends the recording that is under way.
    fn finish(&mut self, now: Instant) -> Result<(), Failure> {
        let Some(Capture { path, writer, frames, span, dropped, lost, .. }) = self.capture.take() else {
            return Ok(());
        };
        writer.finish().map_err(|error| unwritable(&path, error))?;
        self.written += 1;
        let written = Written { n: self.captured, path: &path, frames, span, dropped, lost };
        self.teller.written(self.since_begin(now), written, self.args.before)
    }

    fn since_begin(&self, at: Instant) -> Duration {
        at.saturating_since(self.begin)
    }
}

impl Capture {
    fn write(
        &mut self,
        zero: Duration,
        at: Instant,
        Entry { content, lost }: &Entry,
        endpoint: &Endpoint,
    ) -> Result<(), Failure> {
        let channel = match endpoint {
            Endpoint::Interface(name) => name.as_str(),
            Endpoint::Scenario(_) => "sim0",
            Endpoint::Recording(_) => "log0",
        };
        self.frames += 1;
        self.lost += lost;
        let stamp = at + zero;
        self.span = Some(self.span.map_or((stamp, stamp), |(first, _)| (first, stamp)));
        self.writer.write(stamp, DIGITS, channel, content).map_err(|error| unwritable(&self.path, error))
    }
}

/// An interface is recorded in the time of day, as candump does.
fn zero(endpoint: &Endpoint, now: Instant) -> Duration {
    match endpoint {
        Endpoint::Interface(_) => {
            let wall = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
            wall.saturating_sub(now.saturating_since(Instant::ZERO))
        }
        Endpoint::Scenario(_) | Endpoint::Recording(_) => Duration::ZERO,
    }
}

fn create(path: &Path) -> io::Result<Writer<BufWriter<Box<dyn Write>>>> {
    let format = WriteFormat::of_name(&path.to_string_lossy());
    let out: Box<dyn Write> =
        if is_standard(path) { Box::new(io::stdout()) } else { Box::new(File::create_new(path)?) };
    Writer::new(BufWriter::new(out), format)
}

fn unwritable(path: &Path, error: io::Error) -> Failure {
    if is_standard(path) {
        return Failure::Output(error);
    }
    Failure::Usage(format!("{}: {error}", path.display()))
}

/// Without `--trigger`: what an engineer is called for.
const DEFAULT: [Trigger; 4] =
    [Trigger::TimeOut(None), Trigger::Duplicate, Trigger::BusOff, Trigger::BusError];
/// Nanoseconds.
const DIGITS: u8 = 9;
