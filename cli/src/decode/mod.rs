//! `devicenet decode`: a recording, frame by frame, in words or as JSON.

mod buses;
mod check;
mod clock;
mod copy;
mod decoder;
mod ethernet;
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
pub use ethernet::Decoder as EthernetDecoder;
pub use protocol::Spoken;
pub use sheets::Sheets;

use core::fmt;

use std::cell::RefCell;
use std::io;
use std::rc::Rc;

use crate::args::DecodeArgs;
use crate::exit::{Exit, Failure};
use crate::health;
use crate::output::{self, Attentive, Output};
use crate::recording::{Content, Format, Network, Notes, Opened, RecordedFrame, Recording, RecordingError};
use crate::standard::{is_standard, shown};
use crate::text::count;
use check::{check, check_can, network};
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
    let expected = args.expect.as_deref().map(health::expected).transpose()?;
    let file = shown(&args.file, "<stdin>");
    let output = Rc::new(RefCell::new(Output::new()));
    let network = network(args);
    let opened = match is_standard(&args.file) {
        true => Opened::from_reader(Attentive::new(Rc::clone(&output)), network),
        false => Opened::open(&args.file, network),
    };
    match opened.map_err(|error| unreadable(&file, error))? {
        Opened::Can(recording) => {
            check_can(args)?;
            let decoder = Decoder::new(args, json, output.borrow().is_coloured())
                .with_sheets(sheets)
                .with_expected(expected);
            can(args, recording, decoder, output, file)
        }
        Opened::Ethernet(capture) => ethernet::run(args, json, capture, output, file),
    }
}

fn can(
    args: &DecodeArgs,
    mut recording: Recording,
    decoder: Decoder,
    output: Rc<RefCell<Output>>,
    file: String,
) -> Result<Exit, Failure> {
    let copy = args.record.as_deref().map(|path| Copy::create(path, &args.file)).transpose()?;
    let progress = Progress::new(args, &output.borrow());
    let mut session = Session {
        decoder,
        progress,
        output,
        copy,
        file,
        ear: Spoken::of(args).is_none().then(|| Ear::new(is_standard(&args.file))),
        tally: Tally::default(),
    };
    let read = session.read(&mut recording, args.strict);
    let tally = session.tally;
    let file = session.file.clone();
    let (is_bad, closed) = session.close(&recording);
    tally.conclude(&file, recording.format(), (recording.notes(), Network::Can), (read, closed), is_bad)
}

/// What the reader should know besides the frames.
pub(crate) fn note_the_rest(file: &str, notes: Notes, network: Network) {
    let Notes { dropped, foreign } = notes;
    let (network, other) = match network {
        Network::Can => ("CAN", "`devicenet decode --protocol powerlink` reads those of Ethernet"),
        Network::Ethernet => ("Ethernet", "`devicenet decode --protocol devicenet` reads those of CAN"),
    };
    if dropped > 0 {
        let frames = if dropped == 1 { "frame was" } else { "frames were" };
        output::note(format_args!("{file}: {dropped} {frames} lost when it was recorded, as it says itself"));
    }
    if foreign > 0 {
        let packets = if foreign == 1 { "packet is" } else { "packets are" };
        output::note(format_args!(
            "{file}: {foreign} {packets} of other interfaces than {network}, and left out; {other}"
        ));
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

impl Tally {
    /// Tells what the frames have not, and how it has ended. `is_bad` is what a summary says.
    fn conclude(
        self,
        file: &str,
        format: Format,
        (notes, network): (Notes, Network),
        (read, closed): (Result<(), Failure>, Result<(), Failure>),
        is_bad: Option<bool>,
    ) -> Result<Exit, Failure> {
        note_the_rest(file, notes, network);
        if self.bad_lines > 0 {
            let what = count(self.bad_lines, format.entry());
            output::warn(format_args!("{file}: {what} could not be read"));
        }
        match (read, closed) {
            // Standard output that fails once fails twice, and is one failure.
            (
                Err(failure @ (Failure::Usage(_) | Failure::Refused(_) | Failure::Transport(_))),
                Err(another),
            ) if another.exit() != Exit::Done => {
                output::error(another);
                return Err(failure);
            }
            (read, closed) => read.and(closed)?,
        }
        match self {
            Self { frames: 0, .. } => output::note(format_args!("{file}: no frames")),
            Self { shown: 0, frames, .. } => {
                output::note(format_args!("{file}: no frame of {frames} passed the filters"));
            }
            _ => {}
        }
        let is_bad = is_bad.unwrap_or(self.bad_lines + self.problems > 0);
        Ok(if is_bad { Exit::Findings } else { Exit::Done })
    }
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
        let refused = self.decoder.doubt_bit_rate(recording.channels(), &self.file);
        if refused.is_ok() {
            self.decoder.finish(&mut output.buffer, recording.channels(), &self.file, self.tally.bad_lines);
        }
        let is_bad = self.decoder.is_bad();
        let written = output.flush();
        drop(output);
        self.progress.finish();
        self.decoder.note_unused_sheets();
        let written = self.written(written);
        let copied = self.copy.take().map_or(Ok(()), Copy::finish);
        (is_bad, refused.and(written).and(copied))
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
