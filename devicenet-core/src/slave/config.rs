//! The choices that the specification leaves to a slave.

use core::marker::PhantomData;

use bitflags::bitflags;
use cip_core::connection::TimerResolution;
use cip_core::object::FailureOptions;
use link_core::BitRate;

use super::application::{Application, Parts};
use super::bit_rate::BitRateConfig;
use crate::access;
use crate::id::MacId;
use crate::message::PortNumber;

use cip_core::identity::DeviceIdentity;

/// Everything that a slave must be told besides its [`Application`](super::Application).
///
/// [`new`](Self::new) asks for what has no default; change single fields after that.
///
/// ```
/// # use cip_core::{code::{DeviceType, VendorId}, identity::{DeviceIdentity, ProductName, Revision}};
/// use devicenet_core::{MacId, slave::{Config, Options}};
///
/// # let device = DeviceIdentity {
/// #     vendor: VendorId(65_000), device_type: DeviceType::GENERIC, product_code: 1,
/// #     revision: Revision::new(1, 1).ok_or("revision")?, serial: 1, name: ProductName::new("x").ok_or("name")?,
/// # };
/// let mut config = Config::new(&device, MacId::DEFAULT);
/// config.options.insert(Options::SHUTDOWN_MESSAGE);
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Of network access. Its identity counts for nothing: that of the application's Identity object is used.
    pub access: access::Config,
    /// The bit rate: DeviceNet object, attribute 2.
    pub bit_rate: BitRateConfig,
    /// The steps in which connections count time. Default: 10 ms; without
    /// [`Parts::CHOICES`](super::Parts::CHOICES) it is 1 ms.
    pub resolution: TimerResolution,
    /// How some errors are answered.
    pub failures: FailureOptions,
    /// Identity object, attribute 10, in seconds as stored: how often a heartbeat is sent. 0 is never; `None`: the
    /// device has no such attribute. Default: `None`.
    pub heartbeat_interval: Option<u8>,
    /// How long a fragmented request may pause before what has arrived of it is dropped, in ms. Default: 3000.
    #[doc(alias = "frag.rx_timeout_ms")]
    pub receive_time_out: u16,
    /// The group whose multicast poll is consumed until the master sets another one. Default: the MAC ID of the master.
    #[doc(alias = "mcpoll.default_group")]
    pub multicast_group: Option<MacId>,
    /// Everything that is either so or not so.
    pub options: Options,
}

impl Config {
    /// The defaults, for a device of this identity.
    #[must_use]
    pub const fn new(device: &DeviceIdentity, mac_id: MacId) -> Self {
        let identity = crate::message::DeviceIdentity { vendor: device.vendor, serial: device.serial };
        Self {
            access: access::Config::new(identity, PortNumber::ZERO, mac_id),
            bit_rate: BitRateConfig::new(BitRate::K125),
            resolution: TimerResolution::DEFAULT,
            failures: FailureOptions { group_2_only_failure: false, path_destination_unknown: false },
            heartbeat_interval: None,
            receive_time_out: RECEIVE_TIME_OUT_MILLIS,
            multicast_group: None,
            options: Options::DEFAULT,
        }
    }
}

bitflags! {
    /// Choices between two kinds of behaviour. [`DEFAULT`](Self::DEFAULT) has those that are on unless they are removed.
    #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct Options: u32 {
        /// A request too short for service, class and instance is answered with 0x13; else it is ignored. Off.
        #[doc(alias = "explicit.short_body")]
        const ANSWER_SHORT_BODY = 1 << 0;
        /// Setting the production inhibit time answers with the time that is used, as setting the EPR does. Off.
        #[doc(alias = "conn.pit_response_data")]
        const ANSWER_INHIBIT_TIME = 1 << 1;
        /// Only the client that opened a connection through the UCMM may close it; others get 0x0C. On.
        #[doc(alias = "ucmm.close_by_owner_only")]
        const CLOSE_BY_OWNER_ONLY = 1 << 2;
        /// A missing Message ID is told by an additional code (Group 2: 0x01, Group 1: 0x03, Group 3: 0x04). On.
        #[doc(alias = "ucmm.additional_codes")]
        const UCMM_ADDITIONAL_CODES = 1 << 3;
        /// A UCMM-capable server serves the Group 2 unconnected port too. On.
        #[doc(alias = "g2.port6_on_ucmm_capable")]
        const UNCONNECTED_PORT = 1 << 4;
        /// The repeated last fragment of a request is acknowledged again for one second. On.
        #[doc(alias = "frag.reack_last")]
        const REACKNOWLEDGE_LAST = 1 << 5;
        /// The limit of explicit messages counts the header byte too. Off.
        #[doc(alias = "frag.size_counts_header")]
        const SIZE_COUNTS_HEADER = 1 << 6;
        /// An empty I/O message on a connection that fragments is sent as the byte 0x3F instead of no data. Off.
        #[doc(alias = "io.zero_len_fragmented")]
        const EMPTY_AS_3F = 1 << 7;
        /// I/O messages shorter than the consumed size are accepted; else only empty and full ones. Off.
        #[doc(alias = "io.length_policy")]
        const ACCEPT_SHORTER_IO = 1 << 8;
        /// Attribute 2 of the DeviceNet object reads as the bit rate in use instead of the stored one. Off.
        #[doc(alias = "baud.read_returns")]
        const READ_ACTIVE_BIT_RATE = 1 << 9;
        /// Bit 6 of a Release choice is ignored; else it is an invalid choice. On.
        #[doc(alias = "release.ignore_bit6")]
        const RELEASE_IGNORES_BIT_6 = 1 << 10;
        /// Only the owner may release; others get 0x0C/0x01. On.
        #[doc(alias = "release.only_owner")]
        const RELEASE_BY_OWNER_ONLY = 1 << 11;
        /// An Allocate must carry the allocator's own MAC ID in its header, else 0x09/0x02. Off.
        #[doc(alias = "alloc.require_header_eq_allocator")]
        const ALLOCATE_FOR_ONESELF_ONLY = 1 << 12;
        /// I/O connections that timed out stay readable, and the indicator flashes red, after the ownership has ended. On.
        #[doc(alias = "conn.keep_timed_out")]
        const KEEP_TIMED_OUT = 1 << 13;
        /// The state of a non-existent connection can be read (0); else every service is answered with 0x16. Off.
        #[doc(alias = "conn.nonexistent_get_state")]
        const READ_NON_EXISTENT_STATE = 1 << 14;
        /// I/O connections that are being configured are dropped when their explicit connection goes. On.
        #[doc(alias = "conn.drop_configuring_with_explicit")]
        const DROP_CONFIGURING_WITH_EXPLICIT = 1 << 15;
        /// The time-out of the last I/O connection also deletes an established explicit connection whose watchdog action
        /// is deferred delete. Off.
        #[doc(alias = "conn.io_timeout_deletes_action3")]
        const IO_TIME_OUT_DELETES_ACTION_3 = 1 << 16;
        /// The outputs of a released connection go to their idle state; else to their fault state. Off.
        #[doc(alias = "io.release_action")]
        const IDLE_ON_RELEASE = 1 << 17;
        /// A shutdown message is sent before the node leaves the network on purpose. Off.
        const SHUTDOWN_MESSAGE = 1 << 18;
    }
}

impl Options {
    /// What is on unless it is removed.
    pub const DEFAULT: Self = Self::CLOSE_BY_OWNER_ONLY
        .union(Self::UCMM_ADDITIONAL_CODES)
        .union(Self::UNCONNECTED_PORT)
        .union(Self::REACKNOWLEDGE_LAST)
        .union(Self::RELEASE_IGNORES_BIT_6)
        .union(Self::RELEASE_BY_OWNER_ONLY)
        .union(Self::KEEP_TIMED_OUT)
        .union(Self::DROP_CONFIGURING_WITH_EXPLICIT);
}

impl Default for Options {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The options of a slave. Without [`Parts::CHOICES`] they are constants.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Choices<A> {
    options: Options,
    application: PhantomData<A>,
}

impl<A: Application> Choices<A> {
    pub(super) const fn new(config: &Config) -> Self {
        Self { options: config.options, application: PhantomData }
    }

    pub(super) const fn contains(&self, option: Options) -> bool {
        // The shutdown message is a part of its own.
        if A::PARTS.contains(Parts::CHOICES) || option.contains(Options::SHUTDOWN_MESSAGE) {
            self.options.contains(option)
        } else {
            Options::DEFAULT.contains(option)
        }
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Options {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=u32:#010x}", self.bits());
    }
}

/// The default of [`Config::receive_time_out`].
pub(super) const RECEIVE_TIME_OUT_MILLIS: u16 = 3000;
