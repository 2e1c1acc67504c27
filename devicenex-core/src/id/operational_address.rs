//! The node address.

use core::fmt;

/// An operational address (OA), 0 to 126, or 127 for none **\[P\]**.
///
/// It is given at run time by the network manager, and belongs to a task in the plant rather than to a device: a spare
/// takes over the address of the device that it replaces. A low address means high priority on the bus.
///
/// ```
/// use devicenex_core::OperationalAddress;
///
/// assert_eq!(OperationalAddress::new(67).map(u8::from), Some(67));
/// assert_eq!(OperationalAddress::new(128), None);
/// assert!(OperationalAddress::default().is_none());
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "u8", into = "u8"))]
pub struct OperationalAddress(u8);

/// A number that is not an operational address.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[error("{0} is not an operational address: use 0 to 126, or 127 for none")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InvalidAddress(pub u8);

impl OperationalAddress {
    /// The lowest address, of the highest priority.
    pub const MIN: Self = Self(0);
    /// The highest address that a node can have.
    pub const MAX: Self = Self(126);
    /// 127: a device that has no address, as it is out of the box.
    pub const NONE: Self = Self(127);
    /// How many addresses nodes can have.
    pub const COUNT: usize = 127;

    /// The address of that number; `None` above 127.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        if number <= Self::NONE.0 { Some(Self(number)) } else { None }
    }

    /// The address in the low seven bits; bit 7 is not looked at.
    #[must_use]
    pub const fn from_low_bits(byte: u8) -> Self {
        Self(byte & Self::NONE.0)
    }

    /// The number, 0 to 127.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0
    }

    /// Whether it is 127, which is no address.
    #[must_use]
    pub const fn is_none(self) -> bool {
        self.0 == Self::NONE.0
    }

    /// The number as an index into a table of [`COUNT`](Self::COUNT) nodes; 127 is past its end.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }

    /// The 127 addresses that a node can have, in ascending order.
    pub fn all() -> impl DoubleEndedIterator<Item = Self> + ExactSizeIterator + Clone {
        (0..127_u8).map(Self)
    }
}

/// [`OperationalAddress::NONE`].
impl Default for OperationalAddress {
    fn default() -> Self {
        Self::NONE
    }
}

impl TryFrom<u8> for OperationalAddress {
    type Error = InvalidAddress;

    fn try_from(number: u8) -> Result<Self, InvalidAddress> {
        Self::new(number).ok_or(InvalidAddress(number))
    }
}

impl From<OperationalAddress> for u8 {
    fn from(address: OperationalAddress) -> Self {
        address.0
    }
}

/// The number, in decimal.
impl fmt::Display for OperationalAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, f)
    }
}

impl fmt::Debug for OperationalAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "OperationalAddress({})", self.0)
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for OperationalAddress {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "OA {=u8}", self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn a_hundred_and_twenty_seven_numbers_are_addresses_and_one_is_none() {
        let accepted: std::vec::Vec<_> = (0..=u8::MAX).filter_map(OperationalAddress::new).collect();
        assert_eq!(accepted.len(), OperationalAddress::COUNT + 1);
        assert!(
            accepted
                .into_iter()
                .eq(OperationalAddress::all().chain(core::iter::once(OperationalAddress::NONE)))
        );
        assert!(OperationalAddress::all().all(|address| !address.is_none()));
        assert_eq!(
            InvalidAddress(128).to_string(),
            "128 is not an operational address: use 0 to 126, or 127 for none"
        );
    }
}
