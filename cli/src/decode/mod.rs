//! `devicenet decode`: a recording, frame by frame, in words or as JSON.

mod buses;
mod clock;
mod copy;
mod decoder;
mod filter;
mod json;
mod meaning;
mod outside;
mod progress;
mod protocol;
mod scan_list;
mod sheets;
mod span;
mod summary;

pub use decoder::{Decoder, Verdict};
pub use protocol::Spoken;
pub use sheets::Sheets;

use core::fmt;

use std::cell::RefCell;
use std::io;
use std::rc::Rc;

use crate::args::{DecodeArgs, Protocol};
use crate::exit::{Exit, Failure};
use crate::output::{self, Attentive, Output};
use crate::recording::{Content, Notes, RecordedFrame, Recording, RecordingError};
use crate::scenario::Scenario;
use crate::standard::{at_most_one, is_standard, shown};
use crate::text::count;
use copy::Copy;
use progress::Progress;
use protocol::{Ear, Heard, Why};

/// Decodes a recording.
///
/// # Errors
/// [`Failure`] when the recording cannot be read to its end, with `--strict` also when a line is bad. What precedes the
/// failure is shown, summed up and recorded.
pub fn run(args: &DecodeArgs, json: bool) -> Result<Exit, Failure> {
    check(args, json)?;
    let sheets = Sheets::read(&args.eds)?;
    let expected = args.expect.as_deref().map(Scenario::load).transpose();
    let expected = expected.map_err(|error| Failure::Usage(error.to_string()))?;
    let file = shown(&args.file, "<stdin>");
    let output = Rc::new(RefCell::new(Output::new()));
    let recording = match is_standard(&args.file) {
        true => Recording::from_reader(Attentive::new(Rc::clone(&output))),
        false => Recording::open(&args.file),
    };
    let mut recording = recording.map_err(|error| unreadable(&file, error))?;
    let copy = args.record.as_deref().map(|path| Copy::create(path, &args.file)).transpose()?;
    let mut session = Session {
        decoder: Decoder::new(args, json, output.borrow().is_coloured())
            .with_sheets(sheets)
            .with_expected(expected),
        progress: Progress::new(args, &output.borrow()),
        output: Rc::clone(&output),
        copy,
        file,
        ear: Spoken::of(args).is_none().then(|| Ear::new(is_standard(&args.file))),
        tally: Tally::default(),
    };
    let read = session.read(&mut recording, args.strict);
    let tally = session.tally;
    let file = session.file.clone();
    let (is_bad, closed) = session.close(&recording);
    note_the_rest(&file, recording.notes());
    if tally.bad_lines > 0 {
        let what = count(tally.bad_lines, recording.format().entry());
        output::warn(format_args!("{file}: {what} could not be read"));
    }
    match (read, closed) {
        // Standard output that fails once fails twice, and is one failure.
        (Err(failure @ (Failure::Usage(_) | Failure::Refused(_) | Failure::Transport(_))), Err(another))
            if another.exit() != Exit::Done =>
        {
            output::error(another);
            return Err(failure);
        }
        (read, closed) => read.and(closed)?,
    }
    match tally {
        Tally { frames: 0, .. } => output::note(format_args!("{file}: no frames")),
        Tally { shown: 0, frames, .. } => {
            output::note(format_args!("{file}: no frame of {frames} passed the filters"));
        }
        _ => {}
    }
    let is_bad = is_bad.unwrap_or(tally.bad_lines + tally.problems > 0);
    Ok(if is_bad { Exit::Findings } else { Exit::Done })
}

/// What the reader should know besides the frames.
fn note_the_rest(file: &str, notes: Notes) {
    let Notes { dropped, foreign } = notes;
    if dropped > 0 {
        let frames = if dropped == 1 { "frame was" } else { "frames were" };
        output::note(format_args!("{file}: {dropped} {frames} lost when it was recorded, as it says itself"));
    }
    if foreign > 0 {
        let packets = if foreign == 1 { "packet is" } else { "packets are" };
        output::note(format_args!("{file}: {foreign} {packets} of other interfaces than CAN, and left out"));
    }
}

/// Refuses what the command line allows but cannot be done.
fn check(args: &DecodeArgs, json: bool) -> Result<(), Failure> {
    check_protocol(args)?;
    at_most_one(args.eds.iter().map(|eds| &*eds.path).chain([&*args.file]))?;
    if let (Some(from), Some(to)) = (args.from, args.to)
        && from > to
    {
        return Err(Failure::Usage(format!("--from {from} is after --to {to}: no frame can be shown")));
    }
    check_words(args, json)?;
    if args.scanlist && (json || args.is_record_on_stdout()) {
        return Err(Failure::Usage(
            "a scan list is TOML on standard output: leave --json and `--record -` out".to_owned(),
        ));
    }
    if args.is_record_on_stdout() && (json || args.summary) {
        let other = if json { "--json" } else { "--summary" };
        return Err(Failure::Usage(format!(
            "{other} and `--record -` both want standard output: record into a file, or leave {other} out"
        )));
    }
    Ok(())
}

/// Refuses what the other protocol has.
fn check_protocol(args: &DecodeArgs) -> Result<(), Failure> {
    if let (Protocol::Devicenet, Some(mac @ 64..)) = (args.protocol, args.mac) {
        return Err(Failure::Usage(format!("--mac {mac}: a MAC ID of DeviceNet is 0 to 63")));
    }
    let of_devicenet =
        [("--scanlist", args.scanlist), ("--expect", args.expect.is_some()), ("--eds", !args.eds.is_empty())];
    match of_devicenet.into_iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) if Spoken::of(args) == Some(Spoken::DeviceNex) => {
            Err(Failure::Usage(format!("{option} is for DeviceNet, and the frames are to be DeviceNeX")))
        }
        _ => Ok(()),
    }
}

/// Refuses an option that could change nothing.
fn check_words(args: &DecodeArgs, json: bool) -> Result<(), Failure> {
    if args.bit_rate.is_some() && !args.summary {
        return Err(Failure::Usage(
            "--bit-rate is for the bus load of a summary: add --summary, or leave it out".to_owned(),
        ));
    }
    let without_lines = [
        (args.summary, "--summary"),
        (args.scanlist, "--scanlist"),
        (json, "--json"),
        (args.is_record_on_stdout(), "`--record -`"),
    ];
    match without_lines.into_iter().find(|(is_wanted, _)| *is_wanted) {
        Some((_, other)) if args.time.is_some() => Err(Failure::Usage(format!(
            "--time is for the lines of the text, and {other} prints none: leave one of them out"
        ))),
        _ => Ok(()),
    }
}

/// A recording on its way to where it is wanted.
struct Session {
    file: String,
    output: Rc<RefCell<Output>>,
    decoder: Decoder,
    progress: Progress,
    copy: Option<Copy>,
    /// As long as it is not clear which protocol is spoken.
    ear: Option<Ear>,
    tally: Tally,
}

/// What there was in a recording.
#[derive(Clone, Copy, Default)]
struct Tally {
    frames: u64,
    /// Of them, those that passed the filters.
    shown: u64,
    /// Of those, the ones with a problem.
    problems: u64,
    bad_lines: u64,
}

impl Session {
    fn read(&mut self, recording: &mut Recording, strict: bool) -> Result<(), Failure> {
        let read = self.entries(recording, strict);
        // What was held back comes before what has ended it.
        let rest = match self.ear.take() {
            Some(ear) => {
                let guess = ear.guess();
                self.decide(recording, ear.decided(guess))
            }
            None => Ok(()),
        };
        read.and(rest)
    }

    fn entries(&mut self, recording: &mut Recording, strict: bool) -> Result<(), Failure> {
        while let Some(entry) = recording.next() {
            match entry {
                Ok(frame) => match &mut self.ear {
                    None => self.frame(recording, &frame)?,
                    Some(ear) => {
                        if let Some(decision) = ear.hear(frame)
                            && let Some(ear) = self.ear.take()
                        {
                            self.decide(recording, ear.decided(decision))?;
                        }
                    }
                },
                Err(error) if error.is_fatal() || strict => return Err(unreadable(&self.file, error)),
                Err(error) => {
                    // The message comes after the frames before it.
                    let written = self.output.borrow_mut().flush();
                    self.written(written)?;
                    self.tally.bad_lines += 1;
                    self.progress.suspend(|| output::warn(format_args!("{}:{error}", self.file)));
                }
            }
        }
        Ok(())
    }

    /// Tells which protocol the recording is taken for, where that is not what most are, and decodes what was held back.
    fn decide(&mut self, recording: &Recording, heard: Heard) -> Result<(), Failure> {
        let Heard { spoken, why, held } = heard;
        self.decoder.speak(spoken);
        if spoken == Spoken::DeviceNex {
            self.told(format_args!("decoded as {spoken}: {why}"));
        } else if why == Why::Identifiers && held.iter().any(is_extended) {
            self.told(format_args!(
                "decoded as {spoken}: nothing in the first frames tells; `--protocol devicenex` is the other"
            ));
        }
        held.iter().try_for_each(|frame| self.frame(recording, frame))
    }

    fn told(&self, words: fmt::Arguments<'_>) {
        self.progress.suspend(|| output::note(format_args!("{}: {words}", self.file)));
    }

    #[inline]
    fn frame(&mut self, recording: &Recording, frame: &RecordedFrame) -> Result<(), Failure> {
        self.progress.advance(frame.n);
        self.tally.frames = frame.n;
        let mut output = self.output.borrow_mut();
        match self.decoder.frame(&mut output.buffer, frame, recording.channels()) {
            Verdict::Hidden => return Ok(()),
            Verdict::Fine => {}
            Verdict::Problem => self.tally.problems += 1,
        }
        self.tally.shown += 1;
        let written = output.line_done();
        drop(output);
        if let Err(error) = written {
            self.written(Err(error))?;
        }
        match &mut self.copy {
            Some(copy) => copy.write(recording, frame).inspect_err(|_| self.copy = None),
            None => Ok(()),
        }
    }

    /// Shows what was still to be shown, however reading has ended, and tells whether the summary says that something is wrong.
    fn close(mut self, recording: &Recording) -> (Option<bool>, Result<(), Failure>) {
        let mut output = self.output.borrow_mut();
        self.decoder.finish(&mut output.buffer, recording.channels(), &self.file, self.tally.bad_lines);
        let is_bad = self.decoder.is_bad();
        let written = output.flush();
        drop(output);
        self.progress.finish();
        self.decoder.note_unused_sheets();
        let written = self.written(written);
        let copied = self.copy.take().map_or(Ok(()), Copy::finish);
        (is_bad, written.and(copied))
    }

    /// Whoever closes the pipe that the words go to does not want more of them, but the copy is to be complete.
    #[cold]
    fn written(&mut self, result: io::Result<()>) -> Result<(), Failure> {
        match result {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe && self.copy.is_some() => {
                self.decoder.silence();
                Ok(())
            }
            result => Ok(result?),
        }
    }
}

fn is_extended(frame: &RecordedFrame) -> bool {
    matches!(&frame.content, Content::Classic(classic) if classic.is_extended())
}

/// `file:12:8: ...` with a place in the file, `file: ...` without.
fn unreadable(file: &str, error: RecordingError) -> Failure {
    let separator = if error.is_fatal() { ": " } else { ":" };
    Failure::Usage(format!("{file}{separator}{error}"))
}
