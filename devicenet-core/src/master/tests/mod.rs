//! The master against a tester that plays the slaves by hand.

mod bring_up;
mod bus;
mod cycle;
mod explicit;
mod io;
mod node;
mod replacement;
