//! The Connection object (class 5).

use cip_core::code::{AttributeId, ClassId, GeneralStatus, InstanceId, ServiceCode};
use cip_core::codec::Writer;
use cip_core::connection::{
    ConnectionView, ExplicitCause, ExplicitConnection, ExplicitState, IoCause, IoConnection, IoState,
    PredefinedConnection, TimeoutMultiplier, WatchdogAction,
};
use cip_core::epath::Epath;
use cip_core::object::{Call, Failure, exact, find_next_instance};

use super::application::{Application, End, IoKind, Parts};
use super::config::Options;
use super::connection_view::Instance;
use super::dynamic::FIRST_INSTANCE;
use super::io::LongMessages;
use super::machine::changes;
use super::node::Changed;
use super::server::Server;
use crate::id::{Identifier, MessageGroup};

/// The object, put together for one request.
pub(super) struct ConnectionObject<'s, 'a, A: Application, const MESSAGE: usize, const DYNAMIC: usize> {
    pub(super) server: &'s mut Server<'a, A, MESSAGE, DYNAMIC>,
}

/// An instance that exists.
#[derive(Clone, Copy)]
pub(super) enum Which {
    Explicit,
    Io(IoKind),
    Dynamic(u8),
}

/// What an instance allows says [`ConnectionView`]; which of it can be set depends on the state:
///
/// | Attribute | Configuring | Established, timed out | Explicit |
/// |---|---|---|---|
/// | 1-4, 6-8, 13, 15 | Get | Get | Get |
/// | 5 | Get; Set on instance 5 | Get | Get |
/// | 9, 12 | Get, Set | Get, Set | Get, Set |
/// | 14, 16 | Get; Set if the application selects assemblies | Get; Set is 0x0C | Get |
/// | 17 | Get, Set | Get, Set | Get |
/// | 18 | Get, Set | Get, Set | Get, Set |
///
/// | Service | Class | Instance |
/// |---|---|---|
/// | 0x05 Reset | every instance | yes |
/// | 0x09 Delete | every instance | yes |
/// | 0x0D Apply_Attributes | | I/O |
/// | 0x0E, 0x10 | Get of the revision, 1 | yes |
/// | 0x11 Find_Next_Object_Instance | yes | yes |
///
/// Of these, a slave without [`Parts::OPTIONAL_SERVICES`] has Get, Set and the Reset of an instance, if it has no dynamic
/// connections either.
impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize>
    ConnectionObject<'_, '_, A, MESSAGE, DYNAMIC>
{
    fn next_instance(&self, instance: InstanceId) -> Option<InstanceId> {
        let last = u16::from(FIRST_INSTANCE).saturating_add(u16::try_from(DYNAMIC).unwrap_or(u16::MAX));
        (instance.0.saturating_add(1)..last).map(InstanceId).find(|&next| self.server.which(next).is_some())
    }

    #[inline(never)]
    pub(super) fn get(
        &mut self,
        call: &Call<'_>,
        attribute: AttributeId,
        out: &mut Writer<'_>,
    ) -> Result<(), Failure> {
        let Some(which) = self.server.which(call.instance) else {
            return if attribute.0 == 1 { Ok(out.u8(0)?) } else { Err(ABSENT) };
        };
        if matches!(attribute.0, 17 | 18) && !has_optional_attributes::<A>() {
            return Err(ABSENT);
        }
        let consumed_size = self.server.consumed_size(call);
        Ok(Instance { object: self, which, consumed_size }.get(attribute, out)?)
    }

    pub(super) fn set(
        &mut self,
        instance: InstanceId,
        attribute: AttributeId,
        value: &[u8],
        out: &mut Writer<'_>,
    ) -> Result<(), Failure> {
        let which = self.server.which(instance).ok_or(GONE)?;
        match attribute.0 {
            5 => self.set_multicast_group(which, value)?,
            9 => {
                let requested = u16::from_le_bytes(exact(value)?);
                let used = self.server.node.set_packet_rate(which, requested)?;
                out.u16(used)?;
            }
            12 => {
                let [action] = exact(value)?;
                let allowed: &[_] = match which {
                    Which::Explicit | Which::Dynamic(_) => &ExplicitConnection::ACTIONS,
                    Which::Io(_) => &IoConnection::<PredefinedConnection>::ACTIONS,
                };
                self.server.node.settings_mut(which)?.set_watchdog_action(WatchdogAction(action), allowed)?;
            }
            14 => self.select(which, End::Produced, value)?,
            16 => self.select(which, End::Consumed, value)?,
            _ if !has_optional_attributes::<A>() => return Err(NOT_SETTABLE),
            17 => {
                let Which::Io(kind) = which else { return Err(NOT_SETTABLE) };
                let millis = u16::from_le_bytes(exact(value)?);
                self.server.node.io_mut(kind).settings_mut().set_production_inhibit_time(millis)?;
                if self.server.node.options.contains(Options::ANSWER_INHIBIT_TIME) {
                    out.u16(millis)?;
                }
            }
            18 => {
                let [code] = exact(value)?;
                self.server.node.settings_mut(which)?.set_multiplier(TimeoutMultiplier(code))?;
            }
            _ => return Err(NOT_SETTABLE),
        }
        Ok(())
    }

    pub(super) fn service(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<(), Failure> {
        match call.service {
            ServiceCode::RESET if !call.instance.is_class() => {
                call.no_data()?;
                self.reset(self.server.which(call.instance).ok_or(GONE)?)?;
            }
            _ if !A::PARTS.contains(Parts::OPTIONAL_SERVICES) && DYNAMIC == 0 => return Err(NOT_SUPPORTED),
            ServiceCode::RESET | ServiceCode::DELETE if call.instance.is_class() => {
                call.no_data()?;
                self.each(call.service);
            }
            ServiceCode::DELETE => {
                call.no_data()?;
                self.delete(self.server.which(call.instance).ok_or(GONE)?)?;
            }
            ServiceCode::APPLY_ATTRIBUTES => {
                let Some(Which::Io(kind)) = self.server.which(call.instance) else {
                    return Err(NOT_SUPPORTED);
                };
                call.no_data()?;
                self.server.node.io_step(kind, IoCause::Applied)?;
            }
            ServiceCode::FIND_NEXT_OBJECT_INSTANCE => {
                // It only reads.
                let _ = find_next_instance(|instance| self.next_instance(instance), call, out)?;
            }
            _ => return Err(NOT_SUPPORTED),
        }
        Ok(())
    }

    /// Attribute 5 of instance 5: the group whose command is consumed, while the connection is being configured.
    fn set_multicast_group(&mut self, which: Which, value: &[u8]) -> Result<(), Failure> {
        let Which::Io(kind) = which else { return Err(NOT_SETTABLE) };
        let kind = kind.known::<A>();
        if kind != IoKind::MulticastPoll || self.server.node.io(kind).state() != IoState::Configuring {
            return Err(NOT_SETTABLE);
        }
        let id = u16::from_le_bytes(exact(value)?);
        let group = Identifier::new(id)
            .filter(|id| id.group() == MessageGroup::Group2 && id.message_id() == 1)
            .and_then(Identifier::mac_id)
            .ok_or(Failure::new(GeneralStatus::INVALID_ATTRIBUTE_VALUE))?;
        self.server.node.group = group;
        self.server.node.changed.insert(Changed::FILTER);
        Ok(())
    }

    /// Attributes 14 and 16: the path of another assembly.
    fn select(&mut self, which: Which, end: End, value: &[u8]) -> Result<(), Failure> {
        let Which::Io(kind) = which else { return Err(NOT_SETTABLE) };
        if !A::SELECTS_ASSEMBLIES {
            return Err(NOT_SETTABLE);
        }
        if self.server.node.io(kind).state() != IoState::Configuring {
            return Err(GeneralStatus::OBJECT_STATE_CONFLICT.into());
        }
        let path = Epath::packed(value).logical()?;
        let assembly = path.instance.filter(|_| path.class == Some(ClassId::ASSEMBLY));
        let before = self.server.node.application.assembly(kind, end);
        let selected = assembly
            .is_some_and(|assembly| self.server.node.application.select_assembly(kind, end, assembly));
        if !selected {
            return Err(GeneralStatus::INVALID_ATTRIBUTE_VALUE.into());
        }
        let size = usize::from(self.server.node.application.produced_size(kind))
            .max(self.server.node.application.consumed(kind).len());
        if size > A::Long::CAPACITY {
            // The one before was good enough.
            let _ = before.map(|assembly| self.server.node.application.select_assembly(kind, end, assembly));
            return Err(GeneralStatus::INVALID_ATTRIBUTE_VALUE.into());
        }
        Ok(())
    }

    fn reset(&mut self, which: Which) -> Result<(), Failure> {
        match which {
            Which::Explicit => self.server.node.explicit_step(ExplicitCause::Reset)?,
            // Nobody owns the slave any more: the data would flow for nobody.
            Which::Io(_) if self.server.node.master.is_none() => {
                return Err(GeneralStatus::OBJECT_STATE_CONFLICT.into());
            }
            Which::Io(kind) => self.server.node.io_step(kind, IoCause::Reset)?,
            Which::Dynamic(index) => self.server.node.dynamic_step(index, ExplicitCause::Reset)?,
        }
        Ok(())
    }

    fn delete(&mut self, which: Which) -> Result<(), Failure> {
        match which {
            Which::Explicit => self.server.node.explicit_step(ExplicitCause::Released)?,
            Which::Io(kind) => self.server.node.io_step(kind, IoCause::Released)?,
            Which::Dynamic(index) => self.server.node.dynamic_step(index, ExplicitCause::Released)?,
        }
        self.server.node.allocation_changed();
        Ok(())
    }

    /// The service of the class: what an instance cannot do is passed over.
    fn each(&mut self, service: ServiceCode) {
        let mut instance = InstanceId::CLASS;
        while let Some(next) = self.next_instance(instance) {
            if let Some(which) = self.server.which(next) {
                let _ = if service == ServiceCode::RESET { self.reset(which) } else { self.delete(which) };
            }
            instance = next;
        }
    }
}

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Server<'_, A, MESSAGE, DYNAMIC> {
    pub(super) fn which(&self, instance: InstanceId) -> Option<Which> {
        if instance.0 == 1 {
            return (self.node.explicit.state() != ExplicitState::NonExistent).then_some(Which::Explicit);
        }
        if let Some(kind) = IoKind::of_instance(instance).and_then(IoKind::offered::<A>) {
            return (self.node.io(kind).state() != IoState::NonExistent).then_some(Which::Io(kind));
        }
        let index = u8::try_from(instance.0.checked_sub(FIRST_INSTANCE.into())?).ok()?;
        self.node.is_open(index).then_some(Which::Dynamic(index))
    }

    /// Whether the instance exists, or can be asked for its state all the same.
    pub(super) fn is_connection(&self, instance: InstanceId) -> bool {
        self.which(instance).is_some()
            || (self.node.options.contains(Options::READ_NON_EXISTENT_STATE) && (1..=5).contains(&instance.0))
    }
}

/// Whether an instance has the attributes 17 and 18.
pub(super) const fn has_optional_attributes<A: Application>() -> bool {
    A::PARTS.contains(Parts::OPTIONAL_ATTRIBUTES) || changes::<A>()
}

pub(super) const GONE: Failure = Failure::new(GeneralStatus::OBJECT_DOES_NOT_EXIST);
const NOT_SETTABLE: Failure = Failure::new(GeneralStatus::ATTRIBUTE_NOT_SETTABLE);
const NOT_SUPPORTED: Failure = Failure::new(GeneralStatus::SERVICE_NOT_SUPPORTED);
const ABSENT: Failure = Failure::new(GeneralStatus::ATTRIBUTE_NOT_SUPPORTED);
