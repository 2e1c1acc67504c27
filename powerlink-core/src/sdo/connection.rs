//! The sequence layer: one client's connection.

use link_core::codec::{Full, Wire, Writer};

use super::outgoing::Outgoing;
use crate::NodeId;
use crate::dictionary::ObjectAddress;
use crate::wire::{Con, InitiateSize, SdoCommand, SdoSequence, SequenceHalf};

/// What the server knows of one client.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Connection<const SDO: usize> {
    pub(super) client: NodeId,
    pub(super) phase: Phase,
    /// A frame of the sequence layer alone is to be sent.
    due: Option<Control>,
    /// The last good number of the client.
    received: u8,
    /// The last number of the server.
    sent: u8,
    /// How often the response was sent again without any progress.
    pub(super) retries: u8,
    pub(super) transfer: Transfer,
    /// The data of the transfer.
    pub(super) buffer: [u8; SDO],
}

/// How far a connection is.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Phase {
    Closed,
    /// The client asked for it.
    Opening,
    Open,
}

/// Frames without a command.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Control {
    /// Initialisation is acknowledged.
    Initialisation,
    /// The connection is valid; or, later, everything up to a number arrived.
    Acknowledge,
    /// A frame is missing.
    Retransmission,
}

/// What is being read or written.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Transfer {
    Idle,
    /// The client writes in several frames.
    Receiving(Incoming),
    /// The response is on its way.
    Sending(Outgoing),
}

/// A write in several frames.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Incoming {
    pub(super) transaction: u8,
    pub(super) at: ObjectAddress,
    /// What the client said that there is.
    pub(super) total: u32,
    /// What is in the buffer.
    pub(super) len: usize,
}

/// What a frame means to its connection.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Sequence {
    /// Nothing beyond the sequence layer.
    Handled,
    /// The connection was opened, or opened anew.
    Opened,
    /// The client closed it, or opens another one in its place.
    Closed,
    /// The next frame in order: its command counts.
    InOrder,
    /// It is out of order, or of no connection.
    Ignored,
}

impl<const SDO: usize> Connection<SDO> {
    pub(super) const fn new() -> Self {
        Self {
            client: NodeId::NONE,
            phase: Phase::Closed,
            due: None,
            received: 0,
            sent: 0,
            retries: 0,
            transfer: Transfer::Idle,
            buffer: [0; SDO],
        }
    }

    pub(super) const fn close(&mut self) {
        self.phase = Phase::Closed;
        self.due = None;
        self.transfer = Transfer::Idle;
    }

    /// Follows the sequence layer of a frame. `begins` says that it asks something of the command layer.
    pub(super) fn receive(&mut self, sequence: SdoSequence, begins: bool) -> Sequence {
        let (receive, send) = (sequence.receive, sequence.send);
        match (self.phase, receive.connection, send.connection) {
            (_, _, Con::Initialisation) => {
                let was_open = self.phase == Phase::Open;
                self.close();
                (self.phase, self.received, self.sent, self.retries) = (Phase::Opening, send.number, 0, 0);
                self.due = Some(Control::Initialisation);
                if was_open { Sequence::Closed } else { Sequence::Handled }
            }
            (Phase::Closed, ..) => Sequence::Ignored,
            (phase, Con::None, Con::None) => {
                self.close();
                if phase == Phase::Open { Sequence::Closed } else { Sequence::Handled }
            }
            (Phase::Opening, Con::Initialisation, Con::Valid | Con::Request) => {
                self.phase = Phase::Open;
                self.received = send.number;
                self.due = Some(Control::Acknowledge);
                Sequence::Opened
            }
            // The answer to its initialisation got lost.
            (Phase::Open, Con::Initialisation, Con::Valid | Con::Request) if send.number == self.received => {
                self.due = Some(Control::Acknowledge);
                Sequence::Handled
            }
            (Phase::Open, Con::Valid | Con::Request, Con::Valid | Con::Request) => {
                self.acknowledged(receive);
                self.order(send, begins)
            }
            (Phase::Opening | Phase::Open, ..) => Sequence::Ignored,
        }
    }

    fn acknowledged(&mut self, receive: SequenceHalf) {
        let Transfer::Sending(outgoing) = &mut self.transfer else { return };
        if outgoing.acknowledge(receive.number) {
            self.retries = 0;
        }
        if outgoing.is_done() {
            self.transfer = Transfer::Idle;
        } else if receive.connection == Con::Request {
            outgoing.repeat(false);
        }
    }

    fn order(&mut self, send: SequenceHalf, begins: bool) -> Sequence {
        let ahead = send.number.wrapping_sub(self.received) & NUMBER;
        let outcome = match ahead {
            // One command at a time: it is asked for again behind the answer to the last one.
            1 if begins && self.is_answering() => Sequence::Ignored,
            1 => {
                self.received = send.number;
                Sequence::InOrder
            }
            // Seen before.
            0 | HALF.. => Sequence::Handled,
            // A frame between is missing.
            _ => Sequence::Ignored,
        };
        if outcome == Sequence::Ignored {
            self.due = Some(Control::Retransmission);
        } else if send.connection == Con::Request {
            // What asks for a frame tells as well what arrived.
            self.due = self.due.or(Some(Control::Acknowledge));
        }
        outcome
    }

    /// Whether frames of a response still wait to be sent.
    pub(super) fn is_answering(&self) -> bool {
        matches!(&self.transfer, Transfer::Sending(outgoing) if outgoing.is_unsent())
    }

    /// The frame of a response that the client is to acknowledge next, if nothing can be sent before it does.
    pub(super) fn awaited(&self) -> Option<u8> {
        match &self.transfer {
            Transfer::Sending(outgoing) => outgoing.awaited(),
            Transfer::Idle | Transfer::Receiving(_) => None,
        }
    }

    /// The number that the next frame with a command gets.
    pub(super) const fn next_number(&self) -> u8 {
        self.sent.wrapping_add(1) & NUMBER
    }

    /// How many frames can be sent.
    #[inline]
    pub(super) fn ready(&self) -> usize {
        if self.due.is_none() && !matches!(self.transfer, Transfer::Sending(_)) {
            return 0;
        }
        self.ready_after_all()
    }

    #[inline(never)]
    fn ready_after_all(&self) -> usize {
        let data = match &self.transfer {
            Transfer::Sending(outgoing) => outgoing.ready(),
            Transfer::Idle | Transfer::Receiving(_) => 0,
        };
        match self.due {
            // A frame with a command acknowledges as well.
            Some(Control::Acknowledge) => data.max(1),
            Some(Control::Initialisation | Control::Retransmission) => data.saturating_add(1),
            None => data,
        }
    }

    /// Writes the next frame, from the sequence layer on. Returns whether there was one.
    pub(super) fn emit(&mut self, initiate: InitiateSize, out: &mut Writer<'_>) -> Result<bool, Full> {
        // A missing frame is asked for behind what answers the one before it.
        let control = match self.due {
            Some(Control::Acknowledge | Control::Retransmission) if self.has_data() => None,
            control => control,
        };
        if let Some(control) = control {
            self.due = None;
            let (receive, send) = match control {
                Control::Initialisation => (Con::Initialisation, Con::Initialisation),
                Control::Acknowledge => (Con::Valid, Con::Valid),
                Control::Retransmission => (Con::Request, Con::Valid),
            };
            self.sequence(receive, self.sent, send).emit(out)?;
            return Ok(true);
        }
        let Transfer::Sending(outgoing) = &mut self.transfer else { return Ok(false) };
        if outgoing.ready() == 0 {
            return Ok(false);
        }
        let (number, wants_acknowledge, segmentation, range) = outgoing.take();
        let (transaction, command, is_abort) = (outgoing.transaction, outgoing.command, outgoing.is_abort);
        self.due = self.due.filter(|due| *due == Control::Retransmission);
        self.sent = number;
        let connection = if wants_acknowledge { Con::Request } else { Con::Valid };
        self.sequence(Con::Valid, number, connection).emit(out)?;
        let data = self.buffer.get(range).unwrap_or_default();
        let response = SdoCommand { transaction, is_response: true, is_abort, segmentation, command, data };
        response.emit_as(out, initiate)?;
        Ok(true)
    }

    fn has_data(&self) -> bool {
        matches!(&self.transfer, Transfer::Sending(outgoing) if outgoing.ready() > 0)
    }

    const fn sequence(&self, receive: Con, number: u8, send: Con) -> SdoSequence {
        SdoSequence {
            receive: SequenceHalf::new(self.received, receive),
            send: SequenceHalf::new(number, send),
        }
    }

    /// How long the connection waits for its client: for an acknowledge a third of the time, because it asks two times again.
    /// In ms; with a time of 0 it waits for ever.
    pub(super) fn patience(&self, timeout: u32) -> Option<u32> {
        match self.phase {
            Phase::Closed => None,
            Phase::Opening | Phase::Open if timeout == 0 => None,
            Phase::Opening | Phase::Open if self.awaited().is_some() => Some(timeout.div_ceil(ATTEMPTS)),
            Phase::Opening | Phase::Open => Some(timeout),
        }
    }

    /// The wait is over. Returns whether an open connection is closed by it.
    pub(super) fn expired(&mut self) -> bool {
        match &mut self.transfer {
            Transfer::Sending(outgoing) if outgoing.awaited().is_some() && self.retries < MAX_RETRIES => {
                self.retries = self.retries.saturating_add(1);
                outgoing.repeat(true);
                false
            }
            Transfer::Idle | Transfer::Receiving(_) | Transfer::Sending(_) => {
                let was_open = self.phase == Phase::Open;
                self.close();
                was_open
            }
        }
    }
}

const NUMBER: u8 = 0x3F;
/// From here on a number is an old one, not one ahead.
const HALF: u8 = 0x20;
const MAX_RETRIES: u8 = 2;
/// The first one, and the retries.
const ATTEMPTS: u32 = 3;
