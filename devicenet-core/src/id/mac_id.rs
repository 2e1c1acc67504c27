//! The node address.

use core::fmt;

/// A node address, 0 to 63.
///
/// A low MAC ID means high priority on the bus. 255 in the allocation information of a DeviceNet object means "no
/// master" and is not a MAC ID.
///
/// ```
/// use devicenet_core::MacId;
///
/// assert_eq!(MacId::new(37).map(u8::from), Some(37));
/// assert_eq!(MacId::new(64), None);
/// assert_eq!(MacId::DEFAULT.to_string(), "63");
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "u8", into = "u8"))]
pub struct MacId(u8);

/// A number that is not a MAC ID.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[error("{0} is not a MAC ID: use 0 to 63")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InvalidMacId(pub u8);

impl MacId {
    /// The lowest address, of the highest priority.
    pub const MIN: Self = Self(0);
    /// The highest address.
    pub const MAX: Self = Self(63);
    /// The address of a device out of the box: 63.
    pub const DEFAULT: Self = Self::MAX;
    /// How many addresses there are.
    pub const COUNT: usize = 64;

    /// The MAC ID of that number; `None` above 63.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        if number <= Self::MAX.0 { Some(Self(number)) } else { None }
    }

    /// The MAC ID in the low six bits of a byte or identifier; the others are not looked at.
    #[must_use]
    pub const fn from_low_bits(byte: u8) -> Self {
        Self(byte & 0x3F)
    }

    /// The number, 0 to 63.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0
    }

    /// The number as an index into a table of [`COUNT`](Self::COUNT) nodes.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }

    /// All 64, in ascending order.
    pub fn all() -> impl DoubleEndedIterator<Item = Self> + ExactSizeIterator + Clone {
        (0..64_u8).map(Self)
    }
}

/// [`MacId::DEFAULT`], 63.
impl Default for MacId {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl TryFrom<u8> for MacId {
    type Error = InvalidMacId;

    fn try_from(number: u8) -> Result<Self, InvalidMacId> {
        Self::new(number).ok_or(InvalidMacId(number))
    }
}

impl From<MacId> for u8 {
    fn from(mac: MacId) -> Self {
        mac.0
    }
}

/// The number, in decimal, as on the switches.
impl fmt::Display for MacId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, f)
    }
}

impl fmt::Debug for MacId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "MacId({})", self.0)
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for MacId {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "MAC ID {=u8}", self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn sixty_four_numbers_are_mac_ids_and_no_others() {
        let accepted: std::vec::Vec<_> = (0..=u8::MAX).filter_map(MacId::new).collect();
        assert_eq!(accepted.len(), MacId::COUNT);
        assert!(accepted.into_iter().eq(MacId::all()));
        assert_eq!(MacId::try_from(255), Err(InvalidMacId(255)));
        assert_eq!(InvalidMacId(64).to_string(), "64 is not a MAC ID: use 0 to 63");
    }

    #[test]
    fn out_of_the_box_a_device_is_63() {
        assert_eq!(MacId::default().number(), 63);
    }
}
