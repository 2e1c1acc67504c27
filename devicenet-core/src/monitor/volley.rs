//! Commands to many slaves, bit-strobe and multicast poll, and their responses.

use cip_core::message::AllocationChoice;
use cip_core::monitor::{Connection, ConnectionState, Flaw, Guess, Progress, Seen, Slots, Span};

use super::FragmentationGuess;
use super::connections::Predefined;
use super::io;
use super::kind::Kind;
use super::nodes::{Node, Roles, Volley};
use super::problem::Problem;
use super::reading::{Fields, Message, Reading};
use super::state::State;
use crate::id::{Identifier, MacId};

/// Reads a bit-strobe command of `master`.
pub(super) fn strobe<const N: usize>(state: &mut State<N>, reading: &mut Reading<'_>, master: MacId) {
    let len = reading.frame.data().len();
    reading.fields.explicit.value = Span::tail(len, len);
    reading.kind = Kind::BitStrobeCommand;
    reading.src = Some(master);
    state.add_role(master, Roles::MASTER);
    if len != STROBE_LEN && len != 0 {
        let found = u16::try_from(len).unwrap_or_default();
        // Every slave ignores it.
        reading.flag(Flaw::Length { expected: 8, found });
        return;
    }
    command(state, reading, Predefined::BitStrobe, master);
}

/// Reads a frame of a multicast poll command to `group`.
pub(super) fn poll<'s, const N: usize, const B: usize>(
    state: &mut State<N>,
    slots: &'s mut Slots<N, B>,
    reading: &mut Reading<'_>,
    identifier: Identifier,
    group: MacId,
    guess: FragmentationGuess,
) -> Option<Message<'s>> {
    reading.kind = Kind::MulticastPollCommand;
    // The group need not be the master's own MAC ID.
    reading.src = members(state, group).find_map(|node| {
        node.choice().filter(|choice| choice.contains(AllocationChoice::MULTICAST_POLL)).and(node.owner())
    });
    // All members consume the same message.
    let size = members(state, group).find_map(|node| {
        let connection = node.peek(Predefined::MulticastPoll);
        connection.consumed.size.filter(|_| connection.state != ConnectionState::NonExistent)
    });
    let node = state.node(group);
    node.multicast_side.size = size;
    let (progress, data) = io::data(slots, reading, &mut node.multicast_side, identifier, guess);
    match progress {
        Progress::Part => return None,
        // The command that its first fragment was taken for does not exist.
        Progress::Begun => {
            node.multicast = None;
            return None;
        }
        Progress::Reconsidered => node.multicast = None,
        Progress::Complete => {}
    }
    command(state, reading, Predefined::MulticastPoll, group);
    data.map(|data| {
        let fields = Fields::of_data(data);
        Message { kind: reading.kind, fields, data }
    })
}

/// The slaves whose multicast poll connection belongs to a group, if they have one.
fn members<const N: usize>(state: &State<N>, group: MacId) -> impl Iterator<Item = &Node> {
    state.nodes().map(|(_, node)| node).filter(move |node| node.multicast_group() == Some(group))
}

/// A complete command: who has not answered the one before, and whose watchdogs it restarts.
fn command<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    which: Predefined,
    sender: MacId,
) {
    let at = reading.at;
    let seen = Seen { n: reading.n, at };
    let excused = io::has_other_length(reading);
    let before = last(state.node(sender), which).replace(Volley { seen, answered: 0, excused });
    let mut missing = None;
    let mut count = 0_u8;
    for (mac, node) in state.nodes_mut() {
        let addressed = if which == Predefined::BitStrobe { node.owner() } else { node.multicast_group() };
        if addressed.is_some_and(|addressed| addressed != sender) {
            continue;
        }
        let connection = node.connection(which);
        if connection.state == ConnectionState::Unknown && !connection.answers {
            continue;
        }
        connection.settle(at, false, false);
        if !connection.is_alive() {
            continue;
        }
        // A slave that has joined since then was not meant.
        let unanswered = |volley: Volley| {
            !volley.excused && connection.active <= volley.seen.at && volley.answered & bit(mac) == 0
        };
        if before.is_some_and(unanswered) {
            missing.get_or_insert(mac);
            count = count.saturating_add(1);
        }
        if !excused {
            connection.touch(at);
        }
    }
    match (missing, which) {
        (Some(mac), Predefined::BitStrobe) => reading.flag(Problem::StrobeUnanswered { mac, count }),
        (Some(mac), _) => reading.flag(Problem::MulticastPollUnanswered { mac, count }),
        (None, _) => {}
    }
}

/// Reads a bit-strobe response.
pub(super) fn strobed<const N: usize>(state: &mut State<N>, reading: &mut Reading<'_>, slave: MacId) {
    let owner = state.node(slave).owner();
    let master = owner.or_else(|| {
        let latest = state.nodes().filter_map(|(mac, node)| node.strobe.map(|volley| (volley.seen.n, mac)));
        latest.max().map(|(_, mac)| mac)
    });
    reading.dst = reading.dst.or(master);
    let volley = master.and_then(|master| state.node(master).strobe.as_mut());
    answer(reading, volley, slave);
    join(reading, state.node(slave).connection(Predefined::BitStrobe));
}

/// Reads a multicast poll response.
pub(super) fn polled<const N: usize>(state: &mut State<N>, reading: &mut Reading<'_>, slave: MacId) {
    let told = state.node(slave).multicast_group();
    if told.is_none_or(|group| state.node(group).multicast.is_none()) {
        // Its group was never polled: it belongs to the one that was polled last.
        let polled =
            state.nodes().filter_map(|(mac, node)| node.multicast.map(|volley| (volley.seen.n, mac)));
        let latest = polled.max().map(|(_, mac)| mac);
        let node = state.node(slave);
        node.group = latest.or(node.group);
    }
    let group = state.node(slave).multicast_group();
    let volley = group.and_then(|group| {
        let node = state.node(group);
        if node.multicast_side.guess == Guess::Candidate {
            // It was answered: a message, not a first fragment.
            node.multicast_side.guess = Guess::Plain;
        }
        node.multicast.as_mut()
    });
    let excused = volley.as_deref().filter(|volley| volley.excused).map(|volley| volley.seen.at);
    answer(reading, volley, slave);
    let connection = state.node(slave).connection(Predefined::MulticastPoll);
    join(reading, connection);
    if let Some(taken) = excused {
        connection.touch(taken);
    }
}

fn answer(reading: &mut Reading<'_>, volley: Option<&mut Volley>, slave: MacId) {
    match volley {
        Some(volley) if volley.answered & bit(slave) == 0 => {
            volley.answered |= bit(slave);
            reading.request = Some(volley.seen.answered(reading.at));
        }
        Some(_) => reading.flag(Flaw::UnexpectedIoResponse),
        None => reading.assumed = true,
    }
}

/// A slave that answers a command to many.
fn join(reading: &mut Reading<'_>, connection: &mut Connection) {
    connection.answers = true;
    let at = reading.at;
    connection.prove(reading, at);
}

fn last(node: &mut Node, which: Predefined) -> &mut Option<Volley> {
    if which == Predefined::BitStrobe { &mut node.strobe } else { &mut node.multicast }
}

fn bit(mac: MacId) -> u64 {
    1_u64.rotate_left(u32::from(mac.number()))
}

const STROBE_LEN: usize = 8;
