//! The one door through which each connection changes its state, and what follows from it.
//!
//! The states and transitions are those of CIP: [`IO_EDGES`](cip_core::connection::IO_EDGES) and
//! [`EXPLICIT_EDGES`](cip_core::connection::EXPLICIT_EDGES). What is of DeviceNeX is whom a connection belongs to: instead of
//! a master there is the requester of each connection.
//!
//! | When | Then |
//! |---|---|
//! | the last explicit connection of a requester ends | its I/O connections that are being configured are deleted |
//! | its last established I/O connection ends | its explicit connections in Deferred Delete are deleted |
//! | a dynamic connection is being configured for too long | it is deleted |

use cip_core::code::GeneralStatus;
use cip_core::connection::{
    ExplicitCause, ExplicitState, IoCause, IoMode, IoState, TransportClassTrigger, Watchdog,
};

use super::application::Application;
use super::event::DeviceEvent;
use super::long::LongMessages;
use super::machine::Device;
use super::slot::{Body, Io, News, Slot};
use super::timer::{Timer, apply};
use crate::counter::count;
use crate::id::OperationalAddress;
use crate::message::ConnectionInstance;

impl<A: Application, const MESSAGE: usize, const CONNECTIONS: usize> Device<A, MESSAGE, CONNECTIONS> {
    /// The one door of an I/O connection.
    pub(super) fn io_step(&mut self, place: usize, cause: IoCause) -> Result<(), GeneralStatus> {
        let Some((slot, io)) = io(&mut self.slots, place) else { return Err(GONE) };
        let from = io.connection.state();
        let result = io.connection.handle(cause);
        apply(slot.timers, io.connection.settings(), *result.as_ref().unwrap_or(&Watchdog::Keep));
        self.io_moved(place, from, cause);
        result.map(|_| ())
    }

    /// Sets attribute 9 of an I/O connection, which establishes it if it is being configured.
    pub(super) fn io_packet_rate(&mut self, place: usize, requested: u16) -> Result<u16, GeneralStatus> {
        let resolution = self.settings.resolution;
        let Some((slot, io)) = io(&mut self.slots, place) else { return Err(GONE) };
        let from = io.connection.state();
        let (used, watchdog) = io.connection.set_packet_rate(requested, resolution)?;
        apply(slot.timers, io.connection.settings(), watchdog);
        if io.connection.state() == IoState::Established && !io.trigger().is_server() {
            io.production.start_trigger(io.connection.settings(), slot.timers);
        }
        self.io_moved(place, from, IoCause::PacketRateSet);
        Ok(used)
    }

    /// Begins a connection: with its defaults, being configured.
    pub(super) fn allocate_io(&mut self, place: usize, kind: TransportClassTrigger) {
        let Some((slot, io)) = io(&mut self.slots, place) else { return };
        let from = io.connection.state();
        if matches!(from, IoState::Configuring | IoState::Established) {
            // It begins anew. The outputs are not told: its data go on.
            let _ = io.connection.handle(IoCause::Released);
            #[cfg(test)]
            super::tests::edges::record_io(from, IoCause::Released, io.connection.state());
        }
        #[cfg(test)]
        let between = io.connection.state();
        // It is free now: nothing is refused.
        let _ = io.connection.allocate(kind);
        #[cfg(test)]
        super::tests::edges::record_io(between, IoCause::Allocated, io.connection.state());
        slot.timers.clear_all();
        io.mode = IoMode::Inactive;
        tell_io(slot.news, slot.connection, from, IoState::Configuring, IoCause::Allocated);
        self.start_configuring(place);
        self.filter_changed = true;
    }

    /// While it is being configured, every service for it says that somebody is there.
    pub(super) fn start_configuring(&mut self, place: usize) {
        let millis = self.settings.configuring_time_out;
        if let Some((slot, io)) = io(&mut self.slots, place)
            && io.connection.state() == IoState::Configuring
            && millis != 0
        {
            slot.timers.set_after_millis(Timer::Watchdog, millis.into());
        }
    }

    /// The one door of an explicit connection.
    pub(super) fn explicit_step(&mut self, place: usize, cause: ExplicitCause) -> Result<(), GeneralStatus> {
        let Some(slot) = self.slots.get_mut(place) else { return Err(GONE) };
        let Body::Explicit(explicit) = &mut slot.body else { return Err(GONE) };
        let from = explicit.connection.state();
        let result = explicit.connection.handle(cause);
        apply(&mut slot.timers, explicit.connection.settings(), *result.as_ref().unwrap_or(&Watchdog::Keep));
        self.explicit_moved(place, from, cause);
        result.map(|_| ())
    }

    /// Sets attribute 9 of an explicit connection.
    pub(super) fn explicit_packet_rate(
        &mut self,
        place: usize,
        requested: u16,
    ) -> Result<u16, GeneralStatus> {
        let resolution = self.settings.resolution;
        let Some(slot) = self.slots.get_mut(place) else { return Err(GONE) };
        let Body::Explicit(explicit) = &mut slot.body else { return Err(GONE) };
        let from = explicit.connection.state();
        let (used, watchdog) = explicit.connection.set_packet_rate(requested, resolution)?;
        apply(&mut slot.timers, explicit.connection.settings(), watchdog);
        self.explicit_moved(place, from, ExplicitCause::PacketRateSet);
        Ok(used)
    }

    /// A wait of a connection is over.
    pub(super) fn connection_wait_over(&mut self, place: usize, timer: Timer) {
        let acknowledge = self.acknowledge;
        let Some(slot) = self.slots.get_mut(place) else { return };
        let (connection, requester) = (slot.connection(), slot.requester);
        match (&mut slot.body, timer) {
            (Body::Explicit(_) | Body::Io(_), Timer::Watchdog) => self.watchdog_over(place),
            (Body::Explicit(explicit), Timer::Acknowledge) => {
                if explicit.transfer.not_acknowledged(&mut slot.timers) {
                    self.raise(DeviceEvent::ResponseAbandoned { requester });
                }
            }
            (Body::Explicit(explicit), Timer::Reassembly) => explicit.transfer.reassembly_over(),
            (Body::Io(io), Timer::Acknowledge) => {
                if io.production.not_acknowledged(&acknowledge) {
                    self.raise(DeviceEvent::NotAcknowledged(connection));
                }
            }
            (Body::Io(io), Timer::Trigger) => io.production.triggered(&mut slot.timers),
            (Body::Io(io), Timer::Inhibit) => io.production.inhibit_over(&mut slot.timers),
            (Body::Free, _)
            | (Body::Explicit(_), Timer::Trigger | Timer::Inhibit)
            | (Body::Io(_), Timer::Reassembly) => {}
        }
    }

    fn watchdog_over(&mut self, place: usize) {
        let Some(slot) = self.slots.get(place) else { return };
        // What an established connection has begun is never refused.
        let _ = match slot.io_state() {
            Some(IoState::Configuring) => self.io_step(place, IoCause::ExplicitGone),
            Some(_) => {
                count(&mut self.counters.timed_out);
                self.io_step(place, IoCause::WatchdogExpired)
            }
            None => {
                let requester = slot.requester;
                let io_established = self.slots.iter().any(|other| other.is_established_io_of(requester));
                count(&mut self.counters.timed_out);
                self.explicit_step(place, ExplicitCause::WatchdogExpired { io_established })
            }
        };
    }

    fn io_moved(&mut self, place: usize, from: IoState, cause: IoCause) {
        let Some((slot, io)) = io(&mut self.slots, place) else { return };
        let to = io.connection.state();
        #[cfg(test)]
        super::tests::edges::record_io(from, cause, to);
        if to == from {
            if to == IoState::Established && cause == IoCause::WatchdogExpired {
                set_mode(slot.news, slot.connection, io, IoMode::Fault);
            }
            return;
        }
        tell_io(slot.news, slot.connection, from, to, cause);
        if to == IoState::Established {
            io.production.established(io.trigger());
        }
        if from == IoState::Established {
            io.production = Default::default();
            io.continued = false;
            io.long.unload();
            io.long.discard();
            for timer in [Timer::Trigger, Timer::Inhibit, Timer::Acknowledge] {
                slot.timers.clear(timer);
            }
            set_mode(slot.news, slot.connection, io, IoMode::Fault);
        }
        let requester = slot.requester;
        if let Some(slot) = self.slots.get_mut(place) {
            if from == IoState::Established {
                slot.line.abandon(false);
            }
            if to == IoState::NonExistent {
                slot.free();
            }
        }
        self.filter_changed = true;
        if from == IoState::Established {
            self.end_deferred(requester);
        }
    }

    fn explicit_moved(&mut self, place: usize, from: ExplicitState, cause: ExplicitCause) {
        let Some(slot) = self.slots.get_mut(place) else { return };
        let (connection, requester) = (slot.connection(), slot.requester);
        let Body::Explicit(explicit) = &mut slot.body else { return };
        let to = explicit.connection.state();
        #[cfg(test)]
        super::tests::edges::record_explicit(from, cause, to);
        if to == from {
            return;
        }
        let from = match slot.news.moved {
            Some(DeviceEvent::Explicit { connection: earlier, from, .. }) if earlier == connection => from,
            _ => from,
        };
        slot.news.moved = Some(DeviceEvent::Explicit { connection, from, to, cause });
        if to != ExplicitState::NonExistent {
            return;
        }
        explicit.transfer.close(&mut slot.timers);
        if self.slots.iter().any(|slot| slot.is_explicit_of(requester)) {
            return;
        }
        for place in 0..CONNECTIONS {
            let theirs = self.slots.get(place).is_some_and(|slot| slot.requester == requester);
            if theirs && self.slots.get(place).and_then(Slot::io_state) == Some(IoState::Configuring) {
                let _ = self.io_step(place, IoCause::ExplicitGone);
            }
        }
    }

    /// The last established I/O connection of a requester is the end of its explicit connections that waited for it.
    fn end_deferred(&mut self, requester: OperationalAddress) {
        if self.slots.iter().any(|slot| slot.is_established_io_of(requester)) {
            return;
        }
        for place in 0..CONNECTIONS {
            if self.slots.get(place).is_some_and(|slot| slot.is_explicit_of(requester)) {
                let _ = self.explicit_step(place, ExplicitCause::IoEnded);
            }
        }
    }
}

/// What of a place belongs to a connection, besides itself.
pub(super) struct Around<'a> {
    pub(super) connection: ConnectionInstance,
    pub(super) requester: OperationalAddress,
    pub(super) timers: &'a mut super::timer::Waits,
    pub(super) news: &'a mut News,
}

/// The I/O connection of a place.
pub(super) fn io<L, const MESSAGE: usize>(
    slots: &mut [Slot<L, MESSAGE>],
    place: usize,
) -> Option<(Around<'_>, &mut Io<L>)> {
    let slot = slots.get_mut(place)?;
    let (connection, requester) = (slot.connection(), slot.requester);
    let Slot { body: Body::Io(io), timers, news, .. } = slot else { return None };
    Some((Around { connection, requester, timers, news }, io))
}

pub(super) fn set_mode<L>(news: &mut News, connection: ConnectionInstance, io: &mut Io<L>, mode: IoMode) {
    // A connection without consumed data has none that could mean anything.
    if io.trigger().is_server() && core::mem::replace(&mut io.mode, mode) != mode {
        news.mode = Some((connection, mode));
        news.rest = matches!(mode, IoMode::Idle | IoMode::Fault);
    }
}

/// A change of state before the last one was fetched is told as one.
fn tell_io(news: &mut News, connection: ConnectionInstance, from: IoState, to: IoState, cause: IoCause) {
    let (from, cause) = match news.moved {
        Some(DeviceEvent::Io { connection: earlier, from, cause: first, .. }) if earlier == connection => {
            // A request that establishes a connection at once passes the state in which it is configured.
            let at_once = first == IoCause::Allocated && cause == IoCause::PacketRateSet;
            (from, if at_once { first } else { cause })
        }
        _ => (from, cause),
    };
    news.moved = Some(DeviceEvent::Io { connection, from, to, cause });
}

const GONE: GeneralStatus = GeneralStatus::OBJECT_DOES_NOT_EXIST;
