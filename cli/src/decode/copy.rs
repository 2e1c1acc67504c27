//! The recording that `--record` writes.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use crate::exit::Failure;
use crate::output;
use crate::recording::{RecordedFrame, Recording, Renamed, WriteFormat, Writer};
use crate::standard::{is_standard, shown};

/// A recording being written.
pub(super) struct Copy {
    name: String,
    writer: Writer<BufWriter<Box<dyn Write>>>,
}

impl Copy {
    pub(super) fn create(path: &Path, original: &Path) -> Result<Self, Failure> {
        let name = shown(path, "<stdout>");
        let failed = |error: io::Error| Failure::Usage(format!("{name}: {error}"));
        if !is_standard(path) && is_original(path, original) {
            return Err(Failure::Usage(format!("{name}: is being read, record into another file")));
        }
        let sink: Box<dyn Write> = match is_standard(path) {
            true => Box::new(io::stdout()),
            false => Box::new(File::create(path).map_err(failed)?),
        };
        let writer = Writer::new(BufWriter::new(sink), WriteFormat::of_name(&name)).map_err(failed)?;
        Ok(Self { name, writer })
    }

    pub(super) fn write(&mut self, recording: &Recording, frame: &RecordedFrame) -> Result<(), Failure> {
        // A pcap file does not say which interface it comes from.
        let channel = frame.channel.map_or("can0", |channel| recording.channels().name(channel));
        let written = self.writer.write(frame.at, frame.digits, channel, &frame.content);
        written.map_err(|error| failure(&self.name, error))
    }

    pub(super) fn finish(self) -> Result<(), Failure> {
        for Renamed { name, written } in self.writer.renamed() {
            output::note(format_args!(
                "{}: a name in a candump log is one word, so {name:?} is written as {written:?}",
                self.name
            ));
        }
        self.writer.finish().map_err(|error| failure(&self.name, error))
    }
}

/// Whether two paths are the same file, by whatever name.
#[cfg(unix)]
fn is_original(path: &Path, original: &Path) -> bool {
    use std::os::fd::AsFd as _;
    use std::os::unix::fs::MetadataExt as _;
    // Standard input may be redirected from a file.
    let original = match is_standard(original) {
        true => io::stdin().as_fd().try_clone_to_owned().and_then(|stdin| File::from(stdin).metadata()),
        false => original.metadata(),
    };
    let (Ok(path), Ok(original)) = (path.metadata(), original) else { return false };
    // Not a device: /dev/null can be both.
    path.is_file() && (path.dev(), path.ino()) == (original.dev(), original.ino())
}

/// Whether two paths are the same file.
#[cfg(not(unix))]
fn is_original(path: &Path, original: &Path) -> bool {
    path.canonicalize().is_ok_and(|path| original.canonicalize().is_ok_and(|it| it == path))
}

fn failure(name: &str, error: io::Error) -> Failure {
    match error.kind() {
        io::ErrorKind::BrokenPipe => Failure::Output(error),
        _ => Failure::Usage(format!("{name}: {error}")),
    }
}
