//! What the application tells the manager, and what it can ask about it.

use link_core::Instant;

use super::config::Config;
use super::database::{DatabaseError, PlannedDevice};
use super::event::Counters;
use super::machine::{Manager, NOWHERE, Work};
use super::slot::Slot;
use super::state::{Cause, DeviceState};
use crate::access::Access;
use crate::id::OperationalAddress;
use crate::message::DeviceIdentity;

/// A planned device as it is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct DeviceView<'a, const CONNECTIONS: usize> {
    /// Its entry in the database.
    pub plan: &'a PlannedDevice<CONNECTIONS>,
    /// What is known of it.
    pub state: DeviceState,
    /// Who has the address, gets it, or had it last.
    pub device: Option<DeviceIdentity>,
}

impl<const DEVICES: usize, const CONNECTIONS: usize> Manager<DEVICES, CONNECTIONS> {
    /// Adds a device to the database. A manager that works already asks at once who has its address.
    ///
    /// # Errors
    /// If the address is taken or none, if the device has another one already, if a connection cannot be made as planned, or if
    /// there is no room.
    pub fn add_device(
        &mut self,
        now: Instant,
        plan: PlannedDevice<CONNECTIONS>,
    ) -> Result<(), DatabaseError> {
        self.advance(now);
        plan.check()?;
        let address = plan.address;
        if address == self.config.node.access.first_address() || address == self.own() {
            return Err(DatabaseError::OwnAddress(address));
        }
        if self.place(address).is_some() {
            return Err(DatabaseError::Planned(address));
        }
        let is_same =
            |slot: &&Slot<CONNECTIONS>| plan.identity.serial.is_some() && slot.plan.identity == plan.identity;
        if let Some(slot) = self.slots.iter().find(is_same) {
            return Err(DatabaseError::Identity(slot.address()));
        }
        let place = self.insert(plan, DeviceState::Idle).ok_or(DatabaseError::Full(DEVICES))?;
        if self.is_working() {
            self.begin_probe(place, Cause::Started);
        }
        Ok(())
    }

    /// Takes a device out of the database. It goes on as it is.
    ///
    /// # Errors
    /// If it is not there.
    pub fn remove_device(
        &mut self,
        address: OperationalAddress,
    ) -> Result<PlannedDevice<CONNECTIONS>, DatabaseError> {
        let place = self.place(address).ok_or(DatabaseError::NotPlanned(address))?;
        let slot = self.slots.remove(place);
        self.lanes.forget(address);
        self.places = [NOWHERE; OperationalAddress::COUNT];
        for (number, slot) in (0_u8..).zip(&self.slots) {
            if let Some(place) = self.places.get_mut(slot.address().index()) {
                *place = number;
            }
        }
        self.plan_mini_who();
        Ok(slot.plan)
    }

    /// The planned devices, in the order of the database.
    pub fn devices(&self) -> impl Iterator<Item = DeviceView<'_, CONNECTIONS>> {
        self.slots.iter().map(|slot| DeviceView { plan: &slot.plan, state: slot.state, device: slot.device })
    }

    /// The planned device of an address.
    #[must_use]
    pub fn device(&self, address: OperationalAddress) -> Option<DeviceView<'_, CONNECTIONS>> {
        let slot = self.slots.get(self.place(address)?)?;
        Some(DeviceView { plan: &slot.plan, state: slot.state, device: slot.device })
    }

    /// The devices that stand by and get no address: spares, and unknown ones.
    pub fn standing_by(&self) -> impl Iterator<Item = &DeviceIdentity> {
        self.standing.iter()
    }

    /// Its own network access.
    #[must_use]
    pub const fn access(&self) -> &Access {
        self.node.access()
    }

    /// What it was told at the start.
    #[must_use]
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// What it counted.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Whether it works: it is on line, and no other manager does the work.
    #[must_use]
    pub const fn works(&self) -> bool {
        self.is_working()
    }

    /// Begins or ends learning: whether devices that match nothing are added to the database.
    pub const fn set_learning(&mut self, learning: bool) {
        self.config.learning = learning;
    }

    /// Leaves the work: devices and connections go on as they are, unwatched, until [`resume`](Self::resume).
    pub fn suspend(&mut self, now: Instant) {
        self.advance(now);
        self.stop(Work::Left);
    }

    /// Works again, or as soon as it is on line, even if there is another manager.
    pub fn resume(&mut self, now: Instant) {
        self.advance(now);
        if self.work == Work::Left {
            self.take_over();
        }
    }

    /// Starts anew, as after a power cycle. The database, and what was learned, stays.
    pub fn reset(&mut self, now: Instant) {
        self.advance(now);
        self.stop(Work::Wanted);
        self.tried = None;
        self.node.reset(now);
        self.follow_access();
    }
}
