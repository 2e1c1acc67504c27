//! Who the node is, and the choices that the specification leaves to it.

use crate::id::MacId;
use crate::message::{DeviceIdentity, PortNumber};

/// Everything that [`Access`](super::Access) must be told.
///
/// [`new`](Self::new) asks for what has no default, and sets the rest to the documented defaults; change single fields
/// after that.
///
/// ```
/// use devicenet_core::{MacId, access::Config, message::{DeviceIdentity, PortNumber}};
///
/// // A fictitious vendor. Use the one that ODVA assigned to you.
/// let device = DeviceIdentity { vendor: 0x1234.into(), serial: 0x0000_2345 };
/// let mut config = Config::new(device, PortNumber::ZERO, MacId::DEFAULT);
/// config.offline_set = false;
/// ```
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Vendor ID and serial number, which tell this device from every other one. A [slave](crate::slave) takes them from its
    /// Identity object instead.
    pub device: DeviceIdentity,
    /// The number of this DeviceNet port of the device.
    pub port: PortNumber,
    /// The MAC ID to start with: from non-volatile memory, or from the switches.
    pub mac_id: MacId,
    /// Whether the network may change the MAC ID.
    pub mac_id_source: MacIdSource,
    /// The BOI attribute (DeviceNet object, attribute 3) after power-up and reset. Default: off.
    pub bus_off_interrupt: bool,
    /// The Quick Connect attribute (DeviceNet object, attribute 10) as stored. Default: off.
    pub quick_connect: bool,
    /// Whether the node takes part in the offline connection set while a duplicate keeps it off line. Default: on. A slave
    /// without [`Parts::OFFLINE_SET`](crate::slave::Parts::OFFLINE_SET) has it off.
    pub offline_set: bool,
    /// Whether a check message of a wrong length counts as a sign that somebody else uses the MAC ID. Default: yes, for
    /// whoever sends on that identifier does.
    #[doc(alias = "dupmac.accept_bad_dlc")]
    pub accept_bad_dlc: bool,
    /// What bus-off leads to before the node is on line.
    pub bus_off_while_checking: BusOffWhileChecking,
    /// How long to wait after bus-off before the controller is restarted, besides the 128 x 11 recessive bits that it
    /// waits itself, in ms. Also the wait before a frame is handed out again that the controller gave back unsent; with
    /// zero, a port that refuses every frame keeps the machine busy. Default: 100.
    #[doc(alias = "busoff.backoff_ms")]
    pub bus_off_back_off: u16,
    /// Which values may be written to the bus-off counter.
    #[doc(alias = "boc.set_mode")]
    pub counter_set_mode: CounterSetMode,
    /// Whether setting the MAC ID that is in use already restarts the node. Default: yes, tools expect it.
    #[doc(alias = "mac.set_same_restarts")]
    pub same_mac_id_restarts: bool,
    /// Which nodes a mask in Who and Identify means.
    #[doc(alias = "offline.mask_predicate")]
    pub mask_predicate: MaskPredicate,
    /// The unit of the delay before a Who response, in ms. Default: 10, so that one byte means 0 to 2.55 s.
    #[doc(alias = "offline.who_delay_unit_ms")]
    pub who_delay_unit: u16,
    /// How long the network status indicator flashes red and green after Identify, in ms. Default: 60 000.
    #[doc(alias = "led.identify_timeout_s")]
    pub identify_timeout: u32,
}

impl Config {
    /// The defaults, for a device of this identity.
    #[must_use]
    pub const fn new(device: DeviceIdentity, port: PortNumber, mac_id: MacId) -> Self {
        Self {
            device,
            port,
            mac_id,
            mac_id_source: MacIdSource::Software,
            bus_off_interrupt: false,
            quick_connect: false,
            offline_set: true,
            accept_bad_dlc: true,
            bus_off_while_checking: BusOffWhileChecking::Fault,
            bus_off_back_off: 100,
            counter_set_mode: CounterSetMode::AnyValueClears,
            same_mac_id_restarts: true,
            mask_predicate: MaskPredicate::Subset,
            who_delay_unit: 10,
            identify_timeout: 60_000,
        }
    }
}

/// Where the MAC ID comes from.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum MacIdSource {
    /// From memory: it can be set over the network. The default.
    #[default]
    Software,
    /// From switches: setting it is refused, and Change_MAC_ID restarts the node with the MAC ID that it has.
    Switches,
}

/// What bus-off leads to in `SendingDupMac` and `WaitingDupMac`.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum BusOffWhileChecking {
    /// The communication fault, whatever BOI says: the transition table has no other row, and a node that was thrown off
    /// the bus by its own check had better be looked at. The default.
    #[default]
    Fault,
    /// What BOI says, as on line.
    FollowInterrupt,
}

/// What may be written to the bus-off counter (DeviceNet object, attribute 4).
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum CounterSetMode {
    /// Writing any value sets it to 0. The default.
    #[default]
    AnyValueClears,
    /// Only 0 may be written (Rockwell 2100-GK61).
    OnlyZero,
}

/// Which nodes a mask means (Who and Identify with Match = 0). Tools should use 0x3F only, which means every node.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum MaskPredicate {
    /// All ones of the MAC ID are in the mask: `mac & !mask == 0`. The default.
    #[default]
    Subset,
    /// A one of the MAC ID is in the mask: `mac & mask != 0`. MAC ID 0 is never meant.
    Intersects,
}
