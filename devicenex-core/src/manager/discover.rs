//! What the manager does with what it hears of others: Hellos with and without an address, Mini-whos and ROAMs of another
//! manager.

use link_core::Frame;

use super::database::{IdentityPattern, PlannedDevice};
use super::event::{ManagerEvent, PlannedEvent};
use super::machine::{Manager, NOWHERE, Work};
use super::slot::Slot;
use super::state::{Cause, DeviceState};
use super::timer::Timer;
use crate::access::StateKind;
use crate::counter::{count, count_wide};
use crate::id::{Direction, Identifier, Layout, OperationalAddress};
use crate::message::{DeviceIdentity, Hello, MiniWho, Roam};

impl<const DEVICES: usize, const CONNECTIONS: usize> Manager<DEVICES, CONNECTIONS> {
    pub(super) fn frame(&mut self, frame: &Frame) {
        match Identifier::of_frame(frame).layout() {
            Layout::Hello { .. } => {
                if let Some(mini_who) = MiniWho::of_frame(frame) {
                    return self.another_manager(Some(mini_who.serial_low));
                }
                match Hello::of_frame(frame) {
                    Some(Ok(hello)) => self.hello(&hello),
                    Some(Err(_)) => self.bad_frame(frame),
                    // A remote frame that nobody defines.
                    None => {}
                }
            }
            Layout::Roam { .. } => match Roam::of_frame(frame) {
                Some(Ok(_)) => self.another_manager(None),
                Some(Err(_)) => self.bad_frame(frame),
                None => {}
            },
            Layout::Connection { route, .. }
            | Layout::Connectionless { route, .. }
            | Layout::Explicit { route, .. } => {
                if route.destination == self.own() && route.direction == Direction::Response {
                    self.answer(route.source, frame);
                }
            }
            Layout::Implicit { acknowledge: true, .. } | Layout::Reserved(_) => {}
            Layout::Implicit { source, .. } | Layout::Standard { source, .. } => self.data(source, frame),
        }
    }

    fn bad_frame(&mut self, frame: &Frame) {
        if self.takes_part() {
            count(&mut self.counters.bad_frames);
            self.raise(ManagerEvent::BadFrame(*frame));
        }
    }

    /// Whether it has an address, or is about to.
    fn takes_part(&self) -> bool {
        let kind = self.access().state().kind();
        matches!(kind, StateKind::Hello1 | StateKind::Hello2 | StateKind::Online) && !self.own().is_none()
    }

    /// A Mini-who, or a ROAM: whoever has not asked yet is the second, and leaves the work to the first. Of two that work
    /// already, the one with the lower serial number goes on.
    fn another_manager(&mut self, serial_low: Option<u16>) {
        if !self.takes_part() {
            return;
        }
        count_wide(&mut self.counters.of_other_managers);
        let own = self.access().config().device.serial_low();
        let yields = match self.work {
            Work::Wanted => true,
            Work::Going => !self.has_asked || serial_low.is_some_and(|theirs| theirs < own),
            Work::Left => false,
        };
        if yields || self.other != Some(serial_low) {
            self.other = Some(serial_low);
            let yields = yields || self.work == Work::Left;
            self.raise(ManagerEvent::SecondManager { serial_low, yields });
        }
        if yields {
            self.stop(Work::Left);
            self.set_takeover();
        } else if self.timers.at(Timer::Takeover).is_some() {
            self.set_takeover();
        }
    }

    fn set_takeover(&mut self) {
        if self.config.takeover_after != 0 {
            self.timers.set_after_millis(Timer::Takeover, self.config.takeover_after);
        }
    }

    /// Nothing was heard of the other manager.
    pub(super) fn take_over(&mut self) {
        self.work = Work::Wanted;
        self.other = None;
        self.follow_access();
    }

    fn hello(&mut self, hello: &Hello) {
        if !self.is_working() || hello.source == self.own() {
            return;
        }
        if hello.source.is_none() {
            if hello.direction == Direction::Request {
                self.without_address(hello.device);
            }
            return;
        }
        self.standing.forget(hello.device);
        match self.place(hello.source) {
            Some(place) => match hello.direction {
                Direction::Request => self.wants_address(place, hello.device),
                Direction::Response => self.has_address(place, hello.device),
            },
            None => self.elsewhere(hello),
        }
    }

    /// A device without an address: it joins, or stands by.
    fn without_address(&mut self, device: DeviceIdentity) {
        count_wide(&mut self.counters.hellos);
        let known = |slot: &Slot<CONNECTIONS>| {
            slot.device == Some(device)
                && !slot.shuns(&device)
                && !matches!(slot.state, DeviceState::Idle | DeviceState::Probing | DeviceState::Conflict)
        };
        if let Some(place) = self.slots.iter().position(known).or_else(|| self.vacancy(&device, true)) {
            return self.found(place, device);
        }
        if self.slots.iter().any(|slot| slot.state == DeviceState::Probing) {
            // Where it belongs shows when that is over.
            return;
        }
        if let Some(place) = self.slots.iter().position(|slot| slot.shuns(&device)) {
            return self.disobeys(place);
        }
        let is_spare = self.slots.iter().any(|slot| slot.plan.accepts(&device));
        if is_spare {
            if self.standing.heard(device) {
                self.raise(ManagerEvent::Spare(device));
            }
        } else if let Some(place) = self.learn(device, None) {
            self.found(place, device);
        } else if self.standing.heard(device) {
            self.raise(ManagerEvent::Unknown { device, at: None });
        }
    }

    /// The free role that a device fits best: one for it alone, one for devices like it, one for which it is a spare.
    pub(super) fn vacancy(&self, device: &DeviceIdentity, with_spares: bool) -> Option<usize> {
        let rank = |slot: &Slot<CONNECTIONS>| {
            let plan = &slot.plan;
            if !slot.state.is_absent() || slot.shuns(device) {
                return None;
            }
            if plan.identity.matches(device) {
                return Some(u8::from(plan.identity.serial.is_none()));
            }
            (with_spares && slot.open && plan.is_spare(device)).then_some(2)
        };
        let ranked = self.slots.iter().enumerate().filter_map(|(place, slot)| Some((rank(slot)?, place)));
        ranked.min().map(|(_, place)| place)
    }

    /// Somebody joins with a planned address.
    fn wants_address(&mut self, place: usize, device: DeviceIdentity) {
        let Some(slot) = self.slots.get(place) else { return };
        let same = slot.device == Some(device);
        let accepted = slot.plan.accepts(&device);
        match slot.state {
            DeviceState::Idle | DeviceState::Conflict => {}
            DeviceState::Joining if same => self.joins_again(place),
            DeviceState::Connecting | DeviceState::Running | DeviceState::Retrying if same => {
                self.joins(place, device);
            }
            DeviceState::Joining | DeviceState::Connecting | DeviceState::Running | DeviceState::Retrying => {
                self.tell(place, PlannedEvent::Challenged(device));
            }
            DeviceState::Missing
            | DeviceState::Lost
            | DeviceState::Found
            | DeviceState::Assigned
            | DeviceState::Probing
                if accepted =>
            {
                self.joins(place, device);
            }
            // Whoever has the address is being asked.
            DeviceState::Probing => {}
            DeviceState::Missing | DeviceState::Lost | DeviceState::Found | DeviceState::Assigned => {
                self.conflict(place, Some(device));
            }
        }
    }

    /// Somebody is on line with a planned address.
    fn has_address(&mut self, place: usize, device: DeviceIdentity) {
        let Some(slot) = self.slot(place) else { return };
        let same = slot.device == Some(device);
        match slot.state {
            DeviceState::Idle => {}
            DeviceState::Connecting | DeviceState::Running | DeviceState::Retrying if same => {}
            _ if slot.plan.accepts(&device) => {
                slot.device = Some(device);
                self.on_line(place, Cause::HelloResponse);
            }
            DeviceState::Conflict => {}
            DeviceState::Probing
            | DeviceState::Missing
            | DeviceState::Found
            | DeviceState::Assigned
            | DeviceState::Joining
            | DeviceState::Connecting
            | DeviceState::Running
            | DeviceState::Retrying
            | DeviceState::Lost => self.conflict(place, Some(device)),
        }
    }

    /// Somebody has, or wants, an address that is not planned.
    fn elsewhere(&mut self, hello: &Hello) {
        let (device, at) = (hello.device, hello.source);
        if let Some(place) = self.vacancy(&device, false) {
            // Only on line it can be told another one.
            if hello.direction == Direction::Response {
                self.misplaced(place, device, at);
            }
            return;
        }
        if let Some(place) = self.learn(device, Some(at)) {
            return match hello.direction {
                Direction::Request => self.joins(place, device),
                Direction::Response => self.has_address(place, device),
            };
        }
        if self.strangers.heard(at) {
            // Its own address is missed, if it has left it. There are devices with a cloned identity.
            let own = self.slots.iter().find(|slot| slot.device == Some(device));
            self.raise(match own.map(Slot::address) {
                Some(planned) => ManagerEvent::Misplaced { device, at, planned },
                None => ManagerEvent::Unknown { device, at: Some(at) },
            });
        }
        let announcement = self.access().config().announcement;
        if announcement != 0 && self.timers.at(Timer::Strangers).is_none() {
            self.timers.set_after_millis(Timer::Strangers, announcement.saturating_mul(ANNOUNCEMENTS));
        }
    }

    /// Strangers of which nothing was heard for that long are gone.
    pub(super) fn strangers_over(&mut self) {
        let announcement = self.access().config().announcement;
        if self.strangers.age() {
            self.timers.set_after_millis(Timer::Strangers, announcement.saturating_mul(ANNOUNCEMENTS));
        }
    }

    pub(super) fn misplaced(&mut self, place: usize, device: DeviceIdentity, at: OperationalAddress) {
        let Some(planned) = self.slots.get(place).map(Slot::address) else { return };
        self.raise(ManagerEvent::Misplaced { device, at, planned });
        if self.config.readdress {
            // If another request is under way, the next announcement of the device is the next chance.
            let _ = self.begin_return(at, planned);
        }
    }

    /// Adds a device to the database, if it is to learn and has room.
    fn learn(&mut self, device: DeviceIdentity, at: Option<OperationalAddress>) -> Option<usize> {
        if !self.config.learning {
            return None;
        }
        let address = at.or_else(|| OperationalAddress::all().find(|&address| self.is_free(address)))?;
        let plan = PlannedDevice::new(address, IdentityPattern::exact(device));
        let place = self.insert(plan, DeviceState::Missing)?;
        self.tell(place, PlannedEvent::Learned(device));
        Some(place)
    }

    pub(super) fn insert(&mut self, plan: PlannedDevice<CONNECTIONS>, state: DeviceState) -> Option<usize> {
        let place = self.slots.len();
        let number = u8::try_from(place).ok().filter(|&number| number != NOWHERE)?;
        let address = plan.address;
        let mut slot = Slot::new(plan, self.own(), self.config.waits);
        slot.state = state;
        slot.timers.advance(self.timers.now());
        self.slots.push(slot).ok()?;
        *self.places.get_mut(address.index())? = number;
        self.strangers.forget(address);
        Some(place)
    }
}

/// A node on line tells its address from time to time: one that has left out so many times is gone.
const ANNOUNCEMENTS: u32 = 3;
