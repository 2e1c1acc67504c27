//! Who the node is, its times, and the choices that the paper leaves to it.

use link_core::BitRate;

use crate::bit_rate::Candidates;
use crate::id::OperationalAddress;
use crate::message::{DeviceIdentity, PortByte};

/// Everything that [`Access`](super::Access) must be told. All defaults are decisions **\[D\]**, unless marked otherwise.
///
/// ```
/// use devicenex_core::{access::{Config, Role}, message::{DeviceIdentity, PortByte}};
///
/// // A fictitious vendor. Use the one that ODVA assigned to you.
/// let device = DeviceIdentity { vendor: 0x1234.into(), product_code: 7, major_revision: 1, serial: 0x2345 };
/// let mut config = Config::new(device, PortByte::ZERO, Role::Device);
/// config.bus_off_interrupt = true;
/// ```
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Which tells this device from every other one.
    pub device: DeviceIdentity,
    /// The number of this port of the device.
    pub port: PortByte,
    /// Device or network manager.
    pub role: Role,
    /// How long others have to object after each Hello, in ms, from the moment at which it was on the bus. Default: 1000,
    /// as in DeviceNet.
    pub hello_wait: u16,
    /// How often a node on line tells its address by a Hello response, in ms; 0: never, as in the paper. Default: 10 000.
    /// Without it, two segments that are joined can have two nodes of one address until one of them must defend it.
    pub announcement: u32,
    /// The rates that are tried.
    pub candidates: Candidates,
    /// How long to listen at a rate without a frame, in ms. Default: 3000, longer than the two seconds from one Mini-who
    /// to the next.
    pub dwell: u16,
    /// After how many valid frames in a row the rate is known. Default: 2.
    pub lock_after: u8,
    /// What to do if the controller's mode cannot be set.
    pub mode_refused: ModeRefused,
    /// BOI: whether bus-off leads to a new start. Default: off.
    pub bus_off_interrupt: bool,
    /// How many new starts BOI allows from power-up to power-down. Default: 1. The paper (2.1.1) warns of nodes that come
    /// back again and again.
    pub bus_off_restarts: u8,
    /// How long to wait after bus-off before the controller is restarted, in ms. Also the wait before a frame is handed out
    /// again that the controller gave back unsent. Default: 100.
    pub bus_off_back_off: u16,
    /// Whether the address outlives the loss of the link. Default: yes; a node that is plugged in again asks for its old
    /// address, and has none if somebody took it over (paper 1-8).
    pub keep_address: bool,
    /// Whether a device that has no address obeys a ROAM already while it says Hello. Default: no, it is obeyed in Standby.
    pub early_roam: bool,
}

/// What a node is on its bus.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Role {
    /// It detects the bit rate, and begins without an address **\[P\]**.
    #[default]
    Device,
    /// It sets the bit rate, and begins with an address of its own **\[P\]** (paper 5, 1-1).
    NetworkManager {
        /// 1 in the paper.
        address: OperationalAddress,
        /// The rate of the bus.
        bit_rate: BitRate,
    },
}

/// What a node does whose controller cannot be set to a bit rate, or to listen-only mode.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum ModeRefused {
    /// It is faulted: it might disturb the bus. The default.
    #[default]
    Fault,
    /// It takes the rate that the link has, as set by whoever may. A device still sends nothing before it has heard
    /// enough valid frames.
    TakeRateOfLink,
}

impl Config {
    /// The defaults, for a device of this identity.
    #[must_use]
    pub fn new(device: DeviceIdentity, port: PortByte, role: Role) -> Self {
        Self {
            device,
            port,
            role,
            hello_wait: 1000,
            announcement: 10_000,
            candidates: Candidates::default(),
            dwell: 3000,
            lock_after: 2,
            mode_refused: ModeRefused::Fault,
            bus_off_interrupt: false,
            bus_off_restarts: 1,
            bus_off_back_off: 100,
            keep_address: true,
            early_roam: false,
        }
    }

    /// The address with which the node begins.
    #[must_use]
    pub const fn first_address(&self) -> OperationalAddress {
        match self.role {
            Role::Device => OperationalAddress::NONE,
            Role::NetworkManager { address, .. } => address,
        }
    }
}
