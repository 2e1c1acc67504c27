//! What a slave is, against what the scan list says it is.

use core::fmt;

use super::scan_list::IoInstance;
use super::state::Cause;
use super::status::ScannerStatus;

/// A value of a slave that is not the one in the scan list.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Difference {
    /// Which value.
    pub property: Property,
    /// In the scan list. Of a revision, the major one is in the low byte.
    pub wanted: u16,
    /// What the slave says; `None` if its answer is too short for a value.
    pub found: Option<u16>,
}

/// What is compared before the I/O of a slave begins.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Property {
    /// Vendor ID, part of the electronic key.
    Vendor,
    /// Device type, part of the electronic key.
    DeviceType,
    /// Product code, part of the electronic key.
    ProductCode,
    /// Major revision, and the least minor one; part of the electronic key.
    Revision,
    /// Bytes that the slave produces.
    ProducedSize(IoInstance),
    /// Bytes that the slave consumes.
    ConsumedSize(IoInstance),
}

impl Property {
    /// What a difference in it comes to.
    pub(super) const fn mismatch(self) -> (Cause, ScannerStatus) {
        match self {
            Self::Vendor | Self::DeviceType | Self::ProductCode | Self::Revision => {
                (Cause::KeyMismatch, ScannerStatus::WRONG_DEVICE)
            }
            Self::ProducedSize(_) | Self::ConsumedSize(_) => {
                (Cause::SizeMismatch, ScannerStatus::SIZE_MISMATCH)
            }
        }
    }

    fn value(self, value: u16, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self == Self::Revision {
            let [major, minor] = value.to_le_bytes();
            write!(f, "{major}.{minor}")
        } else {
            write!(f, "{value}")
        }
    }
}

impl fmt::Display for Property {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Vendor => f.write_str("vendor"),
            Self::DeviceType => f.write_str("device type"),
            Self::ProductCode => f.write_str("product code"),
            Self::Revision => f.write_str("revision"),
            Self::ProducedSize(instance) => write!(f, "bytes produced by {instance}"),
            Self::ConsumedSize(instance) => write!(f, "bytes consumed by {instance}"),
        }
    }
}

/// `vendor 7, the scan list says 4660`
impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ", self.property)?;
        match self.found {
            Some(found) => self.property.value(found, f)?,
            None => f.write_str("not told")?,
        }
        f.write_str(", the scan list says ")?;
        self.property.value(self.wanted, f)
    }
}
