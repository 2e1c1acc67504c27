//! The choices that the profile leaves to a device.

use cip_core::code::InstanceId;
use cip_core::connection::TimerResolution;
use cip_core::identity::DeviceIdentity;
use cip_core::message::BodyFormat;
use cip_core::object::{AcknowledgeSettings, FailureOptions};

use crate::access::{self, Role};
use crate::message::PortByte;

/// Everything that a device must be told besides its [`Application`](super::Application). All of it is **\[D\]**.
///
/// [`new`](Self::new) asks for what has no default; change single fields after that.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Network access. Its identity is that of the [`Application`](super::Application).
    pub access: access::Config,
    /// In which steps expected packet rates are measured. 10 ms.
    pub resolution: TimerResolution,
    /// How requests on explicit connections name an object: told in the connection response. Classes and instances of 8 bits.
    pub body_format: BodyFormat,
    /// How some errors are answered.
    pub failures: FailureOptions,
    /// How long the next fragment of a request may take, in ms. 2000.
    pub receive_time_out: u16,
    /// Whether the last fragment of a request is acknowledged again for one second, if it is repeated. True.
    pub reacknowledge_last: bool,
    /// How long a dynamic connection may be configured, in ms, counted from the last service for it: whoever wanted it may be
    /// gone. 10 000; 0: for ever.
    pub configuring_time_out: u16,
    /// Whether the predefined change of state and cyclic connections begin with acknowledges. True.
    pub acknowledged: bool,
    /// How long an acknowledge may take, and how often a message is sent again. The Acknowledge Handler object changes it.
    pub acknowledge: AcknowledgeSettings,
}

impl Config {
    /// The defaults, for a device of this identity.
    #[must_use]
    pub fn new(device: &DeviceIdentity, port: PortByte, role: Role) -> Self {
        Self {
            access: access::Config::new(device.into(), port, role),
            resolution: TimerResolution::DEFAULT,
            body_format: BodyFormat::Class8Instance8,
            failures: FailureOptions::default(),
            receive_time_out: 2000,
            reacknowledge_last: true,
            configuring_time_out: 10_000,
            acknowledged: true,
            acknowledge: AcknowledgeSettings { producer: CHANGE_OF_STATE, ..AcknowledgeSettings::default() },
        }
    }
}

/// The instance with 29 bits.
const CHANGE_OF_STATE: InstanceId = InstanceId(9);
