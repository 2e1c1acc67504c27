//! What the application asks of the managing node, and what it can ask about it.

use core::time::Duration;

use link_core::Instant;

use super::config::{Config, NodePlan};
use super::error::MnError;
use super::event::MnCounters;
use super::machine::ManagingNode;
use super::schedule::Broadcast;
use super::state::{MnCause, MnState, NodePhase};
use super::station::{Command, Goal};
use crate::NodeId;
use crate::wire::{ErrorCode, Identity, NmtCommandId, NodeList};

impl<'p, const N: usize, const DATA: usize, const SDO: usize> ManagingNode<'p, N, DATA, SDO> {
    /// Begins: it listens, and then takes over the network. Does nothing if it has begun.
    pub fn start(&mut self, now: Instant) {
        self.timers.advance(now);
        if self.state == MnState::Off {
            self.enter(MnState::NotActive, MnCause::Start);
        }
    }

    /// Falls silent at once. Nodes notice that themselves.
    pub fn stop(&mut self, now: Instant) {
        self.timers.advance(now);
        if self.state != MnState::Off {
            self.enter(MnState::Off, MnCause::Stop);
        }
    }

    /// Brings a node to a state, or resets it. What it is to be stays, also for when the node comes back later:
    ///
    /// | Command | The node |
    /// |---|---|
    /// | NMTStartNode | is brought to `Operational`, as it is from the beginning |
    /// | NMTStopNode | is brought to `Stopped` |
    /// | NMTEnterPreOperational2 | is brought to `PreOperational2`, and stays there |
    /// | NMTEnableReadyToOperate | is sent that, and nothing else changes |
    /// | the four resets | is sent that, and brought again to where it is to be |
    ///
    /// # Errors
    /// [`MnError`] if the node has no plan, or it is no command for one node.
    pub fn command(&mut self, node: NodeId, command: NmtCommandId) -> Result<(), MnError> {
        let index = self.index_of(node).ok_or(MnError::NoPlan(node))?;
        let station = self.stations.get_mut(index).ok_or(MnError::NoPlan(node))?;
        match goal(command)? {
            Some(goal) => station.pursue(goal),
            None => station.command = Some(Command { command, reason: ErrorCode::NONE }),
        }
        Ok(())
    }

    /// Does the same with every node, by one frame.
    ///
    /// # Errors
    /// [`MnError::Command`] if it is no command for nodes.
    pub fn command_all(&mut self, command: NmtCommandId) -> Result<(), MnError> {
        self.command_some(command, None)
    }

    /// Does the same with the nodes of a list, by one frame: the extended command of a plain one.
    ///
    /// # Errors
    /// [`MnError::Command`] if it is no command for nodes.
    pub fn command_list(&mut self, command: NmtCommandId, list: NodeList) -> Result<(), MnError> {
        self.command_some(command, Some(list))
    }

    fn command_some(&mut self, command: NmtCommandId, list: Option<NodeList>) -> Result<(), MnError> {
        let goal = goal(command)?;
        let nodes = self.plans.iter().zip(&mut self.stations);
        for (_, station) in nodes.filter(|(plan, _)| list.is_none_or(|list| list.contains(plan.node))) {
            if let Some(goal) = goal {
                station.pursue(goal);
            }
        }
        self.broadcast = Some(Broadcast { command, list });
        Ok(())
    }

    /// Sets the process data of a node's PReq, all of them. They count (RD) while the managing node is in `Operational`; before
    /// this is called for the first time, they are zeros that do not count.
    ///
    /// # Errors
    /// [`MnError`] if the node has no plan, they are not as long as its plan maps, or, where that maps nothing, longer than its
    /// limit.
    pub fn set_outputs(&mut self, node: NodeId, data: &[u8]) -> Result<(), MnError> {
        let index = self.index_of(node).ok_or(MnError::NoPlan(node))?;
        let (Some(plan), Some(station)) = (self.plans.get(index), self.stations.get_mut(index)) else {
            return Err(MnError::NoPlan(node));
        };
        let (len, limit, mapped) = (data.len(), plan.preq_limit, plan.output_len());
        if !plan.outputs.is_empty() && len != mapped {
            return Err(MnError::OutputLength { node, len, mapped });
        }
        if len > usize::from(limit) || !station.outputs.set(data) {
            return Err(MnError::TooLong { node, len, limit });
        }
        station.has_outputs = true;
        Ok(())
    }

    /// The process data of a node's last PRes, while they are valid.
    #[must_use]
    pub fn inputs(&self, node: NodeId) -> Option<&[u8]> {
        let station = self.stations.get(self.index_of(node)?)?;
        station.inputs_valid.then(|| station.inputs.get())
    }

    /// The NMT state.
    #[must_use]
    pub const fn state(&self) -> MnState {
        self.state
    }

    /// How far it is with a node.
    #[must_use]
    pub fn phase(&self, node: NodeId) -> Option<NodePhase> {
        Some(self.stations.get(self.index_of(node)?)?.phase)
    }

    /// Whether every node is where the application wants it.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.state == MnState::Operational
            && self.stations.iter().all(|station| match station.goal {
                Goal::Operational => station.phase == NodePhase::Operational,
                Goal::PreOperational2 => station.phase == NodePhase::PreOperational2,
                Goal::Stopped => station.phase == NodePhase::Stopped,
            })
    }

    /// Who a node said that it is.
    #[must_use]
    pub fn identity(&self, node: NodeId) -> Option<Identity> {
        self.stations.get(self.index_of(node)?)?.identity
    }

    /// What it was told at the start.
    #[must_use]
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// The nodes.
    #[must_use]
    pub fn plans(&self) -> &[NodePlan<'p>] {
        &self.plans
    }

    /// What it counted.
    #[must_use]
    pub const fn counters(&self) -> &MnCounters {
        &self.counters
    }

    /// Sets all that it [counted](Self::counters) to 0.
    pub fn clear_counters(&mut self) {
        self.counters = MnCounters::default();
    }

    /// Moves every instant that the machine stores towards zero, so that a model checker can compare histories of different
    /// age.
    pub fn shift_time(&mut self, span: Duration) {
        self.timers.shift(span);
    }
}

/// Where a command leads; `None` if it is sent as it is.
fn goal(command: NmtCommandId) -> Result<Option<Goal>, MnError> {
    match command {
        NmtCommandId::START_NODE => Ok(Some(Goal::Operational)),
        NmtCommandId::STOP_NODE => Ok(Some(Goal::Stopped)),
        NmtCommandId::ENTER_PRE_OPERATIONAL_2 => Ok(Some(Goal::PreOperational2)),
        NmtCommandId::ENABLE_READY_TO_OPERATE => Ok(None),
        _ if command.is_reset() => Ok(None),
        _ => Err(MnError::Command(command)),
    }
}
