//! The bus as a recording: frames as they were sent, failed attempts as the error frames of SocketCAN.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use transport_mock::record::Outcome;

use super::shared::FirstError;
use super::sight::{Nodes, Sight, View};
use crate::recording::{Content, ErrorFrame, WriteFormat, Writer};

/// Records what an attached interface would see.
pub(super) struct RecordView {
    writer: Option<Writer<BufWriter<File>>>,
    error: FirstError,
}

impl RecordView {
    pub(super) fn create(path: &Path, error: FirstError) -> io::Result<Self> {
        let format = WriteFormat::of_name(&path.to_string_lossy());
        let writer = Writer::new(BufWriter::new(File::create(path)?), format)?;
        Ok(Self { writer: Some(writer), error })
    }
}

impl View for RecordView {
    fn see(&mut self, _: &Nodes<'_>, sight: &Sight<'_>) {
        let (Sight::Frame { record, .. }, Some(writer)) = (sight, &mut self.writer) else { return };
        let content = match record.outcome {
            Outcome::Ok => Content::Classic(*record.frame),
            Outcome::Error(error) => Content::Error(ErrorFrame::of_bus_error(error.kind, error.place)),
            Outcome::Abandoned => return,
        };
        // While the bus is cut in two, each part is an interface of its own.
        let channel = format!("sim{}", record.segment);
        self.error.note(writer.write(record.end, DIGITS, &channel, &content));
    }
}

impl Drop for RecordView {
    fn drop(&mut self) {
        if let Some(writer) = self.writer.take() {
            self.error.note(writer.finish());
        }
    }
}

/// Nanoseconds: at 1 Mbit/s a bit is 1000 of them, and clocks may be off.
const DIGITS: u8 = 9;
