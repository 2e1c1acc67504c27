//! The cycle: what is sent when.

use core::time::Duration;

use link_core::Instant;
use link_core::codec::Full;
use link_core::ethernet::Action;

use super::event::{MnEvent, count};
use super::machine::{Due, ManagingNode, Opening, Step, Timer};
use super::schedule::Slot;
use super::state::{MnCause, MnState, NodePhase};
use super::station::{Goal, Station};
use super::timing::{poll_time, slot_time, wire_time};
use crate::ethernet::group;
use crate::wire::{Body, Flags, Frame, NetTime, POWERLINK_V2, Preq, RequestedService, Soa, Soc};
use crate::{MacAddress, NodeId};

impl<const N: usize, const DATA: usize, const SDO: usize> ManagingNode<'_, N, DATA, SDO> {
    /// The next thing to do: frames before events.
    pub(super) fn output<'b>(&mut self, buffer: &'b mut [u8]) -> Option<Action<'b, MnEvent>> {
        let sent = match self.due.take() {
            None => return self.events.pop().map(Action::Event),
            Some(Due::Soc) => self.soc_frame(buffer),
            Some(Due::Preq(index)) => self.preq_frame(index, buffer),
            Some(Due::Soa) => self.soa_frame(buffer),
            Some(Due::Own) => self.own_frame(buffer),
        };
        if let Ok(frame) = sent {
            Some(Action::Transmit(frame))
        } else {
            count(&mut self.counters.not_sent);
            Some(Action::Event(MnEvent::BufferTooShort))
        }
    }

    fn soc_frame<'b>(&mut self, buffer: &'b mut [u8]) -> Result<&'b [u8], Full> {
        count(&mut self.counters.cycles);
        self.rounds = self.rounds.saturating_add(1);
        let soc =
            Soc { flags: self.soc_flags, net_time: NetTime::default(), relative_time: self.relative_time };
        self.after_soc();
        self.step = Step::Begin;
        self.timers.set_after(Timer::Slot, wire_time(0).saturating_add(self.config.wait_soc_preq));
        self.frame_to_all(group::SOC, Body::Soc(soc)).emit(buffer)
    }

    /// What the next SoC shows. The first of every multiplexed cycle has another MC.
    fn after_soc(&mut self) {
        let micros = u64::try_from(self.config.cycle.as_micros()).unwrap_or(u64::MAX);
        self.relative_time = self.relative_time.saturating_add(micros);
        self.prescaled = self.prescaled.saturating_add(1);
        if self.config.prescaler > 0 && self.prescaled >= self.config.prescaler {
            self.prescaled = 0;
            self.soc_flags.toggle(Flags::PRESCALED);
        }
    }

    /// After the polls of a cycle.
    fn next_multiplexed(&mut self) {
        self.multiplexed = self.multiplexed.saturating_add(1);
        if self.multiplexed >= self.config.multiplexed_cycles {
            self.multiplexed = 0;
            if self.config.multiplexed_cycles > 0 {
                self.soc_flags.toggle(Flags::MULTIPLEXED_CYCLE);
            }
        }
    }

    fn preq_frame<'b>(&mut self, index: usize, buffer: &'b mut [u8]) -> Result<&'b [u8], Full> {
        self.step = Step::Poll(index);
        let (Some(plan), Some(station)) = (self.plans.get(index), self.stations.get(index)) else {
            return Err(Full);
        };
        self.timers.set_after(Timer::Slot, poll_time(plan));
        let mut flags = Flags::empty();
        flags.set(Flags::MULTIPLEXED, plan.multiplexed_slot.is_some());
        flags.set(Flags::EXCEPTION_ACKNOWLEDGE, station.exception_acknowledge);
        flags.set(Flags::DATA_VALID, self.state == MnState::Operational && station.has_outputs);
        let preq = Preq { flags, pdo_version: plan.pdo_version, data: station.outputs.get() };
        let (source, from) = (self.config.mac, NodeId::MANAGING_NODE);
        Frame { destination: station.mac, source, to: plan.node, from, body: Body::Preq(preq) }.emit(buffer)
    }

    fn soa_frame<'b>(&mut self, buffer: &'b mut [u8]) -> Result<&'b [u8], Full> {
        if self.state == MnState::PreOperational1 {
            self.rounds = self.rounds.saturating_add(1);
        }
        self.slot = self.next_slot();
        let (service, target) = self.invitation();
        let mut flags = Flags::empty();
        if let Some(station) = self.index_of(target).and_then(|index| self.stations.get(index)) {
            flags.set(Flags::EXCEPTION_RESET, station.phase == NodePhase::Clearing);
            flags.set(Flags::EXCEPTION_ACKNOWLEDGE, station.exception_acknowledge);
        }
        let has_own = self.has_own();
        if has_own {
            self.due = Some(Due::Own);
        }
        self.step = Step::Slot;
        let own = if has_own { wire_time(0) } else { Duration::ZERO };
        self.timers.set_after(Timer::Slot, slot_time(&self.config).saturating_add(own));
        let soa = Soa { state: self.state.code(), flags, service, target, version: POWERLINK_V2 };
        self.frame_to_all(group::SOA, Body::Soa(soa)).emit(buffer)
    }

    fn invitation(&self) -> (RequestedService, NodeId) {
        let node = |index: usize| self.plans.get(index).map_or(NodeId::NONE, |plan| plan.node);
        match self.slot {
            Slot::Nothing => (RequestedService::NO_SERVICE, NodeId::NONE),
            Slot::Ident(node) => (RequestedService::IDENT_REQUEST, node),
            Slot::Status(index) => (RequestedService::STATUS_REQUEST, node(index)),
            Slot::Request(index) => (RequestedService::NMT_REQUEST_INVITE, node(index)),
            Slot::Invite(index) => (RequestedService::UNSPECIFIED_INVITE, node(index)),
            Slot::Broadcast(_) | Slot::Command(..) | Slot::InvalidRequest(_) => {
                (RequestedService::NMT_REQUEST_INVITE, NodeId::MANAGING_NODE)
            }
            Slot::Sdo => (RequestedService::UNSPECIFIED_INVITE, NodeId::MANAGING_NODE),
        }
    }

    pub(super) const fn frame_to_all<'a>(&self, destination: MacAddress, body: Body<'a>) -> Frame<'a> {
        let (source, from) = (self.config.mac, NodeId::MANAGING_NODE);
        Frame { destination, source, to: NodeId::BROADCAST, from, body }
    }

    /// The time of whatever was waited for is over.
    pub(super) fn slot_is_over(&mut self) {
        match self.step {
            Step::Begin => self.poll_after(None),
            Step::Poll(index) => {
                self.pres_is_lost(index);
                self.poll_after(Some(index));
            }
            Step::Slot => {
                self.unanswered();
                self.end_slot();
            }
            Step::Silent | Step::Rest => {}
        }
    }

    /// Polls the next node of this cycle, or begins the asynchronous phase.
    pub(super) fn poll_after(&mut self, index: Option<usize>) {
        self.timers.clear(Timer::Slot);
        let first = index.map_or(0, |index| index.saturating_add(1));
        let next = (first..self.stations.len()).find(|&index| self.is_polled_now(index));
        self.due = Some(next.map_or(Due::Soa, Due::Preq));
        if next.is_none() {
            self.next_multiplexed();
        }
    }

    fn is_polled_now(&self, index: usize) -> bool {
        let (Some(plan), Some(station)) = (self.plans.get(index), self.stations.get(index)) else {
            return false;
        };
        station.phase.is_polled()
            && !plan.is_async_only
            && plan.multiplexed_slot.is_none_or(|slot| slot == self.multiplexed)
    }

    /// The asynchronous slot is over.
    pub(super) fn end_slot(&mut self) {
        self.timers.clear(Timer::Slot);
        self.slot = Slot::Nothing;
        if self.state == MnState::PreOperational1 {
            self.reduced_cycle();
        } else if self.state.is_cyclic() {
            self.step = Step::Rest;
            if core::mem::take(&mut self.is_late) {
                self.begin_cycle();
            }
        }
    }

    /// The next SoA of the reduced cycle, or the first SoC.
    fn reduced_cycle(&mut self) {
        if self.opening == Opening::Quiet && self.rounds == QUIET {
            self.broadcast_reset();
        }
        let is_over = self.opening == Opening::Done && self.timers.at(Timer::State).is_none();
        if is_over && self.every_mandatory(|station| station.phase.is_configured()) {
            return self.enter(MnState::PreOperational2, MnCause::NodesConfigured);
        }
        self.due = Some(Due::Soa);
    }

    /// It is time for the next SoC, which should have been at `at`.
    pub(super) fn cycle_is_over(&mut self, at: Instant) {
        // A cycle that was missed is not made up for.
        let next = at.saturating_add(self.config.cycle);
        self.timers.set(Timer::Cycle, next.max(self.timers.now()));
        if self.step == Step::Rest {
            self.begin_cycle();
        } else {
            count(&mut self.counters.cycles_exceeded);
            self.is_late = true;
        }
    }

    fn begin_cycle(&mut self) {
        match self.state {
            MnState::PreOperational2 if self.every_mandatory(is_ready) => {
                self.enter(MnState::ReadyToOperate, MnCause::NodesReady);
            }
            MnState::ReadyToOperate if self.rounds >= self.config.check_cycles => {
                self.enter(MnState::Operational, MnCause::CommunicationChecked);
            }
            MnState::Off
            | MnState::NotActive
            | MnState::PreOperational1
            | MnState::PreOperational2
            | MnState::ReadyToOperate
            | MnState::Operational => {}
        }
        self.due = Some(Due::Soc);
    }

    fn every_mandatory(&self, holds: impl Fn(&Station<DATA>) -> bool) -> bool {
        let nodes = self.plans.iter().zip(&self.stations);
        nodes.filter(|(plan, _)| plan.is_mandatory).all(|(_, station)| holds(station))
    }
}

/// Ready to operate, or where the application wants it instead.
fn is_ready<const DATA: usize>(station: &Station<DATA>) -> bool {
    match station.phase {
        NodePhase::ReadyToOperate | NodePhase::Operational | NodePhase::Stopped => true,
        NodePhase::PreOperational2 => station.goal == Goal::PreOperational2,
        _ => false,
    }
}

/// SoAs without a request at the begin of `PreOperational1`.
const QUIET: u16 = 10;
