//! What a slave keeps of its I/O connections.

use core::fmt::Debug;
use core::hash::Hash;

use cip_core::connection::IoConnection;
use cip_core::message::AllocationChoice;
use link_core::timers::TimerSet;
use link_core::{Queue, Timers};

use crate::slave::application::{IoKind, IoMode};
use crate::slave::event::{EventQueue, SlaveEvent};
use crate::slave::timer::Timer;

/// Room for some connections.
pub trait Slots: Clone + Eq + Hash + Debug {
    /// What they are for.
    const CHOICE: AllocationChoice;

    /// None of them is allocated.
    const EMPTY: Self;

    /// The waits of a slave with these connections.
    type Timers: TimerSet<Timer> + Clone + Eq + Hash + Debug + Default;

    /// What such a slave has to tell of one input.
    type Events: EventQueue;

    /// One of those that there is room for.
    fn slot(&self, kind: IoKind) -> &Slot;

    /// The same, to change it.
    fn slot_mut(&mut self, kind: IoKind) -> &mut Slot;
}

/// One connection.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Slot {
    pub(in crate::slave) connection: IoConnection,
    pub(in crate::slave) mode: IoMode,
}

/// Room for poll.
pub(super) type PollSlot = [Slot; 1];
/// Room for all of them, in the order of their instances.
pub(super) type EverySlot = [Slot; 4];

impl Slots for PollSlot {
    const CHOICE: AllocationChoice = AllocationChoice::POLL;
    const EMPTY: Self = [Slot::EMPTY];
    type Timers = Timers<Timer, 5>;
    /// Nine when the network is lost.
    type Events = Queue<SlaveEvent, 10>;

    fn slot(&self, _: IoKind) -> &Slot {
        let [poll] = self;
        poll
    }

    fn slot_mut(&mut self, _: IoKind) -> &mut Slot {
        let [poll] = self;
        poll
    }
}

impl Slots for EverySlot {
    const CHOICE: AllocationChoice = AllocationChoice::all();
    const EMPTY: Self = [Slot::EMPTY; 4];
    type Timers = Timers<Timer, 11>;
    /// When all five watchdogs end in one tick, ten transitions, four modes and the allocation; and some dynamic connections.
    type Events = Queue<SlaveEvent, 20>;

    fn slot(&self, kind: IoKind) -> &Slot {
        let [poll, strobe, change_of_state, multicast] = self;
        match kind {
            IoKind::Poll => poll,
            IoKind::BitStrobe => strobe,
            IoKind::ChangeOfState => change_of_state,
            IoKind::MulticastPoll => multicast,
        }
    }

    fn slot_mut(&mut self, kind: IoKind) -> &mut Slot {
        let [poll, strobe, change_of_state, multicast] = self;
        match kind {
            IoKind::Poll => poll,
            IoKind::BitStrobe => strobe,
            IoKind::ChangeOfState => change_of_state,
            IoKind::MulticastPoll => multicast,
        }
    }
}

impl Slot {
    const EMPTY: Self = Self { connection: IoConnection::NON_EXISTENT, mode: IoMode::Inactive };
}
