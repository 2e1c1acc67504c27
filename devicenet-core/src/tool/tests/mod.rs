//! The tool against a tester that plays faulted nodes and other tools by hand.

mod bus;
pub(super) mod edges;
mod exhaustive;
mod sequence;
