//! Status word and state of a device.

use core::fmt;

use crate::text::write_hex16;

bitflags::bitflags! {
    /// The status word (attribute 5).
    ///
    /// | Bit | Meaning |
    /// |---|---|
    /// | 0 | owned: the predefined connection set is allocated |
    /// | 1 | reserved |
    /// | 2 | configured: differs from the out-of-box configuration |
    /// | 3 | reserved |
    /// | 4-7 | [`ExtendedStatus`] |
    /// | 8 | minor recoverable fault |
    /// | 9 | minor unrecoverable fault |
    /// | 10 | major recoverable fault |
    /// | 11 | major unrecoverable fault |
    /// | 12-15 | reserved |
    ///
    /// A word from a device is kept as it is: make one with `from_bits_retain`.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct IdentityStatus: u16 {
        /// The predefined connection set is allocated.
        const OWNED = 0x0001;
        /// The configuration differs from the one out of the box.
        const CONFIGURED = 0x0004;
        /// All bits of the extended status.
        const EXTENDED = 0x00F0;
        /// A fault from which the device recovers, and which does not stop it.
        const MINOR_RECOVERABLE_FAULT = 0x0100;
        /// A fault that remains, and which does not stop the device.
        const MINOR_UNRECOVERABLE_FAULT = 0x0200;
        /// The device is in the state Major recoverable fault.
        const MAJOR_RECOVERABLE_FAULT = 0x0400;
        /// The device is in the state Major unrecoverable fault.
        const MAJOR_UNRECOVERABLE_FAULT = 0x0800;
    }
}

crate::code::codes! {
    /// Bits 4-7 of the status word. Old devices leave them 0.
    pub struct ExtendedStatus(u8), "extended status" in hex {
        UNKNOWN = 0, "self-test or unknown";
        FIRMWARE_UPDATE = 1, "firmware update in progress";
        FAULTED_CONNECTION = 2, "at least one faulted I/O connection";
        NO_CONNECTION = 3, "no I/O connections established";
        BAD_CONFIGURATION = 4, "non-volatile configuration bad";
        MAJOR_FAULT = 5, "major fault";
        RUN = 6, "at least one I/O connection in run mode";
        IDLE = 7, "at least one I/O connection established, all idle";
    }
}

crate::code::codes! {
    /// The state of a device (attribute 8, and byte 4 of the heartbeat).
    pub struct DeviceState(u8), "device state" in decimal {
        NONEXISTENT = 0, "Nonexistent";
        SELF_TESTING = 1, "Device self testing";
        STANDBY = 2, "Standby";
        OPERATIONAL = 3, "Operational";
        MAJOR_RECOVERABLE_FAULT = 4, "Major recoverable fault";
        MAJOR_UNRECOVERABLE_FAULT = 5, "Major unrecoverable fault";
        /// In Get_Attributes_All of a device without the attribute.
        NOT_IMPLEMENTED = 255, "not implemented";
    }
}

impl IdentityStatus {
    /// The extended status.
    pub fn extended(self) -> ExtendedStatus {
        let [low, _] = self.bits().to_le_bytes();
        ExtendedStatus(low >> 4)
    }

    /// The same word with another extended status, of which four bits count.
    #[must_use]
    pub fn with_extended(self, extended: ExtendedStatus) -> Self {
        let bits = u16::from(extended.0 & 0x0F) << 4;
        self.difference(Self::EXTENDED).union(Self::from_bits_retain(bits))
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for IdentityStatus {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=u16:#06x}", self.bits());
    }
}

impl fmt::Display for IdentityStatus {
    /// `0x0065 (owned, configured, at least one I/O connection in run mode)`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("0x")?;
        write_hex16(f, self.bits())?;
        let mut separator = " (";
        for (bit, name) in FLAGS {
            if bit == Self::EXTENDED {
                if self.extended() != ExtendedStatus::UNKNOWN {
                    f.write_str(separator)?;
                    fmt::Display::fmt(&self.extended(), f)?;
                    separator = ", ";
                }
            } else if self.contains(bit) {
                f.write_str(separator)?;
                f.write_str(name)?;
                separator = ", ";
            }
        }
        f.write_str(if separator == ", " { ")" } else { "" })
    }
}

const FLAGS: [(IdentityStatus, &str); 7] = [
    (IdentityStatus::OWNED, "owned"),
    (IdentityStatus::CONFIGURED, "configured"),
    (IdentityStatus::EXTENDED, "extended"),
    (IdentityStatus::MINOR_RECOVERABLE_FAULT, "minor recoverable fault"),
    (IdentityStatus::MINOR_UNRECOVERABLE_FAULT, "minor unrecoverable fault"),
    (IdentityStatus::MAJOR_RECOVERABLE_FAULT, "major recoverable fault"),
    (IdentityStatus::MAJOR_UNRECOVERABLE_FAULT, "major unrecoverable fault"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn status_words_in_text() {
        assert_eq!(IdentityStatus::empty().to_string(), "0x0000");
        let status = IdentityStatus::OWNED.with_extended(ExtendedStatus::RUN);
        assert_eq!(status.to_string(), "0x0061 (owned, at least one I/O connection in run mode)");
        let major = IdentityStatus::from_bits_retain(0xF400);
        assert_eq!(major.to_string(), "0xF400 (major recoverable fault)");
    }

    #[test]
    fn extended_status_replaces_itself_only() {
        for nibble in 0..=15 {
            let status = IdentityStatus::from_bits_retain(0xFFFF).with_extended(ExtendedStatus(nibble));
            assert_eq!(status.extended(), ExtendedStatus(nibble));
            assert_eq!(status.bits() | 0x00F0, 0xFFFF);
        }
    }
}
