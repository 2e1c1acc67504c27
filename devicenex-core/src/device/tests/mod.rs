//! The device, over the wire: the tester is the rest of the bus.
//!
//! The identifiers are written out: they are those of the tables of [`id`](crate::id), by hand. OA 1 is the manager, OA 67
//! the device.

mod bus;
mod connectionless;
pub(super) mod edges;
mod exhaustive;
mod explicit;
mod implicit;
mod long;
mod network;
mod objects;
mod requests;
mod storage;
