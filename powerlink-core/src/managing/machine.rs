//! The machine: its parts, its clock, its doors between states.

use core::time::Duration;

use heapless::Vec;
use link_core::ethernet::{Action, Input, LinkEvent, Machine};
use link_core::timers::TimerKey;
use link_core::{Deadline, Instant, Queue, Timers};

use super::config::{Config, NodePlan};
use super::error::ConfigError;
use super::event::{MnCounters, MnEvent, count};
use super::schedule::{Broadcast, Slot, Turns};
use super::state::{MN_EDGES, MnCause, MnState, NODE_EDGES, NodeCause, NodePhase};
use super::station::Station;
use super::transfer::Application;
use crate::NodeId;
use crate::sdo::Client;
use crate::wire::Flags;

/// A managing node; see the [module](super) text.
///
/// There is room for `N` nodes, each with `DATA` bytes of process data in either direction, and for SDO values of `SDO` bytes,
/// four of which their address takes.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct ManagingNode<'p, const N: usize, const DATA: usize = 36, const SDO: usize = 256> {
    pub(super) config: Config,
    pub(super) plans: Vec<NodePlan<'p>, N>,
    pub(super) stations: Vec<Station<DATA>, N>,
    pub(super) state: MnState,
    pub(super) step: Step,
    /// The frame that is sent next.
    pub(super) due: Option<Due>,
    /// What the asynchronous slot is for.
    pub(super) slot: Slot,
    pub(super) turns: Turns,
    /// A command for all.
    pub(super) broadcast: Option<Broadcast>,
    /// The answer to an NMTRequest that is not followed.
    pub(super) invalid_request: Option<NodeId>,
    pub(super) client: Client<SDO>,
    /// The transfer of the client is the application's.
    pub(super) is_for_application: bool,
    pub(super) application: Application<SDO>,
    /// SoAs, then cycles, since the state was entered; while it listens, 1 once another managing node was heard.
    pub(super) rounds: u16,
    /// How far the reduced cycle is.
    pub(super) opening: Opening,
    /// The number of the cycle in a multiplexed cycle.
    pub(super) multiplexed: u8,
    /// Cycles since PS toggled.
    pub(super) prescaled: u16,
    /// MC and PS of the SoC.
    pub(super) soc_flags: Flags,
    /// µs
    pub(super) relative_time: u64,
    /// There may be nodes whose inputs ended, which was not told yet.
    pub(super) inputs_ended: bool,
    pub(super) counters: MnCounters,
    pub(super) timers: Timers<Timer, 5>,
    pub(super) events: Queue<MnEvent, EVENTS>,
}

/// Where it is in the cycle.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Step {
    /// It sends nothing.
    Silent,
    /// A SoC is sent: the first poll follows.
    Begin,
    /// A node is polled.
    Poll(usize),
    /// A SoA is sent.
    Slot,
    /// It waits for the next SoC.
    Rest,
}

/// A frame to be sent.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Due {
    Soc,
    Preq(usize),
    Soa,
    /// What the managing node invited itself to send.
    Own,
}

/// The begin of the reduced cycle.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Opening {
    /// SoAs without a request.
    Quiet,
    /// Every node was told NMTResetNode, and has time to do so.
    Settling,
    /// Nodes are asked.
    Done,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Timer {
    /// The slot or the poll is over.
    Slot,
    /// The next SoC.
    Cycle,
    /// The waits of the states.
    State,
    /// An SDO frame is not answered.
    Sdo,
    /// The waits of the nodes.
    Tick,
}

impl TimerKey<5> for Timer {
    const ALL: [Self; 5] = [Self::Slot, Self::Cycle, Self::State, Self::Sdo, Self::Tick];
    const WHY: [&'static str; 5] =
        ["answer of a node", "start of cycle", "state of the network", "SDO server", "supervision of nodes"];

    fn index(self) -> usize {
        match self {
            Self::Slot => 0,
            Self::Cycle => 1,
            Self::State => 2,
            Self::Sdo => 3,
            Self::Tick => 4,
        }
    }
}

impl<const N: usize, const DATA: usize, const SDO: usize> Machine for ManagingNode<'_, N, DATA, SDO> {
    type Event = MnEvent;

    fn input(&mut self, now: Instant, input: Input<'_>) {
        let now = self.timers.advance_inline(now);
        if self.timers.is_due(now.preceding()) {
            self.expire(now.preceding());
        }
        match input {
            Input::Frame(bytes) => self.frame(bytes),
            Input::Link(event) => self.link(event),
            Input::Tick => {}
        }
        if self.timers.is_due(now) {
            self.expire(now);
        }
    }

    fn poll<'b>(&mut self, now: Instant, buffer: &'b mut [u8]) -> Option<Action<'b, MnEvent>> {
        self.timers.advance_inline(now);
        self.output(buffer)
    }

    fn sent(&mut self, at: Instant) {
        self.was_sent(at.max(self.timers.now()));
    }

    fn deadline(&self) -> Option<Deadline> {
        if self.due.is_some() || !self.events.is_empty() || self.inputs_ended {
            return Some(Deadline::now(self.timers.now()));
        }
        self.timers.next()
    }
}

impl<'p, const N: usize, const DATA: usize, const SDO: usize> ManagingNode<'p, N, DATA, SDO> {
    /// A managing node for these nodes, which does nothing before [`start`](Self::start). They are polled in this order.
    ///
    /// # Errors
    /// [`ConfigError`] if a plan cannot be followed, or a cycle is too short for all of them.
    pub fn new(config: Config, plans: &[NodePlan<'p>]) -> Result<Self, ConfigError> {
        config.check(plans, DATA, SDO)?;
        if let Some(NodePlan { node, .. }) = plans.get(N) {
            return Err(ConfigError::TooManyNodes { node: *node, plans: plans.len(), room: N });
        }
        let stations = plans.iter().map(|plan| Station::new(plan.loss_of_pres_threshold, plan.output_len()));
        Ok(Self {
            config,
            stations: stations.collect(),
            plans: plans.iter().copied().collect(),
            state: MnState::Off,
            step: Step::Silent,
            due: None,
            slot: Slot::Nothing,
            turns: Turns::default(),
            broadcast: None,
            invalid_request: None,
            client: Client::new(),
            is_for_application: false,
            application: Application::new(),
            rounds: 0,
            opening: Opening::Quiet,
            multiplexed: 0,
            prescaled: 0,
            soc_flags: Flags::empty(),
            relative_time: 0,
            inputs_ended: false,
            counters: MnCounters::default(),
            timers: Timers::new(),
            events: Queue::new(),
        })
    }

    /// The one door between states of the managing node.
    pub(super) fn enter(&mut self, to: MnState, cause: MnCause) {
        let from = self.state;
        debug_assert!(
            MN_EDGES.iter().any(|edge| (edge.from, edge.cause, edge.to) == (from, cause, to)),
            "{from} -> {to} by {cause} is not in the table"
        );
        self.state = to;
        self.rounds = 0;
        self.raise(MnEvent::StateChanged { from, to, cause });
        match to {
            MnState::Off => self.fall_silent(),
            MnState::NotActive => {
                self.fall_silent();
                self.timers.set_after(Timer::State, self.config.wait_not_active);
            }
            MnState::PreOperational1 => {
                self.opening = Opening::Quiet;
                self.timers.set_after(Timer::Tick, TICK);
                self.due = Some(Due::Soa);
            }
            MnState::PreOperational2 => {
                (self.relative_time, self.multiplexed, self.prescaled) = (0, 0, 0);
                self.soc_flags = Flags::empty();
                self.timers.set_after(Timer::Cycle, Duration::ZERO);
                self.step = Step::Rest;
            }
            MnState::ReadyToOperate | MnState::Operational => {}
        }
    }

    /// The one door between phases of a node.
    pub(super) fn enter_phase(&mut self, index: usize, to: NodePhase, cause: NodeCause) {
        let (Some(station), Some(plan)) = (self.stations.get_mut(index), self.plans.get(index)) else {
            return;
        };
        let from = station.phase;
        debug_assert!(
            NODE_EDGES.iter().any(|edge| (edge.from, edge.cause, edge.to) == (from, cause, to)),
            "{from} -> {to} by {cause} is not in the table"
        );
        station.phase = to;
        station.clear_waits();
        if to == NodePhase::Absent {
            station.forget();
        }
        if !to.is_polled() {
            station.has_answered_poll = false;
        }
        let node = plan.node;
        if to != NodePhase::Operational {
            self.end_inputs(index);
        }
        self.raise(MnEvent::NodeChanged { node, from, to, cause });
        self.entered_phase(index, to);
    }

    /// Forgets everything on the way, and says nothing more.
    fn fall_silent(&mut self) {
        self.timers.clear_all();
        (self.step, self.due, self.slot) = (Step::Silent, None, Slot::Nothing);
        (self.broadcast, self.invalid_request) = (None, None);
        for index in 0..self.stations.len() {
            self.begin_anew(index);
            if let Some(station) = self.stations.get_mut(index) {
                station.command = None;
            }
        }
        self.drop_transfers();
    }

    /// A node that begins anew, whatever it was.
    pub(super) fn begin_anew(&mut self, index: usize) {
        if self.stations.get(index).is_some_and(|station| station.phase != NodePhase::Absent) {
            self.enter_phase(index, NodePhase::Absent, NodeCause::Reset);
        }
    }

    fn expire(&mut self, now: Instant) {
        // Each timer that is started again is later than `now`, or the loop ends by their number.
        for _ in 0..MAX_EXPIRED {
            let cycle = self.timers.at(Timer::Cycle);
            match self.timers.take_expired(now) {
                Some(Timer::Slot) => self.slot_is_over(),
                Some(Timer::Cycle) => self.cycle_is_over(cycle.unwrap_or(now)),
                Some(Timer::State) => self.wait_is_over(),
                Some(Timer::Sdo) => self.sdo_timeout(),
                Some(Timer::Tick) => {
                    self.timers.set_after(Timer::Tick, TICK);
                    self.tick();
                }
                None => return,
            }
        }
    }

    fn wait_is_over(&mut self) {
        match self.state {
            MnState::NotActive => self.enter(MnState::PreOperational1, MnCause::Quiet),
            // Nodes had their time to reset; or the reduced cycle has lasted long enough, which the next slot looks at.
            MnState::PreOperational1 if self.opening == Opening::Settling => {
                self.opening = Opening::Done;
                self.timers.set_after(Timer::State, self.config.wait_pre_operational_1);
            }
            MnState::Off
            | MnState::PreOperational1
            | MnState::PreOperational2
            | MnState::ReadyToOperate
            | MnState::Operational => {}
        }
    }

    fn link(&mut self, event: LinkEvent) {
        match event {
            LinkEvent::Up => {}
            LinkEvent::Down => count(&mut self.counters.links_lost),
            LinkEvent::CrcError => count(&mut self.counters.crc_errors),
            LinkEvent::Collision => count(&mut self.counters.collisions),
            LinkEvent::FramesLost { count } => {
                self.counters.frames_lost = self.counters.frames_lost.saturating_add(count.max(1));
            }
            LinkEvent::NotSent => count(&mut self.counters.not_sent),
        }
    }

    pub(super) fn index_of(&self, node: NodeId) -> Option<usize> {
        self.plans.iter().position(|plan| plan.node == node)
    }

    /// A node has no valid inputs any more.
    pub(super) fn end_inputs(&mut self, index: usize) {
        if let Some(station) = self.stations.get_mut(index) {
            station.inputs_valid = false;
            self.inputs_ended |= station.told_inputs;
        }
    }

    /// Tells the end of inputs. It does not wait in the queue of events, where it could be lost: all nodes may leave at once.
    pub(super) fn ended_inputs(&mut self) -> Option<MnEvent> {
        if !self.inputs_ended {
            return None;
        }
        let mut stations = self.plans.iter().zip(&mut self.stations);
        let ended = stations.find(|(_, station)| station.told_inputs && !station.inputs_valid);
        self.inputs_ended = ended.is_some();
        let (plan, station) = ended?;
        station.told_inputs = false;
        Some(MnEvent::Inputs { node: plan.node, is_valid: false })
    }

    pub(super) fn raise(&mut self, event: MnEvent) {
        if self.events.push(event).is_err() {
            count(&mut self.counters.events_lost);
        }
    }
}

/// A span in ticks, at least one.
pub(super) fn ticks(span: Duration) -> u32 {
    u32::try_from(span.as_nanos().div_ceil(TICK.as_nanos())).unwrap_or(u32::MAX).max(1)
}

/// How exactly the waits of the nodes are counted.
const TICK: Duration = Duration::from_millis(5);
const EVENTS: usize = 64;
const MAX_EXPIRED: usize = 16;
