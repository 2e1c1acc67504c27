//! The bus as a recording: frames as they were sent, failed attempts as the error frames of SocketCAN.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use link_core::BusErrorKind;
use link_core::wire::Field;
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
            Outcome::Error(error) => Content::Error(error_frame(error.kind, error.place)),
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

/// What SocketCAN reports of an error on the bus (`linux/can/error.h`): the class, in data byte 2 what was violated, in
/// byte 3 where.
pub(crate) fn error_frame(kind: BusErrorKind, place: Option<(u32, Field)>) -> ErrorFrame {
    let mut data = [0; 8];
    let class = match kind {
        BusErrorKind::Ack => CLASS_ACK | CLASS_BUS_ERROR,
        BusErrorKind::Bit
        | BusErrorKind::Stuff
        | BusErrorKind::Crc
        | BusErrorKind::Form
        | BusErrorKind::Other => CLASS_PROTOCOL | CLASS_BUS_ERROR,
    };
    data[2] = match kind {
        BusErrorKind::Bit => 0x01,
        BusErrorKind::Form => 0x02,
        BusErrorKind::Stuff => 0x04,
        // A CRC error has no bit of its own; its place tells it.
        BusErrorKind::Crc | BusErrorKind::Ack | BusErrorKind::Other => 0x00,
    };
    data[3] = match (kind, place) {
        (BusErrorKind::Crc, _) => 0x08,
        (_, Some((_, field))) => location(field),
        (_, None) => 0x00,
    };
    ErrorFrame { class, data }
}

/// The location codes of Linux; those of the arbitration and control fields are finer than what is known here, so they
/// are unspecified.
const fn location(field: Field) -> u8 {
    match field {
        Field::StartOfFrame => 0x03,
        Field::Arbitration | Field::Control => 0x00,
        Field::Data => 0x0A,
        Field::Crc => 0x08,
        Field::CrcDelimiter => 0x18,
        Field::AckSlot => 0x19,
        Field::AckDelimiter => 0x1B,
        Field::EndOfFrame => 0x1A,
    }
}

const CLASS_PROTOCOL: u32 = 0x008;
const CLASS_ACK: u32 = 0x020;
const CLASS_BUS_ERROR: u32 = 0x080;
/// Nanoseconds: at 1 Mbit/s a bit is 1000 of them, and clocks may be off.
const DIGITS: u8 = 9;
