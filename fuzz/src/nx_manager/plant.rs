//! The plant that the manager is told of, and how its nodes answer.

use cip_core::code::{AttributeId, ClassId, DeviceType, InstanceId, VendorId};
use cip_core::identity::{self, ProductName, Revision};
use devicenex_core::OperationalAddress;
use devicenex_core::id::{Framing, Identifier, Layout, Route};
use devicenex_core::manager::{Attribute, IdentityPattern, PlannedConnection, PlannedDevice, Source};
use devicenex_core::message::DeviceIdentity;
use link_core::Frame;

pub(super) fn oa(number: u8) -> OperationalAddress {
    OperationalAddress::new(number & 0x7F).expect("seven bits")
}

/// The addresses of the plan; and one that is not in it.
pub(super) const NODES: [u8; 4] = [5, 67, 109, 40];
/// That of the manager.
pub(super) const OWN: u8 = 1;

/// The producer, its spare, a consumer, two of one product, a stranger.
pub(super) fn device(which: u8) -> DeviceIdentity {
    let (product_code, serial) =
        [(2, 0x00B2), (2, 0x00B1), (3, 0x000A), (4, 0x000C), (4, 0x010C), (9, 0x0777)]
            [usize::from(which % 6)];
    DeviceIdentity { vendor: VendorId(0x1234), product_code, major_revision: 1, serial }
}

pub(super) fn own() -> identity::DeviceIdentity {
    identity::DeviceIdentity {
        vendor: VendorId(0x1234),
        device_type: DeviceType::COMMUNICATIONS_ADAPTER,
        product_code: 1,
        revision: Revision { major: 1, minor: 1 },
        serial: 0x0080,
        name: ProductName::new("Example Manager").expect("fifteen characters"),
    }
}

pub(super) fn plan(address: u8) -> PlannedDevice<3> {
    let source = Source { address: oa(67), connection: 0 };
    let (identity, connections) = match address {
        67 => (IdentityPattern::exact(device(0)), vec![PlannedConnection::producer(100)]),
        5 => (IdentityPattern::exact(device(2)), vec![PlannedConnection::consumer(source, 0)]),
        _ => {
            let dynamic = PlannedConnection { instance: None, ..PlannedConnection::consumer(source, 500) };
            let connections = vec![
                PlannedConnection::change_of_state(200),
                PlannedConnection::consumer(source, 500),
                dynamic,
            ];
            (IdentityPattern::product_of(device(3)), connections)
        }
    };
    let mut plan = PlannedDevice::new(oa(address), identity);
    plan.connections.extend(connections);
    if address == 67 {
        plan.spares.push(IdentityPattern::exact(device(1))).expect("room");
    }
    let name = Attribute { class: ClassId::IDENTITY, instance: InstanceId(1), attribute: AttributeId(7) };
    plan.reads.push(name).expect("room");
    plan
}

/// The answer of a node to a request: well, refused, with nothing, or with anything.
pub(super) fn answer(request: &Frame, how: u8) -> Option<Frame> {
    let id = Identifier::of_frame(request);
    let back = |route: Route| Route {
        destination: route.source,
        direction: devicenex_core::id::Direction::Response,
        source: route.destination,
    };
    let data = request.data();
    let body: Vec<u8> = match (how % 4, data) {
        (1, _) => vec![0x94, how, 0xFF],
        (2, _) => vec![data.first()? | 0x80],
        (3, _) => [&[data.first()? | 0x80], &[how; 4][..usize::from(how >> 4) % 5]].concat(),
        (_, [0x4B, byte]) => vec![0x4B, *byte, 0, 128, 0],
        (_, [0x4B, byte, _, _, low, high, _]) => vec![0x4B, *byte, 0, *low, *high],
        (_, [0x0E, 1, 1, attribute]) => identity_value(*attribute, how >> 2),
        (_, [0x0E, 5, _, 1]) => vec![0x8E, if how & 0x40 == 0 { 3 } else { 4 }],
        (_, [0x0E, 5, _, 4 | 5]) => vec![0x8E, 7, 0, 0x86, 0x80],
        (_, [0x0E, 5, _, 9]) => vec![0x8E, 100, 0],
        (_, [service, ..]) => vec![service | 0x80, 3],
        (_, []) => return None,
    };
    let body = &body[..body.len().min(8)];
    match id.layout() {
        Layout::Connection { route, transaction } => {
            Identifier::connection(back(route), transaction).frame(body)
        }
        Layout::Connectionless { route, framing: Framing::Complete { transaction } } => {
            Identifier::connectionless(back(route), Framing::Complete { transaction }).frame(body)
        }
        Layout::Explicit { message, route, framing: Framing::Complete { transaction } } => {
            Identifier::explicit(message, back(route), Framing::Complete { transaction })?.frame(body)
        }
        _ => None,
    }
}

fn identity_value(attribute: u8, which: u8) -> Vec<u8> {
    let device = device(which);
    let value = match attribute {
        1 => device.vendor.0.to_le_bytes().to_vec(),
        3 => device.product_code.to_le_bytes().to_vec(),
        4 => vec![device.major_revision, 7],
        6 => device.serial.to_le_bytes().to_vec(),
        _ => vec![2, 0x41, 0x42],
    };
    [&[0x8E], &value[..]].concat()
}
