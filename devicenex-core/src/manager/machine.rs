//! The manager machine: the node that it is, the planned devices, who stands by.

use core::time::Duration;

use heapless::Vec;
use link_core::{
    Action, Deadline, Filter, FilterSet, Frame, Input, Instant, LinkCommand, Machine, Queue, Timers,
};

use super::config::Config;
use super::event::{Counters, ManagerEvent, PlannedEvent};
use super::lanes::Lanes;
use super::node::{OwnNode, Principal};
use super::slot::{Slot, SlotTimer, Tell};
use super::standing::{Standing, Strangers};
use super::state::{Cause, DeviceState};
use super::talk::Talk;
use super::timer::Timer;
use crate::access::AccessEvent;
use crate::counter::count;
use crate::device::DeviceEvent;
use crate::id::{self, Direction, Identifier, Layout, OperationalAddress};
use crate::message::IdentifierLength;

/// A DeviceNeX network manager; see the [module](super) text.
///
/// `DEVICES` is the length of the database, at most 126, and how many others that stand by are remembered; `CONNECTIONS` the
/// most planned connections of a device.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Manager<const DEVICES: usize, const CONNECTIONS: usize> {
    pub(super) config: Config,
    pub(super) node: OwnNode,
    pub(super) work: Work,
    /// In the order of the database.
    pub(super) slots: Vec<Slot<CONNECTIONS>, DEVICES>,
    /// The place in `slots` of each address.
    pub(super) places: [u8; OperationalAddress::COUNT],
    pub(super) standing: Standing<DEVICES>,
    pub(super) talk: Talk,
    pub(super) lanes: Lanes,
    pub(super) timers: Timers<Timer, 7>,
    pub(super) counters: Counters,
    pub(super) mini_who_due: bool,
    /// It has asked since it began to work.
    pub(super) has_asked: bool,
    /// The Mini-who timer runs because a device is missing.
    pub(super) looks: bool,
    pub(super) strangers: Strangers,
    /// The address that it took last because another node has its own.
    pub(super) tried: Option<OperationalAddress>,
    /// The other manager that was told last.
    pub(super) other: Option<Option<u16>>,
    pub(super) events: Queue<ManagerEvent, EVENTS>,
}

/// Whether it works.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Work {
    /// As soon as it is on line.
    Wanted,
    /// It does.
    Going,
    /// Another manager does, or the application has told it not to.
    Left,
}

impl<const DEVICES: usize, const CONNECTIONS: usize> Machine for Manager<DEVICES, CONNECTIONS> {
    type Event = ManagerEvent;

    fn input(&mut self, now: Instant, input: Input) {
        let now = self.advance(now);
        // A wait that ended before this moment ended before this input; one that ends now ends after it.
        self.expire(now.preceding());
        match input {
            Input::Frame(frame) => {
                if self.is_for_node(&frame) {
                    self.node.input(now, input);
                    self.follow_access();
                }
                self.frame(&frame);
            }
            Input::TxDone(token, outcome) if Lanes::own(token) => {
                self.node.input(now, Input::Tick);
                self.tx_done(token, outcome);
            }
            Input::TxDone(..) | Input::Tick | Input::Link(_) => self.node.input(now, input),
        }
        self.follow_access();
        self.expire(now);
        self.advance_talk();
    }

    fn poll(&mut self, now: Instant) -> Option<Action<ManagerEvent>> {
        let now = self.advance(now);
        self.expire(now);
        self.advance_talk();
        self.lanes
            .withdraw()
            .or_else(|| self.poll_node(now))
            .or_else(|| self.events.pop().map(Action::Event))
            .or_else(|| self.transmit())
    }

    fn deadline(&self) -> Option<Deadline> {
        if self.has_output() {
            return Some(Deadline::now(self.timers.now()));
        }
        let slots = self.slots.iter().flat_map(|slot| {
            let watches = slot.made.iter().filter_map(|made| made.watch.next());
            watches.chain(slot.timers.next())
        });
        slots.chain(self.timers.next()).chain(self.node.deadline()).min_by_key(|deadline| deadline.at)
    }

    fn max_in_flight(&self) -> usize {
        Self::MAX_IN_FLIGHT
    }
}

impl<const DEVICES: usize, const CONNECTIONS: usize> Manager<DEVICES, CONNECTIONS> {
    /// What [`max_in_flight`](link_core::Machine::max_in_flight) returns, for the size of a port.
    pub const MAX_IN_FLIGHT: usize = OwnNode::MAX_IN_FLIGHT.saturating_add(Lanes::COUNT);

    /// A manager without power and with an empty database: the first [`LinkEvent::Up`](link_core::LinkEvent::Up) starts
    /// it.
    #[must_use]
    pub fn new(config: Config) -> Self {
        const {
            assert!(DEVICES <= 126, "there are 127 addresses, and one is the manager's own");
            assert!(CONNECTIONS <= 255, "connections are counted in a byte");
        }
        let own = config.node.access.first_address();
        Self {
            node: OwnNode::assembled(config.node.clone(), Principal { device: config.device.clone() }),
            work: Work::Wanted,
            slots: Vec::new(),
            places: [NOWHERE; OperationalAddress::COUNT],
            standing: Standing::new(),
            talk: Talk::new(own, config.waits),
            lanes: Lanes::default(),
            timers: Timers::new(),
            counters: Counters::default(),
            mini_who_due: false,
            has_asked: false,
            looks: false,
            strangers: Strangers::default(),
            tried: None,
            other: None,
            events: Queue::new(),
            config,
        }
    }

    /// What it must hear: every Hello, Mini-who and ROAM, what is for it, and the data of the connections that it watches.
    #[must_use]
    pub fn filter(&self) -> FilterSet {
        let own = self.own();
        if own.is_none() {
            return self.access().filter();
        }
        let mut filters = id::network_manager(own);
        let heard = self.slots.iter().flat_map(|slot| &slot.plan.connections).filter(|plan| plan.is_heard());
        for connection in heard {
            filters.add(match connection.length() {
                IdentifierLength::Extended => id::implicit(),
                IdentifierLength::Standard => Filter::ALL_STANDARD,
            });
        }
        filters
    }

    pub(super) fn advance(&mut self, now: Instant) -> Instant {
        self.timers.advance(now)
    }

    pub(super) const fn is_working(&self) -> bool {
        matches!(self.work, Work::Going)
    }

    pub(super) fn own(&self) -> OperationalAddress {
        self.access().address()
    }

    /// Responses and data are the manager's business; everything else the node looks at that it is.
    fn is_for_node(&self, frame: &Frame) -> bool {
        match Identifier::of_frame(frame).layout() {
            Layout::Hello { .. } | Layout::Roam { .. } | Layout::Reserved(_) => true,
            Layout::Connection { route, .. }
            | Layout::Connectionless { route, .. }
            | Layout::Explicit { route, .. } => {
                !self.access().is_online() || route.direction == Direction::Request
            }
            Layout::Implicit { .. } | Layout::Standard { .. } => !self.access().is_online(),
        }
    }

    pub(super) fn place(&self, address: OperationalAddress) -> Option<usize> {
        let place = *self.places.get(address.index())?;
        (place != NOWHERE).then(|| place.into())
    }

    /// Whether nobody has the address or is to have it, as far as it knows.
    pub(super) fn is_free(&self, address: OperationalAddress) -> bool {
        self.place(address).is_none() && address != self.own() && !self.strangers.has(address)
    }

    /// What is kept for a device, with the present moment in its timers.
    pub(super) fn slot(&mut self, place: usize) -> Option<&mut Slot<CONNECTIONS>> {
        let slot = self.slots.get_mut(place)?;
        slot.timers.advance(self.timers.now());
        Some(slot)
    }

    pub(super) fn raise(&mut self, event: ManagerEvent) {
        if self.events.push(event).is_err() {
            count(&mut self.counters.events_lost);
        }
    }

    pub(super) fn tell(&mut self, place: usize, event: PlannedEvent) {
        if let Some(slot) = self.slots.get(place) {
            let address = slot.address();
            self.raise(ManagerEvent::Planned(address, event));
        }
    }

    /// The state of a device changes.
    pub(super) fn enter(&mut self, place: usize, next: DeviceState, cause: Cause) {
        let Some(slot) = self.slot(place) else { return };
        let event = slot.enter(next, cause);
        self.tell(place, event);
    }

    /// Its own network access got on line, or off.
    pub(super) fn follow_access(&mut self) {
        self.follow_address();
        match (self.work, self.access().is_online()) {
            (Work::Wanted, true) => self.start(),
            (Work::Going, false) => self.stop(Work::Wanted),
            (Work::Wanted, false) | (Work::Going, true) | (Work::Left, _) => {}
        }
    }

    /// It begins to work: whoever has a planned address already is asked who it is, and left as it is.
    pub(super) fn start(&mut self) {
        self.work = Work::Going;
        self.has_asked = false;
        self.strangers = Strangers::default();
        self.other = None;
        self.timers.clear(Timer::Takeover);
        self.raise(ManagerEvent::Started);
        for place in 0..self.slots.len() {
            self.begin_probe(place, Cause::Started);
        }
        self.plan_mini_who();
    }

    /// It does nothing any more. The devices go on as they are.
    pub(super) fn stop(&mut self, work: Work) {
        let worked = core::mem::replace(&mut self.work, work) == Work::Going;
        self.mini_who_due = false;
        self.timers.clear(Timer::MiniWho);
        self.timers.clear(Timer::Answers);
        self.timers.clear(Timer::Strangers);
        self.lanes.abandon();
        self.abandon_talk();
        if !worked {
            return;
        }
        for slot in &mut self.slots {
            // One event tells it of all.
            let _ = slot.enter(DeviceState::Idle, Cause::Stopped);
            slot.open = false;
        }
        self.standing.clear();
        self.raise(ManagerEvent::Stopped);
    }

    fn poll_node(&mut self, now: Instant) -> Option<Action<ManagerEvent>> {
        loop {
            return Some(match self.node.poll(now)? {
                // It must hear more than another node.
                Action::Link(LinkCommand::SetFilter(_)) => {
                    Action::Link(LinkCommand::SetFilter(self.filter()))
                }
                // The manager tells every bad Hello and ROAM itself.
                Action::Event(DeviceEvent::Access(AccessEvent::BadFrame(_))) => continue,
                action => action.map_event(ManagerEvent::Node),
            });
        }
    }

    /// Serves the waits that are over at `until`, as long as there is room for what they raise.
    fn expire(&mut self, until: Instant) {
        while self.events.len() < EVENTS - EVENTS_OF_ONE {
            if let Some(timer) = self.timers.take_expired(until) {
                self.timer_over(timer);
                continue;
            }
            if let Some(place) = self.slots.iter().position(|slot| slot.no_spare == Tell::Due) {
                if let Some(slot) = self.slot(place) {
                    slot.no_spare = Tell::Told;
                }
                self.tell(place, PlannedEvent::NoSpare);
                continue;
            }
            let due = |slot: &mut Slot<CONNECTIONS>| {
                slot.timers.is_due(until) || slot.made.iter_mut().any(|made| made.watch.is_due(until))
            };
            let Some(place) = self.slots.iter_mut().position(due) else { return };
            self.expire_slot(place, until);
        }
    }

    fn expire_slot(&mut self, place: usize, until: Instant) {
        let Some(slot) = self.slot(place) else { return };
        if let Some(timer) = slot.timers.take_expired(until) {
            return match timer {
                SlotTimer::Conversation => self.conversation_over(place),
                SlotTimer::Wait => self.wait_over(place),
                SlotTimer::Poll => self.poll_over(place),
                SlotTimer::Retry => self.retry_over(place),
                SlotTimer::Shun => slot.forgive(),
            };
        }
        let mut watches = (0_u8..).zip(&mut slot.made);
        let expired = watches.find_map(|(number, made)| made.watch.take_expired(until).map(|_| number));
        if let Some(connection) = expired {
            self.fell_silent(place, connection);
        }
    }

    fn timer_over(&mut self, timer: Timer) {
        match timer {
            Timer::MiniWho => self.mini_who_due = true,
            Timer::Answers => self.answers_over(),
            Timer::Spacing => {}
            Timer::Takeover => self.take_over(),
            Timer::Talk => self.talk_over(),
            Timer::Strangers => self.strangers_over(),
            Timer::Rejoin => self.rejoin(),
        }
    }

    /// Moves every instant that the machine stores towards zero, so that a model checker can compare histories of
    /// different age.
    pub fn shift_time(&mut self, span: Duration) {
        self.node.shift_time(span);
        self.timers.shift(span);
        for slot in &mut self.slots {
            slot.timers.shift(span);
            slot.made.iter_mut().for_each(|made| made.watch.shift(span));
        }
    }
}

/// No place in the database.
pub(super) const NOWHERE: u8 = u8::MAX;
/// Of which some are kept free for what one input raises.
const EVENTS: usize = 24;
const EVENTS_OF_ONE: usize = 8;
