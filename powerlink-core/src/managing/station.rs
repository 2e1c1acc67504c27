//! What the managing node knows of one node.

use super::state::NodePhase;
use crate::MacAddress;
use crate::error::ErrorCounter;
use crate::wire::{AsyncRequest, ErrorCode, Identity, NmtCommandId, NmtStateCode};

/// What the managing node knows of one node.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Station<const DATA: usize> {
    pub(super) phase: NodePhase,
    pub(super) goal: Goal,
    /// From its IdentResponse.
    pub(super) mac: MacAddress,
    pub(super) identity: Option<Identity>,
    /// The limits of its last IdentResponse: 0x1F98/4 and /5.
    pub(super) limits: (u16, u16),
    /// It has the configuration of the plan already.
    pub(super) has_configuration: bool,
    /// The state that it showed last.
    pub(super) shown: NmtStateCode,
    /// What it has for the asynchronous slot.
    pub(super) request: AsyncRequest,
    /// EN and EA.
    pub(super) exception_new: bool,
    pub(super) exception_acknowledge: bool,
    /// A command that waits to be sent.
    pub(super) command: Option<Command>,
    /// The next object that is written.
    pub(super) step: u16,
    /// How often the configuration was not taken.
    pub(super) tries: u8,
    /// StatusRequests since it was answered last, or with the same answer.
    pub(super) unanswered: u8,
    /// PRes that showed a wrong state.
    pub(super) wrong: u8,
    /// Ticks until the goal must be reached; 0 while nothing is expected.
    pub(super) patience: u32,
    /// The command that it is to follow, and ticks until that is sent again.
    pub(super) sent: Option<NmtCommandId>,
    pub(super) pause: u32,
    /// Ticks until the next StatusRequest that nothing calls for.
    pub(super) status_in: u32,
    /// Ticks until a StatusRequest may follow the last one.
    pub(super) status_pause: u32,
    /// 0x1C09
    pub(super) loss_of_pres: ErrorCounter,
    pub(super) has_answered_poll: bool,
    /// The application gave outputs.
    pub(super) has_outputs: bool,
    pub(super) outputs: Data<DATA>,
    pub(super) inputs: Data<DATA>,
    /// RD of the last PRes, in operation.
    pub(super) inputs_valid: bool,
    /// The application knows of valid inputs, and not of their end.
    pub(super) told_inputs: bool,
}

/// Process data.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Data<const DATA: usize> {
    bytes: [u8; DATA],
    len: usize,
}

/// Where the application wants a node.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Goal {
    Operational,
    PreOperational2,
    Stopped,
}

/// An NMT command with its reason.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Command {
    pub(super) command: NmtCommandId,
    pub(super) reason: ErrorCode,
}

impl<const DATA: usize> Station<DATA> {
    /// A node that nobody has heard of, with outputs of zeros.
    pub(super) const fn new(loss_of_pres_threshold: u32, output_len: usize) -> Self {
        Self {
            phase: NodePhase::Absent,
            goal: Goal::Operational,
            mac: MacAddress([0; 6]),
            identity: None,
            limits: (0, 0),
            has_configuration: false,
            shown: NmtStateCode::OFF,
            request: AsyncRequest::NONE,
            exception_new: false,
            exception_acknowledge: false,
            command: None,
            step: 0,
            tries: 0,
            unanswered: 0,
            wrong: 0,
            patience: 0,
            sent: None,
            pause: 0,
            status_in: 0,
            status_pause: 0,
            loss_of_pres: ErrorCounter::new(loss_of_pres_threshold),
            has_answered_poll: false,
            has_outputs: false,
            outputs: Data::zeros(output_len),
            inputs: Data::zeros(0),
            inputs_valid: false,
            told_inputs: false,
        }
    }

    /// Forgets what it knew of a node that begins anew. What the application wants of it stays.
    pub(super) fn forget(&mut self) {
        let fresh = Self::new(self.loss_of_pres.threshold, 0);
        let (outputs, loss_of_pres) = (self.outputs.clone(), self.loss_of_pres);
        *self = Self {
            goal: self.goal,
            identity: self.identity,
            command: self.command,
            tries: self.tries,
            has_outputs: self.has_outputs,
            told_inputs: self.told_inputs,
            outputs,
            loss_of_pres: ErrorCounter { threshold_count: 0, ..loss_of_pres },
            ..fresh
        };
    }

    /// What the application wants of the node from now on. One that is refused is asked again when it was to be.
    pub(super) fn pursue(&mut self, goal: Goal) {
        self.goal = goal;
        if self.phase != NodePhase::Refused {
            self.clear_waits();
        }
    }

    /// A fresh wait for the node to follow.
    pub(super) const fn clear_waits(&mut self) {
        (self.patience, self.pause, self.status_pause, self.unanswered, self.wrong) = (0, 0, 0, 0, 0);
        self.sent = None;
    }
}

impl<const DATA: usize> Data<DATA> {
    const fn zeros(len: usize) -> Self {
        Self { bytes: [0; DATA], len }
    }

    pub(super) fn get(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or_default()
    }

    /// Returns whether there was room.
    pub(super) fn set(&mut self, data: &[u8]) -> bool {
        let Some(place) = self.bytes.get_mut(..data.len()) else { return false };
        place.copy_from_slice(data);
        self.len = data.len();
        true
    }
}
