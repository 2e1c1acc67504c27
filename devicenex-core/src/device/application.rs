//! What a device is a device for.

use core::fmt::Debug;
use core::hash::Hash;

use cip_core::code::InstanceId;
use cip_core::connection::{End, IoMode};
use cip_core::object::{Identity, ObjectSet};

use super::long::LongMessages;
use crate::message::{ConnectionInstance, IdentifierLength, Predefined, Production};

/// The device behind a node: who it is, its data, its objects.
///
/// It is a store of data that the node reads and writes; it hears of what happened by events, and never runs in the middle of
/// a request. The module text has a [complete one](super#a-complete-device).
///
/// Everything that it returns must be there at once and stay the same until it is changed through
/// [`Device::application_mut`](super::Device::application_mut) or by a message. Of the connections that it is asked about,
/// those for explicit messages are never one.
pub trait Application: Clone + Eq + Hash + Debug {
    /// The memory for I/O: [`Fragmented`](super::Fragmented), or `()` if no connection produces or consumes more than eight
    /// bytes.
    type Long: LongMessages;

    /// The I/O connections that can be asked for. By default all.
    fn offered(&self) -> Offer {
        Offer::all()
    }

    /// Who the device is and how it is: the Identity object. The node adds whether it is owned.
    fn identity(&self) -> Identity<'_>;

    /// The objects besides Identity, Message Router, link object, Connection and Acknowledge Handler. By default none.
    fn objects(&mut self) -> impl ObjectSet {}

    /// What the connection sends. An empty slice says that there are no valid data.
    ///
    /// For a connection whose data are not sampled by then, they are what was last written to the application.
    fn produced(&self, connection: ConnectionInstance) -> &[u8];

    /// The size of what the connection sends (attribute 7 of the Connection object). By default that of the present data.
    fn produced_size(&self, connection: ConnectionInstance) -> u16 {
        u16::try_from(self.produced(connection).len()).unwrap_or(u16::MAX)
    }

    /// Where the data of the connection go that were received. Its length is the consumed size (attribute 8).
    fn consumed(&mut self, connection: ConnectionInstance) -> &mut [u8];

    /// The assembly that the connection produces or consumes, for attributes 14 and 16. By default none.
    fn assembly(&self, _connection: ConnectionInstance, _end: End) -> Option<InstanceId> {
        None
    }

    /// Makes a connection that is being configured produce or consume another assembly; its sizes follow. False if it cannot.
    fn select_assembly(&mut self, _connection: ConnectionInstance, _end: End, _assembly: InstanceId) -> bool {
        false
    }

    /// Whether [`select_assembly`](Self::select_assembly) does anything. By default not, and the paths cannot be set.
    const SELECTS_ASSEMBLIES: bool = false;

    /// Puts the outputs of the connection into their state for idle or fault. By default all are 0.
    fn rest(&mut self, connection: ConnectionInstance, _mode: IoMode) {
        self.consumed(connection).fill(0);
    }
}

bitflags::bitflags! {
    /// The I/O connections that a device has to offer; one for explicit messages it always has.
    #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
    pub struct Offer: u16 {
        /// Instances 128 to 255 for I/O.
        const DYNAMIC = 1 << 0;
        /// Instances 2 and 3.
        const POLLED = 0b11 << 2;
        /// Instances 4 and 5.
        const BROADCAST = 0b11 << 4;
        /// Instances 6 and 7.
        const MULTICAST_PRODUCER = 0b11 << 6;
        /// Instances 8 and 9.
        const CHANGE_OF_STATE = 0b11 << 8;
        /// Instances 10 and 11.
        const CYCLIC = 0b11 << 10;
        /// Instances 12 and 13.
        const MULTICAST_CONSUMER = 0b11 << 12;
        /// Of all of them, those with 29 bits, and dynamic ones.
        const EXTENDED = 0b10_1010_1010_1001;
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Offer {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=u16:#06x}", self.bits());
    }
}

impl Offer {
    /// Whether the instance is one that is offered.
    #[must_use]
    pub const fn has(self, connection: ConnectionInstance) -> bool {
        let wanted = match connection {
            ConnectionInstance::Predefined(Predefined::Explicit) => return true,
            ConnectionInstance::Predefined(Predefined::Implicit(production, length)) => {
                let both = match production {
                    Production::Polled => Self::POLLED,
                    Production::Broadcast => Self::BROADCAST,
                    Production::MulticastProducer => Self::MULTICAST_PRODUCER,
                    Production::ChangeOfState => Self::CHANGE_OF_STATE,
                    Production::Cyclic => Self::CYCLIC,
                    Production::MulticastConsumer => Self::MULTICAST_CONSUMER,
                };
                match length {
                    IdentifierLength::Standard => both.difference(Self::EXTENDED),
                    IdentifierLength::Extended => both.intersection(Self::EXTENDED),
                }
            }
            ConnectionInstance::Dynamic(_) => Self::DYNAMIC,
            ConnectionInstance::Reserved(_) => return false,
        };
        self.contains(wanted)
    }
}
