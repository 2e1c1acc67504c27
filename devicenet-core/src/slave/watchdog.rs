//! The inactivity timers of the connections of the predefined set: what starts them, and what happens when they run out.

#[cfg(test)]
use cip_core::connection::ExplicitState;
use cip_core::connection::{ExplicitCause, IoCause, TimeoutMultiplier, Watchdog};
use link_core::timers::TimerSet;

use super::application::{Application, IoKind, Parts};
use super::connection_object::has_optional_attributes;
use super::event::count;
use super::node::Node;
use super::timer::Timer;

impl<A: Application, const DYNAMIC: usize> Node<A, DYNAMIC> {
    /// A valid message on an I/O connection. It changes no state, but the time-out.
    #[inline]
    pub(super) fn io_message(&mut self, kind: IoKind) {
        #[cfg(test)]
        {
            let state = self.io(kind).state();
            super::tests::edges::record_io(state, IoCause::Message, state);
        }
        let watchdog = self.io_mut(kind).message();
        self.feed(Timer::Io(kind), watchdog);
    }

    /// A valid message on the predefined explicit connection while it is established. It changes no state, but the time-out.
    #[inline]
    pub(super) fn explicit_message(&mut self) {
        #[cfg(test)]
        super::tests::edges::record_explicit(
            ExplicitState::Established,
            ExplicitCause::Message,
            ExplicitState::Established,
        );
        let watchdog = self.explicit.message();
        self.feed(Timer::Explicit, watchdog);
    }

    /// Does with a timer what its connection says.
    #[inline(never)]
    pub(super) fn apply(&mut self, timer: Timer, watchdog: Watchdog) {
        let (rate, multiplier) = self.timing(timer);
        watchdog.apply(&mut self.timers, timer, rate, multiplier);
    }

    /// The same, where messages come so often that a call counts.
    #[inline]
    fn feed(&mut self, timer: Timer, watchdog: Watchdog) {
        if !A::PARTS.contains(Parts::FAST_WAYS) {
            return self.apply(timer, watchdog);
        }
        let (rate, multiplier) = self.timing(timer);
        match watchdog.millis(rate, multiplier) {
            Some(millis) => self.timers.set_after_millis_inline(timer, millis),
            None if watchdog != Watchdog::Keep => self.timers.clear(timer),
            None => {}
        }
    }

    /// What the time-out of the connection of a timer follows from.
    #[inline]
    fn timing(&self, timer: Timer) -> (u16, TimeoutMultiplier) {
        let settings = match timer {
            Timer::Io(kind) => self.io(kind).settings(),
            _ => self.explicit.settings(),
        };
        let multiplier =
            if has_optional_attributes::<A>() { settings.multiplier() } else { TimeoutMultiplier::default() };
        (settings.expected_packet_rate(), multiplier)
    }

    /// The watchdog of an I/O connection has run out.
    pub(super) fn io_timed_out(&mut self, kind: IoKind) {
        count::<A>(&mut self.events.counters.timed_out);
        // A watchdog that runs belongs to an established connection.
        let _ = self.io_step(kind, IoCause::WatchdogExpired);
    }

    /// The watchdog of the predefined explicit connection has run out.
    pub(super) fn explicit_timed_out(&mut self) {
        count::<A>(&mut self.events.counters.timed_out);
        let io_established = self.is_io_established();
        let _ = self.explicit_step(ExplicitCause::WatchdogExpired { io_established });
    }
}
