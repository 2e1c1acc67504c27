//! What a slave is a slave for.

use core::fmt::Debug;
use core::hash::Hash;

use cip_core::code::InstanceId;
use cip_core::message::AllocationChoice;
use cip_core::object::{Identity, ObjectSet};

use super::io::LongMessages;

pub use cip_core::connection::{End, IoMode};

/// The device behind a slave: who it is, its data, its objects.
///
/// It is a store of data that the slave reads and writes; it hears of what happened by the events of the slave, and never
/// runs in the middle of a request. The module text has a [complete one](super#a-complete-slave).
///
/// Everything that it returns must be there at once and stay the same until it is changed through
/// [`Slave::application_mut`](super::Slave::application_mut) or by a message.
pub trait Application: Clone + Eq + Hash + Debug {
    /// The I/O connections that a master can allocate. The code for others falls away.
    ///
    /// [`CHANGE_OF_STATE`](AllocationChoice::CHANGE_OF_STATE) and [`CYCLIC`](AllocationChoice::CYCLIC) with
    /// [`ACK_SUPPRESSION`](AllocationChoice::ACK_SUPPRESSION) can be allocated without acknowledges too.
    const IO: AllocationChoice;

    /// What the slave can do besides serving explicit messages and I/O. The code for what is left out falls away. By
    /// default everything.
    const PARTS: Parts = Parts::all();

    /// Which of [`IO`](Self::IO) a master can allocate in this device. By default all; a device whose modules or switches
    /// decide, or one that is made from a description, has fewer.
    fn offered(&self) -> AllocationChoice {
        Self::IO
    }

    /// The memory for I/O: [`Fragmented`](super::Fragmented), or `()` if no connection produces or consumes more than eight
    /// bytes; of these, [`PollOnly`](super::PollOnly) if there is no other than poll.
    type Long: LongMessages;

    /// Who the device is and how it is: the Identity object. The slave adds whether it is owned, and the heartbeat
    /// interval.
    fn identity(&self) -> Identity<'_>;

    /// The objects besides Identity, DeviceNet, Connection and Acknowledge Handler. By default none.
    fn objects(&mut self) -> impl ObjectSet {}

    /// What the connection sends. An empty slice says that there are no valid data; more than there is room for goes out as that.
    ///
    /// For a connection whose data are not sampled by then, they are what was last written to the application.
    fn produced(&self, connection: IoKind) -> &[u8];

    /// The size of what the connection sends (attribute 7 of the Connection object). By default that of the present data.
    fn produced_size(&self, connection: IoKind) -> u16 {
        u16::try_from(self.produced(connection).len()).unwrap_or(u16::MAX)
    }

    /// Where the data of the connection go that were received. Its length is the consumed size (attribute 8).
    ///
    /// A bit-strobe command has one bit for each node: a slice of one byte gets that of this node, as 0 or 1.
    fn consumed(&mut self, connection: IoKind) -> &mut [u8];

    /// The assembly that the connection produces or consumes, for attributes 14 and 16. By default none.
    fn assembly(&self, _connection: IoKind, _end: End) -> Option<InstanceId> {
        None
    }

    /// Makes the connection produce or consume another assembly; its sizes follow. False if it cannot. By default it
    /// cannot, and the paths cannot be set.
    fn select_assembly(&mut self, _connection: IoKind, _end: End, _assembly: InstanceId) -> bool {
        false
    }

    /// Whether [`select_assembly`](Self::select_assembly) does anything. By default not.
    const SELECTS_ASSEMBLIES: bool = false;

    /// Puts the outputs of the connection into their state for idle or fault. By default all are 0.
    fn rest(&mut self, connection: IoKind, _mode: IoMode) {
        self.consumed(connection).fill(0);
    }
}

bitflags::bitflags! {
    /// What a slave can do and a small one may do without. What a part does is decided by [`Config`](super::Config) as
    /// ever, if the part is there.
    #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
    pub struct Parts: u16 {
        /// The offline connection set: [`offline_set`](crate::access::Config::offline_set). Without it that is off.
        const OFFLINE_SET = 1 << 0;
        /// Automatic bit rate detection: [`detect`](super::BitRateConfig::detect).
        const BIT_RATE_DETECTION = 1 << 1;
        /// The heartbeat: [`heartbeat_interval`](super::Config::heartbeat_interval).
        const HEARTBEAT = 1 << 2;
        /// The shutdown message: [`SHUTDOWN_MESSAGE`](super::Options::SHUTDOWN_MESSAGE).
        const SHUTDOWN_MESSAGE = 1 << 3;
        /// Choices other than the defaults: [`options`](super::Config::options), [`failures`](super::Config::failures),
        /// [`resolution`](super::Config::resolution) and [`receive_time_out`](super::Config::receive_time_out); of network
        /// access, [`accept_bad_dlc`](crate::access::Config::accept_bad_dlc),
        /// [`bus_off_while_checking`](crate::access::Config::bus_off_while_checking),
        /// [`same_mac_id_restarts`](crate::access::Config::same_mac_id_restarts) and
        /// [`counter_set_mode`](crate::access::Config::counter_set_mode). Without it no expected packet rate is rounded.
        const CHOICES = 1 << 4;
        /// What a DeviceNet object need not have: the attributes 6 to 10 and 12, which are
        /// [switches](super::Slave::set_switches), [Quick Connect](crate::access::Config::quick_connect) and
        /// [diagnostic counters](super::Diagnostics). Of a Connection object, the production inhibit time and the timeout
        /// multiplier, 17 and 18, which a slave with change of state or cyclic has all the same.
        const OPTIONAL_ATTRIBUTES = 1 << 5;
        /// The events of the indicators. What they show can be asked all the same:
        /// [`network_status`](super::Slave::network_status), [`module_status`](super::Slave::module_status).
        const INDICATOR_EVENTS = 1 << 6;
        /// What a Connection object need not have: the services Delete, Apply_Attributes and Find_Next_Object_Instance, and
        /// the Reset of all instances; with dynamic connections it has them all the same. Of Identity, Get_Attributes_All,
        /// which a slave with a heartbeat has all the same.
        const OPTIONAL_SERVICES = 1 << 7;
        /// The events that only tell, and about which nothing has to be done: all of [network access](crate::access), and of
        /// the slave those of connections, allocation, attributes that were set, and frames that were ignored or not sent.
        /// Without it there remain `Received`, `Mode`, `Effect`, `Reset`, those that store something, and those that are
        /// parts of their own; and everything is counted, with [`COUNTERS`](Self::COUNTERS).
        const REPORTS = 1 << 8;
        /// Fewer instructions for more code: for Get_Attribute_Single half of them, on a way of its own, and for a message no
        /// calls to set its time-out. Without it the [deadline](link_core::Machine::deadline) after an input is at once until
        /// [`poll`](link_core::Machine::poll) has returned `None`, whether or not there was something to fetch.
        const FAST_WAYS = 1 << 9;
        /// What is [counted](super::Counters), also of [network access](crate::access::Counters). Without it all counters stay
        /// 0, but for the bus-off counter of the DeviceNet object.
        const COUNTERS = 1 << 10;
        /// That a master or tool can set what a DeviceNet object need not let be set: the attributes 1 to 4, which are MAC ID,
        /// bit rate, bus-off interrupt and bus-off counter. Without it they can be read, and are as the
        /// [`Config`](super::Config) says, from switches for instance.
        const SETTINGS = 1 << 11;
        /// That anything is told at all. Without it the application looks: at its data, which were put to
        /// [rest](Application::rest) if nothing keeps them up to date, and at [`Slave`](super::Slave). A Reset, which is that of
        /// a power cycle, is then the slave's alone, and the effects of objects are nobody's. What has more to tell needs it:
        /// reports, the events of indicators, and what is to be stored, which are settings, the heartbeat, optional
        /// attributes and a bit rate that was detected. With or without it, a program looks between two waits of a
        /// [loop of its own](crate#a-loop-of-ones-own).
        const EVENTS = 1 << 12;
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Parts {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=u16:#06x}", self.bits());
    }
}

/// The I/O connections of the predefined set.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum IoKind {
    /// Instance 2. It also consumes the messages of a master by change of state or cyclic.
    Poll,
    /// Instance 3.
    BitStrobe,
    /// Instance 4, by change of state or cyclic.
    ChangeOfState,
    /// Instance 5.
    MulticastPoll,
}

impl IoKind {
    /// All, in the order of their instances.
    pub const ALL: [Self; 4] = [Self::Poll, Self::BitStrobe, Self::ChangeOfState, Self::MulticastPoll];

    /// The instance of the Connection object, 2 to 5.
    #[must_use]
    pub const fn instance(self) -> InstanceId {
        InstanceId(match self {
            Self::Poll => 2,
            Self::BitStrobe => 3,
            Self::ChangeOfState => 4,
            Self::MulticastPoll => 5,
        })
    }

    /// Itself, if the application offers it; instance 2 is there for change of state and cyclic too. Where a device offers
    /// one connection only, the compiler knows which, and drops the code for the others.
    pub(super) const fn offered<A: Application>(self) -> Option<Self> {
        let choice = match self {
            Self::Poll => AllocationChoice::POLL.union(super::node::BOTH),
            Self::BitStrobe => AllocationChoice::BIT_STROBE,
            Self::ChangeOfState => super::node::BOTH,
            Self::MulticastPoll => AllocationChoice::MULTICAST_POLL,
        };
        if A::IO.intersects(choice) { Some(self) } else { None }
    }

    /// The same, which the application offers. Where it offers no other, the compiler knows which it is.
    // In line, the code around it is longer.
    #[inline(never)]
    pub(super) const fn known<A: Application>(self) -> Self {
        match Self::all_offered::<A>() {
            [only] => *only,
            _ => self,
        }
    }

    /// Those that the application offers, in the order of their instances; the compiler knows them too.
    pub(super) const fn all_offered<A: Application>() -> &'static [Self] {
        let (kinds, count) = const { &offered_first::<A>() };
        kinds.split_at(*count).0
    }

    /// Calls `does` with each that the application offers. For one there is no loop, which the compiler would keep.
    #[inline]
    pub(super) fn each<A: Application>(mut does: impl FnMut(Self)) {
        match const { Self::all_offered::<A>() } {
            [only] => does(*only),
            kinds => kinds.iter().for_each(|&kind| does(kind)),
        }
    }

    /// The first of those that the application offers that `is_it`.
    #[inline]
    pub(super) fn find<A: Application>(is_it: impl Fn(Self) -> bool) -> Option<Self> {
        match const { Self::all_offered::<A>() } {
            [only] => Some(*only).filter(|&kind| is_it(kind)),
            kinds => kinds.iter().copied().find(|&kind| is_it(kind)),
        }
    }

    pub(super) const fn of_instance(instance: InstanceId) -> Option<Self> {
        Some(match instance.0 {
            2 => Self::Poll,
            3 => Self::BitStrobe,
            4 => Self::ChangeOfState,
            5 => Self::MulticastPoll,
            _ => return None,
        })
    }
}

/// The connections that the application offers, before places that mean nothing; and how many they are.
const fn offered_first<A: Application>() -> ([IoKind; 4], usize) {
    let (mut kinds, mut count) = (IoKind::ALL, 0_usize);
    let mut all: &[IoKind] = &IoKind::ALL;
    while let [before @ .., kind] = all {
        if kind.offered::<A>().is_some() {
            let [first, second, third, _] = kinds;
            kinds = [*kind, first, second, third];
            count = count.saturating_add(1);
        }
        all = before;
    }
    (kinds, count)
}

impl core::fmt::Display for IoKind {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(match self {
            Self::Poll => "poll",
            Self::BitStrobe => "bit-strobe",
            Self::ChangeOfState => "COS/cyclic",
            Self::MulticastPoll => "multicast poll",
        })
    }
}
