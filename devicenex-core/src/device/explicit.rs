//! Explicit messages on connections: class 10mmm.

use cip_core::code::{GeneralStatus, ServiceCode};
use cip_core::codec::{Full, Wire, Writer};
use cip_core::connection::ExplicitCause;
use cip_core::fragment::FragmentKind;
use cip_core::message::{BodyFormat, Request};
use cip_core::object::{Call, Failure};
use cip_core::transfer::{FragmentRefused, Part};
use link_core::Frame;

use super::application::Application;
use super::event::Ignored;
use super::machine::Device;
use super::slot::{Body, Reply, Slot};
use crate::counter::count;
use crate::id::{Framing, MessageId, Route};
use crate::message::{FirstFragment, NextFragment};

impl<A: Application, const MESSAGE: usize, const CONNECTIONS: usize> Device<A, MESSAGE, CONNECTIONS> {
    pub(super) fn explicit_frame(
        &mut self,
        message: MessageId,
        route: Route,
        framing: Framing,
        field: &[u8],
    ) -> Result<(), Ignored> {
        let is_theirs = |slot: &Slot<A::Long, MESSAGE>| match &slot.body {
            Body::Explicit(explicit) => slot.is_explicit_of(route.source) && explicit.request == message,
            Body::Free | Body::Io(_) => false,
        };
        let place = self.slots.iter().position(is_theirs).ok_or(Ignored::NoConnection)?;
        self.check_departure()?;
        // It exists: nothing is refused.
        let _ = self.explicit_step(place, ExplicitCause::Message);
        let mut request = [0; MESSAGE];
        let Some((reply, len)) = self.receive(place, route, framing, field, &mut request)? else {
            return Ok(());
        };
        let mut response = [0; MESSAGE];
        let mut out = Writer::new(&mut response);
        self.serve(place, request.get(..len).unwrap_or_default(), &mut out)?;
        if let Some(Body::Explicit(explicit)) = self.slots.get_mut(place).map(|slot| &mut slot.body) {
            explicit.transfer.respond(reply, out.written());
        }
        Ok(())
    }

    /// Takes a frame; if it completes a request, that is in `request`, with its length.
    fn receive(
        &mut self,
        place: usize,
        route: Route,
        framing: Framing,
        field: &[u8],
        request: &mut [u8; MESSAGE],
    ) -> Result<Option<(Reply, usize)>, Ignored> {
        let rules = self.settings.rules;
        let Some(slot) = self.slots.get_mut(place) else { return Err(Ignored::NoConnection) };
        let Slot { body: Body::Explicit(explicit), timers, .. } = slot else {
            return Err(Ignored::NoConnection);
        };
        let client = route.source;
        match framing {
            Framing::Complete { transaction } => {
                explicit.transfer.whole(timers);
                Ok(Some((Reply { client, transaction }, copy(field, request))))
            }
            Framing::Fragment(byte) => {
                let first;
                let part = match byte.kind {
                    FragmentKind::First => {
                        first = FirstFragment::parse(field).map_err(|_| Ignored::TooShort)?;
                        explicit.transaction = first.transaction;
                        &first.body[..]
                    }
                    FragmentKind::Middle if field.len() < Frame::MAX_DATA => return Err(Ignored::TooShort),
                    FragmentKind::Middle | FragmentKind::Last => {
                        NextFragment::parse(field).map_err(|_| Ignored::TooShort)?.body
                    }
                    FragmentKind::Acknowledge => field,
                };
                let reply = Reply { client, transaction: explicit.transaction };
                let is_complete = explicit.transfer.fragment(timers, rules, reply, false, byte, part)?;
                Ok(is_complete.then(|| (reply, copy(explicit.transfer.request(), request))))
            }
        }
    }

    /// Serves a request, and writes its response.
    fn serve(&mut self, place: usize, body: &[u8], out: &mut Writer<'_>) -> Result<(), Ignored> {
        match body.first() {
            Some(&service) if ServiceCode::split(service).1 => return Err(Ignored::Response),
            Some(_) => {}
            None => return Err(Ignored::TooShort),
        }
        count(&mut self.counters.requests);
        let done = match self.call(body) {
            Ok(call) => {
                self.perform(&call, Some(place), out).map(|effects| self.carry_out(&call, place, effects))
            }
            Err(failure) => {
                // Three bytes, for which every buffer has room.
                let _ = failure.emit(out);
                Err(failure)
            }
        };
        if done.is_err() {
            count(&mut self.counters.refused);
        }
        Ok(())
    }

    /// The request in the body format that the connection response told. One that ends before it names an object is
    /// refused **\[D\]**: nothing else is lost on a connection in silence.
    fn call<'r>(&self, body: &'r [u8]) -> Result<Call<'r>, Failure> {
        let format: BodyFormat = self.settings.body_format;
        let request = Request::parse(format, body).map_err(|_| GeneralStatus::NOT_ENOUGH_DATA)?;
        Call::of(&request)
    }
}

/// How the identifier says which part of a response it is.
pub(super) fn framing(reply: Reply, part: &Part<'_>) -> Framing {
    match part {
        Part::Acknowledge(byte, _) => Framing::Fragment(*byte),
        Part::Whole(_) => Framing::Complete { transaction: reply.transaction },
        Part::Fragment(fragment) => Framing::Fragment(fragment.byte),
    }
}

/// The data field that carries it.
pub(super) fn write_part(reply: Reply, part: &Part<'_>, out: &mut Writer<'_>) -> Result<(), Full> {
    match part {
        Part::Acknowledge(_, status) => out.u8((*status).into()),
        Part::Whole(body) => out.bytes(body),
        Part::Fragment(fragment) => {
            if fragment.byte.kind == FragmentKind::First {
                out.u8(reply.transaction)?;
            }
            out.bytes(fragment.data)
        }
    }
}

/// The request, as far as there is room; how long it is. A frame always has room, and what is put together has been checked.
fn copy(from: &[u8], to: &mut [u8]) -> usize {
    let len = from.len().min(to.len());
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
    len
}

impl From<FragmentRefused> for Ignored {
    fn from(why: FragmentRefused) -> Self {
        match why {
            FragmentRefused::NoStatus => Self::TooShort,
            FragmentRefused::Order => Self::FragmentOrder,
            FragmentRefused::StrayAcknowledge => Self::StrayAcknowledge,
        }
    }
}
