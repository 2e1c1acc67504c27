//! The values of the attributes.

use core::fmt;

use crate::text::{write_decimal, write_hex8};

crate::code::codes! {
    /// The state of a connection (attribute 1).
    pub struct ConnectionState(u8), "connection state" in decimal {
        NON_EXISTENT = 0, "Non-existent";
        CONFIGURING = 1, "Configuring";
        WAITING_FOR_CONNECTION_ID = 2, "Waiting for connection ID";
        ESTABLISHED = 3, "Established";
        TIMED_OUT = 4, "Timed out";
        DEFERRED_DELETE = 5, "Deferred delete";
        /// Not on DeviceNet.
        CLOSING = 6, "Closing";
    }
}

crate::code::codes! {
    /// The type of a connection (attribute 2).
    pub struct InstanceType(u8), "instance type" in decimal {
        EXPLICIT = 0, "Explicit messaging";
        IO = 1, "I/O";
        BRIDGED = 2, "Bridged";
    }
}

crate::code::codes! {
    /// What happens when a connection times out (attribute 12).
    pub struct WatchdogAction(u8), "watchdog action" in decimal {
        TRANSITION_TO_TIMED_OUT = 0, "Transition to timed out";
        AUTO_DELETE = 1, "Auto delete";
        AUTO_RESET = 2, "Auto reset";
        DEFERRED_DELETE = 3, "Deferred delete";
    }
}

/// transportClass_trigger (attribute 3).
///
/// | Bits | Content |
/// |---|---|
/// | 7 | 0 client, 1 server |
/// | 6-4 | [`ProductionTrigger`] |
/// | 3-0 | transport class 0-6 |
///
/// ```
/// use cip_core::connection::TransportClassTrigger;
///
/// assert_eq!(TransportClassTrigger(0x83).to_string(), "0x83 server, Cyclic, class 3");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TransportClassTrigger(pub u8);

crate::code::codes! {
    /// What makes a client produce: bits 6-4 of [`TransportClassTrigger`].
    pub struct ProductionTrigger(u8), "production trigger" in decimal {
        CYCLIC = 0, "Cyclic";
        CHANGE_OF_STATE = 1, "Change of state";
        APPLICATION_OBJECT = 2, "Application object";
    }
}

impl TransportClassTrigger {
    /// True for a server, false for a client.
    pub const fn is_server(self) -> bool {
        self.0 & 0x80 != 0
    }

    /// What makes a client produce.
    pub const fn trigger(self) -> ProductionTrigger {
        ProductionTrigger((self.0 >> 4) & 0x07)
    }

    /// The transport class: 0 without duplicate detection, 2 acknowledged, 3 acknowledged and verified.
    pub const fn class(self) -> u8 {
        self.0 & 0x0F
    }
}

impl fmt::Display for TransportClassTrigger {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("0x")?;
        write_hex8(f, self.0)?;
        f.write_str(if self.is_server() { " server, " } else { " client, " })?;
        fmt::Display::fmt(&self.trigger(), f)?;
        f.write_str(", class ")?;
        write_decimal(f, self.class().into())
    }
}

/// initial_comm_characteristics (attribute 6): bits 7-4 how it produces, bits 3-0 how it consumes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CommCharacteristics(pub u8);

crate::code::codes! {
    /// One nibble of [`CommCharacteristics`].
    pub struct CommDirection(u8), "communication" in decimal {
        GROUP_1 = 0, "Group 1";
        GROUP_2_DESTINATION = 1, "Group 2 with destination MAC ID";
        GROUP_2_SOURCE = 2, "Group 2 with source MAC ID";
        GROUP_3 = 3, "Group 3";
        NONE = 15, "none";
    }
}

impl CommCharacteristics {
    /// How the connection produces.
    pub const fn produce(self) -> CommDirection {
        CommDirection(self.0 >> 4)
    }

    /// How the connection consumes.
    pub const fn consume(self) -> CommDirection {
        CommDirection(self.0 & 0x0F)
    }
}

impl fmt::Display for CommCharacteristics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("0x")?;
        write_hex8(f, self.0)?;
        f.write_str(" produces: ")?;
        fmt::Display::fmt(&self.produce(), f)?;
        f.write_str(", consumes: ")?;
        fmt::Display::fmt(&self.consume(), f)
    }
}

/// connection_timeout_multiplier (attribute 18): the inactivity timeout is the expected packet rate times 4, 8, 16
/// and so on up to 512.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TimeoutMultiplier(pub u8);

impl TimeoutMultiplier {
    /// The factor, 4-512; `None` for the reserved values above 7.
    pub const fn factor(self) -> Option<u16> {
        Some(match self.0 {
            0 => 4,
            1 => 8,
            2 => 16,
            3 => 32,
            4 => 64,
            5 => 128,
            6 => 256,
            7 => 512,
            _ => return None,
        })
    }
}

impl fmt::Display for TimeoutMultiplier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(factor) = self.factor() else {
            f.write_str("reserved multiplier ")?;
            return write_decimal(f, self.0.into());
        };
        f.write_str("x")?;
        write_decimal(f, factor.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn attributes_in_text() {
        assert_eq!(TransportClassTrigger(0x12).to_string(), "0x12 client, Change of state, class 2");
        let text = CommCharacteristics(0xF1).to_string();
        assert_eq!(text, "0xF1 produces: none, consumes: Group 2 with destination MAC ID");
        assert_eq!(TimeoutMultiplier(7).to_string(), "x512");
        assert_eq!(TimeoutMultiplier(8).to_string(), "reserved multiplier 8");
    }
}
