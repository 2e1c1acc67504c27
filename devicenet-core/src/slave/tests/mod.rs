//! The slave, with the tester as the rest of the bus.

mod allocation;
mod bus;
pub(super) mod edges;
mod explicit;
mod network;
mod objects;
mod other_io;
mod poll;
mod races;
mod ucmm;
mod worked_trace;
