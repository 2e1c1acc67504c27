//! The states of all connections, their timers, and who owns the slave.

use core::time::Duration;

use devicenet_core::slave::{IoMode, Options};
use link_core::Instant;

use super::{BOTH, EXPLICIT, Model, POLL, STROBE, SUPPRESSION};

/// The states of the Connection object, as attribute 1 has them.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::dn_slave) enum State {
    NonExistent = 0,
    Configuring = 1,
    Established = 3,
    TimedOut = 4,
    Deferred = 5,
}

/// Any connection.
#[derive(Clone, Debug)]
pub(in crate::dn_slave) struct Connection {
    pub(in crate::dn_slave) state: State,
    pub(super) rate: u16,
    pub(super) inhibit: u16,
    pub(super) action: u8,
    pub(super) multiplier: u8,
    pub(super) watchdog: Option<Instant>,
}

/// What an I/O connection was allocated as.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    Polled,
    ConsumeOnly,
    Change { acknowledged: bool },
    Cyclic { acknowledged: bool },
}

/// On what explicit connection the configuration of I/O depends.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Parent {
    Predefined,
    Dynamic(usize),
}

/// Which explicit connection.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Which {
    Explicit,
    Io(usize),
    Dynamic(usize),
}

impl Connection {
    pub(super) const NONE: Self =
        Self { state: State::NonExistent, rate: 0, inhibit: 0, action: 0, multiplier: 0, watchdog: None };

    /// As it is allocated or opened.
    pub(super) fn explicit(now: Instant) -> Self {
        let watchdog = Some(now + Duration::from_secs(10));
        Self { state: State::Established, rate: 2500, action: 1, watchdog, ..Self::NONE }
    }

    pub(in crate::dn_slave) fn exists(&self) -> bool {
        self.state != State::NonExistent
    }

    pub(super) fn restart(&mut self, now: Instant, at_least: u64) {
        let millis = (u64::from(self.rate) * (4 << self.multiplier)).max(at_least);
        self.watchdog = (self.rate != 0).then(|| now + Duration::from_millis(millis));
    }

    pub(super) fn end(&mut self) {
        (self.state, self.watchdog) = (State::NonExistent, None);
    }

    pub(super) fn message_on_explicit(&mut self, now: Instant) {
        self.state = State::Established;
        self.restart(now, 0);
    }
}

impl Model {
    pub(super) fn connection(&mut self, which: Which) -> &mut Connection {
        match which {
            Which::Explicit => &mut self.explicit,
            Which::Io(at) => &mut self.io[at],
            Which::Dynamic(at) => &mut self.dynamic[at].connection,
        }
    }

    pub(in crate::dn_slave) fn is_io_established(&self) -> bool {
        self.io.iter().any(|io| io.state == State::Established)
    }

    pub(in crate::dn_slave) fn is_io_timed_out(&self) -> bool {
        self.io.iter().any(|io| io.state == State::TimedOut)
    }

    /// Attribute 5: what is allocated and has not timed out.
    pub(in crate::dn_slave) fn choice(&self) -> u8 {
        let mut choice = self.held;
        for (at, bits) in BITS.into_iter().enumerate() {
            if self.io[at].state == State::TimedOut {
                choice &= !bits;
            }
        }
        if choice & BOTH == 0 { choice & !SUPPRESSION } else { choice }
    }

    /// An I/O connection becomes established, for whatever reason.
    pub(super) fn establish(&mut self, at: usize, first: bool) {
        let now = self.now;
        self.io[at].state = State::Established;
        self.modes[at] = IoMode::Inactive;
        if self.consumes(at) {
            self.io[at].restart(now, if first { 10_000 } else { 0 });
        }
        if at == CHANGE {
            (self.pending, self.retries) = (false, 0);
            self.lines[CHANGE].due = true;
        }
    }

    /// Nothing that arrives on instance 4 without acknowledges could be missed.
    pub(super) fn consumes(&self, at: usize) -> bool {
        !matches!(self.kinds[at], Kind::Change { acknowledged: false } | Kind::Cyclic { acknowledged: false })
    }

    /// An I/O connection leaves its state for one in which no data flow.
    pub(super) fn end_io(&mut self, at: usize, to: State, idle: bool) {
        let was = core::mem::replace(&mut self.io[at].state, to);
        self.io[at].watchdog = None;
        if was == State::Established {
            self.set_mode(at, if idle { IoMode::Idle } else { IoMode::Fault });
            self.stop_line(at);
            if at == CHANGE {
                (self.trigger, self.inhibit, self.acknowledge) = (None, None, None);
            }
        }
        self.forget_message(at);
    }

    /// Release, or Delete.
    pub(super) fn remove_io(&mut self, at: usize) {
        let idle = self.options.contains(Options::IDLE_ON_RELEASE);
        self.end_io(at, State::NonExistent, idle);
    }

    pub(super) fn allocate_io(&mut self, at: usize, kind: Kind) {
        self.io[at] = Connection { state: State::Configuring, ..Connection::NONE };
        self.kinds[at] = kind;
    }

    /// What follows from the end of connections.
    pub(in crate::dn_slave) fn settle(&mut self) {
        if !self.is_io_established() {
            for connection in core::iter::once(&mut self.explicit)
                .chain(self.dynamic.iter_mut().map(|dynamic| &mut dynamic.connection))
                .filter(|connection| connection.state == State::Deferred)
            {
                connection.end();
            }
        }
        let parent_exists = match self.parent {
            Parent::Predefined => self.explicit.exists(),
            Parent::Dynamic(at) => self.dynamic[at].connection.exists(),
        };
        let alone = !self.is_io_established() && !self.explicit.exists();
        if !parent_exists && (alone || self.options.contains(Options::DROP_CONFIGURING_WITH_EXPLICIT)) {
            for at in 0..4 {
                if self.io[at].state == State::Configuring {
                    self.end_io(at, State::NonExistent, false);
                }
            }
        }
        self.forget_bits();
        if alone && !parent_exists {
            self.master = None;
            if !self.options.contains(Options::KEEP_TIMED_OUT) {
                self.release_timed_out();
                self.forget_bits();
            }
        }
        if !self.explicit.exists() {
            self.pipes[0].close();
        }
        for at in 0..self.dynamic.len() {
            if !self.dynamic[at].connection.exists() {
                self.pipes[at + 1].close();
            }
        }
    }

    pub(super) fn release_timed_out(&mut self) {
        for at in 0..4 {
            if self.io[at].state == State::TimedOut {
                self.end_io(at, State::NonExistent, false);
            }
        }
    }

    fn forget_bits(&mut self) {
        if !self.explicit.exists() {
            self.held &= !EXPLICIT;
        }
        for (at, bits) in BITS.into_iter().enumerate() {
            if !self.io[at].exists() {
                self.held &= !bits;
            }
        }
        if self.held & BOTH == 0 {
            self.held &= !SUPPRESSION;
        }
    }

    /// The network is gone.
    pub(in crate::dn_slave) fn lose_network(&mut self, dropped: bool) {
        self.online = false;
        for at in 0..4 {
            self.end_io(at, State::NonExistent, false);
        }
        self.explicit.end();
        for dynamic in &mut self.dynamic {
            dynamic.connection.end();
        }
        self.settle();
        self.silence(dropped);
        self.leaving = None;
    }

    /// Serves the waits that are over.
    pub(in crate::dn_slave) fn expire(&mut self, until: Instant) {
        while let Some((_, timer)) = self.next_timer().filter(|(at, _)| *at <= until) {
            self.timer(timer);
        }
        for pipe in &mut self.pipes {
            pipe.expire(until);
        }
        self.settle();
    }

    fn next_timer(&self) -> Option<(Instant, Timer)> {
        let io = self.io.iter().enumerate().map(|(at, io)| (io.watchdog, Timer::Watchdog(Which::Io(at))));
        let dynamic = self.dynamic.iter().enumerate();
        let dynamic = dynamic.map(|(at, one)| (one.connection.watchdog, Timer::Watchdog(Which::Dynamic(at))));
        [
            (self.explicit.watchdog, Timer::Watchdog(Which::Explicit)),
            (self.trigger, Timer::Trigger),
            (self.inhibit, Timer::Inhibit),
            (self.acknowledge, Timer::Acknowledge),
        ]
        .into_iter()
        .chain(io)
        .chain(dynamic)
        .filter_map(|(at, timer)| Some((at?, timer)))
        .min_by_key(|(at, _)| *at)
    }

    fn timer(&mut self, timer: Timer) {
        match timer {
            Timer::Watchdog(which) => self.watchdog(which),
            Timer::Trigger => self.produce_change(),
            Timer::Inhibit => {
                self.inhibit = None;
                if self.pending {
                    self.produce_change();
                }
            }
            Timer::Acknowledge => {
                self.acknowledge = None;
                if self.retries < self.retry_limit {
                    self.retries += 1;
                    self.lines[CHANGE].due = true;
                } else {
                    self.retries = 0;
                }
            }
        }
        if timer == Timer::Trigger {
            self.trigger = None;
        }
    }

    fn watchdog(&mut self, which: Which) {
        let (now, io_established) = (self.now, self.is_io_established());
        let connection = self.connection(which);
        connection.watchdog = None;
        let Which::Io(at) = which else {
            connection.state =
                if connection.action == 3 && io_established { State::Deferred } else { State::NonExistent };
            return;
        };
        match connection.action {
            1 => self.end_io(at, State::NonExistent, false),
            2 => {
                connection.restart(now, 0);
                if self.modes[at] != IoMode::Fault {
                    self.set_mode(at, IoMode::Fault);
                    self.forget_message(at);
                }
                return;
            }
            _ => self.end_io(at, State::TimedOut, false),
        }
        let deletes = self.options.contains(Options::IO_TIME_OUT_DELETES_ACTION_3);
        if deletes && self.explicit.action == 3 && !self.is_io_established() {
            self.explicit.end();
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Timer {
    Watchdog(Which),
    Trigger,
    Inhibit,
    Acknowledge,
}

/// The choice bits of the instances 2 to 5.
pub(super) const BITS: [u8; 4] = [POLL, STROBE, BOTH, 0x08];
/// The places of the instances in arrays.
pub(super) const POLLED: usize = 0;
pub(super) const STROBED: usize = 1;
pub(super) const CHANGE: usize = 2;
pub(super) const MULTICAST: usize = 3;
