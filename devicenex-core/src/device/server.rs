//! The objects of a device: which of them a request is for, and what is left to do when it was served.

use cip_core::code::{ClassId, GeneralStatus, InstanceId};
use cip_core::codec::Writer;
use cip_core::connection::IoState;
use cip_core::identity::IdentityStatus;
use cip_core::object::{
    AcknowledgeHandler, Call, Effect, Effects, Failure, Identity, MessageRouter, ObjectSet, respond_with,
    serve,
};

use super::application::Application;
use super::connection_object::ConnectionObject;
use super::departure::{Departure, Why};
use super::event::DeviceEvent;
use super::machine::Device;
use crate::link_object::{Instances, LinkObject};
use crate::message::ConnectionInstance;

impl<A: Application, const MESSAGE: usize, const CONNECTIONS: usize> Device<A, MESSAGE, CONNECTIONS> {
    /// Carries out a service, and writes its response. `place` is the connection that it came on.
    pub(super) fn perform(
        &mut self,
        call: &Call<'_>,
        place: Option<usize>,
        out: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        let failures = self.settings.failures;
        respond_with(call, failures, out, |out| match call.class {
            ClassId::IDENTITY => serve(&mut self.identity(), call, out),
            ClassId::MESSAGE_ROUTER => serve(&mut MessageRouter, call, out),
            ClassId::DEVICENET => self.serve_link(call, place, out),
            ClassId::CONNECTION => {
                let consumed_size = self.consumed_size(call);
                serve(&mut ConnectionObject { device: self, consumed_size }, call, out)
            }
            ClassId::ACKNOWLEDGE_HANDLER => {
                let established = self.is_producer_established();
                let mut handler = AcknowledgeHandler::new(&mut self.acknowledge);
                (handler.established, handler.producers) = (established, &PRODUCERS);
                serve(&mut handler, call, out)
            }
            _ => {
                let served = self.application.objects().serve(call, out);
                served.unwrap_or(Err(GeneralStatus::OBJECT_DOES_NOT_EXIST.into()))
            }
        })
    }

    /// What the service leaves to be done, and to be told.
    pub(super) fn carry_out(&mut self, call: &Call<'_>, place: usize, effects: Effects) {
        if let Some(kind) = effects.reset_type() {
            self.departure = Some(Departure { why: Why::Reset(kind), place });
            return;
        }
        let own = Effect::ATTRIBUTE_SET | Effect::ACKNOWLEDGE;
        let for_application = effects.of().difference(own);
        if !for_application.is_empty() {
            self.raise(DeviceEvent::Effect(for_application));
        }
        if !call.service.is_question() {
            let (class, instance, service) = (call.class, call.instance, call.service);
            self.raise(DeviceEvent::Changed { class, instance, service });
        }
    }

    /// The Identity object: what the application says, and what the node knows. A device with an I/O connection is owned.
    fn identity(&self) -> Identity<'_> {
        let mut identity = self.application.identity();
        if self.slots.iter().any(|slot| slot.io_state().is_some()) {
            identity.status.insert(IdentityStatus::OWNED);
        }
        identity
    }

    fn serve_link(
        &mut self,
        call: &Call<'_>,
        place: Option<usize>,
        out: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        let mut instances = Instances::new();
        for slot in self.slots.iter().filter(|slot| slot.is_open()) {
            // There is room: a device has no more connections. To collect them would bring panicking code.
            let _ = instances.push(slot.instance);
        }
        let mut link = LinkObject::new(&mut self.access, instances);
        let effects = serve(&mut link, call, out)?;
        if let Some((address, place)) = link.new_address().zip(place) {
            self.departure = Some(Departure { why: Why::Address(address), place });
        }
        Ok(effects)
    }

    fn is_producer_established(&self) -> bool {
        self.slots.iter().any(|slot| {
            slot.id() == self.acknowledge.producer && slot.io_state() == Some(IoState::Established)
        })
    }

    /// Attribute 8 of the instance of the Connection object that is asked, if it is for I/O.
    fn consumed_size(&mut self, call: &Call<'_>) -> usize {
        let connection = ConnectionInstance::of(call.instance);
        match self.place_of(connection).and_then(|place| self.slots.get(place)?.io_trigger()) {
            Some(trigger) if trigger.is_server() => self.application.consumed(connection).len(),
            Some(_) | None => 0,
        }
    }
}

/// The connections that attribute 3 of the Acknowledge Handler can name; its settings hold for all.
const PRODUCERS: [InstanceId; 4] = [InstanceId(8), InstanceId(9), InstanceId(10), InstanceId(11)];
