//! The command layer: objects are read and written.

use link_core::codec::{Full, Writer};

use super::connection::{Connection, Incoming, Phase, Sequence, Transfer};
use super::outgoing::Outgoing;
use crate::NodeId;
use crate::dictionary::{Effect, ObjectAddress, ObjectSet, Objects};
use crate::wire::{AbortCode, InitiateSize, Sdo, SdoCommand, SdoCommandId, Segmentation};

/// An SDO server: the clients that it serves, [`CONNECTIONS`] at once, each with a transfer of up to `SDO` bytes.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Server<const SDO: usize> {
    connections: [Connection<SDO>; CONNECTIONS],
    /// Which one sends next.
    turn: usize,
}

/// What a frame led to.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Received {
    /// The connection that the frame belongs to.
    pub connection: Option<usize>,
    /// The wait of the connection begins anew. While a response waits for its acknowledge, that is what acknowledges something
    /// new, or puts another command in its place.
    pub is_progress: bool,
    /// What happened.
    pub outcome: Outcome,
}

/// What happened in a server.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outcome {
    /// Nothing that the application needs to know.
    Nothing,
    /// A client opened a connection.
    Opened,
    /// The client closed its connection.
    Closed,
    /// There is no room for another client.
    Refused,
    /// The frame is of no connection, or out of order.
    Ignored,
    /// An object was written.
    Written(ObjectAddress, Effect),
    /// A command failed.
    Aborted(SdoCommandId, AbortCode),
}

impl<const SDO: usize> Server<SDO> {
    /// Without clients.
    #[must_use]
    pub const fn new() -> Self {
        const { assert!(SDO >= 32, "an object has up to 32 bytes without counting texts") };
        Self { connections: [const { Connection::new() }; CONNECTIONS], turn: 0 }
    }

    /// Forgets the client of a connection, without a word to it. Returns who that is, if the connection was open.
    pub fn close(&mut self, index: usize) -> Option<NodeId> {
        let connection = self.connections.get_mut(index)?;
        let was_open = connection.phase == Phase::Open;
        connection.close();
        was_open.then_some(connection.client)
    }

    /// Takes a frame of a client. `segment` is the most data that a response carries in a frame.
    pub fn receive<O: ObjectSet>(
        &mut self,
        from: NodeId,
        sdo: &Sdo<'_>,
        segment: usize,
        objects: &mut Objects<'_, O>,
    ) -> Received {
        let is_opening = sdo.sequence.send.connection == crate::wire::Con::Initialisation;
        let Some(index) = self.place_of(from, is_opening) else {
            let outcome = if is_opening { Outcome::Refused } else { Outcome::Ignored };
            return Received { connection: None, is_progress: false, outcome };
        };
        let Some(connection) = self.connections.get_mut(index) else {
            return Received { connection: None, is_progress: false, outcome: Outcome::Ignored };
        };
        connection.client = from;
        let awaited = connection.awaited();
        let begins = sdo.command.is_some_and(|command| !command.is_abort && !command.is_response);
        let outcome = match connection.receive(sdo.sequence, begins) {
            Sequence::Handled => Outcome::Nothing,
            Sequence::Opened => Outcome::Opened,
            Sequence::Closed => Outcome::Closed,
            Sequence::Ignored => Outcome::Ignored,
            Sequence::InOrder => {
                sdo.command.map_or(Outcome::Nothing, |command| connection.serve(&command, segment, objects))
            }
        };
        let is_progress = match awaited {
            Some(_) => connection.awaited() != awaited,
            None => outcome != Outcome::Ignored,
        };
        Received { connection: Some(index), is_progress, outcome }
    }

    /// How many frames wait to be sent.
    #[must_use]
    pub fn ready(&self) -> usize {
        self.connections.iter().map(Connection::ready).fold(0, usize::saturating_add)
    }

    /// Whether frames of a response still wait to be sent on a connection.
    #[must_use]
    pub fn is_answering(&self, index: usize) -> bool {
        self.connections.get(index).is_some_and(Connection::is_answering)
    }

    /// Whether a connection waits until its client acknowledges a response: with all that can be sent before.
    #[must_use]
    pub fn is_unacknowledged(&self, index: usize) -> bool {
        self.connections.get(index).is_some_and(|connection| connection.awaited().is_some())
    }

    /// To whom the next frame goes, and of which connection it is. Clients take turns.
    #[must_use]
    pub fn next(&self) -> Option<(usize, NodeId)> {
        (0..CONNECTIONS)
            .filter_map(|step| self.turn.checked_add(step)?.checked_rem(CONNECTIONS))
            .filter_map(|index| Some((index, self.connections.get(index)?)))
            .find(|(_, connection)| connection.ready() > 0)
            .map(|(index, connection)| (index, connection.client))
    }

    /// Writes the next frame of a connection, from the sequence layer on. Returns whether there was one.
    ///
    /// # Errors
    /// [`Full`] if there is no room.
    pub fn emit(&mut self, index: usize, initiate: InitiateSize, out: &mut Writer<'_>) -> Result<bool, Full> {
        self.turn = index.saturating_add(1);
        self.connections.get_mut(index).map_or(Ok(false), |connection| connection.emit(initiate, out))
    }

    /// How long a connection waits for its client, in ms, with the time of 0x1300.
    #[must_use]
    pub fn patience(&self, index: usize, timeout: u32) -> Option<u32> {
        self.connections.get(index)?.patience(timeout)
    }

    /// The wait of a connection is over. Returns the client whose open connection is closed by it.
    pub fn expired(&mut self, index: usize) -> Option<NodeId> {
        let connection = self.connections.get_mut(index)?;
        let client = connection.client;
        connection.expired().then_some(client)
    }

    /// The connection of a client, or room for one.
    fn place_of(&self, client: NodeId, is_opening: bool) -> Option<usize> {
        let is_of_client =
            |connection: &Connection<SDO>| connection.client == client && connection.phase != Phase::Closed;
        let is_free = |connection: &Connection<SDO>| connection.phase == Phase::Closed;
        let known = self.connections.iter().position(is_of_client);
        known.or_else(|| self.connections.iter().position(is_free).filter(|_| is_opening))
    }
}

impl<const SDO: usize> Default for Server<SDO> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const SDO: usize> Connection<SDO> {
    /// Carries out a command, and prepares its response.
    fn serve<O: ObjectSet>(
        &mut self,
        command: &SdoCommand<'_>,
        segment: usize,
        objects: &mut Objects<'_, O>,
    ) -> Outcome {
        if command.is_response {
            return Outcome::Ignored;
        }
        if command.is_abort {
            self.transfer = Transfer::Idle;
            return Outcome::Nothing;
        }
        let served = match command.command {
            SdoCommandId::READ_BY_INDEX => self.read(command, objects),
            SdoCommandId::WRITE_BY_INDEX => self.write(command, objects),
            // Nil: the sequence layer alone.
            SdoCommandId::NIL => return Outcome::Nothing,
            _ => Err(AbortCode::UNKNOWN_COMMAND),
        };
        let (len, is_abort, outcome) = match served {
            Ok(Served::Read(len)) => (len, false, Outcome::Nothing),
            Ok(Served::Written(at, effect)) => (0, false, Outcome::Written(at, effect)),
            Ok(Served::MoreToCome) => return Outcome::Nothing,
            Err(code) => (self.abort(code), true, Outcome::Aborted(command.command, code)),
        };
        let first = self.next_number();
        self.transfer = Transfer::Sending(Outgoing::new(command, is_abort, len, segment, first));
        self.retries = 0;
        outcome
    }

    fn read<O: ObjectSet>(
        &mut self,
        command: &SdoCommand<'_>,
        objects: &Objects<'_, O>,
    ) -> Result<Served, AbortCode> {
        let (at, _) = address(command.data)?;
        let mut out = Writer::new(&mut self.buffer);
        objects.read(at, &mut out)?;
        Ok(Served::Read(out.len()))
    }

    fn write<O: ObjectSet>(
        &mut self,
        command: &SdoCommand<'_>,
        objects: &mut Objects<'_, O>,
    ) -> Result<Served, AbortCode> {
        match command.segmentation {
            Segmentation::Expedited => {
                let (at, value) = address(command.data)?;
                Ok(Served::Written(at, objects.write(at, value)?))
            }
            Segmentation::Initiate { total } => {
                let (at, value) = address(command.data)?;
                if usize::try_from(total).is_ok_and(|total| total > SDO.saturating_add(ADDRESS)) {
                    return Err(AbortCode::OUT_OF_MEMORY);
                }
                let incoming = Incoming { transaction: command.transaction, at, total, len: 0 };
                self.append(incoming, value)?;
                Ok(Served::MoreToCome)
            }
            Segmentation::Segment => {
                let incoming = self.incoming(command)?;
                self.append(incoming, command.data)?;
                Ok(Served::MoreToCome)
            }
            Segmentation::Complete => {
                let incoming = self.incoming(command)?;
                let Incoming { at, total, len, .. } = self.append(incoming, command.data)?;
                let total = usize::try_from(total).unwrap_or(usize::MAX);
                // Whether the size of all data counts the address, peers do not agree.
                if total != len && total != len.saturating_add(ADDRESS) {
                    return Err(AbortCode::LENGTH);
                }
                let value = self.buffer.get(..len).ok_or(AbortCode::OUT_OF_MEMORY)?;
                Ok(Served::Written(at, objects.write(at, value)?))
            }
        }
    }

    /// The write that a further frame belongs to.
    fn incoming(&self, command: &SdoCommand<'_>) -> Result<Incoming, AbortCode> {
        match self.transfer {
            Transfer::Receiving(incoming) if incoming.transaction == command.transaction => Ok(incoming),
            Transfer::Idle | Transfer::Receiving(_) | Transfer::Sending(_) => Err(AbortCode::GENERAL),
        }
    }

    fn append(&mut self, mut incoming: Incoming, data: &[u8]) -> Result<Incoming, AbortCode> {
        let end = incoming.len.saturating_add(data.len());
        let room = self.buffer.get_mut(incoming.len..end).ok_or(AbortCode::OUT_OF_MEMORY)?;
        room.iter_mut().zip(data).for_each(|(to, &from)| *to = from);
        incoming.len = end;
        self.transfer = Transfer::Receiving(incoming);
        Ok(incoming)
    }

    /// Puts an abort code into the buffer, and returns its length.
    fn abort(&mut self, code: AbortCode) -> usize {
        let mut out = Writer::new(&mut self.buffer);
        // The buffer has room for more than a code.
        let _ = out.u32(code.0);
        out.len()
    }
}

/// What a command came to.
enum Served {
    /// A value of so many bytes is in the buffer.
    Read(usize),
    Written(ObjectAddress, Effect),
    /// The client goes on.
    MoreToCome,
}

/// The object that a command is about, and what follows.
fn address(data: &[u8]) -> Result<(ObjectAddress, &[u8]), AbortCode> {
    let ([low, high, sub, _], value) = data.split_first_chunk::<ADDRESS>().ok_or(AbortCode::LENGTH)?;
    Ok((ObjectAddress::new(u16::from_le_bytes([*low, *high]), *sub), value))
}

/// Index, sub-index and a reserved byte.
const ADDRESS: usize = 4;
/// The clients that a server serves at once: the managing node, and a diagnostic device.
pub const CONNECTIONS: usize = 2;
