//! A node: a machine of any protocol, its configuration and its clock.

use std::any::Any;
use std::fmt;

use link_core::{Action, BitRate, Deadline, FilterSet, Input, Instant, Machine};

use crate::bus::{after, span};
use crate::change::Reaction;

/// Names a node of one network: 0 is the first that was added.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct NodeId(u32);

impl NodeId {
    pub(crate) fn new(index: usize) -> Self {
        Self(u32::try_from(index).unwrap_or(u32::MAX))
    }

    /// Its place in the order of the nodes.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

/// `node 3`
impl fmt::Display for NodeId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "node {}", self.0)
    }
}

/// What a node is like.
#[derive(Clone, Debug)]
pub struct NodeConfig {
    /// For traces and messages.
    pub name: String,
    /// When it gets power; `None` if only a [`Change::PowerOn`](crate::Change::PowerOn) gives it.
    pub power_up: Option<Instant>,
    /// The rate of its controller at power-up; `None` is the rate of the bus.
    pub bit_rate: Option<BitRate>,
    /// Its controller is in listen-only mode at power-up.
    pub listen_only: bool,
    /// What its controller accepts at power-up. Its machine may change that.
    pub filter: FilterSet,
    /// How long it takes from an input to the first frame that follows from it.
    pub reaction: Reaction,
    /// How fast (positive) or slow its clock is, in parts per million. Timers and bits follow it.
    pub clock_ppm: i32,
    /// Its machine has power of its own, such as a computer with an adapter that the bus feeds. Without power the
    /// controller is off the bus, and the machine gets [`LinkEvent::Down`](link_core::LinkEvent::Down); with power it
    /// gets [`LinkEvent::Up`](link_core::LinkEvent::Up), and goes on with what it had.
    pub own_power: bool,
}

impl NodeConfig {
    /// A node with power from the beginning, the rate of the bus, no filter, no delay, and an exact clock.
    #[must_use]
    pub fn named(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            power_up: Some(Instant::ZERO),
            bit_rate: None,
            listen_only: false,
            filter: FilterSet::all(),
            reaction: Reaction::Immediate,
            clock_ppm: 0,
            own_power: false,
        }
    }
}

/// A machine behind a pointer, with events of the network's type.
pub(crate) trait Slot<E> {
    fn input(&mut self, now: Instant, input: Input);
    fn poll(&mut self, now: Instant) -> Option<Action<E>>;
    fn deadline(&self) -> Option<Deadline>;
    /// Starts anew.
    fn power_up(&mut self);
    fn machine(&self) -> &dyn Any;
    fn machine_mut(&mut self) -> &mut dyn Any;
}

/// What a machine keeps without power: from the one that was on to the one that starts.
pub(crate) type Keep<M> = Box<dyn FnMut(&M, &mut M)>;

pub(crate) struct Housed<M: Machine, E> {
    pub(crate) machine: M,
    /// As it was added.
    pub(crate) fresh: M,
    pub(crate) keep: Option<Keep<M>>,
    /// Makes an event of the network of one of the machine.
    pub(crate) convert: fn(M::Event) -> E,
}

impl<E, M: Machine + Clone + 'static> Slot<E> for Housed<M, E> {
    fn input(&mut self, now: Instant, input: Input) {
        self.machine.input(now, input);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<E>> {
        Some(self.machine.poll(now)?.map_event(self.convert))
    }

    fn deadline(&self) -> Option<Deadline> {
        self.machine.deadline()
    }

    fn power_up(&mut self) {
        let mut fresh = self.fresh.clone();
        if let Some(keep) = &mut self.keep {
            keep(&self.machine, &mut fresh);
        }
        self.machine = fresh;
    }

    fn machine(&self) -> &dyn Any {
        &self.machine
    }

    fn machine_mut(&mut self) -> &mut dyn Any {
        &mut self.machine
    }
}

/// The clock of a node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalClock {
    /// The same moment on both clocks.
    network: Instant,
    local: Instant,
    ppm: i32,
}

impl LocalClock {
    pub(crate) const fn new(ppm: i32) -> Self {
        Self { network: Instant::ZERO, local: Instant::ZERO, ppm }
    }

    /// It runs at another speed from now on.
    pub(crate) fn set(&mut self, now: Instant, ppm: i32) {
        *self = Self { network: now, local: self.local(now), ppm };
    }

    /// What it shows.
    pub(crate) fn local(self, now: Instant) -> Instant {
        if self.ppm == 0 && self.network == self.local {
            return now;
        }
        after(self.local, scale(span(self.network, now), self.speed(), MILLION, 0))
    }

    /// When it shows `local`.
    pub(crate) fn network(self, local: Instant) -> Instant {
        if self.ppm == 0 && self.network == self.local || local == Instant::MAX {
            return local;
        }
        after(self.network, scale(span(self.local, local), MILLION, self.speed(), self.speed() - 1))
    }

    fn speed(self) -> u64 {
        (1_000_000 + i64::from(self.ppm)).max(1).unsigned_abs()
    }
}

fn scale(nanos: u64, by: u64, over: u64, round_up: u64) -> u64 {
    let scaled = (u128::from(nanos) * u128::from(by) + u128::from(round_up)) / u128::from(over);
    u64::try_from(scaled).unwrap_or(u64::MAX)
}

const MILLION: u64 = 1_000_000;

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_deadline_is_reached_and_not_missed(
            ppm in -50_000..50_000_i32,
            set_at in 0..1_000_000_000_u64,
            wait in 0..1_000_000_000_000_u64,
        ) {
            let mut clock = LocalClock::new(ppm);
            clock.set(Instant::from_nanos(set_at), -ppm);
            let deadline = after(clock.local(Instant::from_nanos(set_at)), wait);
            let at = clock.network(deadline);
            prop_assert!(clock.local(at) >= deadline);
            prop_assert!(clock.local(Instant::from_nanos(at.as_nanos().saturating_sub(1))) <= deadline);
        }
    }
}
