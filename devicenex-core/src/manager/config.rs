//! Who the manager is, its times, and the choices that the paper leaves to it.

use cip_core::client::Waits;
use cip_core::identity::DeviceIdentity;
use link_core::BitRate;

use crate::access::Role;
use crate::device;
use crate::id::{MessageId, OperationalAddress};
use crate::message::PortByte;

/// Everything that [`Manager`](super::Manager) must be told but its [database](super::PlannedDevice). All defaults are
/// decisions **\[D\]**, unless marked otherwise.
///
/// ```
/// use cip_core::code::{DeviceType, VendorId};
/// use cip_core::identity::{DeviceIdentity, ProductName, Revision};
/// use devicenex_core::OperationalAddress;
/// use devicenex_core::manager::Config;
/// use link_core::BitRate;
///
/// // A fictitious vendor. Use the one that ODVA assigned to you.
/// let device = DeviceIdentity {
///     vendor: VendorId(0x03E7),
///     device_type: DeviceType::COMMUNICATIONS_ADAPTER,
///     product_code: 1,
///     revision: Revision::new(1, 1).ok_or("revision")?,
///     serial: 0x2345,
///     name: ProductName::new("Example Manager").ok_or("name")?,
/// };
/// let mut config = Config::new(device, OperationalAddress::try_from(1)?, BitRate::K500);
/// config.learning = true;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Config {
    /// Who the manager is.
    pub device: DeviceIdentity,
    /// The node that it is: its role is [`Role::NetworkManager`].
    pub node: device::Config,
    /// How often it asks who has no address while a device is missing, in ms; 0: only at the start, and when a device is lost
    /// or does not take its address. Default: 2000.
    pub mini_who_interval: u32,
    /// The same while none is missing, in ms; 0: never. Default: 10 000. It finds spares that were plugged in, gives
    /// detectors on a quiet bus something to detect, and shows a second manager that there is one.
    pub idle_mini_who_interval: u32,
    /// For how long after a Mini-who a Hello without an address is taken for an answer to it, in ms: from a device that
    /// stands by, and not from one that joins. Default: 500.
    pub answer_window: u16,
    /// How long the devices wait after each Hello, in ms. Default: that of the manager itself, 1000.
    pub hello_wait: u16,
    /// How much longer the manager waits than they do, in ms: for their clocks, and for the Hello of another that comes
    /// between. Default: 20.
    pub settle: u16,
    /// Whether the devices obey a ROAM while they still say Hello, as [`access::Config::early_roam`](crate::access::Config::early_roam) lets them. Default: no.
    pub early_roam: bool,
    /// How often a device is sent its address before that is reported as failed. Default: 3.
    pub roam_tries: u8,
    /// How long to wait for the Hello that shows that it was taken, in ms. Default: 500.
    pub roam_wait: u16,
    /// How long spares are left alone while the device itself was never seen, in ms: it may come up later than they.
    /// Default: 15 000, in which a device has tried three bit rates and said Hello twice.
    pub spare_wait: u32,
    /// How often a request is sent before a device counts as lost. Default: 2.
    pub connect_tries: u8,
    /// How long to wait for responses. Default: half a second, and on explicit connections that of
    /// [`Waits::CONNECTED`].
    pub waits: Waits,
    /// How long to leave a device alone that refused a connection, or did not take its address, in ms; also after how long a
    /// [conflict](super::DeviceState::Conflict) is looked at again: after twice and then always four times that, if it is
    /// still the same. Default: 10 000.
    pub retry_wait: u32,
    /// How often each device is asked for the state of a connection of which the manager hears nothing, one after the
    /// other, in ms; 0: never. Default: 1000.
    pub poll_interval: u16,
    /// Whether devices that match nothing are added to the database. Default: no.
    pub learning: bool,
    /// Whether a missing device that is on line at an address which is not in the database is given its planned one, over
    /// an explicit connection. Default: yes.
    pub readdress: bool,
    /// For how long another manager must be silent before this one works again, in ms; 0: until
    /// [`Manager::resume`](super::Manager::resume). Default: 0.
    pub takeover_after: u32,
    /// How long the manager is without an address after another node has turned out to have it, in ms: then it says Hello
    /// with it once more, and after that with the next one that is not planned, until nobody objects. 0: never; it waits
    /// for the ROAM of another manager or for [`Manager::reset`](super::Manager::reset). Default: 10 000.
    pub rejoin_after: u32,
    /// The Message ID of the manager's explicit messages, 0 to 7; a low one has a high priority. Default: 6.
    pub message: MessageId,
}

impl Config {
    /// The defaults, for a manager of this identity that has that address and sets that rate.
    #[must_use]
    pub fn new(device: DeviceIdentity, address: OperationalAddress, bit_rate: BitRate) -> Self {
        let node = device::Config::new(&device, PortByte::ZERO, Role::NetworkManager { address, bit_rate });
        Self {
            hello_wait: node.access.hello_wait,
            node,
            device,
            mini_who_interval: 2000,
            idle_mini_who_interval: 10_000,
            answer_window: 500,
            settle: 20,
            early_roam: false,
            roam_tries: 3,
            roam_wait: 500,
            spare_wait: 15_000,
            connect_tries: 2,
            waits: Waits { response: core::time::Duration::from_millis(500), ..Waits::CONNECTED },
            retry_wait: 10_000,
            poll_interval: 1000,
            learning: false,
            readdress: true,
            takeover_after: 0,
            rejoin_after: 10_000,
            message: MessageId::from_low_bits(6),
        }
    }
}
