//! The devices that stand by and get no address: spares of roles that are filled, and unknown ones.

use heapless::Vec;

use crate::message::DeviceIdentity;

/// Those that were told to the application, so that each is told once.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Standing<const N: usize> {
    devices: Vec<StandingBy, N>,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
struct StandingBy {
    device: DeviceIdentity,
    /// It has been heard since the last Mini-who.
    answered: bool,
}

impl<const N: usize> Standing<N> {
    pub(super) const fn new() -> Self {
        Self { devices: Vec::new() }
    }

    pub(super) fn clear(&mut self) {
        self.devices.clear();
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &DeviceIdentity> {
        self.devices.iter().map(|standing| &standing.device)
    }

    /// It was heard; true if it was not known. Where there is no room it never is.
    pub(super) fn heard(&mut self, device: DeviceIdentity) -> bool {
        if let Some(known) = self.devices.iter_mut().find(|known| known.device == device) {
            known.answered = true;
            return false;
        }
        let _ = self.devices.push(StandingBy { device, answered: true });
        true
    }

    /// It stands by no longer.
    pub(super) fn forget(&mut self, device: DeviceIdentity) {
        self.devices.retain(|known| known.device != device);
    }

    /// A Mini-who was sent.
    pub(super) fn ask(&mut self) {
        self.devices.iter_mut().for_each(|known| known.answered = false);
    }

    /// One that has not answered.
    pub(super) fn take_silent(&mut self) -> Option<DeviceIdentity> {
        let place = self.devices.iter().position(|known| !known.answered)?;
        Some(self.devices.swap_remove(place).device)
    }
}
