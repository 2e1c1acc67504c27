//! The Identity object.

use cip_core::code::{AttributeId, DeviceType, InstanceId, ServiceCode, VendorId};
use cip_core::codec::Wire;
use cip_core::identity::{DeviceIdentity, IdentityAttributes, OptionalAttributes};
use link_core::Instant;

use super::super::nodes::{Identity, Node};
use super::super::pairing::Transaction;
use super::super::state::State;
use crate::id::MacId;

pub(super) fn learn<const N: usize>(
    state: &mut State<N>,
    server: MacId,
    instance: InstanceId,
    request: &Transaction,
    data: &[u8],
    at: Instant,
) {
    if request.asked.service == ServiceCode::RESET {
        state.drop_connections(server, at);
        return;
    }
    let node = state.node(server);
    if instance.is_class() {
        return;
    }
    if request.asked.service == ServiceCode::SET_ATTRIBUTE_SINGLE
        && request.asked.attribute == Some(AttributeId(10))
    {
        let [interval, ..] = request.asked.argument.to_le_bytes();
        node.heartbeat_interval = Some(interval);
    }
    if request.asked.service == ServiceCode::GET_ATTRIBUTES_ALL
        && let Ok(all) = IdentityAttributes::parse(data)
    {
        identity_of(node, &all);
        return;
    }
    if request.asked.service != ServiceCode::GET_ATTRIBUTE_SINGLE {
        return;
    }
    let held = &mut node.identity;
    match (request.asked.attribute.unwrap_or(AttributeId(0)).0, data) {
        (1, &[low, high]) => held.vendor = Some(VendorId(u16::from_le_bytes([low, high]))),
        (2, &[low, high]) => held.device_type = Some(DeviceType(u16::from_le_bytes([low, high]))),
        (3, &[low, high]) => held.product = Some(u16::from_le_bytes([low, high])),
        (4, &[major, minor]) => held.revision = Some((major, minor)),
        (6, &[a, b, c, d]) => held.serial = Some(u32::from_le_bytes([a, b, c, d])),
        (7, [len, name @ ..]) if usize::from(*len) == name.len() => node.set_name(name),
        (10, &[interval]) => node.heartbeat_interval = Some(interval),
        _ => {}
    }
}

fn identity_of(node: &mut Node, all: &IdentityAttributes) {
    let DeviceIdentity { vendor, device_type, product_code, revision, serial, name } = &all.identity;
    node.identity = Identity {
        port: node.identity.port,
        vendor: Some(*vendor),
        serial: Some(*serial),
        device_type: Some(*device_type),
        product: Some(*product_code),
        revision: Some((revision.major, revision.minor)),
    };
    node.set_name(name.as_bytes());
    if let OptionalAttributes::Heartbeat(_, _, interval) = all.optional {
        node.heartbeat_interval = Some(interval);
    }
}
