//! What the rules of all networks have to say of a frame.

use super::{Answered, ConnectionState, Flaw};

/// What a rule has found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Remark {
    /// The frame is wrong or suspicious. The first flaw of a frame counts.
    Flaw(Flaw),
    /// It is on a connection that is not established by what was seen before.
    NoConnection(ConnectionState),
    /// The message that it is part of does not fit into the store.
    NotStored,
    /// It was sent before.
    Repeated,
    /// It could not be known for certain without frames that the recording does not contain.
    Assumed,
    /// It answers this frame.
    Answers(Answered),
}

/// The reading of a frame, which takes down what the rules find.
pub trait Remarks {
    /// Takes a remark down.
    fn remark(&mut self, remark: Remark);
}
