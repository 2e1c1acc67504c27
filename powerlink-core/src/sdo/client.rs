//! The client: one connection to one server at a time, and one transfer on it.
//!
//! ```text
//! client                        server
//! InitReq   rcon 0 scon 1 --->
//!                         <---  InitAck  rcon 1 scon 1
//! InitResp  rcon 1 scon 2 --->
//!                         <---  Valid    rcon 2 scon 2
//! command   rcon 2 scon 2 --->
//!                         <---  response rcon 2 scon 2
//! ```

use link_core::codec::{Full, Wire, Writer};

use super::outgoing::Outgoing;
use crate::NodeId;
use crate::dictionary::ObjectAddress;
use crate::wire::{
    AbortCode, Con, InitiateSize, Sdo, SdoCommand, SdoCommandId, SdoSequence, Segmentation, SequenceHalf,
};

/// A client with a buffer for one value, and for the address of its object.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Client<const SDO: usize> {
    server: NodeId,
    phase: Phase,
    due: Option<Control>,
    /// The last good number of the server.
    received: u8,
    /// The last own number.
    sent: u8,
    /// Frames sent again without any progress.
    retries: u8,
    /// How often the connection was opened again for the transfer, whatever was acknowledged meanwhile.
    reopened: u8,
    /// The last transaction.
    transaction: u8,
    job: Option<Job>,
    buffer: [u8; SDO],
}

/// How far the connection is.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Phase {
    Closed,
    /// InitReq is sent.
    Opening,
    /// InitResp is sent.
    Confirming,
    Open,
}

/// Frames without a command.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Control {
    InitReq,
    InitResp,
    Acknowledge,
    /// An acknowledge is wanted in return.
    Ask,
    /// A frame of the server is missing.
    Retransmission,
}

/// A transfer.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
struct Job {
    /// The value to be written follows its address in the buffer.
    command: SdoCommandId,
    /// Bytes of the request.
    len: usize,
    /// The most data in a frame.
    segment: usize,
    state: JobState,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum JobState {
    /// There is no connection yet.
    Waiting,
    Requesting(Outgoing),
    /// Parts of the response are in the buffer.
    Receiving {
        total: usize,
        len: usize,
    },
}

/// What a frame, or a time-out, led to.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Progress {
    /// It goes on.
    Nothing,
    /// It is of no connection, or out of order.
    Ignored,
    /// The transfer is over: the length of what was read, 0 for a write, or why it failed.
    Done(Result<usize, AbortCode>),
}

impl<const SDO: usize> Client<SDO> {
    pub(crate) const fn new() -> Self {
        const { assert!(SDO >= 16, "a value of up to 8 bytes needs its address as well") };
        Self {
            server: NodeId::NONE,
            phase: Phase::Closed,
            due: None,
            received: 0,
            sent: 0,
            retries: 0,
            reopened: 0,
            transaction: 0,
            job: None,
            buffer: [0; SDO],
        }
    }

    /// Whether no transfer is under way.
    pub(crate) const fn is_idle(&self) -> bool {
        self.job.is_none()
    }

    /// The other side.
    pub(crate) const fn server(&self) -> NodeId {
        self.server
    }

    /// Begins to write a value. `segment` is the most data in a frame.
    pub(crate) fn write(&mut self, server: NodeId, at: ObjectAddress, value: &[u8], segment: usize) {
        let len = self.put(at, value);
        self.begin(server, SdoCommandId::WRITE_BY_INDEX, len, segment);
    }

    /// Begins to read a value.
    pub(crate) fn read(&mut self, server: NodeId, at: ObjectAddress, segment: usize) {
        let len = self.put(at, &[]);
        self.begin(server, SdoCommandId::READ_BY_INDEX, len, segment);
    }

    /// What was read.
    pub(crate) fn value(&self, len: usize) -> &[u8] {
        self.buffer.get(..len).unwrap_or_default()
    }

    /// The server is gone: nothing is said to it.
    pub(crate) const fn forget(&mut self) {
        (self.phase, self.due, self.job) = (Phase::Closed, None, None);
    }

    /// Whether there is a frame to be sent.
    pub(crate) fn has_frame(&self) -> bool {
        self.due.is_some() || self.outgoing().is_some_and(|outgoing| outgoing.ready() > 0)
    }

    /// Whether the server is to say something, and nothing is to be sent before.
    pub(crate) fn is_waiting(&self) -> bool {
        self.job.is_some() && !self.has_frame()
    }

    /// Writes the next frame from the sequence layer on. Returns whether there was one.
    pub(crate) fn emit(&mut self, initiate: InitiateSize, out: &mut Writer<'_>) -> Result<bool, Full> {
        if let Some(control) = self.due.take() {
            let (receive, send) = match control {
                Control::InitReq => (Con::None, Con::Initialisation),
                Control::InitResp => (Con::Initialisation, Con::Valid),
                Control::Acknowledge => (Con::Valid, Con::Valid),
                Control::Ask => (Con::Valid, Con::Request),
                Control::Retransmission => (Con::Request, Con::Valid),
            };
            self.sequence(receive, self.sent, send).emit(out)?;
            return Ok(true);
        }
        let (received, transaction) = (self.received, self.transaction);
        let Some(Job { command, state: JobState::Requesting(outgoing), .. }) = &mut self.job else {
            return Ok(false);
        };
        if outgoing.ready() == 0 {
            return Ok(false);
        }
        let (number, wants_acknowledge, segmentation, range) = outgoing.take();
        let connection = if wants_acknowledge { Con::Request } else { Con::Valid };
        let (receive, send) =
            (SequenceHalf::new(received, Con::Valid), SequenceHalf::new(number, connection));
        SdoSequence { receive, send }.emit(out)?;
        let data = self.buffer.get(range).unwrap_or_default();
        SdoCommand { segmentation, ..SdoCommand::request(transaction, *command, data) }
            .emit_as(out, initiate)?;
        self.sent = number;
        Ok(true)
    }

    /// Takes a frame of the server.
    pub(crate) fn receive(&mut self, from: NodeId, sdo: &Sdo<'_>) -> Progress {
        if from != self.server {
            return Progress::Ignored;
        }
        let (receive, send) = (sdo.sequence.receive, sdo.sequence.send);
        match (self.phase, receive.connection, send.connection) {
            (Phase::Opening, Con::Initialisation, Con::Initialisation) => {
                (self.phase, self.received) = (Phase::Confirming, send.number);
                self.due = Some(Control::InitResp);
                Progress::Nothing
            }
            (Phase::Confirming, Con::Valid, Con::Valid | Con::Request) => {
                // Not before a command is answered is it of any use.
                (self.phase, self.received) = (Phase::Open, send.number);
                self.request();
                Progress::Nothing
            }
            (Phase::Opening | Phase::Confirming | Phase::Open, Con::None, Con::None) => {
                self.phase = Phase::Closed;
                self.again()
            }
            (Phase::Open, Con::Valid | Con::Request, Con::Valid | Con::Request) => {
                self.acknowledged(receive);
                self.order(send, sdo.command.as_ref())
            }
            (Phase::Closed | Phase::Opening | Phase::Confirming | Phase::Open, ..) => Progress::Ignored,
        }
    }

    /// Nothing was heard for too long.
    pub(crate) fn expired(&mut self) -> Progress {
        if self.job.is_none() {
            self.forget();
            return Progress::Nothing;
        }
        // The server may have closed a connection that was idle for long, without a word.
        if self.phase != Phase::Open || self.retries > 0 {
            return self.again();
        }
        self.retries = 1;
        match self.job.as_mut().map(|job| &mut job.state) {
            Some(JobState::Requesting(outgoing)) if outgoing.is_unacknowledged() => outgoing.repeat(true),
            _ => self.due = Some(Control::Ask),
        }
        Progress::Nothing
    }

    fn put(&mut self, at: ObjectAddress, value: &[u8]) -> usize {
        let mut out = Writer::new(&mut self.buffer);
        // The owner has seen to it that there is room.
        let written =
            out.u16(at.index).and_then(|()| out.bytes(&[at.sub, 0])).and_then(|()| out.bytes(value));
        debug_assert!(written.is_ok(), "a value of {} bytes does not fit", value.len());
        out.len()
    }

    fn begin(&mut self, server: NodeId, command: SdoCommandId, len: usize, segment: usize) {
        (self.retries, self.reopened) = (0, 0);
        self.transaction = self.transaction.wrapping_add(1);
        self.job = Some(Job { command, len, segment, state: JobState::Waiting });
        if server == self.server && self.phase == Phase::Open {
            // The command acknowledges as well.
            self.due = self.due.filter(|due| *due != Control::Acknowledge);
            return self.request();
        }
        self.server = server;
        self.open();
    }

    const fn open(&mut self) {
        (self.phase, self.received, self.sent) = (Phase::Opening, 0, 0);
        self.due = Some(Control::InitReq);
    }

    /// The connection is open: the command may be sent.
    fn request(&mut self) {
        let first = self.sent.wrapping_add(1) & NUMBER;
        let transaction = self.transaction;
        let Some(job) = &mut self.job else { return };
        let command = SdoCommand::request(transaction, job.command, &[]);
        job.state = JobState::Requesting(Outgoing::new(&command, false, job.len, job.segment, first));
    }

    /// Opens the connection again, with the transfer that waits. What was read into the buffer has taken the place of the
    /// request: then it fails.
    fn again(&mut self) -> Progress {
        if self.retries >= MAX_RETRIES || self.reopened >= MAX_RETRIES {
            return self.fail(AbortCode::TIME_OUT);
        }
        self.retries = self.retries.saturating_add(1);
        self.reopened = self.reopened.saturating_add(1);
        match &mut self.job {
            None => self.forget(),
            Some(Job { state: JobState::Receiving { .. }, .. }) => return self.fail(AbortCode::TIME_OUT),
            Some(job) => {
                job.state = JobState::Waiting;
                self.open();
            }
        }
        Progress::Nothing
    }

    fn fail(&mut self, code: AbortCode) -> Progress {
        self.forget();
        Progress::Done(Err(code))
    }

    fn outgoing(&self) -> Option<&Outgoing> {
        match &self.job.as_ref()?.state {
            JobState::Requesting(outgoing) => Some(outgoing),
            JobState::Waiting | JobState::Receiving { .. } => None,
        }
    }

    fn acknowledged(&mut self, receive: SequenceHalf) {
        let Some(Job { state: JobState::Requesting(outgoing), .. }) = &mut self.job else { return };
        if outgoing.acknowledge(receive.number) {
            self.retries = 0;
        }
        if receive.connection == Con::Request && !outgoing.is_done() {
            outgoing.repeat(false);
        }
    }

    fn order(&mut self, send: SequenceHalf, command: Option<&SdoCommand<'_>>) -> Progress {
        let ahead = send.number.wrapping_sub(self.received) & NUMBER;
        if send.connection == Con::Request {
            self.due = Some(Control::Acknowledge);
        }
        match (ahead, command) {
            (1, Some(command)) => {
                self.received = send.number;
                self.retries = 0;
                self.response(command)
            }
            (0 | HALF.., _) => Progress::Nothing,
            // A response is missing: the number of the server is beyond what arrived.
            (_, None | Some(_)) => {
                self.due = Some(Control::Retransmission);
                Progress::Ignored
            }
        }
    }

    fn response(&mut self, command: &SdoCommand<'_>) -> Progress {
        let transaction = self.transaction;
        let Some(job) = &mut self.job else { return Progress::Ignored };
        if !command.is_response || command.transaction != transaction {
            return Progress::Ignored;
        }
        if let Some(code) = command.abort() {
            return self.end(Err(code));
        }
        if job.command != SdoCommandId::READ_BY_INDEX {
            return self.end(Ok(0));
        }
        let (total, len) = match (command.segmentation, job.state) {
            (Segmentation::Expedited, _) => (command.data.len(), 0),
            (Segmentation::Initiate { total }, _) => (usize::try_from(total).unwrap_or(usize::MAX), 0),
            (Segmentation::Segment | Segmentation::Complete, JobState::Receiving { total, len }) => {
                (total, len)
            }
            (Segmentation::Segment | Segmentation::Complete, _) => {
                return self.end(Err(AbortCode::GENERAL));
            }
        };
        let end = len.saturating_add(command.data.len());
        if total > SDO || end > total {
            // The server may go on sending: the connection is of no use.
            return self.fail(AbortCode::OUT_OF_MEMORY);
        }
        if let Some(place) = self.buffer.get_mut(len..end) {
            place.copy_from_slice(command.data);
        }
        job.state = JobState::Receiving { total, len: end };
        match command.segmentation {
            Segmentation::Expedited => self.end(Ok(end)),
            Segmentation::Complete if end == total => self.end(Ok(end)),
            Segmentation::Complete => self.end(Err(AbortCode::LENGTH)),
            Segmentation::Initiate { .. } | Segmentation::Segment => Progress::Nothing,
        }
    }

    /// The transfer is over; the connection stays open.
    const fn end(&mut self, result: Result<usize, AbortCode>) -> Progress {
        self.job = None;
        self.due = Some(Control::Acknowledge);
        Progress::Done(result)
    }

    const fn sequence(&self, receive: Con, number: u8, send: Con) -> SdoSequence {
        SdoSequence {
            receive: SequenceHalf::new(self.received, receive),
            send: SequenceHalf::new(number, send),
        }
    }
}

const NUMBER: u8 = 0x3F;
/// From here on a number is an old one.
const HALF: u8 = 32;
const MAX_RETRIES: u8 = 2;
