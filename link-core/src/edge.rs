//! The transitions of state machines.
//!
//! A machine lists all of its transitions in a table `EDGES`, with one function by which states change. Debug builds check
//! each step against the table, the documentation shows it, and a test demands that every edge is reached.

use core::fmt;

/// A transition.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Edge<S, C> {
    /// The state that it leaves.
    pub from: S,
    /// Why.
    pub cause: C,
    /// The state that it enters.
    pub to: S,
}

/// A transition with the number of a row in a published table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct NumberedEdge<S, C> {
    /// The row. One that is worded widely stands for several transitions.
    pub number: u8,
    /// The state that it leaves.
    pub from: S,
    /// Why.
    pub cause: C,
    /// The state that it enters.
    pub to: S,
}

/// `| Configuring | EPR set | Established |`
impl<S: fmt::Display, C: fmt::Display> fmt::Display for Edge<S, C> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "| {} | {} | {} |", self.from, self.cause, self.to)
    }
}

/// `| 1 | NonExistent | link up | SendingDupMac |`
impl<S: fmt::Display, C: fmt::Display> fmt::Display for NumberedEdge<S, C> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "| {} | {} | {} | {} |", self.number, self.from, self.cause, self.to)
    }
}
