//! Tests that read like the bus: what a node sends, hears and shows, in the order of time.

mod bus;
mod bus_off;
mod detecting;
pub(super) mod edges;
mod exhaustive;
mod faults;
mod joining;
mod online;
mod standby;
