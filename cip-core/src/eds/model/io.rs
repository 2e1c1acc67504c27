//! `[IO_Info]`: the I/O connections and what they can carry.

use std::string::String;
use std::vec::Vec;

use super::{Spans, find};
use crate::eds::diagnostic::{Code, Findings};
use crate::eds::document::Document;
use crate::eds::fields::{Entries, FieldReader, Need};
use crate::epath::Epath;
use crate::scan::{IoType, IoTypes};

/// `[IO_Info]`
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct IoInfo {
    /// `Default`: the connections that are used together if nobody chooses.
    pub default: IoTypes,
    /// `PollInfo` and its like.
    pub connections: Vec<IoConnection>,
    /// `InputN`: what the device can produce.
    pub inputs: Vec<IoData>,
    /// `OutputN`: what the device can consume.
    pub outputs: Vec<IoData>,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(in crate::eds) default_spans: Spans,
}

/// A connection that the device supports.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct IoConnection {
    /// Which.
    pub ty: IoType,
    /// Which may be used at the same time.
    pub compatible: IoTypes,
    /// The number of the input that it carries if nobody chooses; `None`: nothing.
    pub input: Option<u16>,
    /// The number of the output that it carries if nobody chooses; `None`: nothing.
    pub output: Option<u16>,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(in crate::eds) spans: Spans,
}

/// Data that a connection can carry.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct IoData {
    /// The number in `InputN` or `OutputN`.
    pub number: u16,
    /// Bytes.
    pub size: u16,
    /// Bits that mean something; 0: all.
    pub significant_bits: u16,
    /// The connections that can carry it.
    pub types: IoTypes,
    /// The name.
    pub name: String,
    /// The packed path to it; empty if the device has no choice.
    #[cfg_attr(feature = "serde", serde(serialize_with = "super::serialize_path"))]
    pub path: Vec<u8>,
    /// What it is.
    pub help: String,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(in crate::eds) spans: Spans,
}

impl IoInfo {
    /// The connection of this kind, if the device supports it.
    #[must_use]
    pub fn connection(&self, ty: IoType) -> Option<&IoConnection> {
        self.connections.iter().find(|connection| connection.ty == ty)
    }

    /// `InputN` of this number.
    #[must_use]
    pub fn input(&self, number: u16) -> Option<&IoData> {
        find(&self.inputs, number, |data| data.number)
    }

    /// `OutputN` of this number.
    #[must_use]
    pub fn output(&self, number: u16) -> Option<&IoData> {
        find(&self.outputs, number, |data| data.number)
    }
}

impl IoData {
    /// The path.
    #[must_use]
    pub fn epath(&self) -> Epath<'_> {
        Epath::packed(&self.path)
    }
}

/// The keyword of a connection.
pub(in crate::eds) const fn keyword(ty: IoType) -> &'static str {
    match ty {
        IoType::Poll => "PollInfo",
        IoType::BitStrobe => "StrobeInfo",
        IoType::ChangeOfState => "COSInfo",
        IoType::Cyclic => "CyclicInfo",
        IoType::MulticastPoll => "MPollInfo",
    }
}

pub(super) fn read(document: &Document, findings: &mut Findings) -> Option<IoInfo> {
    let entries = Entries::of(document, "IO_Info");
    entries.header()?;
    let mut info = IoInfo::default();
    if let Some(entry) = entries.require("Default", findings) {
        let mut fields = FieldReader::new(entry, findings);
        info.default = types(&mut fields, "the default I/O type mask", Need::Required);
        fields.finish();
        info.default_spans = Spans::of(entry);
    }
    for ty in IoType::ALL {
        let Some(entry) = entries.find(keyword(ty)) else { continue };
        let mut fields = FieldReader::new(entry, findings);
        info.connections.push(IoConnection {
            ty,
            compatible: types(&mut fields, "the compatible I/O type mask", Need::Required),
            input: fields.number("the default input", Need::Required).filter(|&number| number != 0),
            output: fields.number("the default output", Need::Required).filter(|&number| number != 0),
            spans: Spans::of(entry),
        });
        fields.finish();
    }
    info.inputs = read_data(&entries, "Input", findings);
    info.outputs = read_data(&entries, "Output", findings);
    Some(info)
}

fn read_data(entries: &Entries<'_>, stem: &str, findings: &mut Findings) -> Vec<IoData> {
    let read = |(number, entry)| {
        let mut fields = FieldReader::new(entry, findings);
        let data = IoData {
            number,
            size: fields.number("the size in bytes", Need::Required).unwrap_or(0),
            significant_bits: fields.number("the number of significant bits", Need::Optional).unwrap_or(0),
            types: types(&mut fields, "the compatible I/O type mask", Need::Required),
            name: fields.string("the name", Need::Required).unwrap_or_default(),
            path: fields.sized_path(),
            help: fields.string("the help text", Need::Optional).unwrap_or_default(),
            spans: Spans::of(entry),
        };
        fields.finish();
        data
    };
    entries.numbered(stem).into_iter().map(read).collect()
}

fn types(fields: &mut FieldReader<'_, '_>, what: &str, need: Need) -> IoTypes {
    let bits = fields.number(what, need).unwrap_or(0);
    let types = IoTypes::from_bits_retain(bits);
    let reserved = types.difference(IoTypes::all());
    if !reserved.is_empty() {
        let span = fields.last_span();
        let message = format_args!(
            "{what} is 0x{bits:04X}; bits 5 to 15 are reserved, clear 0x{:04X}",
            reserved.bits()
        );
        fields.findings.add(Code::Reserved, span, message);
    }
    types.intersection(IoTypes::all())
}
