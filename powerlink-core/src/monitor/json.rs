//! Readings as one flat object.

use link_core::recording::json::{Words, optional};
use link_core::text::LowerHex;
use serde::ser::{Serialize, SerializeMap, Serializer};

use super::{Kind, Note, Reading};
use crate::wire::{Body, Flags, IdentResponse, NodeList, SdoCommand, Segmentation, StatusResponse};
use crate::{NodeId, fields};

/// The fields that the decoder adds to those of the captured frame (time, number, length, data), absent ones left out:
///
/// `protocol`, `src`, `dst`, `src_mac`, `dst_mac`, `vlan`, `ethertype` (of another protocol), `kind`, `nmt_state`, `flags`,
/// `priority`, `waiting`, `value`, `cycle` { `interval`, `net_time`, `relative_time` }, `requested_service`, `target`,
/// `asnd_service`, `nmt_command`, `reason`, `nodes`, `identity` {..}, `errors` [..], `sdo` {..}, `message`,
/// `request` { `n`, `latency` in seconds }, `problem`, `problem_code`, `note`, `text`.
impl Serialize for Reading<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        let protocol = if self.kind == Kind::Foreign { "unknown" } else { "powerlink" };
        map.serialize_entry("protocol", protocol)?;
        optional(&mut map, "src", self.src)?;
        optional(&mut map, "dst", self.dst)?;
        if let Some(envelope) = &self.envelope {
            map.serialize_entry("src_mac", &Words(envelope.source))?;
            map.serialize_entry("dst_mac", &Words(envelope.destination))?;
            optional(&mut map, "vlan", envelope.vlan)?;
            optional(&mut map, "ethertype", Some(envelope.ethertype).filter(|_| !envelope.is_powerlink()))?;
        }
        map.serialize_entry("kind", &self.kind)?;
        optional(&mut map, "nmt_state", self.state().map(Words))?;
        self.body_fields(&mut map)?;
        optional(&mut map, "value", self.value().map(|value| Words(LowerHex(value))))?;
        optional(&mut map, "interval", self.interval.map(|interval| interval.as_secs_f64()))?;
        optional(&mut map, "message", self.message.map(|message| Words(LowerHex(message.data))))?;
        optional(&mut map, "request", self.request)?;
        optional(&mut map, "problem", self.problem)?;
        optional(&mut map, "problem_code", self.problem.map(|problem| problem.code()))?;
        optional(&mut map, "note", self.note)?;
        map.serialize_entry("text", &Words(self))?;
        map.end()
    }
}

impl Reading<'_> {
    fn body_fields<M: SerializeMap>(&self, map: &mut M) -> Result<(), M::Error> {
        match &self.body {
            Some(Body::Soc(soc)) => {
                map.serialize_entry("flags", &SOC.of(soc.flags))?;
                map.serialize_entry("relative_time", &soc.relative_time)
            }
            Some(Body::Preq(preq)) => map.serialize_entry("flags", &PREQ.of(preq.flags)),
            Some(Body::Pres(pres)) => {
                map.serialize_entry("flags", &PRES.of(pres.flags))?;
                waiting(map, pres.request)
            }
            Some(Body::Soa(soa)) => {
                map.serialize_entry("flags", &SOA.of(soa.flags))?;
                map.serialize_entry("requested_service", &Words(soa.service))?;
                optional(map, "target", Some(soa.target).filter(|target| *target != NodeId::NONE))
            }
            Some(Body::IdentResponse(ident)) => {
                waiting(map, ident.request)?;
                map.serialize_entry("identity", &IdentityFields(ident))
            }
            Some(Body::StatusResponse(status)) => {
                map.serialize_entry("flags", &STATUS.of(status.flags))?;
                waiting(map, status.request)?;
                map.serialize_entry("errors", &Errors(status))
            }
            Some(Body::NmtRequest(request)) => {
                map.serialize_entry("nmt_command", &Words(request.command))?;
                map.serialize_entry("target", &request.target)
            }
            Some(Body::NmtCommand(command)) => {
                map.serialize_entry("nmt_command", &Words(command.command))?;
                optional(map, "reason", command.reason().map(Words))?;
                let nodes = command.command.is_extended().then(|| Nodes(NodeList::of(command.data)));
                optional(map, "nodes", nodes)
            }
            Some(Body::Sdo(sdo)) => {
                map.serialize_entry("sequence", &Words(sdo.sequence))?;
                let fields = sdo.command.as_ref().map(|command| SdoFields { reading: self, command });
                optional(map, "sdo", fields)
            }
            Some(Body::OtherAsnd(service, _)) => map.serialize_entry("asnd_service", &Words(service)),
            Some(Body::Other(message_type, _)) => map.serialize_entry("message_type", &message_type),
            None => Ok(()),
        }
    }
}

/// The flags that a message uses.
struct FlagNames(&'static [(Flags, &'static str)]);

impl FlagNames {
    const fn of(&self, flags: Flags) -> SetFlags {
        SetFlags(self.0, flags)
    }
}

/// The names of those that are set.
struct SetFlags(&'static [(Flags, &'static str)], Flags);

impl Serialize for SetFlags {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(names, flags) = self;
        serializer.collect_seq(names.iter().filter(|(flag, _)| flags.contains(*flag)).map(|(_, name)| name))
    }
}

struct Nodes(NodeList);

impl Serialize for Nodes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq((0..=u8::MAX).filter(|&node| self.0.contains(NodeId(node))))
    }
}

struct Errors<'a>(&'a StatusResponse);

impl Serialize for Errors<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.errors().map(|entry| Words(entry.code)))
    }
}

/// The fields of an IdentResponse that tell who a node is: `vendor`, `product`, `revision`, `serial`, `device_type`, `features`,
/// `poll_in_size`, `poll_out_size`, `response_time` in seconds, `ip`.
#[derive(Debug, Clone, Copy)]
pub struct IdentityFields<'a>(pub &'a IdentResponse);

impl Serialize for IdentityFields<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let ident = self.0;
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("vendor", &ident.identity.vendor_id)?;
        map.serialize_entry("product", &ident.identity.product_code)?;
        map.serialize_entry("revision", &Words(ident.identity.revision()))?;
        map.serialize_entry("serial", &ident.identity.serial_number)?;
        map.serialize_entry("device_type", &ident.device_type)?;
        map.serialize_entry("features", &ident.features.bits())?;
        map.serialize_entry("poll_in_size", &ident.poll_in_size)?;
        map.serialize_entry("poll_out_size", &ident.poll_out_size)?;
        map.serialize_entry(
            "response_time",
            &core::time::Duration::from_nanos(ident.response_time.into()).as_secs_f64(),
        )?;
        map.serialize_entry("ip", &Words(ident.ip.address))?;
        map.end()
    }
}

struct SdoFields<'a> {
    reading: &'a Reading<'a>,
    command: &'a SdoCommand<'a>,
}

impl Serialize for SdoFields<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { reading, command } = self;
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("command", &Words(command.command))?;
        map.serialize_entry("response", &command.is_response)?;
        map.serialize_entry("transaction", &command.transaction)?;
        reading.object.map_or(Ok(()), |at| fields::object(&mut map, at))?;
        optional(&mut map, "name", reading.object_name())?;
        let (part, total) = match command.segmentation {
            Segmentation::Expedited => (None, None),
            Segmentation::Initiate { total } => (Some("first"), Some(total)),
            Segmentation::Segment => (Some("middle"), None),
            Segmentation::Complete => (Some("last"), None),
        };
        optional(&mut map, "part", part)?;
        optional(&mut map, "total", total)?;
        command.abort().map_or(Ok(()), |code| fields::abort(&mut map, code))?;
        map.end()
    }
}

impl Serialize for Note {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// What waits for the asynchronous slot.
fn waiting<M: SerializeMap>(map: &mut M, request: crate::wire::AsyncRequest) -> Result<(), M::Error> {
    if request.count() == 0 {
        return Ok(());
    }
    map.serialize_entry("waiting", &request.count())?;
    map.serialize_entry("priority", &request.priority())
}

const SOC: FlagNames = FlagNames(&[(Flags::MULTIPLEXED_CYCLE, "MC"), (Flags::PRESCALED, "PS")]);
const PREQ: FlagNames =
    FlagNames(&[(Flags::MULTIPLEXED, "MS"), (Flags::EXCEPTION_ACKNOWLEDGE, "EA"), (Flags::DATA_VALID, "RD")]);
const PRES: FlagNames =
    FlagNames(&[(Flags::MULTIPLEXED, "MS"), (Flags::EXCEPTION_NEW, "EN"), (Flags::DATA_VALID, "RD")]);
const SOA: FlagNames = FlagNames(&[(Flags::EXCEPTION_ACKNOWLEDGE, "EA"), (Flags::EXCEPTION_RESET, "ER")]);
const STATUS: FlagNames = FlagNames(&[(Flags::EXCEPTION_NEW, "EN"), (Flags::EXCEPTION_CLEAR, "EC")]);
