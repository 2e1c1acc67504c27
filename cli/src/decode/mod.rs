//! `devicenet decode`: a recording, frame by frame, in words or as JSON.

mod decoder;
mod json;
mod outside;
mod progress;
mod summary;

pub use decoder::{Decoder, Verdict};

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use crate::args::DecodeArgs;
use crate::exit::{Exit, Failure};
use crate::output::{self, Output};
use crate::recording::{RecordedFrame, Recording, RecordingError, WriteFormat, Writer};
use progress::Progress;

/// Decodes a recording.
///
/// # Errors
/// [`Failure`] when the recording cannot be read to its end, with `--strict` also when a line is bad.
pub fn run(args: &DecodeArgs, json: bool) -> Result<Exit, Failure> {
    let file = &args.file;
    let unreadable = |error: &dyn core::fmt::Display| Failure::Usage(format!("{}: {error}", shown(file)));
    let mut recording = Recording::open(file).map_err(|error| unreadable(&error))?;
    let mut output = Output::new();
    let mut progress = Progress::new(file, &output);
    let mut decoder = Decoder::new(args, json, output.is_coloured());
    let mut copy = args.record.as_deref().map(Copy::create).transpose()?;
    let is_live = file.as_os_str() == "-";
    let mut bad_lines = 0u64;
    let mut problems = 0u64;
    loop {
        if is_live && !recording.is_next_line_here() {
            output.flush()?;
        }
        let frame = match recording.next() {
            None => break,
            Some(Ok(frame)) => frame,
            Some(Err(error)) if error.is_fatal() || args.strict => {
                output.flush()?;
                progress.finish();
                return Err(match error {
                    RecordingError::Bad(bad) => Failure::Usage(format!("{}:{bad}", shown(file))),
                    error => unreadable(&error),
                });
            }
            Some(Err(error)) => {
                bad_lines += 1;
                output.flush()?;
                progress.suspend(|| output::warn(format_args!("{}:{error}", shown(file))));
                continue;
            }
        };
        progress.advance(frame.n);
        match decoder.frame(&mut output.buffer, &frame, recording.channels()) {
            Verdict::Hidden => continue,
            Verdict::Fine => {}
            Verdict::Problem => problems += 1,
        }
        output.line_done()?;
        if let Some(copy) = &mut copy {
            copy.write(&recording, &frame)?;
        }
    }
    decoder.finish(&mut output.buffer, recording.channels(), &shown(file));
    output.flush()?;
    progress.finish();
    if let Some(copy) = copy {
        copy.finish()?;
    }
    if bad_lines > 0 {
        let lines = if bad_lines == 1 { "line" } else { "lines" };
        output::warn(format_args!("{}: {bad_lines} {lines} could not be read", shown(file)));
    }
    Ok(if bad_lines + problems > 0 { Exit::Findings } else { Exit::Done })
}

/// The recording that `--record` writes.
struct Copy<'a> {
    path: &'a Path,
    writer: Writer<BufWriter<File>>,
}

impl<'a> Copy<'a> {
    fn create(path: &'a Path) -> Result<Self, Failure> {
        let format = WriteFormat::of_name(&path.to_string_lossy());
        let writer = File::create(path).and_then(|file| Writer::new(BufWriter::new(file), format));
        let writer = writer.map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
        Ok(Self { path, writer })
    }

    fn write(&mut self, recording: &Recording, frame: &RecordedFrame) -> Result<(), Failure> {
        // A pcap file does not say which interface it comes from.
        let channel = frame.channel.map_or("can0", |channel| recording.channels().name(channel));
        let written = self.writer.write(frame.at, frame.digits, channel, &frame.content);
        written.map_err(|error| Failure::Usage(format!("{}: {error}", self.path.display())))
    }

    fn finish(self) -> Result<(), Failure> {
        let path = self.path;
        self.writer.finish().map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))
    }
}

/// A path in messages.
fn shown(path: &Path) -> String {
    match path.as_os_str() == "-" {
        true => "standard input".to_owned(),
        false => path.display().to_string(),
    }
}
