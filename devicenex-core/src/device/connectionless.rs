//! The connectionless server: class 11100.
//!
//! | Request | Answer |
//! |---|---|
//! | from OA 127 | none **\[D\]** |
//! | Get_Attribute_Single (0x0E) | as on a connection **\[P\]** |
//! | another service | `94 08 FF`, and nothing changes **\[D\]** |
//! | without service, or in fragments | none: the only request has four bytes **\[D\]** |
//! | so many at once that no answer could wait | none: the client asks again **\[D\]** |
//!
//! A response of more than eight bytes goes out in fragments, which the client acknowledges under an identifier of its own
//! *requests*. One such response is under way at a time; a client that asks again gives up its earlier one **\[D\]**.

use cip_core::code::{ClassId, GeneralStatus, InstanceId, ServiceCode};
use cip_core::codec::Writer;
use cip_core::fragment::FragmentKind;
use cip_core::object::{Call, Failure};
use link_core::{Frame, TxOutcome};

use super::application::Application;
use super::event::{DeviceEvent, Ignored};
use super::line::{Done, Line};
use super::machine::Device;
use super::slot::{Pipe, Reply};
use super::timer::{Timer, Waits};
use crate::counter::count;
use crate::id::{Direction, Framing, Identifier, OperationalAddress, Route};

/// The port, for responses that take more than a frame.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Port<const MESSAGE: usize> {
    pub(super) pipe: Pipe<MESSAGE>,
    /// Whose the response is.
    pub(super) client: OperationalAddress,
    pub(super) line: Line,
    pub(super) timers: Waits,
}

impl<const MESSAGE: usize> Port<MESSAGE> {
    pub(super) const fn new() -> Self {
        Self {
            pipe: Pipe::new(MESSAGE, Reply::NOBODY),
            client: OperationalAddress::NONE,
            line: Line::IDLE,
            timers: Waits::new(),
        }
    }
}

impl<A: Application, const MESSAGE: usize, const CONNECTIONS: usize> Device<A, MESSAGE, CONNECTIONS> {
    pub(super) fn connectionless_frame(
        &mut self,
        route: Route,
        framing: Framing,
        field: &[u8],
    ) -> Result<(), Ignored> {
        match framing {
            Framing::Complete { transaction } => self.connectionless_request(route, transaction, field),
            Framing::Fragment(byte) if byte.kind == FragmentKind::Acknowledge => {
                if route.source != self.port.client {
                    return Err(Ignored::StrayAcknowledge);
                }
                let (reply, rules) = (Reply { client: route.source, transaction: 0 }, self.settings.rules);
                let Port { pipe, timers, .. } = &mut self.port;
                pipe.fragment(timers, rules, reply, false, byte, field)?;
                Ok(())
            }
            Framing::Fragment(_) => Err(Ignored::Fragment),
        }
    }

    fn connectionless_request(&mut self, route: Route, transaction: u8, field: &[u8]) -> Result<(), Ignored> {
        let service = *field.first().ok_or(Ignored::TooShort)?;
        if ServiceCode::split(service).1 {
            return Err(Ignored::Response);
        }
        self.check_room()?;
        let client = route.source;
        let mut response = [0; MESSAGE];
        let mut out = Writer::new(&mut response);
        let served = match call(field) {
            Ok(call) => self.perform(&call, None, &mut out).map(|_| ()),
            Err(failure) => {
                // Three bytes, for which every buffer has room.
                let _ = failure.emit(&mut out);
                Err(failure)
            }
        };
        let response = out.written();
        let back = Route { destination: client, direction: Direction::Response, source: route.destination };
        if response.len() <= Frame::MAX_DATA {
            let framing = Framing::Complete { transaction };
            self.answer(Identifier::connectionless(back, framing), response);
        } else if self.port.client == client || self.port.pipe.is_quiet() {
            let Port { pipe, timers, .. } = &mut self.port;
            pipe.whole(timers);
            pipe.respond(Reply { client, transaction }, response);
            self.port.client = client;
        } else {
            return Err(Ignored::Busy);
        }
        count(&mut self.counters.requests);
        count(&mut self.counters.connectionless);
        if served.is_err() {
            count(&mut self.counters.refused);
        }
        Ok(())
    }

    /// No request is carried out whose answer would be lost, or that a node which is about to leave would have to answer.
    pub(super) fn check_room(&self) -> Result<(), Ignored> {
        self.check_departure()?;
        if self.answers.is_full() { Err(Ignored::Busy) } else { Ok(()) }
    }

    /// A response in one frame.
    pub(super) fn answer(&mut self, id: Identifier, field: &[u8]) {
        let Some(frame) = id.frame(field) else {
            debug_assert!(false, "the answer has up to eight bytes");
            return;
        };
        // There is room: it was checked before the request was carried out.
        let _ = self.answers.push(frame);
    }

    pub(super) fn answer_done(&mut self, outcome: TxOutcome) -> Option<()> {
        let Done { given_back, .. } = self.answering.0.done(outcome)?;
        let id = self.answering.1.take();
        if let Some(id) = id.filter(|_| given_back) {
            self.not_sent(id, outcome);
        }
        Some(())
    }

    pub(super) fn port_done(&mut self, outcome: TxOutcome) -> Option<()> {
        let Done { what: _, given_back, .. } = self.port.line.done(outcome)?;
        let Port { pipe, timers, .. } = &mut self.port;
        pipe.handed(timers);
        if given_back {
            let back = Route {
                destination: self.port.client,
                direction: Direction::Response,
                source: self.access.address(),
            };
            self.not_sent(Identifier::connectionless(back, Framing::Complete { transaction: 0 }), outcome);
        }
        Some(())
    }

    pub(super) fn port_wait_over(&mut self, timer: Timer) {
        let Port { pipe, timers, client, .. } = &mut self.port;
        match timer {
            Timer::Acknowledge => {
                if pipe.not_acknowledged(timers) {
                    let requester = *client;
                    self.raise(DeviceEvent::ResponseAbandoned { requester });
                }
            }
            // It receives no fragments.
            Timer::Reassembly | Timer::Watchdog | Timer::Trigger | Timer::Inhibit => {}
        }
    }
}

/// The request, if it is one that needs no connection.
fn call(body: &[u8]) -> Result<Call<'_>, Failure> {
    match *body {
        [service, ref rest @ ..] if service == ServiceCode::GET_ATTRIBUTE_SINGLE.request_byte() => {
            let [class, instance, data @ ..] = rest else {
                return Err(GeneralStatus::NOT_ENOUGH_DATA.into());
            };
            let (class, instance) = (ClassId((*class).into()), InstanceId((*instance).into()));
            Ok(Call::new(ServiceCode::GET_ATTRIBUTE_SINGLE, class, instance, data))
        }
        _ => Err(GeneralStatus::SERVICE_NOT_SUPPORTED.into()),
    }
}
