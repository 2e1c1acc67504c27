//! The choices that a scanner's user has.

use core::time::Duration;

use cip_core::identity::DeviceIdentity;
use cip_core::message::BodyFormat;

use super::replacement::ReplacementMode;
use crate::client::Waits;
use crate::id::MacId;
use crate::slave;

/// Who the master is, and how it works.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Who the master is: its Identity object.
    pub device: DeviceIdentity,
    /// Its own place on the network, and its own objects. It has no unconnected port of Group 2.
    pub node: slave::Config,
    /// Interscan delay: from the end of one poll scan to the start of the next; explicit messages have their time then.
    /// Default 10 ms. With 0 the next scan starts when all responses of the last are there, and frames with higher
    /// identifiers had a moment to begin; it waits for answers to explicit messages for up to 2 ms, and for no more than
    /// every eighth slave's, or those of slaves that are brought up, and one more. After an error on the bus it
    /// gives way until nothing was heard for 2 ms.
    pub interscan_delay: Duration,
    /// How long a scan waits for responses that are still missing, counted from its last command. Default 10 ms.
    pub response_wait: Duration,
    /// A slave with [`ScanRate::Background`](super::ScanRate::Background) is polled once in so many scans. Default 1.
    pub background_ratio: u16,
    /// How a slave is first addressed.
    pub first_contact: FirstContact,
    /// The body format that is asked of the UCMM; the slave may choose a smaller one. Default 16/16.
    pub ucmm_format: BodyFormat,
    /// Waits on explicit connections.
    #[doc(alias = "client.response_timeout_ms")]
    pub connected: Waits,
    /// Waits on the unconnected port and with the UCMM.
    pub unconnected: Waits,
    /// How often a request is sent before its slave counts as absent. Default 2.
    pub tries: u8,
    /// The first pause after an attempt that failed. It doubles with each further one. Default 1 s.
    pub retry_after: Duration,
    /// The longest pause. Default 16 s.
    pub retry_at_most: Duration,
    /// Whether the slave's explicit connection is asked to stay as long as its I/O (watchdog action 3). Default true; a
    /// slave that refuses is left as it is.
    pub deferred_delete: bool,
    /// Automatic device replacement. Default off.
    pub replacement: ReplacementMode,
    /// How often MAC ID 63 is looked at while a slave is missing. Default 5 s.
    pub replacement_retry: Duration,
}

/// Which of its two doors is knocked at first.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum FirstContact {
    /// The unconnected port of Group 2, which nearly every slave has; the UCMM when nobody answers there. A Group 2 Only
    /// slave is up two seconds sooner than with [`Ucmm`](Self::Ucmm).
    #[default]
    Group2,
    /// The UCMM; the unconnected port when nobody answers there.
    Ucmm,
}

impl Config {
    /// The defaults, for a master of this identity.
    #[must_use]
    pub fn new(device: DeviceIdentity, mac_id: MacId) -> Self {
        let mut node = slave::Config::new(&device, mac_id);
        node.options.remove(slave::Options::UNCONNECTED_PORT);
        Self {
            device,
            node,
            interscan_delay: Duration::from_millis(10),
            response_wait: Duration::from_millis(10),
            background_ratio: 1,
            first_contact: FirstContact::Group2,
            ucmm_format: BodyFormat::Class16Instance16,
            connected: Waits::CONNECTED,
            unconnected: Waits::UNCONNECTED,
            tries: 2,
            retry_after: Duration::from_secs(1),
            retry_at_most: Duration::from_secs(16),
            deferred_delete: true,
            replacement: ReplacementMode::Off,
            replacement_retry: Duration::from_secs(5),
        }
    }
}
