//! Names and meanings of the values in a message.

use std::collections::HashMap;

use cip_core::code::{AttributeId, ClassId, InstanceId};
use cip_core::codec::Reader;
use cip_core::eds::{Assembly, Eds, IoData, IoInfo, Param, Slot, whole_number};
use cip_core::scan::IoType;
use cip_core::text::Hex;
use devicenet_core::monitor::{Fields, Kind, Predefined};
use serde::Serialize;

use super::Node;

/// Which way values go.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Flow {
    /// From the slave, as I/O.
    Produced,
    /// To the slave, as I/O.
    Consumed,
    /// From the slave, in a response.
    Answer,
    /// To the slave, in a request.
    Order,
}

/// A value and what it is.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub(in crate::decode) struct Named {
    /// The name of the parameter, or of the data.
    pub(in crate::decode) name: String,
    /// What the value means.
    pub(in crate::decode) text: String,
    /// The parameter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::decode) param: Option<u16>,
    /// Where it stands in the data, if it is a piece of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::decode) first_bit: Option<u32>,
    /// How many bits it has there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::decode) bits: Option<u32>,
}

/// The value of an attribute that is read or written: of a parameter, of an assembly, or a path of a connection, which is
/// kept for later.
pub(super) fn attribute(
    eds: &Eds,
    params: &HashMap<(ClassId, InstanceId, AttributeId), u16>,
    node: &mut Node,
    fields: &Fields,
    value: &[u8],
) -> Vec<Named> {
    let (Some(class), Some(instance), Some(attribute)) =
        (fields.explicit.class, fields.explicit.instance, fields.explicit.attribute)
    else {
        return Vec::new();
    };
    if let Some(param) = params.get(&(class, instance, attribute)).and_then(|&number| eds.param(number)) {
        return whole_param(param, node, value).into_iter().collect();
    }
    match (class, attribute) {
        (ClassId::CONNECTION, PRODUCED_PATH | CONSUMED_PATH) => {
            let flow = if attribute == PRODUCED_PATH { Flow::Produced } else { Flow::Consumed };
            // Others carry nothing that has a name in the file, and there may be thousands of them.
            if let Some(predefined) = Predefined::from_instance(instance) {
                node.paths.insert((predefined, flow), value.to_vec());
            }
            Vec::new()
        }
        (ClassId::ASSEMBLY, ASSEMBLY_DATA) => {
            let number = u8::try_from(instance.0).ok();
            let path = number.map(|number| [0x20, 0x04, 0x24, number, 0x30, 0x03]);
            let assembly = path.and_then(|path| eds.assembly_at(&path));
            assembly.and_then(|assembly| members(eds, assembly, node, value)).unwrap_or_default()
        }
        _ => Vec::new(),
    }
}

/// The pieces of I/O data, where their size is that of the data described.
pub(super) fn io(eds: &Eds, node: &mut Node, kind: Kind, flow: Flow, data: &[u8]) -> Vec<Named> {
    let Some(described) = described(eds, node, kind, flow, data.len()) else { return Vec::new() };
    let path = match &described {
        Described::Path(path) => path,
        Described::Data(io) => &io.path,
    };
    let named = eds.assembly_at(path).and_then(|assembly| members(eds, assembly, node, data));
    if let Some(named) = named.filter(|named| !named.is_empty()) {
        return named;
    }
    match described {
        Described::Data(io) if !data.is_empty() => vec![Named {
            name: io.name.clone(),
            text: Hex(data).to_string(),
            param: None,
            first_bit: None,
            bits: None,
        }],
        Described::Data(_) | Described::Path(_) => Vec::new(),
    }
}

/// What says what I/O data are.
enum Described<'a> {
    /// A path that was read or written on the bus.
    Path(Vec<u8>),
    /// The file.
    Data(&'a IoData),
}

fn described<'a>(eds: &'a Eds, node: &Node, kind: Kind, flow: Flow, len: usize) -> Option<Described<'a>> {
    let (types, predefined) = connection(kind)?;
    if let Some(path) = node.paths.get(&(predefined, flow)) {
        let known = eds.io_info().and_then(|io| list(io, flow).iter().find(|data| data.path == *path));
        return Some(known.map_or_else(|| Described::Path(path.clone()), Described::Data));
    }
    let io = eds.io_info()?;
    let has_size = |data: &&IoData| usize::from(data.size) == len;
    let default = types.iter().filter_map(|&ty| io.connection(ty)).find_map(|connection| match flow {
        Flow::Produced | Flow::Answer => connection.input.and_then(|number| io.input(number)),
        Flow::Consumed | Flow::Order => connection.output.and_then(|number| io.output(number)),
    });
    if let Some(data) = default.filter(has_size) {
        return Some(Described::Data(data));
    }
    // Another one, if only one can be meant.
    let allowed = |data: &&IoData| types.iter().any(|ty| data.types.contains(ty.mask()));
    let mut others = list(io, flow).iter().filter(has_size).filter(allowed);
    let other = others.next()?;
    others.next().is_none().then_some(Described::Data(other))
}

/// The members of an assembly, if the data have its size.
fn members(eds: &Eds, assembly: &Assembly, node: &mut Node, data: &[u8]) -> Option<Vec<Named>> {
    let slots = eds.layout(assembly)?;
    let end = slots.iter().map(|slot| slot.first_bit.saturating_add(slot.bits)).max().unwrap_or(0);
    let size = assembly.size.map_or(end.div_ceil(8) as usize, usize::from);
    if size != data.len() {
        return None;
    }
    Some(slots.iter().filter_map(|slot| member(slot, node, data)).collect())
}

fn member(slot: &Slot<'_>, node: &mut Node, data: &[u8]) -> Option<Named> {
    let text = match (slot.param, slot.value_in(data), slot.bytes_in(data)) {
        (Some(param), Some(value), _) => {
            if slot.param_bit == 0 {
                node.values.insert(param.number, value.into());
            }
            param.text_of_bits(value, slot.bits, slot.param_bit, |number| node.values.get(&number).copied())
        }
        (_, _, Some(bytes)) => Hex(bytes).to_string(),
        (None, Some(value), None) => format!("0x{value:X}"),
        (_, None, None) => return None,
    };
    Some(Named {
        name: slot.name.to_string(),
        text,
        param: slot.param.map(|param| param.number),
        first_bit: Some(slot.first_bit),
        bits: Some(slot.bits),
    })
}

fn whole_param(param: &Param, node: &mut Node, value: &[u8]) -> Option<Named> {
    let read = param.data_type?.read(&mut Reader::new(value)).ok()?;
    if let Some(number) = whole_number(&read) {
        node.values.insert(param.number, number);
    }
    let text = param.text_of_bytes(value, |number| node.values.get(&number).copied())?;
    Some(Named { name: param.name.clone(), text, param: Some(param.number), first_bit: None, bits: None })
}

/// The connections of an EDS that a kind of message can belong to, and that of the predefined set.
fn connection(kind: Kind) -> Option<(&'static [IoType], Predefined)> {
    let (types, predefined): (&[IoType], Predefined) = match kind {
        Kind::PollCommand | Kind::PollResponse => (&[IoType::Poll], Predefined::Poll),
        Kind::BitStrobeResponse => (&[IoType::BitStrobe], Predefined::BitStrobe),
        Kind::CosCyclic => (&[IoType::ChangeOfState, IoType::Cyclic], Predefined::CosCyclic),
        Kind::MulticastPollResponse => (&[IoType::MulticastPoll], Predefined::MulticastPoll),
        _ => return None,
    };
    Some((types, predefined))
}

fn list(io: &IoInfo, flow: Flow) -> &[IoData] {
    match flow {
        Flow::Produced | Flow::Answer => &io.inputs,
        Flow::Consumed | Flow::Order => &io.outputs,
    }
}

const PRODUCED_PATH: AttributeId = AttributeId(14);
const CONSUMED_PATH: AttributeId = AttributeId(16);
const ASSEMBLY_DATA: AttributeId = AttributeId(3);

#[cfg(test)]
mod tests {
    use super::*;

    /// A recording may name any number of connections; what is kept of a node must not grow with it.
    #[test]
    fn paths_are_kept_of_predefined_connections_only() {
        let eds = Eds::parse(Vec::new()).unwrap();
        let mut node = Node::default();
        for instance in 1..=u16::MAX {
            for path in [PRODUCED_PATH, CONSUMED_PATH] {
                let mut fields = Fields::default();
                (fields.explicit.class, fields.explicit.instance) =
                    (Some(ClassId::CONNECTION), Some(InstanceId(instance)));
                fields.explicit.attribute = Some(path);
                attribute(&eds, &HashMap::new(), &mut node, &fields, &[0x20, 0x04]);
            }
        }
        assert_eq!(node.paths.len(), 10);
    }
}
