//! What is known of the nodes.

use heapless::Vec;
use link_core::Instant;

use super::{Answered, Problem, Reading};
use crate::nmt::{Cause, EDGES, NmtState};
use crate::wire::{IdentResponse, NmtCommand, NmtStateCode, Pres};
use crate::{MacAddress, NodeId};

/// What is known of a node.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct NodeRecord {
    /// Its node ID.
    pub node: NodeId,
    /// Where it sends from.
    pub mac: Option<MacAddress>,
    /// Frames that it has sent.
    pub frames: u64,
    /// The state that it reported last.
    pub state: Option<NmtStateCode>,
    /// The last states that it was in, the oldest first.
    pub history: Vec<StateChange, MAX_HISTORY>,
    /// Changes of state for which there was no more room in the history.
    pub forgotten: u64,
    /// Its last IdentResponse.
    pub ident: Option<IdentResponse>,
    /// PReqs to it.
    pub polls: u64,
    /// PReqs that it did not answer in time.
    pub pres_missing: u64,
    /// Answers that came after all.
    pub pres_late: u64,
    /// IdentRequests and StatusRequests that it did not answer.
    pub answers_missing: u64,
    tracking: Tracking,
}

/// A node is in another state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct StateChange {
    /// When it first said so.
    pub at: Instant,
    /// The number of that frame.
    pub n: u64,
    /// The state.
    pub state: NmtStateCode,
}

/// What is kept between frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Tracking {
    poll: Poll,
    /// A reset was commanded, and nothing heard since.
    is_resetting: bool,
    /// StatusResponses in a row whose EC is not the ER of the request.
    disagreements: u8,
    /// Commands since the last change of state, and between the two before.
    commands: [Commands; 2],
}

/// The last PReq to a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Poll {
    /// There was none.
    Never,
    Waiting {
        n: u64,
        at: Instant,
    },
    /// The managing node has gone on.
    Missed {
        at: Instant,
    },
    Answered,
}

/// Commands that a state change can be due to: bit n stands for number n of [`COMMANDS`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Commands(u8);

impl NodeRecord {
    pub(super) const fn new(node: NodeId) -> Self {
        Self {
            node,
            mac: None,
            frames: 0,
            state: None,
            history: Vec::new(),
            forgotten: 0,
            ident: None,
            polls: 0,
            pres_missing: 0,
            pres_late: 0,
            answers_missing: 0,
            tracking: Tracking {
                poll: Poll::Never,
                is_resetting: false,
                disagreements: 0,
                // What was commanded before the first frame is not known.
                commands: [Commands::NONE, Commands::ALL],
            },
        }
    }

    /// Whether it was heard or polled.
    pub(super) const fn is_known(&self) -> bool {
        self.frames > 0 || self.polls > 0
    }

    /// Whether it is there, and not on its way through a reset.
    pub(super) const fn is_present(&self) -> bool {
        self.frames > 0 && !self.tracking.is_resetting
    }

    pub(super) fn heard(&mut self, reading: &mut Reading<'_>, mac: MacAddress) {
        self.frames = self.frames.saturating_add(1);
        self.tracking.is_resetting = false;
        if let Some(before) = self.mac.replace(mac).filter(|before| *before != mac) {
            reading.flag(Problem::TwoSources { before });
        }
    }

    pub(super) fn commanded(&mut self, command: &NmtCommand<'_>) {
        let Some(cause) = Cause::of_command(command.command).filter(|_| command.is_for(self.node)) else {
            return;
        };
        let [recent, _] = &mut self.tracking.commands;
        recent.insert(cause);
        let is_reset = matches!(
            cause,
            Cause::SwReset | Cause::ResetNode | Cause::ResetCommunication | Cause::ResetConfiguration
        );
        if is_reset {
            self.tracking.is_resetting = true;
            self.tracking.poll = Poll::Never;
        }
    }

    /// It is in a state.
    pub(super) fn in_state(&mut self, reading: &mut Reading<'_>, state: NmtStateCode) {
        let Some(before) = self.state.replace(state) else {
            self.remember(reading, state);
            return;
        };
        if before == state {
            return;
        }
        let [recent, older] = self.tracking.commands;
        // The managing node has a machine of its own.
        if self.node.is_controlled_node() && !can_follow(before, state, recent.and(older)) {
            reading.flag(Problem::StateCannotFollow { before });
        }
        self.tracking.commands = [Commands::NONE, recent];
        self.remember(reading, state);
    }

    fn remember(&mut self, reading: &Reading<'_>, state: NmtStateCode) {
        if self.history.is_full() {
            self.history.remove(0);
            self.forgotten = self.forgotten.saturating_add(1);
        }
        // There is room now.
        let _ = self.history.push(StateChange { at: reading.at, n: reading.n, state });
    }

    /// It is polled, with process data of a size, where that was captured.
    pub(super) fn polled(&mut self, reading: &mut Reading<'_>, size: Option<usize>) {
        self.polls = self.polls.saturating_add(1);
        self.tracking.poll = Poll::Waiting { n: reading.n, at: reading.at };
        let limit = self.ident.map(|ident| ident.poll_in_size);
        if let Some(size) = size {
            self.check_size(reading, limit, size);
        }
    }

    /// The managing node goes on: whether it waited for this node in vain.
    pub(super) const fn is_missed(&mut self) -> bool {
        let Poll::Waiting { at, .. } = self.tracking.poll else { return false };
        self.tracking.poll = Poll::Missed { at };
        self.pres_missing = self.pres_missing.saturating_add(1);
        true
    }

    pub(super) fn responded(&mut self, reading: &mut Reading<'_>) {
        match self.tracking.poll {
            // PRes chaining knows no PReq.
            Poll::Never => {}
            Poll::Waiting { n, at } => {
                reading.request = Some(Answered { n, latency: reading.at.saturating_since(at) });
                self.tracking.poll = Poll::Answered;
            }
            Poll::Missed { at } => {
                let after = reading.at.checked_since(at);
                self.pres_late = self.pres_late.saturating_add(1);
                self.tracking.poll = Poll::Answered;
                reading.flag(Problem::PresLate { after });
            }
            Poll::Answered => reading.flag(Problem::PresWithoutPreq),
        }
    }

    pub(super) fn check_pres(&self, reading: &mut Reading<'_>, pres: &Pres<'_>) {
        let limit = self.ident.map(|ident| ident.poll_out_size);
        self.check_size(reading, limit, pres.data.len());
    }

    fn check_size(&self, reading: &mut Reading<'_>, limit: Option<u16>, size: usize) {
        if let Some(limit) = limit.filter(|&limit| size > usize::from(limit)) {
            reading.flag(Problem::SizeOver { node: self.node, limit, size });
        }
    }

    /// A StatusResponse to a request with or without ER has EC, or has it not.
    pub(super) fn shook_hands(&mut self, reading: &mut Reading<'_>, reset: bool, clear: bool) {
        let disagreements = &mut self.tracking.disagreements;
        *disagreements = if reset == clear { 0 } else { disagreements.saturating_add(1) };
        // The answer to the request that changes ER may still have the EC of before.
        if *disagreements > 1 {
            reading.flag(Problem::HandshakeNotAnswered { responses: *disagreements });
        }
    }
}

impl Commands {
    const NONE: Self = Self(0);
    const ALL: Self = Self(u8::MAX);

    fn insert(&mut self, cause: Cause) {
        self.0 |= bit(cause).unwrap_or(0);
    }

    const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// What nobody commands can happen at any time.
    fn allow(self, cause: Cause) -> bool {
        bit(cause).is_none_or(|bit| self.0 & bit != 0)
    }
}

/// The bit of the command without which a cause has no effect.
fn bit(cause: Cause) -> Option<u8> {
    let needed = match cause {
        // CT6 takes both.
        Cause::ApplicationReady => Cause::EnableReadyToOperate,
        cause => cause,
    };
    let number = COMMANDS.iter().position(|&command| command == needed)?;
    1_u8.checked_shl(u32::try_from(number).ok()?)
}

/// Whether a node can get from one state to another in any number of steps. States of other numbers are not judged.
fn can_follow(from: NmtStateCode, to: NmtStateCode, commands: Commands) -> bool {
    let (Some(from), Some(to)) = (number(from), number(to)) else { return true };
    let mut reached = [false; NmtState::ALL.len()];
    if let Some(slot) = reached.get_mut(from) {
        *slot = true;
    }
    let is_reached = |reached: &[bool], state| reached.get(state).copied().unwrap_or(false);
    // Each round reaches one more state at least, or is the last.
    for _ in NmtState::ALL {
        for edge in EDGES.iter().filter(|edge| commands.allow(edge.cause)) {
            let (Some(source), Some(target)) = (number(edge.from.code()), number(edge.to.code())) else {
                continue;
            };
            if is_reached(&reached, source)
                && let Some(slot) = reached.get_mut(target)
            {
                *slot = true;
            }
        }
        if is_reached(&reached, to) {
            return true;
        }
    }
    false
}

/// The place of a state in the list of all.
fn number(state: NmtStateCode) -> Option<usize> {
    NmtState::ALL.iter().position(|known| known.code() == state)
}

/// States in a history.
pub const MAX_HISTORY: usize = 16;
const COMMANDS: [Cause; 8] = [
    Cause::SwReset,
    Cause::ResetNode,
    Cause::ResetCommunication,
    Cause::ResetConfiguration,
    Cause::StartNode,
    Cause::StopNode,
    Cause::EnterPreOperational2,
    Cause::EnableReadyToOperate,
];
