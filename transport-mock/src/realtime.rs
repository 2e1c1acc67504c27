//! Virtual time that follows the wall clock.

use std::time::Duration;

use link_core::Instant;

use crate::{Network, Sink};

/// A clock that can be waited for.
pub trait WallClock {
    /// The present moment.
    fn now(&mut self) -> Instant;

    /// Returns at `at`, or earlier when there is something else to do.
    fn sleep_until(&mut self, at: Instant);
}

/// The clock of the computer.
#[derive(Clone, Copy, Debug)]
pub struct SystemClock {
    epoch: std::time::Instant,
}

impl SystemClock {
    /// A clock whose zero is now.
    #[must_use]
    pub fn start() -> Self {
        Self { epoch: std::time::Instant::now() }
    }
}

impl WallClock for SystemClock {
    fn now(&mut self) -> Instant {
        Instant::ZERO + self.epoch.elapsed()
    }

    fn sleep_until(&mut self, at: Instant) {
        std::thread::sleep(at.saturating_since(self.now()));
    }
}

/// Runs a network so that its time follows a clock.
///
/// It calls the network only when something is due, so between two events it costs nothing. To do something at the
/// present moment, such as injecting a frame, use [`at_now`](Self::at_now).
#[derive(Debug)]
pub struct Realtime<E, C> {
    network: Network<E>,
    clock: C,
    /// Virtual seconds in a second.
    speed: u32,
    /// The same moment on both clocks.
    wall: Instant,
    virtual_time: Instant,
}

impl<E: 'static, C: WallClock> Realtime<E, C> {
    /// Follows `clock` from now on, `speed` times as fast; 0 counts as 1.
    pub fn new(network: Network<E>, mut clock: C, speed: u32) -> Self {
        let (wall, virtual_time) = (clock.now(), network.now());
        Self { network, clock, speed: speed.max(1), wall, virtual_time }
    }

    /// The network as it was when it ran last.
    #[must_use]
    pub const fn network(&self) -> &Network<E> {
        &self.network
    }

    /// Gives the network back.
    #[must_use]
    pub fn into_network(self) -> Network<E> {
        self.network
    }

    /// Brings the network up to the present moment.
    pub fn catch_up(&mut self, sink: &mut impl Sink<E>) {
        let wall = self.wall_now();
        let now = self.virtual_time(wall);
        self.network.run_until(now.max(self.network.now()), sink);
    }

    /// Brings the network up to the present moment, and does something with it.
    pub fn at_now<R>(&mut self, sink: &mut impl Sink<E>, act: impl FnOnce(&mut Network<E>) -> R) -> R {
        self.catch_up(sink);
        act(&mut self.network)
    }

    /// When the network must be called next, on the clock; [`Instant::MAX`] if it has nothing more to do by itself.
    #[must_use]
    pub fn next_wakeup(&self) -> Instant {
        let next = self.network.next_event_time();
        if next == Instant::MAX {
            return next;
        }
        let nanos = u128::from(next.as_nanos().saturating_sub(self.virtual_time.as_nanos()));
        // Rounded up, and one more: a beginning is done when its moment has passed.
        let nanos = nanos.div_ceil(u128::from(self.speed)) + 1;
        self.wall + Duration::from_nanos(u64::try_from(nanos).unwrap_or(u64::MAX))
    }

    /// Runs for `span` of the clock. `between` is called each time before it sleeps, and breaks off by `false`.
    pub fn run_for(
        &mut self,
        span: Duration,
        sink: &mut impl Sink<E>,
        mut between: impl FnMut(&mut Network<E>) -> bool,
    ) {
        let end = self.wall_now() + span;
        loop {
            self.catch_up(sink);
            let go_on = between(&mut self.network);
            if !go_on || self.wall_now() >= end {
                return;
            }
            let wakeup = self.next_wakeup().min(end);
            self.clock.sleep_until(wakeup);
        }
    }

    fn wall_now(&mut self) -> Instant {
        self.clock.now()
    }

    fn virtual_time(&self, wall: Instant) -> Instant {
        let elapsed = wall.saturating_since(self.wall);
        self.virtual_time + elapsed.saturating_mul(self.speed)
    }
}
