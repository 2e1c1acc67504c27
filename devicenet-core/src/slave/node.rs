//! What the objects of a slave look at and change, with the one door through which each instance of the Connection object changes
//! its state.

use cip_core::connection::{
    ExplicitCause, ExplicitConnection, ExplicitState, IoCause, IoConnection, IoState, PredefinedConnection,
    Settings, TimerResolution,
};
use cip_core::identity::IdentityStatus;
use cip_core::message::AllocationChoice;
use cip_core::object::{AcknowledgeSettings, Failure, FailureOptions, Identity};
use link_core::timers::TimerSet;
use link_core::{Instant, Timers};

use super::application::{Application, IoKind, IoMode, Parts};
use super::config::{Choices, Options};
use super::connection_object::Which;
use super::departure::Departure;
use super::devicenet_object::Port;
use super::dynamic::Dynamic;
use super::event::{Events, Ignored, Received, SlaveEvent, count};
use super::io::{LongMessages, Slots};
use super::lines::Lines;
use super::machine::changes;
use super::timer::Timer;
use crate::access::Access;
use crate::id::{Identifier, MacId};

/// The connections, who owns them, network access, the application. What is asked most comes first: a Cortex-M0 reaches the first
/// 32 bytes from a pointer in one short instruction.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[repr(C)]
pub(super) struct Node<A: Application, const DYNAMIC: usize> {
    /// Something that others have to follow has changed.
    pub(super) changed: Changed,
    /// The connections of the predefined set that exist, those that timed out included.
    pub(super) held: AllocationChoice,
    pub(super) master: Option<MacId>,
    pub(super) departure: Option<Departure>,
    pub(super) lines: Lines,
    /// Instance 1.
    pub(super) explicit: ExplicitConnection,
    /// Instances 2 to 5, as many as there is room for.
    pub(super) slots: SlotsOf<A>,
    pub(super) resolution: TimerResolution,
    /// Through which explicit connection the I/O connections are configured.
    pub(super) parent: Parent,
    /// Whose multicast poll is consumed.
    pub(super) group: MacId,
    /// Whose it is after an allocation, if not the master's.
    pub(super) foreign_group: Option<MacId>,
    pub(super) heartbeat_interval: Option<u8>,
    /// What was received since that was told.
    pub(super) received: Received,
    pub(super) acknowledge: AcknowledgeSettings,
    pub(super) failures: FailureOptions,
    pub(super) events: Events<<SlotsOf<A> as Slots>::Events>,
    pub(super) options: Choices<A>,
    pub(super) application: A,
    pub(super) timers: <SlotsOf<A> as Slots>::Timers,
    /// Instances 6 and up.
    pub(super) dynamic: [Dynamic; DYNAMIC],
    pub(super) dynamic_timers: [Timers<Timer, 3>; DYNAMIC],
    pub(super) access: Access,
    pub(super) port: Port,
}

type SlotsOf<A> = <<A as Application>::Long as LongMessages>::Slots;

/// An explicit connection that others hang on.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Parent {
    /// Instance 1.
    Predefined,
    /// A connection opened through the UCMM.
    Dynamic(u8),
}

bitflags::bitflags! {
    /// What must be looked at before the next action.
    #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
    pub(super) struct Changed: u8 {
        /// The mode of instance 2, 3, 4 or 5.
        const MODES = 0x0F;
        /// A connection: ownership, filters.
        const CONNECTIONS = 0x10;
        /// The allocation information.
        const ALLOCATION = 0x20;
        /// The filters that the node needs.
        const FILTER = 0x40;
        /// The heartbeat interval.
        const HEARTBEAT = 0x80;
    }
}

impl<A: Application, const DYNAMIC: usize> Node<A, DYNAMIC> {
    /// The Identity object: what the application says, and what the slave knows.
    #[inline(always)]
    pub(super) fn identity(&self) -> Identity<'_> {
        let mut identity = self.application.identity();
        if self.master.is_some() {
            identity.status.insert(IdentityStatus::OWNED);
        }
        identity.heartbeat_interval = self.heartbeat_interval;
        identity
    }

    /// How some errors are answered. Without [`Parts::CHOICES`] that is a constant.
    pub(super) fn failures(&self) -> FailureOptions {
        if A::PARTS.contains(Parts::CHOICES) { self.failures } else { FailureOptions::default() }
    }

    /// The steps in which connections count time. Without [`Parts::CHOICES`], 1 ms.
    pub(super) fn resolution(&self) -> TimerResolution {
        if A::PARTS.contains(Parts::CHOICES) { self.resolution } else { TimerResolution::FINEST }
    }

    /// A connection; one that is not offered does not exist.
    pub(super) fn io(&self, kind: IoKind) -> &IoConnection {
        match kind.offered::<A>() {
            Some(kind) => &self.slots.slot(kind).connection,
            None => &IoConnection::NON_EXISTENT,
        }
    }

    /// A connection that is offered.
    pub(super) fn io_mut(&mut self, kind: IoKind) -> &mut IoConnection {
        &mut self.slots.slot_mut(kind).connection
    }

    pub(super) fn mode(&self, kind: IoKind) -> IoMode {
        self.slots.slot(kind).mode
    }

    pub(super) fn set_mode(&mut self, kind: IoKind, mode: IoMode) {
        if core::mem::replace(&mut self.slots.slot_mut(kind).mode, mode) != mode {
            self.changed.insert(mode_bit(kind));
        }
    }

    /// Attribute 5 of the DeviceNet object: what is allocated and has not timed out.
    pub(super) fn choice(&self) -> AllocationChoice {
        let mut choice = self.held;
        IoKind::each::<A>(|kind| {
            if self.io(kind).state() == IoState::TimedOut {
                choice.remove(bits_of(kind));
            }
        });
        if changes::<A>() && !choice.intersects(BOTH) {
            choice.remove(AllocationChoice::ACK_SUPPRESSION);
        }
        choice
    }

    /// The one door of an I/O connection.
    pub(super) fn io_step(&mut self, kind: IoKind, cause: IoCause) -> Result<(), Failure> {
        let from = self.io(kind).state();
        let result = self.io_mut(kind).handle(cause);
        self.io_moved(kind, from, cause);
        self.apply(Timer::Io(kind), result?);
        Ok(())
    }

    /// What a client has set on an instance.
    pub(super) fn settings_mut(&mut self, which: Which) -> Result<&mut Settings, Failure> {
        match which {
            Which::Explicit => Ok(self.explicit.settings_mut()),
            Which::Io(kind) => Ok(self.io_mut(kind).settings_mut()),
            Which::Dynamic(index) => self.dynamic_settings_mut(index),
        }
    }

    /// Sets attribute 9 of an instance, and returns what is used from now on.
    pub(super) fn set_packet_rate(&mut self, which: Which, requested: u16) -> Result<u16, Failure> {
        let resolution = self.resolution();
        let used = self.settings_mut(which)?.set_packet_rate(requested, resolution)?;
        match which {
            Which::Explicit => self.explicit_step(ExplicitCause::PacketRateSet)?,
            Which::Io(kind) => self.io_step(kind, IoCause::PacketRateSet)?,
            Which::Dynamic(index) => self.dynamic_step(index, ExplicitCause::PacketRateSet)?,
        }
        if changes::<A>()
            && matches!(which, Which::Io(IoKind::ChangeOfState))
            && self.io(IoKind::ChangeOfState).state() == IoState::Established
        {
            self.start_trigger();
        }
        Ok(used)
    }

    /// The one door of the predefined explicit connection.
    pub(super) fn explicit_step(&mut self, cause: ExplicitCause) -> Result<(), Failure> {
        let from = self.explicit.state();
        let result = self.explicit.handle(cause);
        self.explicit_moved(from, cause);
        self.apply(Timer::Explicit, result?);
        Ok(())
    }

    pub(super) fn is_io_established(&self) -> bool {
        IoKind::find::<A>(|kind| self.io(kind).state() == IoState::Established).is_some()
    }

    pub(super) fn is_io_timed_out(&self) -> bool {
        IoKind::find::<A>(|kind| self.io(kind).state() == IoState::TimedOut).is_some()
    }

    /// Allocates an instance, or allocates it anew after a time-out.
    pub(super) fn allocate_io(&mut self, kind: IoKind, as_what: PredefinedConnection) {
        let from = self.io(kind).state();
        if self.io_mut(kind).allocate(as_what).is_ok() {
            self.io_moved(kind, from, IoCause::Allocated);
            self.timers.clear(Timer::Io(kind));
        }
    }

    fn io_moved(&mut self, kind: IoKind, from: IoState, cause: IoCause) {
        let to = self.io(kind).state();
        #[cfg(test)]
        super::tests::edges::record_io(from, cause, to);
        if to == from {
            if to == IoState::Established && cause == IoCause::WatchdogExpired {
                self.set_mode(kind, IoMode::Fault);
            }
            return;
        }
        self.report(SlaveEvent::Io { connection: kind, from, to, cause });
        self.changed.insert(Changed::CONNECTIONS);
        if cause == IoCause::WatchdogExpired || from == IoState::TimedOut {
            self.allocation_changed();
        }
        if from == IoState::Established {
            self.io_ended(kind, cause);
        }
        if to == IoState::Established {
            // Nothing is told: the outputs are as they were. The end of the connection is a change again.
            self.slots.slot_mut(kind).mode = IoMode::Inactive;
            if changes::<A>() && kind == IoKind::ChangeOfState {
                self.begin_production();
            }
        }
    }

    fn io_ended(&mut self, kind: IoKind, cause: IoCause) {
        let idle = cause == IoCause::Released && self.options.contains(Options::IDLE_ON_RELEASE);
        self.set_mode(kind, if idle { IoMode::Idle } else { IoMode::Fault });
        self.lines.stop(kind);
        if changes::<A>() && kind == IoKind::ChangeOfState {
            for timer in [Timer::Trigger, Timer::Inhibit, Timer::Acknowledge] {
                self.timers.clear(timer);
            }
        }
        let deferred = self.explicit.settings().watchdog_action()
            == cip_core::connection::WatchdogAction::DEFERRED_DELETE;
        if cause == IoCause::WatchdogExpired
            && deferred
            && self.options.contains(Options::IO_TIME_OUT_DELETES_ACTION_3)
            && !self.is_io_established()
        {
            let _ = self.explicit_step(ExplicitCause::WatchdogExpired { io_established: false });
        }
    }

    fn explicit_moved(&mut self, from: ExplicitState, cause: ExplicitCause) {
        let to = self.explicit.state();
        #[cfg(test)]
        super::tests::edges::record_explicit(from, cause, to);
        if to != from {
            self.report(SlaveEvent::Explicit { instance: 1, from, to, cause });
            self.changed.insert(Changed::CONNECTIONS);
        }
    }

    /// Tells what nothing has to be done about, if the slave has [`Parts::REPORTS`].
    pub(super) fn report(&mut self, event: SlaveEvent) {
        if A::PARTS.contains(Parts::REPORTS) {
            self.events.raise::<A>(event);
        }
    }

    /// Counts a frame that was ignored, and tells of it.
    #[cold]
    pub(super) fn ignored(&mut self, id: Identifier, why: Ignored) {
        count::<A>(&mut self.events.counters.ignored);
        self.report(SlaveEvent::Ignored { id, why });
    }

    /// The present moment, as the slave was told it.
    pub(super) fn advance(&mut self, now: Instant) -> Instant {
        self.advance_inline(now)
    }

    #[inline]
    pub(super) fn advance_inline(&mut self, now: Instant) -> Instant {
        for timers in &mut self.dynamic_timers {
            timers.advance_inline(now);
        }
        if A::PARTS.contains(Parts::FAST_WAYS) {
            self.timers.advance_inline(now)
        } else {
            self.timers.advance(now)
        }
    }
}

/// What stands for a kind of connection in the allocation information.
pub(super) const fn bits_of(kind: IoKind) -> AllocationChoice {
    match kind {
        IoKind::Poll => AllocationChoice::POLL,
        IoKind::BitStrobe => AllocationChoice::BIT_STROBE,
        IoKind::ChangeOfState => BOTH,
        IoKind::MulticastPoll => AllocationChoice::MULTICAST_POLL,
    }
}

pub(super) const fn mode_bit(kind: IoKind) -> Changed {
    Changed::from_bits_retain(match kind {
        IoKind::Poll => 0x01,
        IoKind::BitStrobe => 0x02,
        IoKind::ChangeOfState => 0x04,
        IoKind::MulticastPoll => 0x08,
    })
}

/// Instance 4 by either trigger.
pub(super) const BOTH: AllocationChoice = AllocationChoice::CHANGE_OF_STATE.union(AllocationChoice::CYCLIC);
