//! `devicenet decode`: a recording, frame by frame, in words or as JSON.

mod decoder;
mod json;
mod outside;
mod progress;
mod summary;

pub use decoder::{Decoder, Verdict};

use std::cell::RefCell;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::rc::Rc;

use crate::args::DecodeArgs;
use crate::exit::{Exit, Failure};
use crate::output::{self, Attentive, Output};
use crate::recording::{Notes, RecordedFrame, Recording, RecordingError, Renamed, WriteFormat, Writer};
use progress::Progress;

/// Decodes a recording.
///
/// # Errors
/// [`Failure`] when the recording cannot be read to its end, with `--strict` also when a line is bad.
pub fn run(args: &DecodeArgs, json: bool) -> Result<Exit, Failure> {
    if args.is_record_on_stdout() && (json || args.summary) {
        let other = if json { "--json" } else { "--summary" };
        return Err(Failure::Usage(format!(
            "{other} and `--record -` both want standard output: record into a file, or leave {other} out"
        )));
    }
    let file = shown(&args.file, "<stdin>");
    let unreadable = |error: RecordingError| {
        let separator = if error.is_fatal() { ": " } else { ":" };
        Failure::Usage(format!("{file}{separator}{error}"))
    };
    let output = Rc::new(RefCell::new(Output::new()));
    let recording = match is_standard(&args.file) {
        true => Recording::from_reader(Attentive::new(Rc::clone(&output))),
        false => Recording::open(&args.file),
    };
    let mut recording = recording.map_err(unreadable)?;
    let mut copy = args.record.as_deref().map(|path| Copy::create(path, &args.file)).transpose()?;
    let mut progress = Progress::new(&args.file, &output.borrow());
    let mut decoder = Decoder::new(args, json, output.borrow().is_coloured());
    let (mut frames, mut shown_frames, mut bad_lines, mut problems) = (0u64, 0u64, 0u64, 0u64);
    while let Some(entry) = recording.next() {
        let mut output = output.borrow_mut();
        let frame = match entry {
            Ok(frame) => frame,
            Err(error) => {
                output.flush()?;
                if error.is_fatal() || args.strict {
                    progress.finish();
                    return Err(unreadable(error));
                }
                bad_lines += 1;
                progress.suspend(|| output::warn(format_args!("{file}:{error}")));
                continue;
            }
        };
        progress.advance(frame.n);
        frames = frame.n;
        match decoder.frame(&mut output.buffer, &frame, recording.channels()) {
            Verdict::Hidden => continue,
            Verdict::Fine => {}
            Verdict::Problem => problems += 1,
        }
        shown_frames += 1;
        output.line_done()?;
        if let Some(copy) = &mut copy {
            copy.write(&recording, &frame)?;
        }
    }
    let mut output = output.borrow_mut();
    decoder.finish(&mut output.buffer, recording.channels(), &file);
    output.flush()?;
    progress.finish();
    if let Some(copy) = copy {
        copy.finish()?;
    }
    note_the_rest(&file, recording.notes());
    if bad_lines > 0 {
        let lines = if bad_lines == 1 { "line" } else { "lines" };
        output::warn(format_args!("{file}: {bad_lines} {lines} could not be read"));
    }
    match (frames, shown_frames) {
        (0, _) => output::note(format_args!("{file}: no frames")),
        (_, 0) => output::note(format_args!("{file}: no frame of {frames} passed the filters")),
        _ => {}
    }
    Ok(if bad_lines + problems > 0 { Exit::Findings } else { Exit::Done })
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

/// The recording that `--record` writes.
struct Copy {
    name: String,
    writer: Writer<BufWriter<Box<dyn Write>>>,
}

impl Copy {
    fn create(path: &Path, original: &Path) -> Result<Self, Failure> {
        let name = shown(path, "<stdout>");
        let failed = |error: io::Error| Failure::Usage(format!("{name}: {error}"));
        let is_original =
            path.canonicalize().is_ok_and(|path| original.canonicalize().is_ok_and(|it| it == path));
        if is_original {
            return Err(Failure::Usage(format!("{name}: is being read, record into another file")));
        }
        let sink: Box<dyn Write> = match is_standard(path) {
            true => Box::new(io::stdout()),
            false => Box::new(File::create(path).map_err(failed)?),
        };
        let writer = Writer::new(BufWriter::new(sink), WriteFormat::of_name(&name)).map_err(failed)?;
        Ok(Self { name, writer })
    }

    fn write(&mut self, recording: &Recording, frame: &RecordedFrame) -> Result<(), Failure> {
        // A pcap file does not say which interface it comes from.
        let channel = frame.channel.map_or("can0", |channel| recording.channels().name(channel));
        let written = self.writer.write(frame.at, frame.digits, channel, &frame.content);
        written.map_err(|error| failure(&self.name, error))
    }

    fn finish(self) -> Result<(), Failure> {
        for Renamed { name, written } in self.writer.renamed() {
            output::note(format_args!(
                "{}: a name in a candump log is one word, so {name:?} is written as {written:?}",
                self.name
            ));
        }
        self.writer.finish().map_err(|error| failure(&self.name, error))
    }
}

fn failure(name: &str, error: io::Error) -> Failure {
    match error.kind() {
        io::ErrorKind::BrokenPipe => Failure::Output(error),
        _ => Failure::Usage(format!("{name}: {error}")),
    }
}

/// Whether a path means standard input or output.
fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// A path in messages.
fn shown(path: &Path, standard: &str) -> String {
    match is_standard(path) {
        true => standard.to_owned(),
        false => path.display().to_string(),
    }
}
