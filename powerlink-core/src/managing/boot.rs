//! A node is brought from nowhere to operation, and supervised there.

use super::config::NodePlan;
use super::event::MnEvent;
use super::machine::{ManagingNode, Opening, Timer, ticks};
use super::state::{MnState, NodeCause, NodePhase};
use super::station::{Command, Goal};
use crate::MacAddress;
use crate::wire::{ErrorCode, Flags, IdentResponse, NmtCommandId, NmtStateCode, StatusResponse};

impl<const N: usize, const DATA: usize, const SDO: usize> ManagingNode<'_, N, DATA, SDO> {
    /// Every node was told NMTResetNode.
    pub(super) fn settle(&mut self) {
        self.opening = Opening::Settling;
        self.timers.set_after(Timer::State, self.config.wait_after_reset);
    }

    pub(super) fn entered_phase(&mut self, index: usize, phase: NodePhase) {
        let (retry_after, period) = (ticks(self.config.retry_after), ticks(self.config.status_period));
        let (Some(station), Some(plan)) = (self.stations.get_mut(index), self.plans.get(index)) else {
            return;
        };
        let node = plan.node;
        match phase {
            NodePhase::Absent => self.drop_transfer(node),
            NodePhase::Clearing => station.step = 0,
            NodePhase::Restarting => {
                let (command, reason) = (NmtCommandId::RESET_CONFIGURATION, ErrorCode::NONE);
                station.command = Some(Command { command, reason });
                self.drop_transfer(node);
            }
            NodePhase::Refused => {
                (station.patience, station.tries) = (retry_after, 0);
                self.drop_transfer(node);
            }
            NodePhase::PreOperational2 => station.status_in = period,
            NodePhase::Operational => (station.tries, station.status_in) = (0, period),
            NodePhase::Signalling
            | NodePhase::Configuring
            | NodePhase::Configured
            | NodePhase::ReadyToOperate
            | NodePhase::Stopped => {}
        }
    }

    pub(super) fn ident(&mut self, index: usize, mac: MacAddress, ident: &IdentResponse) {
        let (Some(station), Some(plan)) = (self.stations.get_mut(index), self.plans.get(index)) else {
            return;
        };
        station.identity = Some(ident.identity);
        station.shown = ident.state;
        station.request = ident.request;
        let limits = (ident.poll_in_size, ident.poll_out_size);
        let has_limits = limits == (plan.preq_limit, plan.pres_limit);
        let has_stamp = plan.configuration.is_none_or(|stamp| stamp == ident.configuration);
        match station.phase {
            NodePhase::Absent if station.command.is_some() => {}
            NodePhase::Absent => {
                (station.mac, station.limits) = (mac, limits);
                station.has_configuration = plan.configuration.is_some() && has_stamp && has_limits;
                if let Some(reason) = mismatch(plan, ident) {
                    self.refuse(index, reason, NodeCause::Mismatch);
                } else if is_beyond_boot(ident.state) {
                    // It did not hear the reset, and is where nobody brought it.
                    let (command, reason) = (NmtCommandId::RESET_NODE, ErrorCode::WRONG_STATE);
                    station.command = Some(Command { command, reason });
                } else {
                    self.enter_phase(index, NodePhase::Clearing, NodeCause::Identified);
                }
            }
            NodePhase::Restarting if station.command.is_some() => {}
            NodePhase::Restarting => {
                if let Some(reason) = mismatch(plan, ident) {
                    self.refuse(index, reason, NodeCause::Mismatch);
                } else if has_limits && has_stamp {
                    (station.mac, station.limits) = (mac, limits);
                    self.enter_phase(index, NodePhase::Configured, NodeCause::Identified);
                } else {
                    (station.limits, station.has_configuration) = (limits, false);
                    station.tries = station.tries.saturating_add(1);
                    if station.tries >= MOST_TRIES {
                        self.refuse(index, ErrorCode::BOOT_CONFIGURATION, NodeCause::Mismatch);
                    } else {
                        self.enter_phase(index, NodePhase::Clearing, NodeCause::NotTaken);
                    }
                }
            }
            NodePhase::Clearing
            | NodePhase::Signalling
            | NodePhase::Configuring
            | NodePhase::Configured
            | NodePhase::PreOperational2
            | NodePhase::ReadyToOperate
            | NodePhase::Operational
            | NodePhase::Stopped
            | NodePhase::Refused => {}
        }
    }

    pub(super) fn status(&mut self, index: usize, status: &StatusResponse) {
        let period = ticks(self.config.status_period);
        let (Some(station), Some(plan)) = (self.stations.get_mut(index), self.plans.get(index)) else {
            return;
        };
        let node = plan.node;
        station.shown = status.state;
        station.request = status.request;
        (station.unanswered, station.status_in) = (0, period);
        let is_cleared = status.flags.contains(Flags::EXCEPTION_CLEAR);
        match station.phase {
            NodePhase::Clearing if is_cleared => {
                station.exception_acknowledge = false;
                return self.enter_phase(index, NodePhase::Signalling, NodeCause::ExceptionClear);
            }
            NodePhase::Signalling if !is_cleared => {
                return self.enter_phase(index, NodePhase::Configuring, NodeCause::SignallingRuns);
            }
            NodePhase::Clearing | NodePhase::Signalling => {
                station.wrong = station.wrong.saturating_add(1);
                if station.wrong < STUCK {
                    return;
                }
                if station.phase == NodePhase::Clearing {
                    return self.lose(index, ErrorCode::BOOT_CHECK_COMMUNICATION);
                }
                return self.enter_phase(index, NodePhase::Clearing, NodeCause::SignallingStuck);
            }
            NodePhase::Absent | NodePhase::Refused => return,
            // It was switched off and on again, and begins anew by itself.
            _ if is_cleared => return self.give_up(index, ErrorCode::WRONG_STATE),
            _ => {}
        }
        if station.request.count() == 0 {
            // It has nothing to say yet.
            station.status_pause = 1;
        }
        let is_new = status.flags.contains(Flags::EXCEPTION_NEW);
        station.exception_new = is_new;
        if core::mem::replace(&mut station.exception_acknowledge, is_new) != is_new {
            for entry in status.errors() {
                self.raise(MnEvent::NodeError { node, code: entry.code });
            }
        }
        self.follow_state(index);
    }

    /// Goes on with a node by the state that it shows.
    pub(super) fn follow_state(&mut self, index: usize) {
        let Some(station) = self.stations.get_mut(index) else { return };
        let (phase, shown, goal) = (station.phase, station.shown, station.goal);
        let next = match (phase, shown) {
            (NodePhase::Configured, NmtStateCode::PRE_OPERATIONAL_2) if self.state.is_cyclic() => {
                NodePhase::PreOperational2
            }
            (NodePhase::PreOperational2, NmtStateCode::READY_TO_OPERATE) => NodePhase::ReadyToOperate,
            (NodePhase::ReadyToOperate, NmtStateCode::OPERATIONAL) if self.state == MnState::Operational => {
                NodePhase::Operational
            }
            (NodePhase::Operational, NmtStateCode::PRE_OPERATIONAL_2) if goal == Goal::PreOperational2 => {
                NodePhase::PreOperational2
            }
            (NodePhase::Stopped, NmtStateCode::PRE_OPERATIONAL_2) if goal != Goal::Stopped => {
                NodePhase::PreOperational2
            }
            (NodePhase::Configured, NmtStateCode::PRE_OPERATIONAL_1 | NmtStateCode::PRE_OPERATIONAL_2)
            | (NodePhase::PreOperational2, NmtStateCode::PRE_OPERATIONAL_2)
            | (NodePhase::ReadyToOperate, NmtStateCode::READY_TO_OPERATE)
            | (NodePhase::Operational, NmtStateCode::OPERATIONAL) => return station.wrong = 0,
            (NodePhase::Stopped, NmtStateCode::STOPPED) => {
                if goal == Goal::Stopped {
                    station.clear_waits();
                }
                return;
            }
            (
                NodePhase::Configured
                | NodePhase::PreOperational2
                | NodePhase::ReadyToOperate
                | NodePhase::Operational,
                _,
            ) => return self.wrong_state(index),
            // Stopping has its own time-out; before, states do not matter.
            (
                NodePhase::Absent
                | NodePhase::Clearing
                | NodePhase::Signalling
                | NodePhase::Configuring
                | NodePhase::Restarting
                | NodePhase::Stopped
                | NodePhase::Refused,
                _,
            ) => return,
        };
        self.enter_phase(index, next, NodeCause::StateShown);
    }

    fn wrong_state(&mut self, index: usize) {
        let threshold = self.config.state_threshold;
        let Some(station) = self.stations.get_mut(index) else { return };
        station.wrong = station.wrong.saturating_add(1);
        if station.wrong >= threshold {
            self.lose(index, ErrorCode::WRONG_STATE);
        }
    }

    /// A node is lost, and begins anew.
    fn give_up(&mut self, index: usize, reason: ErrorCode) {
        let Some(node) = self.plans.get(index).map(|plan| plan.node) else { return };
        self.raise(MnEvent::NodeLost { node, reason });
        if self.stations.get(index).is_some_and(|station| station.phase != NodePhase::Absent) {
            self.enter_phase(index, NodePhase::Absent, NodeCause::Lost);
        }
    }

    /// A node is lost, and is told to reset.
    pub(super) fn lose(&mut self, index: usize, reason: ErrorCode) {
        self.give_up(index, reason);
        if let Some(station) = self.stations.get_mut(index) {
            station.command = Some(Command { command: NmtCommandId::RESET_NODE, reason });
        }
    }

    pub(super) fn refuse(&mut self, index: usize, reason: ErrorCode, cause: NodeCause) {
        let Some(node) = self.plans.get(index).map(|plan| plan.node) else { return };
        self.raise(MnEvent::NodeRefused { node, reason });
        self.enter_phase(index, NodePhase::Refused, cause);
    }

    /// The waits of the nodes.
    pub(super) fn tick(&mut self) {
        for index in 0..self.stations.len() {
            let Some(station) = self.stations.get_mut(index) else { return };
            station.pause = station.pause.saturating_sub(1);
            station.status_pause = station.status_pause.saturating_sub(1);
            station.status_in = station.status_in.saturating_sub(1);
            if station.patience == 0 {
                continue;
            }
            station.patience = station.patience.saturating_sub(1);
            if station.patience > 0 {
                continue;
            }
            match station.phase {
                NodePhase::Refused => self.enter_phase(index, NodePhase::Absent, NodeCause::Retry),
                NodePhase::PreOperational2 => self.lose(index, ErrorCode::BOOT_STEP_2),
                NodePhase::ReadyToOperate | NodePhase::Operational => {
                    self.lose(index, ErrorCode::WRONG_STATE);
                }
                NodePhase::Stopped
                    if station.goal != Goal::Stopped || station.shown != NmtStateCode::STOPPED =>
                {
                    self.lose(index, ErrorCode::WRONG_STATE);
                }
                NodePhase::Absent
                | NodePhase::Clearing
                | NodePhase::Signalling
                | NodePhase::Configuring
                | NodePhase::Restarting
                | NodePhase::Configured
                | NodePhase::Stopped => {}
            }
        }
    }
}

/// What of an IdentResponse is not what the plan says.
fn mismatch(plan: &NodePlan<'_>, ident: &IdentResponse) -> Option<ErrorCode> {
    let identity = ident.identity;
    let checks = [
        (plan.device_type, ident.device_type, ErrorCode::BOOT_DEVICE_TYPE),
        (plan.vendor_id, identity.vendor_id, ErrorCode::BOOT_VENDOR_ID),
        (plan.product_code, identity.product_code, ErrorCode::BOOT_PRODUCT_CODE),
        (plan.revision, identity.revision, ErrorCode::BOOT_REVISION),
        (plan.serial_number, identity.serial_number, ErrorCode::BOOT_SERIAL),
    ];
    let wrong = checks.into_iter().find(|(wanted, is, _)| wanted.is_some_and(|wanted| wanted != *is));
    wrong.map(|(_, _, reason)| reason)
}

/// States in which a node cannot be that nobody brought there.
const fn is_beyond_boot(state: NmtStateCode) -> bool {
    matches!(state, NmtStateCode::READY_TO_OPERATE | NmtStateCode::OPERATIONAL | NmtStateCode::STOPPED)
}

/// How often a node may fail to show its configuration.
const MOST_TRIES: u8 = 3;
/// StatusResponses without the EC that is waited for.
const STUCK: u8 = 8;
