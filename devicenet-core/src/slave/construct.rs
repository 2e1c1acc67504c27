//! Making a slave.

use core::fmt;

use cip_core::connection::{ExplicitConnection, TimerResolution};
use cip_core::fragment::{IO_MESSAGE_MAX, IO_UNFRAGMENTED_LEN};
use cip_core::identity::DeviceState;
use cip_core::message::AllocationChoice;
use cip_core::object::{AcknowledgeSettings, FailureOptions};
use link_core::{Queue, Timers};

use super::application::{Application, IoKind, Parts};
use super::config::{Choices, Config, Options, RECEIVE_TIME_OUT_MILLIS};
use super::detection::Detection;
use super::devicenet_object::{Diagnostics, Port};
use super::dynamic::Dynamic;
use super::event::{Events, Received};
use super::indicator::ModuleStatus;
use super::io::{LongMessages, Slots};
use super::lines::Lines;
use super::machine::{DynamicTransfer, Errand, Slave};
use super::node::{Changed, Node, Parent, bits_of};
use super::transfer::Transfer;
use crate::access::{Access, BusOffWhileChecking, CounterSetMode, NetworkStatus};
use crate::id::MacId;

/// Why a slave cannot be made.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum InvalidSlave {
    /// See [`Application::Long`].
    #[error(fmt = too_long)]
    TooLong {
        /// Which connection.
        connection: IoKind,
        /// What it produces or consumes.
        size: usize,
        /// What [`Application::Long`] holds.
        room: usize,
    },
    /// The answer to Allocate and every error response must fit, and the heartbeat of the application's data.
    #[error("explicit messages of {0} bytes are too short: use at least 8")]
    MessageTooShort(usize),
    /// See [`Application::PARTS`].
    #[error("the configuration asks for what the application leaves out: add {0:?} to Application::PARTS")]
    PartLeftOut(Parts),
    /// There are only so many Message IDs.
    #[error("{0} dynamic connections are more than the message groups have room for: use at most 16")]
    TooManyConnections(usize),
}

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Slave<A, MESSAGE, DYNAMIC> {
    /// A slave without power: the first [`LinkEvent::Up`](link_core::LinkEvent::Up) starts it.
    ///
    /// # Errors
    /// See [`InvalidSlave`].
    pub fn new(config: Config, mut application: A) -> Result<Self, InvalidSlave> {
        if MESSAGE < 8 {
            return Err(InvalidSlave::MessageTooShort(MESSAGE));
        }
        if DYNAMIC > 16 {
            return Err(InvalidSlave::TooManyConnections(DYNAMIC));
        }
        let missing = parts_of(&config).difference(A::PARTS);
        if !missing.is_empty() {
            return Err(InvalidSlave::PartLeftOut(missing));
        }
        check_sizes(&mut application)?;
        Ok(Self::assembled(config, application))
    }

    /// The same without checks, for a node whose sizes are known to be right.
    pub(crate) fn assembled(config: Config, application: A) -> Self {
        const {
            let room = <<A::Long as LongMessages>::Slots as Slots>::CHOICE;
            assert!(room.contains(A::IO), "PollOnly has room for poll only: let Application::Long be ()");
            let tells = A::PARTS.contains(Parts::EVENTS) || !A::PARTS.intersects(TELLING);
            assert!(tells, "what Application::PARTS has needs Parts::EVENTS");
        }
        let identity = application.identity();
        // What was told last: without that part nothing ever is.
        let module = if A::PARTS.contains(Parts::INDICATOR_EVENTS) {
            ModuleStatus::of(identity.state.unwrap_or(DeviceState::OPERATIONAL), identity.status)
        } else {
            ModuleStatus::Off
        };
        let limit = if config.options.contains(Options::SIZE_COUNTS_HEADER) {
            MESSAGE.saturating_sub(1)
        } else {
            MESSAGE
        };
        let transfer = DynamicTransfer {
            transfer: Transfer::new(limit),
            in_flight: false,
            piece: None,
            unwanted: false,
        };
        let (detect, receive_time_out) = (config.bit_rate.detect, config.receive_time_out);
        Self {
            node: Node::new(config, application),
            explicit: Transfer::new(limit),
            transfers: [(); DYNAMIC].map(|()| transfer.clone()),
            long: A::Long::default(),
            answers: Queue::new(),
            detection: Detection::new(detect),
            heartbeat_due: false,
            errand: Errand::None,
            online: false,
            pending: false,
            shown: NetworkStatus::Off,
            module,
            receive_time_out,
        }
    }
}

impl<A: Application, const DYNAMIC: usize> Node<A, DYNAMIC> {
    pub(super) fn new(config: Config, application: A) -> Self {
        let device = application.identity().device;
        let (vendor, serial) = (device.vendor, device.serial);
        let options = Choices::new(&config);
        let mut access = config.access;
        access.offline_set &= A::PARTS.contains(Parts::OFFLINE_SET);
        access.device = crate::message::DeviceIdentity { vendor, serial };
        Self {
            options,
            failures: config.failures,
            resolution: config.resolution,
            explicit: ExplicitConnection::NON_EXISTENT,
            slots: Slots::EMPTY,
            dynamic: [Dynamic::CLOSED; DYNAMIC],
            held: AllocationChoice::empty(),
            master: None,
            parent: Parent::Predefined,
            group: MacId::MIN,
            foreign_group: config.multicast_group,
            acknowledge: AcknowledgeSettings::default(),
            heartbeat_interval: config.heartbeat_interval,
            departure: None,
            changed: Changed::empty(),
            lines: Lines::default(),
            timers: Default::default(),
            dynamic_timers: [const { Timers::new() }; DYNAMIC],
            received: Received::default(),
            events: Events::default(),
            access: Access::new(access),
            port: Port {
                stored: config.bit_rate.rate,
                active: config.bit_rate.rate,
                rate_from_switches: config.bit_rate.from_switches,
                switches: None,
                diagnostics: Diagnostics::default(),
            },
            application,
        }
    }
}

fn too_long(connection: &IoKind, size: &usize, room: &usize, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    write!(f, "{connection} has {size} bytes, and ")?;
    match connection {
        IoKind::BitStrobe => f.write_str("a bit-strobe message never has more than 8"),
        _ if *size > IO_MESSAGE_MAX => write!(f, "no I/O message is longer than {IO_MESSAGE_MAX}"),
        _ => write!(f, "there is room for {room}: let Application::Long be Fragmented<{size}>"),
    }
}

/// What the configuration asks for and has not by default.
fn parts_of(config: &Config) -> Parts {
    let mut parts = Parts::empty();
    parts.set(Parts::BIT_RATE_DETECTION, config.bit_rate.detect);
    parts.set(Parts::HEARTBEAT, config.heartbeat_interval.is_some());
    parts.set(Parts::SHUTDOWN_MESSAGE, config.options.contains(Options::SHUTDOWN_MESSAGE));
    let choices = config.options.difference(Options::SHUTDOWN_MESSAGE) != Options::DEFAULT;
    let access_choices = !config.access.accept_bad_dlc
        || !config.access.same_mac_id_restarts
        || config.access.bus_off_while_checking != BusOffWhileChecking::default()
        || config.access.counter_set_mode != CounterSetMode::default();
    // A slave without that part has the finest, whichever of the two its configuration says.
    let coarse = !matches!(config.resolution, TimerResolution::DEFAULT | TimerResolution::FINEST);
    let times = coarse || config.receive_time_out != RECEIVE_TIME_OUT_MILLIS;
    let others = access_choices || times || config.failures != FailureOptions::default();
    parts.set(Parts::CHOICES, choices || others);
    parts.set(Parts::OPTIONAL_ATTRIBUTES, config.access.quick_connect);
    parts
}

fn check_sizes<A: Application>(application: &mut A) -> Result<(), InvalidSlave> {
    for connection in IoKind::ALL {
        if !A::IO.intersects(bits_of(connection)) {
            continue;
        }
        let room = match connection {
            IoKind::BitStrobe => IO_UNFRAGMENTED_LEN,
            IoKind::Poll | IoKind::ChangeOfState | IoKind::MulticastPoll => {
                A::Long::CAPACITY.min(IO_MESSAGE_MAX)
            }
        };
        let consumed = match connection {
            IoKind::ChangeOfState => 0,
            IoKind::Poll | IoKind::BitStrobe | IoKind::MulticastPoll => {
                application.consumed(connection).len()
            }
        };
        let size = consumed.max(application.produced_size(connection).into());
        if size > room {
            return Err(InvalidSlave::TooLong { connection, size, room });
        }
    }
    Ok(())
}

/// The parts that have something to tell.
const TELLING: Parts = Parts::SETTINGS
    .union(Parts::HEARTBEAT)
    .union(Parts::OPTIONAL_ATTRIBUTES)
    .union(Parts::BIT_RATE_DETECTION)
    .union(Parts::INDICATOR_EVENTS)
    .union(Parts::REPORTS);

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn what_is_too_long_is_told_with_what_helps() {
        let told = |connection, size| InvalidSlave::TooLong { connection, size, room: 8 }.to_string();
        assert_eq!(
            told(IoKind::Poll, 9),
            "poll has 9 bytes, and there is room for 8: let Application::Long be Fragmented<9>"
        );
        assert_eq!(
            told(IoKind::BitStrobe, 9),
            "bit-strobe has 9 bytes, and a bit-strobe message never has more than 8"
        );
        assert_eq!(told(IoKind::Poll, 500), "poll has 500 bytes, and no I/O message is longer than 448");
    }
}
