//! Readings in words.

use core::fmt::{self, Display as _, Formatter};

use link_core::text::{ByteCount, write_decimal, write_prefixed_hex};

use super::{Kind, Note, Reading};
use crate::NodeId;
use crate::dictionary::{Entry, ObjectAddress, STANDARD_ENTRIES};
use crate::wire::{Body, Con, Sdo, SdoCommand, Segmentation};

/// The words, and after them the problem.
impl fmt::Display for Reading<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.words().fmt(f)?;
        match &self.problem {
            Some(problem) => {
                f.write_str("  ! ")?;
                problem.fmt(f)
            }
            None => Ok(()),
        }
    }
}

/// The words of a reading, without its problem. See [`Reading::words`].
#[derive(Debug, Clone, Copy)]
pub struct Words<'a>(&'a Reading<'a>);

impl Reading<'_> {
    /// The words alone, for an output that shows the problem in its own way.
    #[must_use]
    pub fn words(&self) -> Words<'_> {
        Words(self)
    }

    /// What the object of an SDO command is called, if every node has it.
    #[must_use]
    pub fn object_name(&self) -> Option<&'static str> {
        Entry::find(STANDARD_ENTRIES, self.object?).ok().map(|entry| entry.name)
    }
}

impl fmt::Display for Words<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self(reading) = *self;
        write_ends(f, reading)?;
        match &reading.body {
            Some(Body::Sdo(sdo)) => write_sdo(f, reading, sdo)?,
            Some(body) => body.fmt(f)?,
            None => write_unread(f, reading)?,
        }
        if let Some(note) = reading.note {
            f.write_str(" (")?;
            note.fmt(f)?;
            f.write_str(")")?;
        }
        Ok(())
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cut { kept, length } => write!(f, "cut: the capture has {kept} of its {length} bytes"),
            Self::ClockBack { by } => {
                write!(f, "the clock of the capture goes back by {} us", by.as_micros())
            }
            Self::Repeated => f.write_str("repeated"),
            Self::NotStored => f.write_str("transfer too long for the decoder"),
        }
    }
}

/// `MN -> 1  `; with MAC addresses where there are no node IDs.
fn write_ends(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
    match (reading.src, reading.dst, reading.envelope) {
        (Some(from), Some(to), _) => {
            write_node(f, from)?;
            f.write_str(" -> ")?;
            write_node(f, to)?;
        }
        (_, _, Some(envelope)) => write!(f, "{} -> {}", envelope.source, envelope.destination)?,
        _ => f.write_str("? -> ?")?,
    }
    f.write_str("  ")
}

fn write_node(f: &mut Formatter<'_>, node: NodeId) -> fmt::Result {
    match node {
        NodeId::MANAGING_NODE | NodeId::BROADCAST => node.fmt(f),
        NodeId(number) => write_decimal(f, number.into()),
    }
}

/// `ARP`, `EtherType 0x9000`, `PReq`, and how many bytes there are; the note tells it of a frame that is cut.
fn write_unread(f: &mut Formatter<'_>, reading: &Reading<'_>) -> fmt::Result {
    let mut bytes = reading.payload().len();
    match (reading.kind, reading.envelope) {
        (Kind::Foreign, Some(envelope)) => match envelope.protocol() {
            Some(protocol) => f.write_str(protocol)?,
            None => {
                f.write_str("EtherType ")?;
                write_prefixed_hex(f, envelope.ethertype.into())?;
            }
        },
        (Kind::AsndIdentResponse, _) => f.write_str("IdentResponse")?,
        (Kind::AsndStatusResponse, _) => f.write_str("StatusResponse")?,
        (Kind::AsndNmtRequest, _) => f.write_str("NMTRequest")?,
        (Kind::AsndNmtCommand, _) => f.write_str("NMTCommand")?,
        (Kind::AsndSdo, _) => f.write_str("SDO")?,
        (Kind::Invalid, _) if reading.src.is_some() => f.write_str("POWERLINK")?,
        (Kind::Invalid | Kind::Foreign, _) => {
            bytes = reading.frame.length;
            f.write_str("frame")?;
        }
        (kind, _) => f.write_str(kind.message())?,
    }
    if matches!(reading.note, Some(Note::Cut { .. })) {
        return Ok(());
    }
    f.write_str(", ")?;
    ByteCount(bytes).fmt(f)
}

/// `SDO, rcon=2/0 scon=2/1, WriteByIndex 0x1006/0 NMT_CycleLen_U32, transaction 3, 4 bytes`
fn write_sdo(f: &mut Formatter<'_>, reading: &Reading<'_>, sdo: &Sdo<'_>) -> fmt::Result {
    write!(f, "SDO, {}", sdo.sequence)?;
    let Some(command) = &sdo.command else {
        return f.write_str(match (sdo.sequence.receive.connection, sdo.sequence.send.connection) {
            (Con::None, Con::None) => ", close",
            (Con::None, Con::Initialisation) => ", open",
            (Con::Initialisation, _) => ", opening",
            (Con::Request, _) => ", send again",
            _ => ", acknowledge",
        });
    };
    write!(f, ", {}", command.command)?;
    if command.is_response {
        f.write_str(" response")?;
    }
    if let Some(object) = reading.object {
        write_object(f, object)?;
        if let Some(name) = reading.object_name() {
            f.write_str(" ")?;
            f.write_str(name)?;
        }
    }
    write!(f, ", transaction {}", command.transaction)?;
    write_outcome(f, reading, command)
}

fn write_outcome(f: &mut Formatter<'_>, reading: &Reading<'_>, command: &SdoCommand<'_>) -> fmt::Result {
    if let Some(code) = command.abort() {
        return write!(f, ", abort 0x{:08X}: {code}", code.0);
    }
    match command.segmentation {
        Segmentation::Expedited => {}
        Segmentation::Initiate { total } => write!(f, ", first part of {total} bytes")?,
        Segmentation::Segment => f.write_str(", part")?,
        Segmentation::Complete => f.write_str(", last part")?,
    }
    match reading.value() {
        Some(value) => write!(f, ", {}", ByteCount(value.len()))?,
        None if command.is_response => f.write_str(", ok")?,
        None => {}
    }
    match &reading.message {
        Some(message) => write!(f, ", completes {}", ByteCount(message.data.len())),
        None => Ok(()),
    }
}

/// ` 0x1006/0`
fn write_object(f: &mut Formatter<'_>, at: ObjectAddress) -> fmt::Result {
    write!(f, " 0x{:04X}/{}", at.index, at.sub)
}
