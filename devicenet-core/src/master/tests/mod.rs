//! The master against a tester that plays the slaves by hand.

mod bring_up;
mod bus;
mod cycle;
pub(super) mod edges;
mod exhaustive;
mod explicit;
mod io;
mod loss;
mod node;
mod ownership;
mod replacement;
mod storage;
