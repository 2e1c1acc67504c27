//! The Acknowledge Handler object (class 0x2B).

use super::{AttributeRule, Effect, Effects, Failure, Object, Size, exact};
use crate::code::{AttributeId, ClassId, GeneralStatus, InstanceId};
use crate::codec::{Full, Writer};

/// What can be set in the Acknowledge Handler, for its owner to keep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AcknowledgeSettings {
    /// Attribute 1, in ms: how long an acknowledge is waited for. Default: 16.
    pub timer: u16,
    /// Attribute 2: how often a message is sent again. Default: 1.
    pub retry_limit: u8,
    /// Attribute 3: the connection whose messages are acknowledged. Default: 4.
    pub producer: InstanceId,
}

/// Instance 1 of the Acknowledge Handler: how a change-of-state or cyclic producer treats the acknowledges of its
/// messages.
///
/// | Attribute | Value | Access |
/// |---|---|---|
/// | 1 | acknowledge timer in ms, UINT, 1-65535 | Get and Set |
/// | 2 | retry limit, USINT | Get and Set |
/// | 3 | instance of the producing connection, UINT | Get; Set while the connection is not established |
/// | 4-7 | | Get, with [`AcknowledgeLists`] |
///
/// A timer of 0 and a connection that cannot be the producer are 0x09, a Set of attribute 3 in the established state
/// 0x0C. The timer is rounded up to the resolution of the device. Class attribute 1 (revision) is 1. Add_AckData_Path
/// and Remove_AckData_Path are not offered: 0x08. Source: CIP Vol. 1, chapter 5; product manuals.
///
/// ```
/// use cip_core::code::{ClassId, InstanceId, ServiceCode};
/// use cip_core::codec::Writer;
/// use cip_core::object::{AcknowledgeHandler, AcknowledgeSettings, Call, FailureOptions, respond};
///
/// let mut settings = AcknowledgeSettings::default();
/// let mut handler = AcknowledgeHandler::new(&mut settings);
/// handler.resolution = 10;
///
/// let set = Call::new(ServiceCode::SET_ATTRIBUTE_SINGLE, ClassId::ACKNOWLEDGE_HANDLER, InstanceId(1), &[1, 25, 0]);
/// let mut buffer = [0; 8];
/// let mut out = Writer::new(&mut buffer);
/// respond(&mut (handler,), &set, FailureOptions::default(), &mut out).map_err(|_| "refused")?;
/// assert_eq!(out.written(), [0x90, 30, 0]);
/// assert_eq!(settings.timer, 30);
/// # Ok::<(), &str>(())
/// ```
#[derive(Debug, PartialEq, Eq, Hash)]
pub struct AcknowledgeHandler<'a> {
    /// Attributes 1-3.
    pub settings: &'a mut AcknowledgeSettings,
    /// The resolution of the timer in ms; 0 is taken as 1. Default: 1.
    pub resolution: u16,
    /// Whether a Set of attribute 1 is answered with the value used, as a Set of a packet rate is. Default: yes.
    pub timer_in_response: bool,
    /// Whether the connection of attribute 3 is established. Default: no.
    pub established: bool,
    /// The connections that attribute 3 can name. Default: instance 4, of the predefined connection set.
    pub producers: &'a [InstanceId],
}

/// The same with the lists, which a small device does without.
///
/// | Attribute | Value | Access |
/// |---|---|---|
/// | 1-3 | as [`AcknowledgeHandler`] | |
/// | 4 | size of the list of attribute 5, BYTE | Get |
/// | 5 | BYTE count, UINT connection instance each | Get |
/// | 6 | size of the list of attribute 7, BYTE | Get, if there |
/// | 7 | BYTE count, [`AcknowledgePath`] each | Get, if there |
#[derive(Debug, PartialEq, Eq, Hash)]
pub struct AcknowledgeLists<'a> {
    /// Attributes 1-3.
    pub handler: AcknowledgeHandler<'a>,
    /// Attributes 4 and 5: the connections that consume acknowledges.
    pub acknowledges: &'a [InstanceId],
    /// Attributes 6 and 7, if the device has them: where data that come with an acknowledge go.
    pub data_paths: Option<&'a [AcknowledgePath<'a>]>,
}

/// Where data that come with an acknowledge go (attribute 7).
///
/// | Byte | Content |
/// |---|---|
/// | 0-1 | instance of the connection, UINT |
/// | 2 | length of the path in bytes, USINT |
/// | 3.. | packed path |
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AcknowledgePath<'a> {
    /// The connection.
    pub connection: InstanceId,
    /// The packed path.
    pub path: &'a [u8],
}

impl Default for AcknowledgeSettings {
    fn default() -> Self {
        Self { timer: 16, retry_limit: 1, producer: PREDEFINED }
    }
}

impl<'a> AcknowledgeHandler<'a> {
    /// The object of a device with the predefined connection set, whose timer counts
    /// milliseconds.
    pub const fn new(settings: &'a mut AcknowledgeSettings) -> Self {
        Self {
            settings,
            resolution: 1,
            timer_in_response: true,
            established: false,
            producers: &[PREDEFINED],
        }
    }

    fn set_timer(&mut self, value: &[u8], out: &mut Writer<'_>) -> Result<(), Failure> {
        let timer = match u16::from_le_bytes(exact(value)?) {
            0 => return Err(GeneralStatus::INVALID_ATTRIBUTE_VALUE.into()),
            timer => rounded_up(timer, self.resolution),
        };
        if self.timer_in_response {
            out.u16(timer)?;
        }
        self.settings.timer = timer;
        Ok(())
    }

    fn set_producer(&mut self, value: &[u8]) -> Result<(), Failure> {
        let producer = InstanceId(u16::from_le_bytes(exact(value)?));
        if !self.producers.contains(&producer) {
            return Err(GeneralStatus::INVALID_ATTRIBUTE_VALUE.into());
        }
        if self.established {
            return Err(GeneralStatus::OBJECT_STATE_CONFLICT.into());
        }
        self.settings.producer = producer;
        Ok(())
    }
}

impl Object for AcknowledgeHandler<'_> {
    const CLASS: ClassId = ClassId::ACKNOWLEDGE_HANDLER;

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        if instance.0 == 1 { RULES.get(..3) } else { None }
    }

    fn get(&self, _: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        match attribute.0 {
            1 => out.u16(self.settings.timer),
            2 => out.u8(self.settings.retry_limit),
            _ => out.u16(self.settings.producer.0),
        }?;
        Ok(())
    }

    fn set(
        &mut self,
        _: InstanceId,
        attribute: AttributeId,
        value: &[u8],
        out: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        match attribute.0 {
            1 => self.set_timer(value, out)?,
            2 => [self.settings.retry_limit] = exact(value)?,
            _ => self.set_producer(value)?,
        }
        Ok(Effect::ACKNOWLEDGE.into())
    }
}

impl Object for AcknowledgeLists<'_> {
    const CLASS: ClassId = ClassId::ACKNOWLEDGE_HANDLER;

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        let count = if self.data_paths.is_some() { 7 } else { 5 };
        if instance.0 == 1 { RULES.get(..count) } else { None }
    }

    fn get(&self, instance: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        let data_paths = self.data_paths.unwrap_or_default();
        match attribute.0 {
            4 => emit_count(self.acknowledges, out),
            5 => {
                emit_count(self.acknowledges, out)?;
                self.acknowledges.iter().try_for_each(|connection| out.u16(connection.0))
            }
            6 => emit_count(data_paths, out),
            7 => {
                emit_count(data_paths, out)?;
                data_paths.iter().try_for_each(|path| path.emit(out))
            }
            _ => return self.handler.get(instance, attribute, out),
        }?;
        Ok(())
    }

    fn set(
        &mut self,
        instance: InstanceId,
        attribute: AttributeId,
        value: &[u8],
        out: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        self.handler.set(instance, attribute, value, out)
    }
}

impl AcknowledgePath<'_> {
    fn emit(&self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u16(self.connection.0)?;
        emit_count(self.path, out)?;
        out.bytes(self.path)
    }
}

/// The next multiple of `resolution`, or the highest there is.
fn rounded_up(value: u16, resolution: u16) -> u16 {
    let Some(over @ 1..) = value.checked_rem(resolution) else { return value };
    let below = value.saturating_sub(over);
    below.checked_add(resolution).unwrap_or(below)
}

fn emit_count<T>(list: &[T], out: &mut Writer<'_>) -> Result<(), Full> {
    out.u8(u8::try_from(list.len()).map_err(|_| Full)?)
}

const RULES: &[AttributeRule] = &[
    AttributeRule::get_set(1, 2),
    AttributeRule::get_set(2, 1),
    AttributeRule::get_set(3, 2),
    AttributeRule::get(4, 1),
    AttributeRule::get(5, 0).sized(Size::Any),
    AttributeRule::get(6, 1),
    AttributeRule::get(7, 0).sized(Size::Any),
];

/// The change-of-state or cyclic connection of the predefined set.
const PREDEFINED: InstanceId = InstanceId(4);
