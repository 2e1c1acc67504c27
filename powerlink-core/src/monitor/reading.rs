//! What a frame means.

use core::time::Duration;

use link_core::Instant;
use link_core::codec::{ParseError, Reader};
use link_core::recording::Answered;

use super::envelope::Ends;
use super::problem::{IDENT_RESPONSE, STATUS_RESPONSE};
use super::{Envelope, Kind, Problem};
use crate::NodeId;
use crate::dictionary::ObjectAddress;
use crate::ethernet::{ETHERNET_HEADER, MAX_FRAME};
use crate::wire::{Body, NmtStateCode, SdoCommandId, ServiceId};

/// A frame as it was captured: from the destination MAC address on, without the CRC.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Captured<'a> {
    /// What was kept of it.
    pub bytes: &'a [u8],
    /// How many bytes it had on the wire.
    pub length: usize,
}

impl<'a> From<&'a [u8]> for Captured<'a> {
    /// A frame that was kept whole.
    fn from(bytes: &'a [u8]) -> Self {
        Self { bytes, length: bytes.len() }
    }
}

/// What a frame is, who has sent it, what it answers, and what is wrong with it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Reading<'a> {
    /// When it was on the wire.
    pub at: Instant,
    /// Its number in the recording.
    pub n: u64,
    /// The frame itself.
    pub frame: Captured<'a>,
    /// What it is.
    pub kind: Kind,
    /// Its addresses, unless it ends in them.
    pub envelope: Option<Envelope>,
    /// The sender.
    pub src: Option<NodeId>,
    /// The receiver.
    pub dst: Option<NodeId>,
    /// The message, if it could be read.
    pub body: Option<Body<'a>>,
    /// On a PRes its PReq, on an IdentResponse and a StatusResponse the SoA that asked for it, on an SDO response its request.
    pub request: Option<Answered>,
    /// On a SoC: since the one before, if none is missing between.
    pub interval: Option<Duration>,
    /// The object that an SDO command is about; that of a response is known from its request.
    pub object: Option<ObjectAddress>,
    /// On the frame that completes an SDO transfer in several parts.
    pub message: Option<Message<'a>>,
    /// What is worth knowing, but no problem.
    pub note: Option<Note>,
    /// What is wrong, or shown to be missing before.
    pub problem: Option<Problem>,
}

/// The data of an SDO transfer in several parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Message<'a> {
    /// What it did.
    pub command: SdoCommandId,
    /// The value, without index and sub-index.
    pub data: &'a [u8],
}

/// What is worth knowing of a frame, but no problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Note {
    /// The capture kept the beginning of the frame only, and not all of its message.
    Cut {
        /// Bytes that were kept.
        kept: usize,
        /// Bytes on the wire.
        length: usize,
    },
    /// It has an earlier time than the frame before it: times across that moment mean nothing.
    ClockBack {
        /// How much earlier.
        by: Duration,
    },
    /// An SDO frame that came before with the same number.
    Repeated,
    /// A transfer in several parts is longer than what the monitor keeps.
    NotStored,
}

impl<'a> Reading<'a> {
    /// What a frame says by itself.
    pub(super) fn parse(at: Instant, n: u64, frame: Captured<'a>) -> Self {
        let mut reading = Self {
            at,
            n,
            frame,
            kind: Kind::Invalid,
            envelope: None,
            src: None,
            dst: None,
            body: None,
            request: None,
            interval: None,
            object: None,
            message: None,
            note: None,
            problem: None,
        };
        if let Err(error) = reading.read() {
            reading.unreadable(error);
        }
        reading
    }

    fn read(&mut self) -> Result<(), ParseError> {
        let mut reader = Reader::new(self.frame.bytes);
        let envelope = Envelope::read(&mut reader)?;
        self.envelope = Some(envelope);
        if !envelope.is_powerlink() {
            self.kind = Kind::Foreign;
            return Ok(());
        }
        let ends = Ends::read(&mut reader)?;
        (self.src, self.dst) = (Some(ends.from), Some(ends.to));
        let told = Kind::told(ends.message_type, reader.peek().first().copied().map(ServiceId));
        let body = Body::read(ends.message_type, &mut reader);
        // What has a length of its own, and what the capture has cut, is what its headers say.
        let is_cut = |error: &ParseError| error.is_short() && self.frame.bytes.len() < self.frame.length;
        let is_told = match (&body, told) {
            (Err(error), _) if is_cut(error) => true,
            (_, Some(Kind::AsndStatusResponse | Kind::AsndIdentResponse)) => true,
            _ => false,
        };
        if let Some(told) = told.filter(|_| is_told) {
            self.kind = told;
        }
        let body = self.body.insert(body?);
        self.kind = Kind::of(body);
        Ok(())
    }

    /// Lengths, the group, and whether it may be sent at all.
    pub(super) fn check_envelope(&mut self, envelope: &Envelope, from: NodeId) {
        let tag = envelope.header_len().saturating_sub(ETHERNET_HEADER);
        let length = self.frame.length.saturating_sub(tag);
        match self.kind {
            _ if length > MAX_FRAME.saturating_add(CRC) => self.flag(Problem::TooLong { length }),
            Kind::AsndStatusResponse if length < STATUS_RESPONSE => {
                self.flag(Problem::StatusResponseShort { length });
            }
            Kind::AsndIdentResponse if length < IDENT_RESPONSE => {
                self.flag(Problem::IdentResponseShort { length });
            }
            _ => {}
        }
        if self.kind.is_of_managing_node() && from != NodeId::MANAGING_NODE {
            self.flag(Problem::NotManagingNode);
        }
        if let Some(expected) = self.kind.group().filter(|group| *group != envelope.destination) {
            self.flag(Problem::WrongGroup { expected });
        }
    }

    /// The state that the sender reports, or the managing node in a SoA.
    #[must_use]
    pub fn state(&self) -> Option<NmtStateCode> {
        match &self.body {
            Some(Body::Pres(pres)) => Some(pres.state),
            Some(Body::Soa(soa)) => Some(soa.state),
            Some(Body::IdentResponse(ident)) => Some(ident.state),
            Some(Body::StatusResponse(status)) => Some(status.state),
            Some(_) => None,
            None => self.state_of_cut(),
        }
    }

    /// The same of a frame that the capture has cut behind it: it is near the front.
    fn state_of_cut(&self) -> Option<NmtStateCode> {
        let is_cut = matches!(self.note, Some(Note::Cut { .. }));
        let at = match self.kind {
            Kind::Pres | Kind::Soa => 3,
            Kind::AsndIdentResponse | Kind::AsndStatusResponse => 6,
            _ => return None,
        };
        self.payload().get(at).filter(|_| is_cut).copied().map(NmtStateCode)
    }

    /// What the frame carries for an application: process data, or the value of an object.
    #[must_use]
    pub fn value(&self) -> Option<&'a [u8]> {
        match &self.body {
            Some(Body::Preq(preq)) => Some(preq.data),
            Some(Body::Pres(pres)) => Some(pres.data),
            Some(Body::Sdo(sdo)) => {
                let command = sdo.command.filter(|command| !command.is_abort)?;
                match (command.command, command.is_response) {
                    (SdoCommandId::WRITE_BY_INDEX, false) if command.begins() => command.data.get(ADDRESS..),
                    (SdoCommandId::READ_BY_INDEX, false) => None,
                    (SdoCommandId::WRITE_BY_INDEX, true) => None,
                    _ => Some(command.data),
                }
            }
            _ => None,
        }
    }

    /// What is behind the Ethernet headers.
    #[must_use]
    pub fn payload(&self) -> &'a [u8] {
        let headers = self.envelope.map_or(0, |envelope| envelope.header_len());
        self.frame.bytes.get(headers..).unwrap_or_default()
    }

    /// The first problem is the one that is told.
    pub(super) fn flag(&mut self, problem: Problem) {
        self.problem.get_or_insert(problem);
    }

    /// It ends too early, or has a value that cannot be: a problem, unless it is the capture that has cut it. That of a response
    /// with a length of its own is told by that.
    fn unreadable(&mut self, error: ParseError) {
        if self.frame.bytes.len() < self.frame.length && error.is_short() {
            self.note = Some(Note::Cut { kept: self.frame.bytes.len(), length: self.frame.length });
        } else if self.kind == Kind::Invalid {
            self.flag(Problem::Malformed(error));
        }
    }
}

/// That some analysers capture behind a frame; it is read as padding.
const CRC: usize = 4;
/// Index, sub-index and a reserved byte before a value.
pub(super) const ADDRESS: usize = 4;
