//! The Connection object (class 5).

use cip_core::code::{AttributeId, ClassId, GeneralStatus, InstanceId, ServiceCode};
use cip_core::codec::Writer;
use cip_core::connection::{
    CommCharacteristics, ConnectionPath, ConnectionState, ConnectionView, End, ExplicitCause, InstanceType,
    IoCause, IoState, Settings, TimeoutMultiplier, TransportClassTrigger, WatchdogAction,
};
use cip_core::epath::Epath;
use cip_core::object::{AttributeRule, Call, Effects, Failure, Object, Size, exact};

use super::application::Application;
use super::long::LongMessages;
use super::machine::Device;
use super::slot::{Body, Slot};
use crate::connection::ConnectionId;
use crate::id::{Identifier, Layout};
use crate::message::{ConnectionInstance, GroupSelect, Predefined, Production};

/// The object, put together for one request.
///
/// What can be read says [`ConnectionView`]. What of it can be set depends on the connection and its state **\[D\]**:
///
/// | Attribute | Explicit | I/O, predefined | I/O, dynamic |
/// |---|---|---|---|
/// | 3 | | change of state and cyclic: with or without acknowledges | while it is being configured |
/// | 5 | | multicast, consuming | while it is being configured |
/// | 9, 12, 18 | yes | yes | yes |
/// | 14, 16 | | | while it is being configured, if the application selects assemblies |
/// | 17 | | yes | yes |
///
/// What cannot be set is 0x0E, what cannot be set in the present state 0x0C, a wrong value 0x09.
///
/// | Service | Class | Instance |
/// |---|---|---|
/// | 0x05 Reset | every instance | yes |
/// | 0x09 Delete | every instance | yes |
/// | 0x0D Apply_Attributes | | I/O |
/// | 0x0E, 0x10 | Get of the revision, 1 | yes |
/// | 0x11 Find_Next_Object_Instance | yes | yes |
pub(super) struct ConnectionObject<'a, A: Application, const MESSAGE: usize, const CONNECTIONS: usize> {
    pub(super) device: &'a mut Device<A, MESSAGE, CONNECTIONS>,
    /// Attribute 8 of the instance that is asked, if it is for I/O.
    pub(super) consumed_size: usize,
}

impl<A: Application, const MESSAGE: usize, const CONNECTIONS: usize> Object
    for ConnectionObject<'_, A, MESSAGE, CONNECTIONS>
{
    const CLASS: ClassId = ClassId::CONNECTION;

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        self.place(instance).ok().map(|_| RULES)
    }

    fn next_instance(&self, instance: InstanceId) -> Option<InstanceId> {
        let open = self.device.slots.iter().filter(|slot| slot.is_open()).map(Slot::id);
        open.filter(|next| next.0 > instance.0).min()
    }

    fn get(&self, instance: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        let slot = self.device.slots.get(self.place(instance)?).ok_or(GONE)?;
        let settings = slot.settings().ok_or(GONE)?;
        let consumed_size = self.consumed_size;
        Ok(Instance { device: self.device, slot, settings, consumed_size }.get(attribute, out)?)
    }

    fn set(
        &mut self,
        instance: InstanceId,
        attribute: AttributeId,
        value: &[u8],
        out: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        let place = self.place(instance)?;
        let state = self.device.slots.get(place).and_then(Slot::io_state);
        match (attribute.0, state) {
            (3, Some(state)) => self.set_trigger(place, state, value)?,
            (5, Some(state)) => self.set_consumed(place, state, value)?,
            (9, state) => {
                let requested = u16::from_le_bytes(exact(value)?);
                let used = match state {
                    Some(_) => self.device.io_packet_rate(place, requested),
                    None => self.device.explicit_packet_rate(place, requested),
                }?;
                out.u16(used)?;
            }
            (12, _) => {
                let [action] = exact(value)?;
                let action = WatchdogAction(action);
                match self.body(place)? {
                    Body::Explicit(explicit) => explicit.connection.set_watchdog_action(action),
                    Body::Io(io) => io.connection.set_watchdog_action(action),
                    Body::Free => return Err(GONE),
                }?;
            }
            (14, Some(state)) => self.select(place, state, End::Produced, value)?,
            (16, Some(state)) => self.select(place, state, End::Consumed, value)?,
            (17, Some(_)) => {
                let millis = u16::from_le_bytes(exact(value)?);
                self.settings(place)?.set_production_inhibit_time(millis)?;
            }
            (18, _) => {
                let [code] = exact(value)?;
                self.settings(place)?.set_multiplier(TimeoutMultiplier(code))?;
            }
            _ => return Err(NOT_SETTABLE),
        }
        self.device.start_configuring(place);
        Ok(Effects::NONE)
    }

    fn service(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<Effects, Failure> {
        match call.service {
            ServiceCode::RESET | ServiceCode::DELETE if call.instance.is_class() => {
                call.no_data()?;
                self.each(call.service);
            }
            ServiceCode::RESET | ServiceCode::DELETE => {
                call.no_data()?;
                self.end(self.place(call.instance)?, call.service)?;
            }
            ServiceCode::APPLY_ATTRIBUTES => {
                let place = self.place(call.instance)?;
                if self.device.slots.get(place).and_then(Slot::io_state).is_none() {
                    return Err(NOT_SUPPORTED);
                }
                call.no_data()?;
                self.device.io_step(place, IoCause::Applied)?;
            }
            ServiceCode::FIND_NEXT_OBJECT_INSTANCE => {
                return cip_core::object::find_next_instance(
                    |instance| self.next_instance(instance),
                    call,
                    out,
                );
            }
            _ => return Err(NOT_SUPPORTED),
        }
        Ok(Effects::NONE)
    }
}

impl<A: Application, const MESSAGE: usize, const CONNECTIONS: usize>
    ConnectionObject<'_, A, MESSAGE, CONNECTIONS>
{
    fn place(&self, instance: InstanceId) -> Result<usize, Failure> {
        self.device.place_of(ConnectionInstance::of(instance)).ok_or(GONE)
    }

    fn body(&mut self, place: usize) -> Result<&mut Body<A::Long, MESSAGE>, Failure> {
        self.device.slots.get_mut(place).map(|slot| &mut slot.body).ok_or(GONE)
    }

    fn settings(&mut self, place: usize) -> Result<&mut Settings, Failure> {
        match self.body(place)? {
            Body::Explicit(explicit) => Ok(explicit.connection.settings_mut()),
            Body::Io(io) => Ok(io.connection.settings_mut()),
            Body::Free => Err(GONE),
        }
    }

    fn connection(&self, place: usize) -> Result<ConnectionInstance, Failure> {
        self.device.slots.get(place).map(Slot::connection).ok_or(GONE)
    }

    /// Attribute 3.
    fn set_trigger(&mut self, place: usize, state: IoState, value: &[u8]) -> Result<(), Failure> {
        let connection = self.connection(place)?;
        let allowed = connection.allowed_triggers();
        if allowed.is_empty() {
            return Err(NOT_SETTABLE);
        }
        check_configuring(connection, state)?;
        let [byte] = exact(value)?;
        let trigger = TransportClassTrigger(byte);
        if !allowed.contains(&trigger) {
            return Err(INVALID);
        }
        self.device.set_trigger(place, trigger);
        Ok(())
    }

    /// Attribute 5.
    fn set_consumed(&mut self, place: usize, state: IoState, value: &[u8]) -> Result<(), Failure> {
        let connection = self.connection(place)?;
        let is_settable = matches!(
            connection,
            ConnectionInstance::Dynamic(_)
                | ConnectionInstance::Predefined(Predefined::Implicit(Production::MulticastConsumer, _))
        );
        if !is_settable {
            return Err(NOT_SETTABLE);
        }
        check_configuring(connection, state)?;
        let id = ConnectionId::from(u32::from_le_bytes(exact(value)?));
        if self.device.set_consumed(place, id) { Ok(()) } else { Err(INVALID) }
    }

    /// Attributes 14 and 16: the path of another assembly.
    fn select(&mut self, place: usize, state: IoState, end: End, value: &[u8]) -> Result<(), Failure> {
        let connection = self.connection(place)?;
        if !A::SELECTS_ASSEMBLIES || !matches!(connection, ConnectionInstance::Dynamic(_)) {
            return Err(NOT_SETTABLE);
        }
        check_configuring(connection, state)?;
        let path = Epath::packed(value).logical()?;
        let assembly = path.instance.filter(|_| path.class == Some(ClassId::ASSEMBLY)).ok_or(INVALID)?;
        let application = &mut self.device.application;
        let before = application.assembly(connection, end);
        if !application.select_assembly(connection, end, assembly) {
            return Err(INVALID);
        }
        let size =
            usize::from(application.produced_size(connection)).max(application.consumed(connection).len());
        if size > A::Long::CAPACITY {
            // The one before was good enough.
            let _ = before.map(|assembly| application.select_assembly(connection, end, assembly));
            return Err(INVALID);
        }
        Ok(())
    }

    /// Reset or Delete of an instance.
    fn end(&mut self, place: usize, service: ServiceCode) -> Result<(), Failure> {
        let is_reset = service == ServiceCode::RESET;
        let is_io = self.device.slots.get(place).and_then(Slot::io_state).is_some();
        Ok(match (is_io, is_reset) {
            (true, true) => self.device.io_step(place, IoCause::Reset),
            (true, false) => self.device.io_step(place, IoCause::Released),
            (false, true) => self.device.explicit_step(place, ExplicitCause::Reset),
            (false, false) => self.device.explicit_step(place, ExplicitCause::Released),
        }?)
    }

    /// The service of the class: what an instance cannot do is passed over.
    fn each(&mut self, service: ServiceCode) {
        for place in 0..CONNECTIONS {
            let _ = self.end(place, service);
        }
    }
}

/// A connection that is read.
struct Instance<'a, A: Application, const MESSAGE: usize, const CONNECTIONS: usize> {
    device: &'a Device<A, MESSAGE, CONNECTIONS>,
    slot: &'a Slot<A::Long, MESSAGE>,
    settings: &'a Settings,
    consumed_size: usize,
}

impl<A: Application, const MESSAGE: usize, const CONNECTIONS: usize> Instance<'_, A, MESSAGE, CONNECTIONS> {
    fn produced(&self) -> Option<Identifier> {
        self.slot.produced(self.device.access.address())
    }

    fn consumed(&self) -> Option<Identifier> {
        self.slot.consumed(self.device.access.address())
    }

    fn path(&self, end: End, is_used: bool) -> ConnectionPath {
        let io = self.slot.io_state().filter(|_| is_used);
        let assembly = io.and_then(|_| self.device.application.assembly(self.slot.connection(), end));
        assembly.map_or(ConnectionPath::Empty, ConnectionPath::Assembly)
    }
}

impl<A: Application, const MESSAGE: usize, const CONNECTIONS: usize> ConnectionView
    for Instance<'_, A, MESSAGE, CONNECTIONS>
{
    type Id = ConnectionId;

    fn state(&self) -> ConnectionState {
        self.slot.state()
    }

    fn instance_type(&self) -> InstanceType {
        if self.slot.io_state().is_some() { InstanceType::IO } else { InstanceType::EXPLICIT }
    }

    fn transport_class_trigger(&self) -> TransportClassTrigger {
        self.slot.io_trigger().unwrap_or(Predefined::Explicit.transport_class_trigger())
    }

    fn produced_id(&self) -> ConnectionId {
        self.produced().into()
    }

    fn consumed_id(&self) -> ConnectionId {
        self.consumed().into()
    }

    /// In each half the group of the identifier, 0xF for none **\[D\]**.
    fn comm_characteristics(&self) -> CommCharacteristics {
        CommCharacteristics(group(self.produced()) << 4 | group(self.consumed()))
    }

    fn produced_size(&self) -> u16 {
        match &self.slot.body {
            Body::Io(io) if io.produces() && !io.only_acknowledges() => {
                self.device.application.produced_size(self.slot.connection())
            }
            Body::Io(_) | Body::Free => 0,
            Body::Explicit(_) => short(MESSAGE),
        }
    }

    fn consumed_size(&self) -> u16 {
        short(if self.slot.io_state().is_some() { self.consumed_size } else { MESSAGE })
    }

    fn settings(&self) -> &Settings {
        self.settings
    }

    fn produced_path(&self) -> ConnectionPath {
        self.path(End::Produced, self.produced_size() != 0)
    }

    fn consumed_path(&self) -> ConnectionPath {
        let is_acknowledged = self.slot.io_trigger().is_some_and(|trigger| !trigger.is_server());
        match self.consumed() {
            Some(_) if is_acknowledged => ConnectionPath::AcknowledgeHandler,
            consumed => self.path(End::Consumed, consumed.is_some()),
        }
    }
}

/// The Group Select code of an identifier.
fn group(identifier: Option<Identifier>) -> u8 {
    match identifier.map(Identifier::layout) {
        Some(Layout::Implicit { .. }) => GroupSelect::IMPLICIT_29.number(),
        Some(Layout::Explicit { .. }) => GroupSelect::EXPLICIT_29.number(),
        Some(Layout::Standard { group, .. }) => GroupSelect::from(group).number(),
        _ => 0xF,
    }
}

/// A dynamic connection takes what makes it what it is while it is being configured only; the others are made already.
fn check_configuring(connection: ConnectionInstance, state: IoState) -> Result<(), Failure> {
    if matches!(connection, ConnectionInstance::Dynamic(_)) && state != IoState::Configuring {
        return Err(GeneralStatus::OBJECT_STATE_CONFLICT.into());
    }
    Ok(())
}

/// A size in an attribute.
fn short(size: usize) -> u16 {
    u16::try_from(size).unwrap_or(u16::MAX)
}

/// What an instance of its kind and in its state does not let be set is refused by [`set`](ConnectionObject::set), before
/// it looks at the length.
const RULES: &[AttributeRule] = &[
    AttributeRule::get(1, 1),
    AttributeRule::get(2, 1),
    AttributeRule::get_set(3, 1).sized(Size::Any),
    AttributeRule::get(4, 4),
    AttributeRule::get_set(5, 4).sized(Size::Any),
    AttributeRule::get(6, 1),
    AttributeRule::get(7, 2),
    AttributeRule::get(8, 2),
    AttributeRule::get_set(9, 2),
    AttributeRule::get_set(12, 1),
    AttributeRule::get(13, 2),
    AttributeRule::get_set(14, 0).sized(Size::Any),
    AttributeRule::get(15, 2),
    AttributeRule::get_set(16, 0).sized(Size::Any),
    AttributeRule::get_set(17, 2).sized(Size::Any),
    AttributeRule::get_set(18, 1),
];
const GONE: Failure = Failure::new(GeneralStatus::OBJECT_DOES_NOT_EXIST);
const NOT_SETTABLE: Failure = Failure::new(GeneralStatus::ATTRIBUTE_NOT_SETTABLE);
const NOT_SUPPORTED: Failure = Failure::new(GeneralStatus::SERVICE_NOT_SUPPORTED);
const INVALID: Failure = Failure::new(GeneralStatus::INVALID_ATTRIBUTE_VALUE);
