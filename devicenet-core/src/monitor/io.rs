//! I/O between a slave and its master: poll, COS/cyclic, and the responses to bit-strobe and multicast poll.

use cip_core::fragment::{FragmentByte, FragmentKind, IO_UNFRAGMENTED_LEN};
use cip_core::message::AllocationChoice;
use cip_core::monitor::{Flaw, Frag, Piece, Seen, Slots, Span, Stream};

use super::FragmentationGuess;
use super::connection::{Connection, Flow, Guess, Side};
use super::connections::{ConnectionState, Predefined};
use super::kind::Kind;
use super::nodes::{Node, Roles};
use super::problem::Problem;
use super::reading::{Fields, Message, Note, Reading};
use super::state::State;
use super::volley;
use crate::id::{Identifier, MacId};

/// How far a frame takes its message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Progress {
    /// The message is complete.
    Complete,
    /// It is not, or is lost.
    Part,
    /// It is not, and its first fragment was taken for a message of its own.
    Begun,
    /// It is complete, and its first fragment was taken for a message of its own.
    Reconsidered,
}

/// One direction of the I/O between a slave and its master.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Lane {
    pub(super) identifier: Identifier,
    pub(super) slave: MacId,
    pub(super) which: Predefined,
    pub(super) flow: Flow,
}

/// Reads a frame between a slave and its master: everything but the commands to many slaves.
pub(super) fn observe<'s, const N: usize, const B: usize>(
    state: &mut State<N>,
    slots: &'s mut Slots<N, B>,
    reading: &mut Reading<'_>,
    lane: Lane,
    guess: FragmentationGuess,
) -> Option<Message<'s>> {
    let Lane { slave, which, flow, .. } = lane;
    let at = reading.at;
    state.settle(slave, at);
    if which == Predefined::CosCyclic && flow == Flow::Produced && state.establishes(slave, which) {
        // Its answer to the request is still to come.
        state.node(slave).connection(which).enter(ConnectionState::Established, at);
    }
    let node = state.node(slave);
    let choice = node.choice();
    let changes = changes_only(choice);
    let acknowledged = choice.is_none_or(|choice| !choice.contains(AllocationChoice::ACK_SUPPRESSION));
    reading.kind = kind(which, flow, changes);
    reading.assumed = node.allocation.is_none();
    let owner = node.owner();
    match flow {
        Flow::Consumed => (reading.src, reading.dst) = (owner, Some(slave)),
        Flow::Produced => (reading.src, reading.dst) = (Some(slave), owner),
    }
    node.roles |= Roles::SLAVE;
    let connection = node.connection(which);
    connection.count(reading.frame.data().len());
    connection.side(flow).heard = true;
    let opposite = connection.side(flow.opposite());
    if opposite.guess == Guess::Candidate {
        // It was answered: a message, not a first fragment.
        opposite.guess = Guess::Plain;
    }
    let (progress, message) = data(slots, reading, connection.side(flow), lane.identifier, guess);
    let reconsidered = match progress {
        Progress::Part => return None,
        Progress::Begun => {
            connection.waiting = None;
            return None;
        }
        Progress::Complete => false,
        Progress::Reconsidered => true,
    };
    match (which, flow) {
        (Predefined::CosCyclic, Flow::Produced) => {
            produced(reading, state.node(slave), acknowledged, reconsidered)
        }
        (Predefined::CosCyclic, Flow::Consumed) => {
            let connection = state.node(slave).connection(which);
            response(reading, connection, connection.produced.heard, reconsidered);
            connection.touch(at);
        }
        (Predefined::BitStrobe, _) => volley::strobed(state, reading, slave),
        (Predefined::MulticastPoll, _) => volley::polled(state, reading, slave),
        (_, Flow::Consumed) => {
            command(reading, state.node(slave).connection(which), acknowledged || !changes, reconsidered);
        }
        (_, Flow::Produced) => {
            let connection = state.node(slave).connection(which);
            response(reading, connection, connection.consumed.heard, reconsidered);
        }
    }
    message.map(|data| {
        let fields = Fields { value: Span::tail(data.len(), data.len()), ..Fields::default() };
        Message { kind: reading.kind, fields, data }
    })
}

fn kind(which: Predefined, flow: Flow, changes: bool) -> Kind {
    match (which, flow) {
        (Predefined::BitStrobe, _) => Kind::BitStrobeResponse,
        (Predefined::MulticastPoll, _) => Kind::MulticastPollResponse,
        (Predefined::CosCyclic, Flow::Produced) => Kind::CosCyclic,
        (Predefined::CosCyclic, Flow::Consumed) => Kind::CosCyclicAck,
        (_, Flow::Consumed) if changes => Kind::CosCyclic,
        (_, Flow::Consumed) => Kind::PollCommand,
        (_, Flow::Produced) if changes => Kind::CosCyclicAck,
        (_, Flow::Produced) => Kind::PollResponse,
    }
}

/// True if instance 2 is only the master's direction of COS/cyclic.
fn changes_only(choice: Option<AllocationChoice>) -> bool {
    choice.is_some_and(|choice| {
        choice.intersects(AllocationChoice::CHANGE_OF_STATE | AllocationChoice::CYCLIC)
            && !choice.contains(AllocationChoice::POLL)
    })
}

/// A command, which wants an answer if `answered`.
fn command(reading: &mut Reading<'_>, connection: &mut Connection, answered: bool, reconsidered: bool) {
    let told_absent = !connection.assumed && !connection.is_alive();
    if told_absent || matches!(connection.state, ConnectionState::TimedOut | ConnectionState::NonExistent) {
        reading.note = Some(Note::NoConnection(connection.state));
        reading.assumed |= connection.assumed;
    }
    if reconsidered {
        connection.waiting = None;
    }
    let excused = has_other_length(reading);
    let before_excused = core::mem::replace(&mut connection.excused, excused);
    if let Some(before) = connection.waiting.take()
        && connection.is_alive()
        && !before_excused
    {
        reading.flag(Flaw::PollUnanswered { n: before.n });
    }
    if answered {
        connection.waiting = Some(Seen { n: reading.n, at: reading.at });
    }
    if !excused {
        connection.touch(reading.at);
    }
}

/// A slave may ignore a command of another length than its size, or take it: only the answer tells.
pub(super) fn has_other_length(reading: &Reading<'_>) -> bool {
    matches!(reading.problem, Some(Problem::Flaw(Flaw::IoLength { .. })))
}

/// The answer to a command or message of the other side, of which at least one was `heard`.
fn response(reading: &mut Reading<'_>, connection: &mut Connection, heard: bool, reconsidered: bool) {
    if let Some(command) = connection.waiting.take() {
        reading.request = Some(command.answered(reading.at));
        connection.answers = true;
        prove(reading, connection);
        if core::mem::take(&mut connection.excused) {
            connection.touch(command.at);
        }
    } else if reconsidered {
        // Its first fragment has been paired.
    } else if heard {
        reading.flag(Flaw::UnexpectedIoResponse);
    } else {
        reading.assumed = true;
    }
}

/// A COS or cyclic message of the slave.
fn produced(reading: &mut Reading<'_>, node: &mut Node, acknowledged: bool, reconsidered: bool) {
    let connection = node.connection(Predefined::CosCyclic);
    if reconsidered {
        connection.waiting = None;
    }
    if let Some(before) = connection.waiting.take()
        && connection.answers
    {
        reading.flag(Flaw::Unacknowledged { n: before.n });
    }
    if acknowledged {
        connection.waiting = Some(Seen { n: reading.n, at: reading.at });
    }
    prove(reading, connection);
    if !acknowledged || !connection.answers {
        // Only an acknowledge restarts the watchdog; without acknowledges there is none.
        connection.touch(reading.at);
    }
}

/// The slave takes part in the connection: it is established, whatever was seen before.
pub(super) fn prove(reading: &mut Reading<'_>, connection: &mut Connection) {
    if connection.state == ConnectionState::Established {
        return;
    }
    if !connection.assumed {
        reading.note = Some(Note::NoConnection(connection.state));
        reading.assumed = true;
    }
    connection.infer(ConnectionState::Established, reading.at);
}

/// The data of a frame: whole, or a fragment if the connection size is above eight bytes or the frames look like it.
pub(super) fn data<'s, const N: usize, const B: usize>(
    slots: &'s mut Slots<N, B>,
    reading: &mut Reading<'_>,
    side: &mut Side,
    identifier: Identifier,
    guess: FragmentationGuess,
) -> (Progress, Option<&'s [u8]>) {
    let frame = reading.frame;
    let field = frame.data();
    let stream = Stream::io(identifier.raw());
    let size = side.size;
    if let Some(size) = size {
        side.guess = Guess::Plain;
        if usize::from(size) <= IO_UNFRAGMENTED_LEN {
            check_size(reading, Some(size), field.len());
            reading.fields.value = Span::tail(field.len(), field.len());
            return (Progress::Complete, None);
        }
    } else if side.guess != Guess::Fragmented && !(continues(side.guess, field) && slots.is_receiving(stream))
    {
        let before = core::mem::replace(&mut side.guess, Guess::Plain);
        if let ([0, _, _, _, _, _, _, _], FragmentationGuess::On) = (field, guess) {
            side.guess = Guess::Candidate;
            slots.io(stream, reading.at, None, field);
        } else if before == Guess::Candidate {
            // Only a candidate is kept: the search is for nothing in all other frames, which are nearly all.
            slots.discard(stream);
        }
        reading.fields.value = Span::tail(field.len(), field.len());
        return (Progress::Complete, None);
    }
    let guessed = size.is_none();
    let confirmed = guessed && side.guess == Guess::Candidate;
    reading.assumed |= guessed;
    let byte = field.first().copied().map(FragmentByte::from);
    let known = side.known;
    side.known |= byte.is_none_or(|byte| byte.kind != FragmentKind::Middle);
    let piece = slots.io(stream, reading.at, size, field);
    if guessed && matches!(piece, Piece::Broken(_)) {
        // It was not fragmented after all, or has changed.
        side.guess = Guess::Plain;
        reading.fields.value = Span::tail(field.len(), field.len());
        return (Progress::Complete, None);
    }
    if guessed {
        side.guess = Guess::Fragmented;
    }
    reading.frag = byte.map(Frag::new);
    match piece {
        Piece::Whole(message) => {
            check_size(reading, size, message.len());
            let progress = if confirmed { Progress::Reconsidered } else { Progress::Complete };
            (progress, Some(message))
        }
        Piece::Broken(problem) => {
            reading.flag(problem);
            (Progress::Part, None)
        }
        Piece::Headless => {
            match byte {
                Some(byte) if known => reading.flag(Flaw::NoFirstFragment { found: byte.count() }),
                Some(_) | None => reading.assumed = true,
            }
            (Progress::Part, None)
        }
        Piece::Overflow => {
            reading.note = Some(Note::NotStored);
            (Progress::Part, None)
        }
        Piece::Kept | Piece::Repeated if confirmed => (Progress::Begun, None),
        Piece::Kept | Piece::Repeated => (Progress::Part, None),
    }
}

/// True if the frame is the second fragment after a frame that could be the first, if that is still kept.
fn continues(guess: Guess, field: &[u8]) -> bool {
    let second = field.first().copied().map(FragmentByte::from).is_some_and(|byte| {
        let full = byte.kind == FragmentKind::Last || field.len() == IO_UNFRAGMENTED_LEN;
        matches!(byte.kind, FragmentKind::Middle | FragmentKind::Last) && byte.count() == 1 && full
    });
    guess == Guess::Candidate && second
}

/// An empty message is idle or "no data", whatever the size.
fn check_size(reading: &mut Reading<'_>, size: Option<u16>, len: usize) {
    let found = u16::try_from(len).unwrap_or(u16::MAX);
    if let Some(expected) = size.filter(|&size| found != 0 && found != size) {
        reading.flag(Flaw::IoLength { expected, found });
    }
}
