//! The plant of the DeviceNeX targets: who there is, and what a manager is told of it.

use cip_core::code::{AttributeId, ClassId, DeviceType, InstanceId, VendorId};
use cip_core::identity::{self, ProductName, Revision};
use devicenex_core::OperationalAddress;
use devicenex_core::manager::{Attribute, IdentityPattern, PlannedConnection, PlannedDevice, Source};
use devicenex_core::message::DeviceIdentity;

pub(crate) fn oa(number: u8) -> OperationalAddress {
    OperationalAddress::new(number & 0x7F).expect("seven bits")
}

/// The addresses of the plan; and one that is not in it.
pub(crate) const NODES: [u8; 4] = [5, 67, 109, 40];
/// That of the manager.
pub(crate) const OWN: u8 = 1;

/// The producer, its spare, a consumer, two of one product, a stranger.
pub(crate) fn device(which: u8) -> DeviceIdentity {
    let (product_code, serial) =
        [(2, 0x00B2), (2, 0x00B1), (3, 0x000A), (4, 0x000C), (4, 0x010C), (9, 0x0777)]
            [usize::from(which % 6)];
    DeviceIdentity { vendor: VendorId(0x1234), product_code, major_revision: 1, serial }
}

pub(crate) fn own() -> identity::DeviceIdentity {
    identity::DeviceIdentity {
        vendor: VendorId(0x1234),
        device_type: DeviceType::COMMUNICATIONS_ADAPTER,
        product_code: 1,
        revision: Revision { major: 1, minor: 1 },
        serial: 0x0080,
        name: ProductName::new("Example Manager").expect("fifteen characters"),
    }
}

pub(crate) fn plan(address: u8) -> PlannedDevice<3> {
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
