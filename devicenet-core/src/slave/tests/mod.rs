//! The slave, with the tester as the rest of the bus.

mod allocation;
mod bus;
pub(super) mod edges;
mod effects;
mod explicit;
mod fast_get;
mod leaving;
mod network;
mod objects;
mod other_io;
mod parts;
mod poll;
mod races;
mod ucmm;
mod worked_trace;

impl<A: super::Application, const MESSAGE: usize, const DYNAMIC: usize> super::Slave<A, MESSAGE, DYNAMIC> {
    /// For explorations: machines that differ only in what they counted are the same.
    pub(crate) fn forget_counts(&mut self) {
        self.node.access.forget_counts();
        self.node.events.counters = super::Counters::default();
    }
}
