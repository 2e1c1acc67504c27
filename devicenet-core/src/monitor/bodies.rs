//! Complete explicit messages, from the service byte on.

use cip_core::monitor::{Answered, Flow, Seen};

use super::explicit::Route;
use super::kind::Kind;
use super::problem::Problem;
use super::reading::{Fields, Note, Reading};
use super::state::State;
use super::{requests, responses};
use crate::message::ExplicitHeader;

/// A complete message, read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Parsed {
    pub(super) kind: Kind,
    pub(super) fields: Fields<'static>,
    pub(super) request: Option<Answered>,
    pub(super) problem: Option<Problem>,
    pub(super) note: Option<Note>,
    pub(super) assumed: bool,
}

impl Parsed {
    pub(super) fn new(kind: Kind) -> Self {
        Self { kind, fields: Fields::default(), request: None, problem: None, note: None, assumed: false }
    }

    /// The message is the frame.
    pub(super) fn apply(self, reading: &mut Reading<'_>) {
        reading.kind = self.kind;
        reading.fields = Fields { is_ucmm: reading.fields.is_ucmm, ..self.fields };
        self.apply_around(reading);
    }

    /// The frame completes the message: what concerns the frame.
    pub(super) fn apply_around(self, reading: &mut Reading<'_>) {
        reading.request = self.request;
        reading.flag_if(self.problem);
        reading.note = reading.note.or(self.note);
        reading.assumed |= self.assumed;
    }

    pub(super) fn flag(&mut self, problem: impl Into<Problem>) {
        self.problem.get_or_insert(problem.into());
    }
}

/// Reads a complete message of an explicit connection. `before` is the number of bytes before the service byte in what
/// the reader of the fields will see.
pub(super) fn message<const N: usize>(
    state: &mut State<N>,
    route: &Route,
    seen: Seen,
    header: ExplicitHeader,
    body: &[u8],
    before: usize,
) -> Parsed {
    match route.flow {
        Flow::Consumed => requests::connected(state, route, seen, header, body, before),
        Flow::Produced => responses::connected(state, route, seen, header, body, before),
    }
}
