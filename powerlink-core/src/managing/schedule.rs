//! The asynchronous slot: who gets it.
//!
//! There is one slot in a cycle. The reasons to use it take turns, and so do the nodes for each reason, so that nobody waits
//! for ever.

use link_core::codec::{Full, Wire, Writer};

use super::event::count;
use super::machine::{ManagingNode, Opening, ticks};
use super::state::{MnState, NodeCause, NodePhase};
use super::station::{Command, Goal, Station};
use crate::NodeId;
use crate::ethernet::{MIN_FRAME, group};
use crate::wire::{
    AsyncRequest, ErrorCode, Header, MessageType, NmtCommand, NmtCommandId, NmtStateCode, NodeList,
    ServiceId, pad,
};

/// What a slot is for.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Slot {
    Nothing,
    Ident(NodeId),
    Status(usize),
    /// A node has an NMT request.
    Request(usize),
    /// A node has anything else.
    Invite(usize),
    Broadcast(Broadcast),
    Command(usize, Command),
    /// The answer to a request that is not followed.
    InvalidRequest(NodeId),
    Sdo,
}

/// A command for several nodes.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Broadcast {
    /// The plain command.
    pub(super) command: NmtCommandId,
    /// For whom; `None` for all.
    pub(super) list: Option<NodeList>,
}

/// The reasons for a slot, in the order of their turns.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Reason {
    Command,
    Request,
    Status,
    Invite,
    Sdo,
    Ident,
}

/// Whose turn it was.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Turns {
    reason: usize,
    nodes: [usize; REASONS.len()],
}

impl<const N: usize, const DATA: usize, const SDO: usize> ManagingNode<'_, N, DATA, SDO> {
    /// Chooses what the next slot is for.
    pub(super) fn next_slot(&mut self) -> Slot {
        if self.state == MnState::PreOperational1 && self.opening != Opening::Done {
            return self.broadcast.take().map_or(Slot::Nothing, Slot::Broadcast);
        }
        self.feed_client();
        for step in 1..=REASONS.len() {
            let place = self.turns.reason.saturating_add(step).checked_rem(REASONS.len()).unwrap_or(0);
            let Some(&reason) = REASONS.get(place) else { continue };
            if let Some(slot) = self.slot_for(reason, place) {
                self.turns.reason = place;
                return slot;
            }
        }
        Slot::Nothing
    }

    /// After ten SoAs every node begins anew.
    pub(super) fn broadcast_reset(&mut self) {
        self.broadcast = Some(Broadcast { command: NmtCommandId::RESET_NODE, list: None });
    }

    fn slot_for(&mut self, reason: Reason, place: usize) -> Option<Slot> {
        match reason {
            Reason::Command => {
                if let Some(broadcast) = self.broadcast.take() {
                    return Some(Slot::Broadcast(broadcast));
                }
                if let Some(node) = self.invalid_request.take() {
                    return Some(Slot::InvalidRequest(node));
                }
                let index = self.next_node(place, |this, index| this.wanted_command(index).is_some())?;
                Some(Slot::Command(index, self.wanted_command(index)?))
            }
            Reason::Request => {
                let wants = |request: AsyncRequest| request.priority() == AsyncRequest::NMT;
                self.next_node(place, |this, index| this.has_request(index, wants)).map(Slot::Request)
            }
            Reason::Status => self.next_node(place, Self::wants_status).map(Slot::Status),
            Reason::Invite => {
                let wants = |request: AsyncRequest| request.priority() != AsyncRequest::NMT;
                self.next_node(place, |this, index| this.has_request(index, wants)).map(Slot::Invite)
            }
            Reason::Sdo => self.client.has_frame().then_some(Slot::Sdo),
            Reason::Ident => {
                let index = self.next_node(place, Self::wants_ident)?;
                Some(Slot::Ident(self.plans.get(index).map_or(NodeId::DIAGNOSTIC, |plan| plan.node)))
            }
        }
    }

    /// The next node for a reason; the diagnostic device is behind all others.
    fn next_node(&mut self, place: usize, wanted: impl Fn(&Self, usize) -> bool) -> Option<usize> {
        let turn = self.turns.nodes.get(place).copied().unwrap_or(0);
        let behind = self.stations.len().saturating_add(1);
        let index = (1..=behind)
            .filter_map(|step| turn.saturating_add(step).checked_rem(behind))
            .find(|&index| wanted(self, index))?;
        *self.turns.nodes.get_mut(place)? = index;
        Some(index)
    }

    fn has_request(&self, index: usize, wanted: impl Fn(AsyncRequest) -> bool) -> bool {
        let station = self.stations.get(index);
        station.is_some_and(|station| station.request.count() > 0 && wanted(station.request))
    }

    fn wants_ident(&self, index: usize) -> bool {
        let Some(station) = self.stations.get(index) else { return self.config.asks_diagnostic_device };
        station.command.is_none() && matches!(station.phase, NodePhase::Absent | NodePhase::Restarting)
    }

    /// A command that waits, or that brings the node nearer to its goal.
    fn wanted_command(&self, index: usize) -> Option<Command> {
        let station = self.stations.get(index)?;
        station.command.or_else(|| {
            let is_repeated = |command: &NmtCommandId| station.sent == Some(*command);
            let command = self.next_step(station);
            let command = command.filter(|command| station.pause == 0 || !is_repeated(command))?;
            Some(Command { command, reason: ErrorCode::NONE })
        })
    }

    fn next_step(&self, station: &Station<DATA>) -> Option<NmtCommandId> {
        match (station.phase, station.goal) {
            (NodePhase::PreOperational2, Goal::Operational) => (station.has_answered_poll
                || station.shown == NmtStateCode::PRE_OPERATIONAL_2)
                .then_some(NmtCommandId::ENABLE_READY_TO_OPERATE),
            (NodePhase::ReadyToOperate, Goal::Operational) => {
                (self.state == MnState::Operational).then_some(NmtCommandId::START_NODE)
            }
            // From `ReadyToOperate` there is no way back but by `Stopped`.
            (
                NodePhase::PreOperational2 | NodePhase::ReadyToOperate | NodePhase::Operational,
                Goal::Stopped,
            )
            | (NodePhase::ReadyToOperate, Goal::PreOperational2) => Some(NmtCommandId::STOP_NODE),
            (NodePhase::Stopped, Goal::Stopped) => {
                (station.shown != NmtStateCode::STOPPED).then_some(NmtCommandId::STOP_NODE)
            }
            (NodePhase::Operational, Goal::PreOperational2)
            | (NodePhase::Stopped, Goal::Operational | Goal::PreOperational2) => {
                Some(NmtCommandId::ENTER_PRE_OPERATIONAL_2)
            }
            _ => None,
        }
    }

    /// Whether a node is to be asked for its status: to go on, to hear of an error, or because it is time.
    fn wants_status(&self, index: usize) -> bool {
        let (Some(station), Some(plan)) = (self.stations.get(index), self.plans.get(index)) else {
            return false;
        };
        if station.status_pause > 0 {
            return false;
        }
        let is_polled = station.phase.is_polled() && !plan.is_async_only;
        let waits_for_sdo = !is_polled
            && self.client.is_waiting()
            && self.client.server() == plan.node
            && station.request.count() == 0;
        let has_error = station.exception_new != station.exception_acknowledge;
        match station.phase {
            NodePhase::Absent | NodePhase::Restarting | NodePhase::Refused => waits_for_sdo,
            NodePhase::Clearing | NodePhase::Signalling => true,
            NodePhase::Configuring => waits_for_sdo,
            NodePhase::Configured => self.state.is_cyclic() || waits_for_sdo,
            NodePhase::PreOperational2
            | NodePhase::ReadyToOperate
            | NodePhase::Operational
            | NodePhase::Stopped => {
                // Where nothing else shows it: the next step, or a wrong state that is not to last.
                let moves = !is_polled && (self.next_step(station).is_some() || station.wrong > 0);
                moves || waits_for_sdo || has_error || station.status_in == 0
            }
        }
    }

    /// Whether the managing node itself sends in the slot.
    pub(super) const fn has_own(&self) -> bool {
        matches!(self.slot, Slot::Broadcast(_) | Slot::Command(..) | Slot::InvalidRequest(_) | Slot::Sdo)
    }

    /// What the managing node sends in its own slot.
    pub(super) fn own_frame<'b>(&mut self, buffer: &'b mut [u8]) -> Result<&'b [u8], Full> {
        let mut out = Writer::new(buffer);
        match self.slot {
            Slot::Broadcast(broadcast) => {
                self.broadcast_frame(broadcast, &mut out)?;
                self.broadcast_was_sent(broadcast);
            }
            Slot::Command(index, command) => {
                let node = self.plans.get(index).map_or(NodeId::NONE, |plan| plan.node);
                let reason = command.reason.0.to_le_bytes();
                let data = if command.reason == ErrorCode::NONE { &[][..] } else { &reason };
                self.command_frame(node, NmtCommand { command: command.command, data }, &mut out)?;
                self.command_was_sent(index, command.command);
            }
            Slot::InvalidRequest(node) => {
                let command = NmtCommand { command: NmtCommandId::INVALID_SERVICE, data: &[] };
                self.command_frame(node, command, &mut out)?;
            }
            Slot::Sdo => {
                self.asnd_header(self.client.server(), ServiceId::SDO, &mut out)?;
                self.client.emit(self.config.initiate_size, &mut out)?;
                self.supervise_client();
            }
            Slot::Nothing | Slot::Ident(_) | Slot::Status(_) | Slot::Request(_) | Slot::Invite(_) => {}
        }
        pad(&mut out, MIN_FRAME)?;
        Ok(out.into_written())
    }

    fn broadcast_frame(&self, broadcast: Broadcast, out: &mut Writer<'_>) -> Result<(), Full> {
        let Broadcast { command, list } = broadcast;
        let all = NodeId::BROADCAST;
        match list {
            Some(list) => {
                self.command_frame(all, NmtCommand { command: command.extended(), data: &list.0 }, out)
            }
            None => self.command_frame(all, NmtCommand { command, data: &[] }, out),
        }
    }

    fn command_frame(&self, to: NodeId, command: NmtCommand<'_>, out: &mut Writer<'_>) -> Result<(), Full> {
        self.asnd_header(to, ServiceId::NMT_COMMAND, out)?;
        command.emit(out)
    }

    fn asnd_header(&self, to: NodeId, service: ServiceId, out: &mut Writer<'_>) -> Result<(), Full> {
        let (source, from) = (self.config.mac, NodeId::MANAGING_NODE);
        Header { destination: group::ASND, source, message_type: MessageType::ASND, to, from }.emit(out)?;
        out.u8(service.0)
    }

    fn command_was_sent(&mut self, index: usize, command: NmtCommandId) {
        let (timeout, repeat) = (ticks(self.config.command_timeout), ticks(self.config.command_repeat));
        let Some(station) = self.stations.get_mut(index) else { return };
        if station.command.take().is_some() {
            if command.is_reset() && !matches!(station.phase, NodePhase::Absent | NodePhase::Restarting) {
                self.begin_anew(index);
            }
            return;
        }
        if command == NmtCommandId::STOP_NODE && station.phase != NodePhase::Stopped {
            self.enter_phase(index, NodePhase::Stopped, NodeCause::StopSent);
        }
        let Some(station) = self.stations.get_mut(index) else { return };
        station.pause = repeat;
        if station.sent.replace(command) != Some(command) {
            station.patience = timeout;
        }
    }

    fn broadcast_was_sent(&mut self, broadcast: Broadcast) {
        if self.opening == Opening::Quiet {
            self.settle();
        }
        for index in 0..self.stations.len() {
            let node = self.plans.get(index).map_or(NodeId::NONE, |plan| plan.node);
            let is_meant = broadcast.list.is_none_or(|list| list.contains(node));
            let is_polled = self.stations.get(index).is_some_and(|station| station.phase.is_polled());
            if is_meant && broadcast.command.is_reset() {
                self.begin_anew(index);
            } else if is_meant && is_polled && broadcast.command == NmtCommandId::STOP_NODE {
                self.enter_phase(index, NodePhase::Stopped, NodeCause::StopSent);
            }
        }
    }

    /// Nobody answered in the slot.
    pub(super) fn unanswered(&mut self) {
        let index = match self.slot {
            Slot::Status(index) | Slot::Request(index) | Slot::Invite(index) => index,
            _ => return,
        };
        count(&mut self.counters.unanswered);
        let threshold = self.config.status_threshold;
        let Some(station) = self.stations.get_mut(index) else { return };
        if !matches!(self.slot, Slot::Status(_)) {
            // It says again what it has.
            station.request = AsyncRequest::NONE;
            return;
        }
        station.unanswered = station.unanswered.saturating_add(1);
        if station.unanswered >= threshold && station.phase != NodePhase::Refused {
            self.lose(index, ErrorCode::NO_STATUS_RESPONSE);
        }
    }
}

const REASONS: [Reason; 6] =
    [Reason::Command, Reason::Request, Reason::Status, Reason::Invite, Reason::Sdo, Reason::Ident];
