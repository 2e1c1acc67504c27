//! The master machine: the node that it is, the slaves, the scan.

use core::time::Duration;

use heapless::Vec;
use link_core::timers::TimerKey;
use link_core::{
    Action, BusErrorKind, Deadline, FilterSet, Input, Instant, LinkCommand, LinkEvent, Machine, Timers,
};

use super::board::{Board, Known};
use super::config::Config;
use super::cycle::Cycle;
use super::event::{Counters, MasterEvent};
use super::lanes::Lanes;
use super::node::{OwnNode, Scanner};
use super::replacement::{Candidate, ReplacementMode};
use super::slot::{Output, Slot, SlotTimer};
use super::state::{Cause, Stage};
use crate::access::NetworkStatus;
use crate::collision;
use crate::counter::count;
use crate::id::{self, MacId};
use crate::slave;

/// A DeviceNet master; see the [module](super) text.
///
/// `SLAVES` is the length of the scan list, at most 63; `MESSAGE` the longest explicit body and I/O message, and the
/// room for each slave's attribute writes.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Master<const SLAVES: usize, const MESSAGE: usize> {
    pub(super) config: Config,
    pub(super) node: OwnNode,
    /// What its network access said the last time that it was looked at.
    pub(super) on_line: bool,
    pub(super) run: bool,
    /// In the order of their MAC IDs; `board` leads to them.
    pub(super) slots: Vec<Slot<MESSAGE>, SLAVES>,
    pub(super) board: Board<SLAVES>,
    pub(super) multicast_output: Output<MESSAGE>,
    pub(super) candidate: Candidate<MESSAGE>,
    pub(super) cycle: Cycle,
    pub(super) lanes: Lanes,
    pub(super) timers: Timers<Timer, 5>,
    pub(super) counters: Counters,
    /// Missing responses of the scan that was completed.
    pub(super) scan_done: Option<u8>,
    pub(super) filter_due: bool,
    pub(super) shown: NetworkStatus,
    /// Nobody acknowledges what it sends.
    pub(super) unacknowledged: bool,
}

/// The waits of the scan, one of the explicit lane, and one of the scanner status.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Timer {
    Interscan,
    ResponseWait,
    Quiet,
    /// Requests to unconnected ports wait after a collision.
    BackOff,
    /// Frames were lost, and the status says so.
    Overrun,
}

impl TimerKey<5> for Timer {
    const ALL: [Self; 5] = [Self::Interscan, Self::ResponseWait, Self::Quiet, Self::BackOff, Self::Overrun];
    const WHY: [&'static str; 5] = [
        "interscan delay",
        "I/O responses",
        "frames of lower priority",
        "another master to go first",
        "no more frames lost",
    ];

    fn index(self) -> usize {
        match self {
            Self::Interscan => 0,
            Self::ResponseWait => 1,
            Self::Quiet => 2,
            Self::BackOff => 3,
            Self::Overrun => 4,
        }
    }
}

impl<const SLAVES: usize, const MESSAGE: usize> Machine for Master<SLAVES, MESSAGE> {
    type Event = MasterEvent;

    fn input(&mut self, now: Instant, input: Input) {
        let now = self.advance(now);
        // A wait that ended before this moment ended before this input; one that ends now ends after it.
        self.expire(now.saturating_sub(Duration::from_nanos(1)));
        match input {
            Input::Frame(frame) => {
                self.node.input(now, input);
                self.follow_access();
                if !super::receive::is_response_of_scan(&frame) {
                    self.cycle.gave_way();
                    self.cycle.unanswered = self.cycle.unanswered.saturating_sub(1);
                }
                self.unacknowledged = false;
                self.frame(&frame);
                self.give_way();
            }
            Input::TxDone(token, outcome) if Lanes::own(token) => {
                self.node.input(now, Input::Tick);
                self.follow_access();
                self.tx_done(token, outcome);
                self.give_way();
            }
            Input::TxDone(..) | Input::Tick => self.node.input(now, input),
            Input::Link(event) => {
                self.node.input(now, input);
                self.link(event);
            }
        }
        self.expire(now);
        self.follow_access();
        self.follow_missing();
        self.scan();
        self.board.settle(&self.slots);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<MasterEvent>> {
        self.advance(now);
        self.scan();
        let action = self
            .lanes
            .withdraw()
            .or_else(|| self.poll_node(now))
            .or_else(|| self.set_filter())
            .or_else(|| self.event().map(Action::Event))
            .or_else(|| self.transmit());
        self.board.settle(&self.slots);
        action
    }

    fn deadline(&self) -> Option<Deadline> {
        if self.has_output() {
            return Some(Deadline::now(self.timers.now()));
        }
        let waits = [self.board.deadline(&self.slots), self.candidate.timers.next(), self.timers.next()];
        waits.into_iter().flatten().chain(self.node.deadline()).min_by_key(|deadline| deadline.at)
    }

    fn max_in_flight(&self) -> usize {
        Self::MAX_IN_FLIGHT
    }
}

impl<const SLAVES: usize, const MESSAGE: usize> Master<SLAVES, MESSAGE> {
    /// What [`max_in_flight`](link_core::Machine::max_in_flight) returns, for the size of a port.
    pub const MAX_IN_FLIGHT: usize = OwnNode::MAX_IN_FLIGHT.saturating_add(Lanes::COUNT);

    /// A master without power and with an empty scan list: the first [`LinkEvent::Up`] starts it. It is idle until
    /// [`set_run`](Self::set_run).
    #[must_use]
    pub fn new(config: Config) -> Self {
        const {
            assert!(SLAVES <= 63, "there are 64 MAC IDs, and one is the master's own");
            assert!(MESSAGE >= 16, "the master's own requests take up to 16 bytes");
        }
        Self {
            node: OwnNode::assembled(config.node.clone(), Scanner { device: config.device.clone() }),
            on_line: false,
            run: false,
            slots: Vec::new(),
            board: Board::new(),
            multicast_output: Output::zeroed(0),
            candidate: Candidate::new(config.node.access.mac_id),
            cycle: Cycle::new(),
            lanes: Lanes::default(),
            timers: Timers::new(),
            counters: Counters::default(),
            scan_done: None,
            filter_due: false,
            shown: NetworkStatus::Off,
            unacknowledged: false,
            config,
        }
    }

    /// What it must hear: its own duplicate MAC ID check and those of its slaves, UCMM responses and heartbeats, and of
    /// each slave, and of a device that may replace one, the explicit responses and all I/O.
    #[must_use]
    pub fn filter(&self) -> FilterSet {
        let candidate = (self.config.replacement != ReplacementMode::Off).then_some(MacId::MAX);
        let slaves = self.slots.iter().map(|slot| slot.entry.mac_id).chain(candidate);
        let mut filters = id::master(self.access().mac_id(), slaves);
        filters.add(id::duplicate_mac_checks());
        let node = if self.on_line { self.node.filter() } else { self.access().filter() };
        filters.extend(node.as_slice().iter().copied());
        filters
    }

    /// Every clock of the machine, set to the latest moment.
    pub(super) fn advance(&mut self, now: Instant) -> Instant {
        let now = self.timers.advance(now);
        self.board.advance(now);
        self.candidate.timers.advance(now);
        now
    }

    /// Serves every wait that is over at `until`.
    fn expire(&mut self, until: Instant) {
        while let Some(timer) = self.timers.take_expired(until) {
            match timer {
                Timer::Interscan => self.cycle.delay_over = true,
                Timer::ResponseWait => self.cycle.wait_over = true,
                Timer::Quiet => self.cycle.quiet = true,
                Timer::BackOff | Timer::Overrun => {}
            }
        }
        let own = self.access().mac_id();
        for slave in self.board.due(&self.slots, until) {
            let Some(slot) = self.board.get_mut(&mut self.slots, slave) else { continue };
            while let Some(timer) = slot.timers.take_expired(until) {
                match timer {
                    SlotTimer::Conversation => slot.conversation_expired(&self.config, own),
                    SlotTimer::Retry => {
                        if slot.stage == Stage::Waiting {
                            slot.begin(&self.config, own);
                        }
                    }
                    SlotTimer::Watchdog(_) => slot.lost(Cause::TimedOut),
                    SlotTimer::Restart => slot.restarted(),
                    SlotTimer::Trigger => slot.trigger_output(),
                }
            }
        }
        self.expire_candidate(until);
    }

    /// Follows network access on line and off line.
    pub(super) fn follow_access(&mut self) {
        let on_line = self.access().is_online();
        if on_line == self.on_line {
            return;
        }
        self.on_line = on_line;
        if on_line {
            self.filter_due = true;
            let own = self.access().mac_id();
            for slot in self.board.all_mut(&mut self.slots) {
                slot.master_on_line(own);
            }
        } else {
            for slot in self.board.all_mut(&mut self.slots) {
                slot.master_off_line();
            }
            self.candidate.stop();
            self.cycle.stop();
            self.timers.clear_all();
            self.lanes.abandon();
        }
    }

    fn link(&mut self, event: LinkEvent) {
        if collision::is_collision(event) {
            self.cycle.was_disturbed();
            self.give_way();
        }
        if collision::is_collision(event) && self.lanes.take_back() {
            let pause = collision::pause(self.access().mac_id(), self.counters.collisions);
            self.timers.set_after(Timer::BackOff, pause);
            count(&mut self.counters.collisions);
        }
        match event {
            // A port that is up has no filter yet.
            LinkEvent::Up => self.filter_due = true,
            LinkEvent::BusError(BusErrorKind::Ack) => self.unacknowledged = true,
            LinkEvent::Down | LinkEvent::BusOff => self.unacknowledged = false,
            LinkEvent::Refused(_) => count(&mut self.counters.refused),
            LinkEvent::Overrun { .. } => self.timers.set_after(Timer::Overrun, OVERRUN_SHOWN),
            LinkEvent::ErrorWarning
            | LinkEvent::ErrorPassive
            | LinkEvent::ErrorActive
            | LinkEvent::BusError(_)
            | LinkEvent::Counters { .. }
            | LinkEvent::ModeSet(_)
            | LinkEvent::FilterSet => {}
        }
    }

    /// What the node wants; its filter and its network status are a part of the master's.
    fn poll_node(&mut self, now: Instant) -> Option<Action<MasterEvent>> {
        loop {
            return Some(match self.node.poll(now)? {
                Action::Link(LinkCommand::SetFilter(_)) => {
                    self.filter_due = false;
                    Action::Link(LinkCommand::SetFilter(self.filter()))
                }
                Action::Event(slave::Event::Slave(slave::SlaveEvent::NetworkStatus(_))) => continue,
                action => action.map_event(|event| match event {
                    slave::Event::Access(event) => MasterEvent::Access(event),
                    slave::Event::Slave(event) => MasterEvent::Node(event),
                }),
            });
        }
    }

    /// What the network status indicator shows: the slaves count as connections.
    #[must_use]
    pub fn network_status(&self) -> NetworkStatus {
        match self.node.network_status() {
            status if !self.on_line => status,
            _ if !self.board.with(&self.slots, Known::IsLost).is_empty() => NetworkStatus::FlashingRed,
            _ if !self.board.with(&self.slots, Known::IsRunning).is_empty() => NetworkStatus::SolidGreen,
            status => status,
        }
    }

    fn show_status(&mut self) -> Option<MasterEvent> {
        let status = self.network_status();
        (core::mem::replace(&mut self.shown, status) != status).then_some(MasterEvent::NetworkStatus(status))
    }

    fn set_filter(&mut self) -> Option<Action<MasterEvent>> {
        if !core::mem::take(&mut self.filter_due) {
            return None;
        }
        Some(Action::Link(LinkCommand::SetFilter(self.filter())))
    }

    fn event(&mut self) -> Option<MasterEvent> {
        if let Some(event) = self.show_status() {
            return Some(event);
        }
        if let Some(event) = self.candidate_event() {
            return Some(event);
        }
        if let Some(missing) = self.scan_done.take() {
            return Some(MasterEvent::ScanDone { missing });
        }
        let mac_id = self.board.with(&self.slots, Known::HasEvents).first()?;
        let slot = self.board.get_mut(&mut self.slots, mac_id)?;
        if !slot.events.is_empty() {
            return Some(MasterEvent::Slave { mac_id, event: slot.events.remove(0) });
        }
        let count = core::mem::take(&mut slot.events_lost);
        self.counters.events_lost = self.counters.events_lost.saturating_add(count);
        Some(MasterEvent::EventsLost { count })
    }
}

/// How long status 74 is shown after the last loss: no event says that all is well again.
const OVERRUN_SHOWN: Duration = Duration::from_secs(10);
