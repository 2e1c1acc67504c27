//! From nobody to a device that is on line with its address.

use link_core::TxOutcome;

use super::event::{ManagerEvent, PlannedEvent};
use super::machine::Manager;
use super::slot::{Probe, SlotTimer, Task, Tell};
use super::state::{Cause, DeviceState};
use super::timer::Timer;
use crate::counter::{count, count_wide};
use crate::id::OperationalAddress;
use crate::message::DeviceIdentity;

impl<const DEVICES: usize, const CONNECTIONS: usize> Manager<DEVICES, CONNECTIONS> {
    /// Asks who has the address.
    pub(super) fn begin_probe(&mut self, place: usize, cause: Cause) {
        let Some(slot) = self.slot(place) else { return };
        slot.device = None;
        slot.was = None;
        slot.open = false;
        slot.no_spare = Tell::No;
        slot.roams = 0;
        slot.forgive();
        slot.probe = Probe::default();
        self.enter(place, DeviceState::Probing, cause);
        self.advance_slot(place);
    }

    /// A part of the identity of whoever has the address; `None` if it does not tell.
    pub(super) fn probed(&mut self, place: usize, value: Option<&[u8]>) {
        let Some(slot) = self.slot(place) else { return };
        if value.and_then(|value| slot.probe.take(value)).is_none() {
            return self.conflict(place, None);
        }
        let Some(device) = slot.probe.identity() else { return self.advance_slot(place) };
        if !slot.plan.accepts(&device) {
            return self.conflict(place, Some(device));
        }
        slot.device = Some(device);
        self.on_line(place, Cause::Identified);
    }

    /// Nobody has the address.
    pub(super) fn nobody(&mut self, place: usize) {
        if let Some(slot) = self.slot(place) {
            slot.holder = None;
        }
        self.enter(place, DeviceState::Missing, Cause::NoResponse);
        self.begin_spare_wait(place);
        self.plan_mini_who();
    }

    fn begin_spare_wait(&mut self, place: usize) {
        let span = self.config.spare_wait;
        if let Some(slot) = self.slot(place) {
            slot.timers.set_after_millis(SlotTimer::Wait, span);
        }
    }

    /// A device that is to have the address has none. If it answers a Mini-who it stands by; else it joins, and stands by
    /// when nobody is asked to wait for it any more.
    pub(super) fn found(&mut self, place: usize, device: DeviceIdentity) {
        let stands_by = self.timers.at(Timer::Answers).is_some() || self.config.early_roam;
        let wait = u32::from(self.config.hello_wait).saturating_add(self.config.settle.into());
        let tries = self.config.roam_tries;
        let Some(slot) = self.slot(place) else { return };
        let known = slot.device == Some(device) && !slot.state.is_absent();
        if slot.state.is_on_line() || slot.state == DeviceState::Joining {
            // It was restarted; if it does not come back it is what was lost.
            slot.was = slot.device;
        }
        slot.device = Some(device);
        match slot.state {
            DeviceState::Found => {}
            DeviceState::Assigned | DeviceState::Joining if slot.roams >= tries => {
                return self.not_taken(place);
            }
            DeviceState::Assigned | DeviceState::Joining => {
                self.enter(place, DeviceState::Found, Cause::HelloWithoutAddress)
            }
            _ => {
                slot.roams = 0;
                self.enter(place, DeviceState::Found, Cause::HelloWithoutAddress);
            }
        }
        self.standing.forget(device);
        if !known {
            self.tell(place, PlannedEvent::Found(device));
        }
        let Some(slot) = self.slot(place) else { return };
        if stands_by {
            slot.roam_due = true;
            slot.timers.clear(SlotTimer::Wait);
        } else {
            slot.timers.set_after_millis(SlotTimer::Wait, wait);
        }
        self.plan_mini_who();
    }

    /// The ROAM is on the bus, or is not.
    pub(super) fn roam_done(&mut self, address: OperationalAddress, outcome: TxOutcome) {
        let Some(place) = self.place(address) else { return };
        let Some(slot) = self.slot(place) else { return };
        if slot.state != DeviceState::Found {
            return;
        }
        if outcome != TxOutcome::Sent {
            slot.roam_due = true;
            return count(&mut self.counters.not_sent);
        }
        slot.roams = slot.roams.saturating_add(1);
        count_wide(&mut self.counters.roams);
        self.enter(place, DeviceState::Assigned, Cause::RoamSent);
        let span = self.config.roam_wait.into();
        if let Some(slot) = self.slot(place) {
            slot.timers.set_after_millis(SlotTimer::Wait, span);
        }
    }

    /// It says Hello with the address, for the first time.
    pub(super) fn joins(&mut self, place: usize, device: DeviceIdentity) {
        if let Some(slot) = self.slot(place) {
            slot.device = Some(device);
        }
        self.enter(place, DeviceState::Joining, Cause::HelloRequest);
        self.begin_hello_wait(place, 2);
        self.plan_mini_who();
    }

    /// It says Hello with the address once more: the second time, or because another wants it too.
    pub(super) fn joins_again(&mut self, place: usize) {
        self.begin_hello_wait(place, 1);
    }

    fn begin_hello_wait(&mut self, place: usize, waits: u32) {
        let wait = u32::from(self.config.hello_wait).saturating_mul(waits);
        let span = wait.saturating_add(self.config.settle.into());
        if let Some(slot) = self.slot(place) {
            slot.timers.set_after_millis(SlotTimer::Wait, span);
        }
    }

    /// A device has the address, and is on line.
    pub(super) fn on_line(&mut self, place: usize, cause: Cause) {
        self.enter(place, DeviceState::Connecting, cause);
        let Some(slot) = self.slot(place) else { return };
        slot.open = false;
        slot.no_spare = Tell::No;
        slot.roams = 0;
        slot.reads = 0;
        slot.holder = None;
        slot.forgive();
        let (address, was) = (slot.address(), slot.was.take());
        if let Some(device) = slot.device {
            self.tell(place, PlannedEvent::Addressed(device));
            if let Some(was) = was.filter(|was| *was != device) {
                count(&mut self.counters.replaced);
                self.tell(place, PlannedEvent::Replaced { was, by: device });
            }
        }
        self.plan_mini_who();
        self.end_return(address);
        self.advance_slot(place);
    }

    /// The wait of the state is over.
    pub(super) fn wait_over(&mut self, place: usize) {
        let tries = self.config.roam_tries;
        let Some(slot) = self.slot(place) else { return };
        match slot.state {
            DeviceState::Found => slot.roam_due = true,
            DeviceState::Assigned if slot.roams >= tries => self.not_taken(place),
            DeviceState::Assigned => {
                self.enter(place, DeviceState::Found, Cause::WaitOver);
                if let Some(slot) = self.slot(place) {
                    slot.roam_due = true;
                }
            }
            DeviceState::Joining => self.on_line(place, Cause::WaitOver),
            DeviceState::Missing => {
                slot.open = true;
                let was = slot.was;
                if was.is_some() {
                    count(&mut self.counters.lost);
                }
                self.enter(place, DeviceState::Lost, Cause::WaitOver);
                self.tell(place, PlannedEvent::Lost(was));
                self.ask_soon();
            }
            DeviceState::Conflict => self.begin_probe(place, Cause::WaitOver),
            DeviceState::Idle
            | DeviceState::Probing
            | DeviceState::Connecting
            | DeviceState::Running
            | DeviceState::Retrying
            | DeviceState::Lost => {}
        }
    }

    /// It did not take the address: it is gone, or does not obey. For a while others have precedence.
    fn not_taken(&mut self, place: usize) {
        let span = self.config.retry_wait;
        let Some(slot) = self.slot(place) else { return };
        let device = core::mem::replace(&mut slot.device, slot.was);
        let open = slot.open;
        self.enter(place, if open { DeviceState::Lost } else { DeviceState::Missing }, Cause::NotTaken);
        if let (Some(device), Some(slot)) = (device, self.slot(place)) {
            slot.shun(device);
            slot.timers.set_after_millis(SlotTimer::Shun, span);
            self.tell(place, PlannedEvent::NotAddressed(device));
        }
        if !open {
            self.begin_spare_wait(place);
        }
        self.ask_soon();
    }

    /// A device that did not take the address has none, and says so: it does not obey, and spares need not wait for it.
    pub(super) fn disobeys(&mut self, place: usize) {
        let Some(slot) = self.slot(place) else { return };
        if slot.state == DeviceState::Missing {
            slot.open = true;
            slot.no_spare = Tell::No;
            self.enter(place, DeviceState::Lost, Cause::NotTaken);
            self.ask_soon();
        }
    }

    /// The device does not answer any more: whoever may have its address gets it.
    pub(super) fn lost(&mut self, place: usize) {
        let Some(slot) = self.slot(place) else { return };
        let device = slot.device;
        slot.was = device;
        slot.open = true;
        slot.no_spare = Tell::No;
        count(&mut self.counters.lost);
        self.enter(place, DeviceState::Lost, Cause::NoResponse);
        self.tell(place, PlannedEvent::Lost(device));
        self.ask_soon();
    }

    /// Somebody else has the address: told once, and looked at again in longer and longer intervals.
    pub(super) fn conflict(&mut self, place: usize, device: Option<DeviceIdentity>) {
        let retry_wait = self.config.retry_wait;
        let Some(slot) = self.slot(place) else { return };
        slot.device = None;
        let is_told = slot.holder.replace(device) == Some(device);
        slot.conflicts = if is_told { slot.conflicts.saturating_add(1).min(MOST_DOUBLINGS) } else { 0 };
        let span = retry_wait.saturating_mul(1_u32.checked_shl(slot.conflicts.into()).unwrap_or(1));
        let at = slot.address();
        self.enter(place, DeviceState::Conflict, Cause::OtherIdentity);
        if let Some(slot) = self.slot(place) {
            slot.timers.set_after_millis(SlotTimer::Wait, span);
        }
        if !is_told {
            self.tell(place, PlannedEvent::Conflict(device));
        }
        // It may be missing at another place.
        let vacancy = device.and_then(|device| Some((self.vacancy(&device, false)?, device)));
        if let Some((other, device)) = vacancy {
            self.misplaced(other, device, at);
        }
        self.plan_mini_who();
    }

    /// Somebody is missing.
    pub(super) fn is_looking(&self) -> bool {
        self.slots.iter().any(|slot| slot.state.is_absent())
    }

    /// Plans the next Mini-who by who is missing; the first one when it is known who is there.
    pub(super) fn plan_mini_who(&mut self) {
        if !self.is_working()
            || self.mini_who_due
            || self.slots.iter().any(|slot| slot.state == DeviceState::Probing)
        {
            return;
        }
        let looking = self.is_looking();
        if looking && !self.has_asked {
            return self.ask_soon();
        }
        if self.timers.at(Timer::MiniWho).is_some() && self.looks == looking {
            return;
        }
        self.looks = looking;
        let span = if looking { self.config.mini_who_interval } else { self.config.idle_mini_who_interval };
        match span {
            0 => self.timers.clear(Timer::MiniWho),
            millis => self.timers.set_after_millis(Timer::MiniWho, millis),
        }
    }

    /// A Mini-who as soon as may be.
    pub(super) fn ask_soon(&mut self) {
        match self.timers.at(Timer::Spacing) {
            None => self.mini_who_due = true,
            Some(at) => self.timers.set(Timer::MiniWho, at),
        }
        self.looks = true;
    }

    pub(super) fn mini_who_done(&mut self, outcome: TxOutcome) {
        if outcome == TxOutcome::Sent {
            count_wide(&mut self.counters.mini_whos);
            self.has_asked = true;
            self.standing.ask();
            self.timers.set_after_millis(Timer::Answers, self.config.answer_window.into());
            self.timers.set_after_millis(Timer::Spacing, SPACING);
        } else {
            count(&mut self.counters.not_sent);
        }
        self.timers.clear(Timer::MiniWho);
        self.plan_mini_who();
    }

    /// Whoever stands by has answered.
    pub(super) fn answers_over(&mut self) {
        for _ in 0..ANSWERS_AT_ONCE {
            let Some(device) = self.standing.take_silent() else { break };
            self.raise(ManagerEvent::StandbyLeft(device));
        }
        if self.mini_who_due {
            return;
        }
        for slot in &mut self.slots {
            if slot.state == DeviceState::Lost && slot.no_spare == Tell::No {
                slot.no_spare = Tell::Due;
            }
        }
    }

    /// The next part of the identity that is asked for.
    pub(super) fn probe_next(&mut self, place: usize) {
        let attribute = self.slots.get(place).and_then(|slot| slot.probe.missing());
        if let Some(attribute) = attribute {
            self.read(place, Task::Probe, (IDENTITY, 1, attribute));
        }
    }
}

impl Probe {
    /// The attribute of the Identity object that is to be read next.
    fn missing(&self) -> Option<u8> {
        [
            self.vendor.is_none(),
            self.product_code.is_none(),
            self.major_revision.is_none(),
            self.serial.is_none(),
        ]
        .into_iter()
        .zip([1, 3, 4, 6])
        .find_map(|(is_missing, attribute)| is_missing.then_some(attribute))
    }

    fn take(&mut self, value: &[u8]) -> Option<()> {
        match self.missing()? {
            1 => self.vendor = Some(u16::from_le_bytes(value.try_into().ok()?)),
            3 => self.product_code = Some(u16::from_le_bytes(value.try_into().ok()?)),
            4 => self.major_revision = Some(*value.first()?),
            _ => self.serial = Some(u32::from_le_bytes(value.try_into().ok()?)),
        }
        Some(())
    }

    fn identity(&self) -> Option<DeviceIdentity> {
        Some(DeviceIdentity {
            vendor: self.vendor?.into(),
            product_code: self.product_code?,
            major_revision: self.major_revision?,
            serial: self.serial?,
        })
    }
}

/// The class of the Identity object.
const IDENTITY: u16 = 0x01;
/// The least time from one Mini-who to the next, in ms: one serves several that are lost at once.
const SPACING: u32 = 50;
/// A conflict is looked at again after four times the first interval at the latest.
const MOST_DOUBLINGS: u8 = 2;
/// Not more at once than there is room for events.
const ANSWERS_AT_ONCE: usize = 4;
