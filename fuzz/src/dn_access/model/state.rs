//! The states of the table.

use link_core::Instant;

/// The states of the table, with what the rows need.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::dn_access) enum State {
    NonExistent,
    Sending {
        done: u8,
        controller: Controller,
    },
    Waiting {
        done: u8,
        until: Instant,
    },
    /// With Quick Connect, the second request comes later.
    OnLine {
        answer_due: bool,
        second: Sending,
        /// The controller gave something back: nothing is sent before this.
        pause: Option<Instant>,
    },
    Faulted(Fault),
}

/// Whether the request can be handed to the controller.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::dn_access) enum Controller {
    Ready,
    BackOff(Instant),
    Restarting { commanded: bool },
    GivenBack(Instant),
}

/// A frame that is sent after a wait.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::dn_access) enum Sending {
    Nothing,
    At(Instant),
    Due,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::dn_access) enum Fault {
    BusOff,
    /// The Who response, byte 0 of the Identify response, and until when the indicator flashes.
    Duplicate {
        who: Sending,
        identify: Option<u8>,
        flashing: Option<Instant>,
    },
}

/// What a frame is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::dn_access) enum Kind {
    CheckRequest,
    CheckResponse,
    WhoResponse,
    IdentifyResponse(u8),
}

impl Sending {
    pub(super) fn expire(&mut self, until: Instant) {
        if matches!(*self, Self::At(at) if at <= until) {
            *self = Self::Due;
        }
    }
}
