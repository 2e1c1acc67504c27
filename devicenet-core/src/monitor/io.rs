//! I/O between a slave and its master: poll, COS/cyclic, and the responses to bit-strobe and multicast poll.

use cip_core::message::AllocationChoice;
use cip_core::monitor::{
    Connection, ConnectionState, Flaw, Flow, Guess, Progress, Seen, Side, Slots, Stream,
};

use super::FragmentationGuess;
use super::connections::Predefined;
use super::kind::Kind;
use super::nodes::{Node, Roles};
use super::problem::Problem;
use super::reading::{Fields, Message, Reading};
use super::state::State;
use super::volley;
use crate::id::{Identifier, MacId};

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
    let changes = changes_only(choice)
        || flow == Flow::Consumed && node.seems_to_produce_only() && reading.frame.data().is_empty();
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
        let fields = Fields::of_data(data);
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
        connection.is_missing(reading);
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
    if reconsidered && connection.waiting.is_none() {
        // Its first fragment has been paired.
        return;
    }
    let at = reading.at;
    let Some(command) = connection.answer(reading, heard, at) else { return };
    connection.prove(reading, at);
    if core::mem::take(&mut connection.excused) {
        connection.touch(command.at);
    }
}

/// A COS or cyclic message of the slave.
fn produced(reading: &mut Reading<'_>, node: &mut Node, acknowledged: bool, reconsidered: bool) {
    let at = reading.at;
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
        connection.waiting = Some(Seen { n: reading.n, at });
    }
    connection.prove(reading, at);
    if !acknowledged || !connection.answers {
        // Only an acknowledge restarts the watchdog; without acknowledges there is none.
        connection.touch(at);
    }
}

/// The data of a frame, and the message that it completes.
pub(super) fn data<'s, const N: usize, const B: usize>(
    slots: &'s mut Slots<N, B>,
    reading: &mut Reading<'_>,
    side: &mut Side,
    identifier: Identifier,
    guess: FragmentationGuess,
) -> (Progress, Option<&'s [u8]>) {
    let stream = Stream::io(identifier.raw());
    let part = side.frame(slots, reading.at, stream, reading.frame.data(), guess);
    reading.fields.explicit.value = part.value;
    reading.frag = part.frag;
    part.tell(reading);
    (part.progress, part.message)
}
