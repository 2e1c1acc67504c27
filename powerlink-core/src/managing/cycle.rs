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
            None => return self.events.pop().or_else(|| self.ended_inputs()).map(Action::Event),
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
        self.begin_wait();
        self.frame_to_all(group::SOC, Body::Soc(soc)).emit(buffer)
    }

    /// What the next SoC shows. The first of every multiplexed cycle has another MC.
    fn after_soc(&mut self) {
        self.pass_cycles(1);
        self.prescaled = self.prescaled.saturating_add(1);
        if self.config.prescaler > 0 && self.prescaled >= self.config.prescaler {
            self.prescaled = 0;
            self.soc_flags.toggle(Flags::PRESCALED);
        }
    }

    /// RelativeTime goes on, whether a SoC is sent or left out.
    fn pass_cycles(&mut self, count: u64) {
        let micros = u64::from(self.cycle_micros()).saturating_mul(count);
        self.relative_time = self.relative_time.saturating_add(micros);
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
        self.begin_wait();
        let (Some(plan), Some(station)) = (self.plans.get(index), self.stations.get(index)) else {
            return Err(Full);
        };
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
        if self.has_own() {
            self.due = Some(Due::Own);
        }
        self.step = Step::Slot;
        self.begin_wait();
        let soa = Soa { state: self.state.code(), flags, service, target, version: POWERLINK_V2 };
        self.frame_to_all(group::SOA, Body::Soa(soa)).emit(buffer)
    }

    /// What was just sent leaves the others their time. A driver that knows better when that was tells it with `was_sent`.
    fn begin_wait(&mut self) {
        if let Some(span) = self.wait() {
            self.timers.set_after(Timer::Slot, span);
        }
    }

    /// How long it waits after the frame of its step.
    fn wait(&self) -> Option<Duration> {
        match self.step {
            Step::Begin => Some(wire_time(0).saturating_add(self.config.wait_soc_preq)),
            Step::Poll(index) => self.plans.get(index).map(poll_time),
            Step::Slot => {
                let own = if self.has_own() { wire_time(0) } else { Duration::ZERO };
                Some(slot_time(&self.config).saturating_add(own))
            }
            Step::Silent | Step::Rest => None,
        }
    }

    /// The frame that was made last left at this moment. Time-outs count from there, and so does the time between two SoCs.
    pub(super) fn was_sent(&mut self, at: Instant) {
        let is_own = self.step == Step::Slot && self.has_own() && self.due.is_none();
        // The slot of an own frame began with its SoA.
        if let Some(span) = self.wait().filter(|_| !is_own) {
            self.timers.set(Timer::Slot, at.saturating_add(span));
        }
        if self.step == Step::Begin
            && let Some(next) = self.timers.at(Timer::Cycle)
        {
            self.next_cycle(next, at.saturating_add(self.half_a_cycle()));
        }
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

    /// It is time for the next SoC, which should have been at `at`. A late one is sent up to the middle of its cycle; what cannot be
    /// sent by then, or while the cycle before is not over, is left out and not made up for.
    pub(super) fn cycle_is_over(&mut self, at: Instant) {
        let now = self.timers.now();
        let is_over = self.step == Step::Rest;
        if is_over && now < at.saturating_add(self.half_a_cycle()) {
            self.timers.set(Timer::Cycle, at.saturating_add(self.config.cycle));
            return self.begin_cycle();
        }
        // The SoC of the cycle that now is may still be sent, unless the cycle before is not over.
        let still = if is_over { self.half_a_cycle() } else { Duration::ZERO };
        self.next_cycle(at, now.saturating_add_nanos(1).saturating_sub(still));
    }

    /// The next SoC is at the first moment of the grid, which `at` is one of, that is not before `earliest`. Those between are
    /// left out.
    fn next_cycle(&mut self, at: Instant, earliest: Instant) {
        let cycle = u64::from(self.cycle_micros()).saturating_mul(1_000);
        let missing = u64::try_from(earliest.saturating_since(at).as_nanos()).unwrap_or(u64::MAX);
        let missed = missing.saturating_add(cycle.saturating_sub(1)).checked_div(cycle).unwrap_or(0);
        self.timers.set(Timer::Cycle, at.saturating_add_nanos(cycle.saturating_mul(missed)));
        if missed > 0 {
            self.pass_cycles(missed);
            let exceeded = &mut self.counters.cycles_exceeded;
            *exceeded = exceeded.saturating_add(u32::try_from(missed).unwrap_or(u32::MAX));
            self.raise(MnEvent::CycleExceeded);
        }
    }

    fn half_a_cycle(&self) -> Duration {
        self.config.cycle.checked_div(2).unwrap_or_default()
    }

    /// The length of a cycle; without one that 0x1006 can say, there is no managing node.
    pub(super) fn cycle_micros(&self) -> u32 {
        self.config.cycle_micros().unwrap_or(u32::MAX)
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
