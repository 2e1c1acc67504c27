//! The status of a slave or of the scanner, in the codes that scanner displays show.

use core::fmt;

/// A scanner status: 0 is normal, 64 to 99 are the codes that DeviceNet scanners show in turn with the node address.
///
/// They are a de facto standard of Rockwell scanners (1771-SDN, 1756-DNB, 1769-SDN) that others took over.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
pub struct ScannerStatus(pub u8);

macro_rules! statuses {
    ($($CONSTANT:ident = $code:literal, $text:literal;)*) => {
        impl ScannerStatus {
            $(
                #[doc = concat!(stringify!($code), ": ", $text, ".")]
                pub const $CONSTANT: Self = Self($code);
            )*

            /// What it means; `None` for a code that no manual explains.
            #[must_use]
            pub const fn name(self) -> Option<&'static str> {
                match self.0 {
                    $($code => Some($text),)*
                    _ => None,
                }
            }
        }
    };
}

statuses! {
    NORMAL = 0, "normal";
    AUTO_SCAN = 65, "AutoScan enabled, scanner idle";
    SECONDARY = 67, "this scanner is the secondary";
    NO_SECONDARY = 68, "the primary did not find a secondary";
    SECONDARY_MISMATCH = 69, "configuration of primary and secondary differs";
    DUPLICATE_MAC_ID = 70, "duplicate MAC ID check failed";
    ILLEGAL_SCAN_LIST = 71, "illegal data in the scan list";
    STOPPED_COMMUNICATING = 72, "slave stopped communicating";
    WRONG_DEVICE = 73, "slave does not match the electronic key";
    DATA_OVERRUN = 74, "data overrun on the port";
    NO_TRAFFIC = 75, "no scan list, or no traffic of other nodes";
    NO_DIRECT_TRAFFIC = 76, "no traffic for this scanner";
    SIZE_MISMATCH = 77, "data size does not match the scan list";
    NOT_FOUND = 78, "slave not found";
    TRANSMIT_FAILED = 79, "scanner failed to transmit";
    SCANNER_IDLE = 80, "scanner is idle";
    SCANNER_FAULTED = 81, "scanner faulted";
    FRAGMENT_SEQUENCE = 82, "error in the sequence of fragmented I/O messages";
    INITIALISATION_REFUSED = 83, "slave answered its initialisation with an error";
    INITIALISING = 84, "slave is being initialised";
    WRONG_LENGTH = 85, "slave sent data of a wrong length";
    SLAVE_IDLE = 86, "slave produces idle data while the scanner runs";
    SHARED_INPUT_NOT_ALLOCATED = 87, "the owner has not allocated the shared input yet";
    SHARED_INPUT_MISMATCH = 88, "shared input: connections of the owner differ";
    REPLACEMENT_FAILED = 89, "automatic device replacement or configuration failed";
    PORT_DISABLED = 90, "port disabled by the user";
    BUS_OFF = 91, "bus-off";
    NO_NETWORK_POWER = 92, "no network power";
    UPDATE_IN_PROGRESS = 95, "firmware update or configuration load in progress";
    TEST_MODE = 96, "port in test mode";
    HALTED = 97, "port halted by the user";
    FIRMWARE_FAILURE = 98, "unrecoverable firmware failure";
    HARDWARE_FAILURE = 99, "unrecoverable hardware failure";
}

impl fmt::Display for ScannerStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.0, self.name().unwrap_or("reserved"))
    }
}

impl fmt::Debug for ScannerStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}
