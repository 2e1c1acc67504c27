//! What a master must know of a slave before it has asked it anything: an entry of its scan list.

use core::fmt;

use crate::code::{DeviceType, VendorId};
use crate::epath::Epath;
use crate::identity::Revision;
use crate::message::AllocationChoice;
use crate::text::write_joined;

bitflags::bitflags! {
    /// Kinds of I/O connections, as the I/O type mask of an EDS has them (CIP Vol. 3, chapter 7).
    ///
    /// | Bit | Connection |
    /// |---|---|
    /// | 0 | poll |
    /// | 1 | bit-strobe |
    /// | 2 | change of state |
    /// | 3 | cyclic |
    /// | 4 | multicast poll |
    /// | 5-15 | reserved |
    ///
    /// The mask is not the [`AllocationChoice`], whose bits are in another order;
    /// [`allocation_choice`](Self::allocation_choice) converts.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct IoTypes: u16 {
        /// Poll.
        const POLL = 0x01;
        /// Bit-strobe.
        const BIT_STROBE = 0x02;
        /// Change of state.
        const CHANGE_OF_STATE = 0x04;
        /// Cyclic.
        const CYCLIC = 0x08;
        /// Multicast poll.
        const MULTICAST_POLL = 0x10;
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for IoTypes {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=u16:#06x}", self.bits());
    }
}

/// `poll + cyclic`; `none` for zero.
impl fmt::Display for IoTypes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.intersects(Self::all()) {
            return f.write_str("none");
        }
        let own = IoType::ALL.into_iter().filter(|ty| self.contains(ty.mask()));
        write_joined(f, " + ", own.map(IoType::name))
    }
}

impl IoTypes {
    /// The choice byte of an Allocate for these connections and nothing else.
    ///
    /// ```
    /// use cip_core::message::AllocationChoice;
    /// use cip_core::scan::IoTypes;
    ///
    /// let choice = (IoTypes::POLL | IoTypes::CYCLIC).allocation_choice();
    /// assert_eq!(choice, AllocationChoice::POLL | AllocationChoice::CYCLIC);
    /// ```
    #[must_use]
    pub fn allocation_choice(self) -> AllocationChoice {
        let named = IoType::ALL.into_iter().filter(|ty| self.contains(ty.mask()));
        named.fold(AllocationChoice::empty(), |choice, ty| choice | ty.allocation_choice())
    }
}

/// A kind of I/O connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum IoType {
    /// Poll.
    Poll,
    /// Bit-strobe.
    BitStrobe,
    /// Change of state.
    ChangeOfState,
    /// Cyclic.
    Cyclic,
    /// Multicast poll.
    MulticastPoll,
}

impl IoType {
    /// All, in the order of their bits.
    pub const ALL: [Self; 5] =
        [Self::Poll, Self::BitStrobe, Self::ChangeOfState, Self::Cyclic, Self::MulticastPoll];

    /// Its bit.
    #[must_use]
    pub const fn mask(self) -> IoTypes {
        match self {
            Self::Poll => IoTypes::POLL,
            Self::BitStrobe => IoTypes::BIT_STROBE,
            Self::ChangeOfState => IoTypes::CHANGE_OF_STATE,
            Self::Cyclic => IoTypes::CYCLIC,
            Self::MulticastPoll => IoTypes::MULTICAST_POLL,
        }
    }

    /// Its name in texts.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Poll => "poll",
            Self::BitStrobe => "bit-strobe",
            Self::ChangeOfState => "change of state",
            Self::Cyclic => "cyclic",
            Self::MulticastPoll => "multicast poll",
        }
    }

    /// Its bit in the choice byte of an Allocate.
    #[must_use]
    pub const fn allocation_choice(self) -> AllocationChoice {
        match self {
            Self::Poll => AllocationChoice::POLL,
            Self::BitStrobe => AllocationChoice::BIT_STROBE,
            Self::ChangeOfState => AllocationChoice::CHANGE_OF_STATE,
            Self::Cyclic => AllocationChoice::CYCLIC,
            Self::MulticastPoll => AllocationChoice::MULTICAST_POLL,
        }
    }
}

impl fmt::Display for IoType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What a master knows of a slave of its scan list. [`Eds::scan_entry`](crate::eds::Eds::scan_entry) (feature `std`)
/// takes it from an Electronic Data Sheet.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ScanEntry {
    /// What the slave must be.
    pub key: DeviceKey,
    /// The connections that it supports, at most one of a kind.
    pub connections: heapless::Vec<ScanConnection, 5>,
    /// The connections that are used together if nobody chooses.
    pub default: IoTypes,
}

/// What a device must be to be the one that is meant: attributes 1 to 4 of its Identity object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DeviceKey {
    /// Attribute 1.
    pub vendor: VendorId,
    /// Attribute 2.
    pub device_type: DeviceType,
    /// Attribute 3.
    pub product_code: u16,
    /// Attribute 4.
    pub revision: Revision,
}

/// A connection that a slave supports.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ScanConnection {
    /// Its kind.
    pub ty: IoType,
    /// The kinds that may be used at the same time; its own may be among them.
    pub compatible: IoTypes,
    /// What the slave produces.
    pub produced: ScanData,
    /// What the slave consumes.
    pub consumed: ScanData,
}

/// What a connection carries in one direction.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ScanData {
    /// Bytes; 0: nothing.
    pub size: u16,
    /// The packed path to the data, usually an assembly; empty if the device has no choice.
    pub path: heapless::Vec<u8, SCAN_PATH_MAX>,
}

impl ScanEntry {
    /// The connection of a kind, if the slave supports it.
    #[must_use]
    pub fn connection(&self, ty: IoType) -> Option<&ScanConnection> {
        self.connections.iter().find(|connection| connection.ty == ty)
    }

    /// The connections that are used together if nobody chooses.
    pub fn default_connections(&self) -> impl Iterator<Item = &ScanConnection> {
        self.connections.iter().filter(|connection| self.default.contains(connection.ty.mask()))
    }
}

impl ScanData {
    /// The path.
    #[must_use]
    pub fn epath(&self) -> Epath<'_> {
        Epath::packed(&self.path)
    }
}

/// The longest path of a scan list in bytes. A path to an assembly has 6, at most 9.
pub const SCAN_PATH_MAX: usize = 32;

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn the_mask_and_the_choice_have_different_bits() {
        let masks = IoType::ALL.map(|ty| ty.mask().bits());
        assert_eq!(masks, [0x01, 0x02, 0x04, 0x08, 0x10]);
        let choices = IoType::ALL.map(|ty| ty.allocation_choice().bits());
        assert_eq!(choices, [0x02, 0x04, 0x10, 0x20, 0x08]);
        assert_eq!(IoTypes::all().allocation_choice().bits(), 0x3E);
        assert_eq!((IoTypes::POLL | IoTypes::MULTICAST_POLL).to_string(), "poll + multicast poll");
        assert_eq!(IoTypes::empty().to_string(), "none");
    }
}
