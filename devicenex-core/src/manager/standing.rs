//! Those for whom there is no place: devices that stand by and get no address, spares of roles that are filled and unknown
//! ones; and strangers that have an address.

use heapless::Vec;

use crate::id::OperationalAddress;
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

/// The addresses of unknown devices, a bit each, so that each is told once for as long as it is there.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Strangers {
    told: u128,
    /// Of these, the ones that were heard since it was last looked.
    heard: u128,
}

impl Strangers {
    /// It was heard; true if it was not known.
    pub(super) fn heard(&mut self, at: OperationalAddress) -> bool {
        let is_new = !self.has(at);
        self.told |= bit(at);
        self.heard |= bit(at);
        is_new
    }

    pub(super) fn has(&self, at: OperationalAddress) -> bool {
        self.told & bit(at) != 0
    }

    /// The address is planned now.
    pub(super) fn forget(&mut self, at: OperationalAddress) {
        self.told &= !bit(at);
        self.heard &= !bit(at);
    }

    /// Whoever was not heard since the last time is gone. Whether anybody is left.
    pub(super) fn age(&mut self) -> bool {
        self.told &= core::mem::take(&mut self.heard);
        self.told != 0
    }
}

fn bit(at: OperationalAddress) -> u128 {
    1_u128.checked_shl(at.number().into()).unwrap_or_default()
}
