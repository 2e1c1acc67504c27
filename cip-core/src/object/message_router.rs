//! The Message Router object (class 0x02), and several requests in one.

use super::{AttributeRule, Call, Effects, Failure, FailureOptions, Object, ObjectSet, Size, respond, serve};
use crate::code::{AttributeId, ClassId, GeneralStatus, InstanceId, ServiceCode};
use crate::codec::{Full, Wire, Writer};
use crate::message::{BodyFormat, MultipleServicePacket, Request};

/// The Message Router of a small device: the class exists, and its instance 1 has no attributes (0x14).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MessageRouter;

/// A set of objects with a Message Router in front that tells about them.
///
/// | Attribute | Value | Access |
/// |---|---|---|
/// | 1 | object list: UINT count, UINT class each | Get |
/// | 2 | number of connections available, UINT | Get, if there |
/// | 3 | number of active connections, UINT | Get, if there |
/// | 4 | active connections, UINT each | Get, if there |
///
/// | Service | Answer |
/// |---|---|
/// | 0x0A Multiple_Service_Packet | as [`MultipleServicePacket`]: the responses, in the order of the requests |
///
/// The requests in a packet have the body format of their connection. A packet in a packet is refused (0x08), so that
/// the work is bounded by the length of the message. A packet whose response would have no room for the refusal of
/// each of its requests is refused as a whole before anything is done (0x11); a response without room is replaced by
/// that refusal. An error response cannot hold others, so that a packet with failures is a success, unless all its
/// requests have failed: 0x1E. Class attribute 1 (revision) is 1. Source: CIP Vol. 1, chapter 5 and appendix A.
///
/// ```
/// use cip_core::codec::Writer;
/// use cip_core::message::{BodyFormat, Request};
/// use cip_core::object::{Call, FailureOptions, Router, respond};
///
/// let mut router = Router::new((), BodyFormat::Class8Instance8);
/// // Twice attribute 1 of the Message Router.
/// let body = [0x0A, 2, 1, 2, 0, 6, 0, 10, 0, 0x0E, 2, 1, 1, 0x0E, 2, 1, 9];
/// let call = Call::of(&Request::parse(router.format, &body).map_err(|_| "request")?).map_err(|_| "path")?;
/// let mut buffer = [0; 32];
/// let mut out = Writer::new(&mut buffer);
/// respond(&mut router, &call, FailureOptions::default(), &mut out).map_err(|_| "refused")?;
/// assert_eq!(out.written(), [0x8A, 2, 0, 6, 0, 11, 0, 0x8E, 1, 0, 2, 0, 0x94, 0x14, 0xFF]);
/// # Ok::<(), &str>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Router<'a, S> {
    /// The objects.
    pub objects: S,
    /// The body format of the connection that the request comes from.
    pub format: BodyFormat,
    /// How requests in a packet are refused.
    pub options: FailureOptions,
    /// Attributes 2-4, if the device has them.
    pub connections: Option<RouterConnections<'a>>,
}

/// The connections of a device, as its Message Router tells of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RouterConnections<'a> {
    /// Attribute 2.
    pub available: u16,
    /// Attribute 4; their number is attribute 3.
    pub active: &'a [u16],
}

impl<S: ObjectSet> Router<'_, S> {
    /// A router without attributes 2-4.
    pub fn new(objects: S, format: BodyFormat) -> Self {
        Self { objects, format, options: FailureOptions::default(), connections: None }
    }

    fn packet(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Result<Effects, Failure> {
        call.check_path()?;
        let packet = MultipleServicePacket::parse(call.data)?;
        let count = packet.services().count();
        if out.remaining() < count.saturating_mul(OFFSET + REFUSAL).saturating_add(COUNT) {
            return Err(GeneralStatus::REPLY_DATA_TOO_LARGE.into());
        }
        let start = out.len();
        out.u16(u16::try_from(count).map_err(|_| Full)?)?;
        let mut offset_at = out.len();
        for _ in 0..count {
            out.u16(0)?;
        }
        let mut effects = Effects::NONE;
        let mut any = count == 0;
        let mut left = count;
        for request in packet.services() {
            left = left.saturating_sub(1);
            let at = out.len();
            let offset = u16::try_from(at.saturating_sub(start)).map_err(|_| Full)?;
            out.patch(offset_at, &offset.to_le_bytes())?;
            offset_at = offset_at.saturating_add(OFFSET);
            let answered = self.embedded(request, out);
            any |= answered.is_ok();
            effects = effects.then(answered.unwrap_or_default());
            if out.remaining() < left.saturating_mul(REFUSAL) {
                out.truncate(at);
                Failure::new(GeneralStatus::REPLY_DATA_TOO_LARGE).emit(out)?;
            }
        }
        if any { Ok(effects) } else { Err(GeneralStatus::EMBEDDED_SERVICE_ERROR.into()) }
    }

    /// Writes the response to one request of a packet.
    fn embedded(&mut self, request: &[u8], out: &mut Writer<'_>) -> Result<Effects, Failure> {
        let request = Request::parse(self.format, request).map_err(Failure::from);
        match request.and_then(|request| Call::of(&request)) {
            Ok(call) => {
                let front = Front { classes: &self.objects, connections: self.connections };
                if call.class == ClassId::MESSAGE_ROUTER {
                    return respond(&mut (front,), &call, self.options, out);
                }
                respond(&mut self.objects, &call, self.options, out)
            }
            Err(failure) => {
                failure.emit(out)?;
                Err(failure)
            }
        }
    }
}

impl<S: ObjectSet> ObjectSet for Router<'_, S> {
    fn serve(&mut self, call: &Call<'_>, out: &mut Writer<'_>) -> Option<Result<Effects, Failure>> {
        if call.class != ClassId::MESSAGE_ROUTER {
            return self.objects.serve(call, out);
        }
        let packet = call.service == ServiceCode::MULTIPLE_SERVICE_PACKET && call.instance == FIRST;
        if !packet {
            let mut front = Front { classes: &self.objects, connections: self.connections };
            return Some(serve(&mut front, call, out));
        }
        Some(self.packet(call, out))
    }

    fn classes(&self) -> impl Iterator<Item = ClassId> {
        own_and(&self.objects)
    }
}

impl Object for MessageRouter {
    const CLASS: ClassId = ClassId::MESSAGE_ROUTER;

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        (instance == FIRST).then_some(&[])
    }

    fn get(&self, _: InstanceId, _: AttributeId, _: &mut Writer<'_>) -> Result<(), Failure> {
        Err(GeneralStatus::ATTRIBUTE_NOT_SUPPORTED.into())
    }
}

/// The object in front of a set: it looks at the classes, and so cannot be part of the set.
pub(super) struct Front<'a, S> {
    pub(super) classes: &'a S,
    pub(super) connections: Option<RouterConnections<'a>>,
}

impl<S: ObjectSet> Object for Front<'_, S> {
    const CLASS: ClassId = ClassId::MESSAGE_ROUTER;

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        let count = if self.connections.is_some() { 4 } else { 1 };
        if instance == FIRST { RULES.get(..count) } else { None }
    }

    fn get(&self, _: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        if attribute.0 == 1 {
            let count = u16::try_from(own_and(self.classes).count()).map_err(|_| Full)?;
            out.u16(count)?;
            return Ok(own_and(self.classes).try_for_each(|class| out.u16(class.0))?);
        }
        let connections = self.connections.ok_or(Failure::new(GeneralStatus::ATTRIBUTE_NOT_SUPPORTED))?;
        match attribute.0 {
            2 => out.u16(connections.available),
            3 => out.u16(u16::try_from(connections.active.len()).map_err(|_| Full)?),
            _ => connections.active.iter().try_for_each(|&connection| out.u16(connection)),
        }?;
        Ok(())
    }
}

/// The class of the router, then those of the objects.
fn own_and<S: ObjectSet>(objects: &S) -> impl Iterator<Item = ClassId> {
    let others = objects.classes().filter(|&class| class != ClassId::MESSAGE_ROUTER);
    core::iter::once(ClassId::MESSAGE_ROUTER).chain(others)
}

const RULES: &[AttributeRule] = &[
    AttributeRule::get(1, 0).sized(Size::Any),
    AttributeRule::get(2, 2),
    AttributeRule::get(3, 2),
    AttributeRule::get(4, 0).sized(Size::Any),
];
const FIRST: InstanceId = InstanceId(1);

/// The number of responses in a packet takes two bytes, the offset of a response two, a refusal three.
const COUNT: usize = 2;
const OFFSET: usize = 2;
const REFUSAL: usize = 3;
