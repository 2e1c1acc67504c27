//! Making a device, and asking it.

use cip_core::code::InstanceId;
use cip_core::connection::{ConnectionState, WatchdogAction};
use cip_core::fragment::IO_MESSAGE_MAX;
use cip_core::transfer::Rules;
use link_core::Queue;

use super::application::Application;
use super::config::Config;
use super::connectionless::Port;
use super::event::Counters;
use super::line::Line;
use super::long::LongMessages;
use super::machine::{Device, Settings};
use super::slot::Slot;
use crate::access::Access;
use crate::connection::ConnectionId;
use crate::id::OperationalAddress;
use crate::link_object::MOST_CONNECTIONS;
use crate::message::ConnectionInstance;

/// Why a device cannot be made.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum InvalidDevice {
    /// See [`Application::Long`].
    #[error(
        "{connection} has {size} bytes, and there is room for {room}: let Application::Long be Fragmented<{size}>, at most 448"
    )]
    TooLong {
        /// Which connection.
        connection: ConnectionInstance,
        /// What it produces or consumes.
        size: usize,
        /// What [`Application::Long`] holds.
        room: usize,
    },
    /// Every error response must fit into a frame, and a frame into a message.
    #[error("explicit messages of {0} bytes are too short: use at least 8")]
    MessageTooShort(usize),
    /// There are only so many instances.
    #[error("{0} connections are too many: use at most 127")]
    TooManyConnections(usize),
}

/// A connection of a device, as it is now.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Connection {
    /// Which.
    pub instance: ConnectionInstance,
    /// Who asked for it.
    pub requester: OperationalAddress,
    /// Attribute 1.
    pub state: ConnectionState,
    /// Attribute 4.
    pub produced: ConnectionId,
    /// Attribute 5.
    pub consumed: ConnectionId,
    /// Attribute 9, in ms.
    pub expected_packet_rate: u16,
    /// Attribute 12.
    pub watchdog_action: WatchdogAction,
}

impl<A: Application, const MESSAGE: usize, const CONNECTIONS: usize> Device<A, MESSAGE, CONNECTIONS> {
    /// A device without power: the first [`LinkEvent::Up`](link_core::LinkEvent::Up) starts it. The identity with which it
    /// joins is that of the application.
    ///
    /// # Errors
    /// See [`InvalidDevice`].
    pub fn new(config: Config, mut application: A) -> Result<Self, InvalidDevice> {
        if MESSAGE < 8 {
            return Err(InvalidDevice::MessageTooShort(MESSAGE));
        }
        if CONNECTIONS > MOST_CONNECTIONS {
            return Err(InvalidDevice::TooManyConnections(CONNECTIONS));
        }
        check_sizes(&mut application)?;
        Ok(Self::assembled(config, application))
    }

    /// One whose sizes are known to be right.
    pub(crate) fn assembled(config: Config, application: A) -> Self {
        let mut access = config.access;
        access.device = application.identity().device.into();
        Self {
            application,
            access: Access::new(access),
            slots: [const { Slot::FREE }; CONNECTIONS],
            port: Port::new(),
            answers: Queue::new(),
            answering: (Line::IDLE, None),
            settings: Settings {
                resolution: config.resolution,
                body_format: config.body_format,
                failures: config.failures,
                rules: Rules {
                    receive_time_out: config.receive_time_out,
                    reacknowledge_last: config.reacknowledge_last,
                },
                configuring_time_out: config.configuring_time_out,
                acknowledged: config.acknowledged,
                acknowledge: config.acknowledge,
            },
            acknowledge: config.acknowledge,
            departure: None,
            online: false,
            filter_changed: false,
            counters: Counters::default(),
            events: Queue::new(),
        }
    }

    /// Its network access.
    #[must_use]
    pub const fn access(&self) -> &Access {
        &self.access
    }

    /// The device behind it.
    #[must_use]
    pub const fn application(&self) -> &A {
        &self.application
    }

    /// The same, to change its data. If what is produced by change of state has changed, call [`produce`](Self::produce) or
    /// [`inputs_changed`](Self::inputs_changed) after that; sizes must stay as they are.
    pub const fn application_mut(&mut self) -> &mut A {
        &mut self.application
    }

    /// What was counted since the device was made, besides its [network access](Access::counters).
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// The connections that exist.
    pub fn connections(&self) -> impl Iterator<Item = Connection> {
        let own = self.access.address();
        self.slots.iter().filter(|slot| slot.is_open()).filter_map(move |slot| {
            let settings = slot.settings()?;
            Some(Connection {
                instance: slot.connection(),
                requester: slot.requester,
                state: slot.state(),
                produced: slot.produced(own).into(),
                consumed: slot.consumed(own).into(),
                expected_packet_rate: settings.expected_packet_rate(),
                watchdog_action: settings.watchdog_action(),
            })
        })
    }

    /// Moves every instant that it stores towards zero, so that a model checker can compare histories of different age.
    pub fn shift_time(&mut self, span: core::time::Duration) {
        self.access.shift_time(span);
        self.port.timers.shift(span);
        for slot in &mut self.slots {
            slot.timers.shift(span);
        }
    }
}

/// The predefined connections, and the first dynamic one for all others: what assemblies are selected for them is checked then.
fn check_sizes<A: Application>(application: &mut A) -> Result<(), InvalidDevice> {
    let room = A::Long::CAPACITY.min(IO_MESSAGE_MAX);
    for number in (2..=13).chain([128]) {
        let connection = ConnectionInstance::of(InstanceId(number));
        if !application.offered().has(connection) {
            continue;
        }
        let produced = usize::from(application.produced_size(connection));
        let size = produced.max(application.consumed(connection).len());
        if size > room {
            return Err(InvalidDevice::TooLong { connection, size, room });
        }
    }
    Ok(())
}
