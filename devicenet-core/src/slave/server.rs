//! What answers an explicit request, whichever way it came.

use cip_core::code::{ClassId, GeneralStatus, InstanceId, ServiceCode};
use cip_core::codec::Writer;
use cip_core::fragment::IO_UNFRAGMENTED_LEN;
use cip_core::message::{AllocationChoice, BodyFormat, Request};
use cip_core::object::{
    AcknowledgeHandler, Call, Effect, Effects, Failure, ObjectSet, respond_with, serve, serve_plain,
};

use super::allocation::{Door, Requester};
use super::application::{Application, IoKind, Parts};
use super::config::Options;
use super::departure::Departure;
use super::event::{Ignored, SlaveEvent, count};
use super::machine::{DynamicTransfer, Slave};
use super::node::{BOTH, Changed, Node};
use super::transfer::Transfer;
use super::unconnected;
use cip_core::connection::IoState;

/// All objects of a slave, put together for one request.
pub(super) struct Server<'a, A: Application, const MESSAGE: usize, const DYNAMIC: usize> {
    pub(super) node: &'a mut Node<A, DYNAMIC>,
    pub(super) requester: Requester,
}

/// The objects, the predefined explicit connection, and those that were opened dynamically.
pub(super) type Serving<'a, A, const MESSAGE: usize, const DYNAMIC: usize> =
    (Server<'a, A, MESSAGE, DYNAMIC>, &'a mut Transfer<MESSAGE>, &'a mut [DynamicTransfer<MESSAGE>; DYNAMIC]);

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Slave<A, MESSAGE, DYNAMIC> {
    /// The objects for a request, and beside them the buffers of the explicit connections.
    pub(super) const fn serving(&mut self, requester: Requester) -> Serving<'_, A, MESSAGE, DYNAMIC> {
        let server = Server { node: &mut self.node, requester };
        (server, &mut self.explicit, &mut self.transfers)
    }
}

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Server<'_, A, MESSAGE, DYNAMIC> {
    /// Answers a request, from the service byte on. An error: there is no answer.
    pub(super) fn answer(&mut self, body: &[u8], out: &mut Writer<'_>) -> Result<(), Ignored> {
        match body.first() {
            Some(&service) if ServiceCode::split(service).1 => return Err(Ignored::Response),
            Some(_) => {}
            None => return Err(Ignored::TooShort),
        }
        let call = self.call(body)?;
        count::<A>(&mut self.node.events.counters.requests);
        let done = match call {
            Ok(call) => self.perform(&call, out).map(|()| self.tell(&call)),
            Err(failure) => {
                // Three bytes, for which every buffer has room.
                let _ = failure.emit(out);
                Err(failure)
            }
        };
        if done.is_err() {
            count::<A>(&mut self.node.events.counters.refused);
        }
        Ok(())
    }

    /// Carries out a service, and writes its response.
    #[inline(never)]
    pub(super) fn perform(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<(), Failure> {
        respond_with(call, self.node.failures(), out, |out| self.serve(call, out))
    }

    fn serve(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<(), Failure> {
        // Paths come through dynamic connections only: this tells the compiler so.
        let by_ids = Call::new(call.service, call.class, call.instance, call.data);
        let call = if DYNAMIC == 0 { &by_ids } else { call };
        if self.requester.door == Door::Unconnected {
            unconnected::check(call)?;
        }
        let has_more_of_identity = A::PARTS.intersects(Parts::OPTIONAL_SERVICES.union(Parts::HEARTBEAT));
        match call.class {
            ClassId::IDENTITY if has_more_of_identity => {
                let mut identity = self.node.identity();
                let effects = serve(&mut identity, call, out)?;
                self.node.heartbeat_interval = identity.heartbeat_interval;
                self.carry_out(effects);
                Ok(())
            }
            ClassId::IDENTITY | ClassId::DEVICENET | ClassId::CONNECTION => serve_plain(self, call, out),
            _ => self.serve_others(call, out),
        }
    }

    /// The request in the body format of its connection.
    fn call<'r>(&self, body: &'r [u8]) -> Result<Result<Call<'r>, Failure>, Ignored> {
        if DYNAMIC == 0 || self.requester.format == BodyFormat::Class8Instance8 {
            if let [service, class, instance, data @ ..] = body {
                let (class, instance) = (ClassId((*class).into()), InstanceId((*instance).into()));
                return Ok(Ok(Call::new(ServiceCode(*service), class, instance, data)));
            }
        } else if let Ok(request) = Request::parse(self.requester.format, body) {
            return Ok(Call::of(&request));
        }
        if self.node.options.contains(Options::ANSWER_SHORT_BODY) {
            Ok(Err(GeneralStatus::NOT_ENOUGH_DATA.into()))
        } else {
            Err(Ignored::TooShort)
        }
    }

    /// The connections that can be allocated.
    pub(super) fn offer(&self) -> AllocationChoice {
        let device = self.node.application.offered().union(AllocationChoice::EXPLICIT);
        offered::<A>().intersection(device)
    }

    /// What a service leaves to be done.
    pub(super) fn carry_out(&mut self, effects: Effects) {
        if let Some(kind) = effects.reset_type() {
            self.node.departure = Some(Departure::reset(kind, self.requester.door));
            return;
        }
        let own = Effect::ATTRIBUTE_SET | Effect::HEARTBEAT_INTERVAL | Effect::ACKNOWLEDGE;
        if effects.of().contains(Effect::HEARTBEAT_INTERVAL) {
            let seconds = self.node.heartbeat_interval.unwrap_or(0);
            self.node.changed.insert(Changed::HEARTBEAT);
            self.node.events.raise::<A>(SlaveEvent::StoreHeartbeatInterval(seconds));
        }
        let for_application = effects.of().difference(own);
        if !for_application.is_empty() {
            self.node.events.raise::<A>(SlaveEvent::Effect(for_application));
        }
    }

    /// Tells of a service that has changed something. What the unconnected port is there for is told as an allocation, a reset when
    /// it takes place.
    fn tell(&mut self, call: &Call<'_>) {
        if self.node.departure.is_some_and(|departure| departure.is_reset()) {
            return;
        }
        if !call.service.is_question() && self.requester.door != Door::Unconnected {
            let (class, instance, service) = (call.class, call.instance, call.service);
            self.node.report(SlaveEvent::Changed { class, instance, service });
        }
    }

    /// Attribute 8 of the instance of the Connection object that is asked, if it is for I/O.
    pub(super) fn consumed_size(&mut self, call: &Call<'_>) -> usize {
        match IoKind::of_instance(call.instance).and_then(IoKind::offered::<A>) {
            Some(kind @ (IoKind::Poll | IoKind::MulticastPoll)) => self.node.application.consumed(kind).len(),
            Some(IoKind::BitStrobe) => IO_UNFRAGMENTED_LEN,
            Some(IoKind::ChangeOfState) | None => 0,
        }
    }

    #[inline(never)]
    fn serve_others(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<(), Failure> {
        let served = if call.class == ClassId::ACKNOWLEDGE_HANDLER && A::IO.intersects(BOTH) {
            let established = self.node.io(IoKind::ChangeOfState).state() == IoState::Established;
            let mut handler = AcknowledgeHandler::new(&mut self.node.acknowledge);
            handler.established = established;
            Some(serve(&mut handler, call, out))
        } else {
            self.node.application.objects().serve(call, out)
        };
        let effects = served.unwrap_or(Err(GeneralStatus::OBJECT_DOES_NOT_EXIST.into()))?;
        self.carry_out(effects);
        Ok(())
    }
}

/// What can be allocated: what the application offers, and the explicit connection.
pub(super) const fn offered<A: Application>() -> AllocationChoice {
    A::IO.union(AllocationChoice::EXPLICIT).difference(AllocationChoice::ACK_SUPPRESSION)
}
