//! SDO connections: which frames are missing, which response belongs to which request, transfers in several parts.

use link_core::Instant;

use super::reading::ADDRESS;
use super::{Answered, Message, Note, Problem, Reading};
use crate::NodeId;
use crate::dictionary::ObjectAddress;
use crate::wire::{Con, Sdo, SdoCommand, SdoCommandId, SdoSequence, Segmentation};

/// The connections of a network, and room for the data of `N` transfers in several parts at a time.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Connections<const N: usize, const B: usize> {
    slots: [Connection; CONNECTIONS],
    buffers: [Buffer<B>; N],
    /// Connections given up for others.
    pub(super) evicted: u64,
    /// Transfers that were longer than the storage, or lost it to others.
    pub(super) not_stored: u64,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Connection {
    ends: Option<Ends>,
    /// The number of its last frame.
    last: u64,
    /// The last numbers of client and server.
    sent: [Option<u8>; 2],
    transfer: Option<Transfer>,
}

/// The data of a transfer in several parts.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Buffer<const B: usize> {
    /// Whose they are.
    of: Option<Ends>,
    /// The number of the last frame that added some.
    last: u64,
    bytes: [u8; B],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Ends {
    client: NodeId,
    server: NodeId,
}

/// A request, and what became of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Transfer {
    transaction: u8,
    n: u64,
    at: Instant,
    command: SdoCommandId,
    object: Option<ObjectAddress>,
    is_answered: bool,
    parts: Option<Parts>,
}

/// The parts so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Parts {
    is_response: bool,
    len: usize,
    is_stored: bool,
}

impl<const N: usize, const B: usize> Connections<N, B> {
    pub(super) const fn new() -> Self {
        Self {
            slots: [const { Connection::new() }; CONNECTIONS],
            buffers: [const { Buffer { of: None, last: 0, bytes: [0; B] } }; N],
            evicted: 0,
            not_stored: 0,
        }
    }

    /// Follows a frame from one node to another. Returns the data of a transfer that it completes.
    pub(super) fn observe(
        &mut self,
        reading: &mut Reading<'_>,
        (from, to): (NodeId, NodeId),
        sdo: &Sdo<'_>,
    ) -> Option<Message<'_>> {
        let is_response = sdo.command.map(|command| command.is_response);
        let (client, server) = if is_response == Some(true) { (to, from) } else { (from, to) };
        let Self { slots, buffers, evicted, not_stored } = self;
        let connection = find(slots, evicted, Ends { client, server })?;
        connection.last = reading.n;
        let sequence = sdo.sequence;
        if (sequence.receive.connection, sequence.send.connection) == (Con::None, Con::Initialisation) {
            connection.begin(Ends { client: from, server: to });
        }
        let is_client = connection.ends.is_some_and(|ends| ends.client == from);
        let is_new = connection.in_order(reading, sequence, is_client, sdo.command.is_some());
        let command = sdo.command?;
        if !is_new {
            reading.note = Some(Note::Repeated);
            reading.object = connection.transfer_of(&command).and_then(|transfer| transfer.object);
            return None;
        }
        let completed = if command.is_response {
            connection.response(reading, &command, buffers)
        } else {
            connection.request(reading, &command, buffers)
        }?;
        if !completed.is_stored {
            *not_stored = not_stored.saturating_add(1);
            reading.note = Some(Note::NotStored);
            return None;
        }
        let buffer = buffers.iter().find(|buffer| buffer.of == connection.ends)?;
        Some(Message { command: command.command, data: buffer.bytes.get(..completed.len)? })
    }

    /// A frame between two nodes was not captured whole: its number and its part are not known.
    pub(super) fn forget(&mut self, one: NodeId, other: NodeId) {
        if let Some(connection) = self.slots.iter_mut().find(|slot| slot.is_between(one, other)) {
            connection.sent = [None; 2];
            connection.transfer = None;
        }
    }
}

/// The connection of two nodes; for a new one the place of that which was used least recently.
fn find<'s>(slots: &'s mut [Connection], evicted: &mut u64, ends: Ends) -> Option<&'s mut Connection> {
    let known = slots.iter().position(|slot| slot.is_between(ends.client, ends.server));
    if let Some(index) = known {
        return slots.get_mut(index);
    }
    let slot = slots.iter_mut().min_by_key(|slot| slot.ends.map(|_| slot.last))?;
    if slot.ends.is_some() {
        *evicted = evicted.saturating_add(1);
    }
    slot.begin(ends);
    Some(slot)
}

/// The room of a connection; for a transfer that begins, that which was used least recently.
fn room<const B: usize>(buffers: &mut [Buffer<B>], of: Ends, begins: bool) -> Option<&mut Buffer<B>> {
    let known = buffers.iter().position(|buffer| buffer.of == Some(of));
    if let Some(index) = known {
        return buffers.get_mut(index);
    }
    let oldest = buffers.iter_mut().filter(|_| begins).min_by_key(|buffer| buffer.of.map(|_| buffer.last))?;
    oldest.of = Some(of);
    Some(oldest)
}

impl Connection {
    const fn new() -> Self {
        Self { ends: None, last: 0, sent: [None; 2], transfer: None }
    }

    fn is_between(&self, one: NodeId, other: NodeId) -> bool {
        self.ends.is_some_and(|Ends { client, server }| {
            (client, server) == (one, other) || (client, server) == (other, one)
        })
    }

    const fn begin(&mut self, ends: Ends) {
        self.ends = Some(ends);
        self.sent = [None; 2];
        self.transfer = None;
    }

    /// Whether a frame is a new one: it was not seen before.
    fn in_order(
        &mut self,
        reading: &mut Reading<'_>,
        sequence: SdoSequence,
        is_client: bool,
        has_command: bool,
    ) -> bool {
        let [client, server] = &mut self.sent;
        let last = if is_client { client } else { server };
        let number = sequence.send.number;
        match sequence.send.connection {
            Con::None => {
                *last = None;
                true
            }
            Con::Initialisation => {
                *last = Some(number);
                true
            }
            Con::Valid | Con::Request => {
                let Some(before) = last.replace(number) else { return true };
                // A frame without a command has the number of the last one that had.
                let due = if has_command { before.wrapping_add(1) & NUMBER } else { before };
                let ahead = number.wrapping_sub(due) & NUMBER;
                match ahead {
                    0 => true,
                    HALF.. => {
                        // It came before; the newest number stays.
                        *last = Some(before);
                        false
                    }
                    _ => {
                        reading.flag(Problem::SequenceGap { expected: due, found: number });
                        true
                    }
                }
            }
        }
    }

    fn transfer_of(&mut self, command: &SdoCommand<'_>) -> Option<&mut Transfer> {
        self.transfer.as_mut().filter(|transfer| transfer.transaction == command.transaction)
    }

    fn request<const B: usize>(
        &mut self,
        reading: &mut Reading<'_>,
        command: &SdoCommand<'_>,
        buffers: &mut [Buffer<B>],
    ) -> Option<Parts> {
        if command.begins() && !command.is_abort {
            let object = object_of(command);
            reading.object = object;
            let parts = matches!(command.segmentation, Segmentation::Initiate { .. });
            let parts = parts.then_some(Parts { is_response: false, len: 0, is_stored: true });
            self.transfer = Some(Transfer {
                transaction: command.transaction,
                n: reading.n,
                at: reading.at,
                command: command.command,
                object,
                is_answered: false,
                parts,
            });
            let address = if object.is_some() { ADDRESS } else { 0 };
            return self.collect(command, command.data.get(address..).unwrap_or_default(), buffers);
        }
        reading.object = self.transfer_of(command)?.object;
        self.collect(command, command.data, buffers)
    }

    fn response<const B: usize>(
        &mut self,
        reading: &mut Reading<'_>,
        command: &SdoCommand<'_>,
        buffers: &mut [Buffer<B>],
    ) -> Option<Parts> {
        let transfer = self.transfer_of(command).filter(|transfer| transfer.command == command.command)?;
        reading.object = transfer.object;
        if !core::mem::replace(&mut transfer.is_answered, true) {
            let latency = reading.at.saturating_since(transfer.at);
            reading.request = Some(Answered { n: transfer.n, latency });
        }
        if matches!(command.segmentation, Segmentation::Initiate { .. }) {
            transfer.parts = Some(Parts { is_response: true, len: 0, is_stored: true });
        }
        if command.is_abort {
            transfer.parts = None;
        }
        self.collect(command, command.data, buffers)
    }

    /// Adds a part, and returns what there is after the last.
    fn collect<const B: usize>(
        &mut self,
        command: &SdoCommand<'_>,
        data: &[u8],
        buffers: &mut [Buffer<B>],
    ) -> Option<Parts> {
        let transfer =
            self.transfer.as_mut().filter(|transfer| transfer.transaction == command.transaction)?;
        let parts = transfer.parts.as_mut().filter(|parts| parts.is_response == command.is_response)?;
        let begins = matches!(command.segmentation, Segmentation::Initiate { .. });
        let buffer = room(buffers, self.ends?, begins);
        let end = parts.len.saturating_add(data.len());
        let place = buffer.and_then(|buffer| {
            buffer.last = self.last;
            buffer.bytes.get_mut(parts.len..end)
        });
        match place {
            Some(place) if parts.is_stored => {
                place.copy_from_slice(data);
                parts.len = end;
            }
            _ => parts.is_stored = false,
        }
        if command.segmentation != Segmentation::Complete {
            return None;
        }
        transfer.parts.take()
    }
}

impl SdoCommand<'_> {
    /// Whether it is the first or the only part.
    pub(super) const fn begins(&self) -> bool {
        matches!(self.segmentation, Segmentation::Expedited | Segmentation::Initiate { .. })
    }
}

/// The object that a request names.
fn object_of(command: &SdoCommand<'_>) -> Option<ObjectAddress> {
    let names_one = matches!(command.command, SdoCommandId::READ_BY_INDEX | SdoCommandId::WRITE_BY_INDEX);
    let [low, high, sub, _] = command.data.first_chunk::<ADDRESS>().filter(|_| names_one)?;
    Some(ObjectAddress::new(u16::from_le_bytes([*low, *high]), *sub))
}

/// More than a network has nodes.
pub(super) const CONNECTIONS: usize = 256;
const NUMBER: u8 = 0x3F;
/// From here on a number is an old one, not one ahead.
const HALF: u8 = 0x20;
