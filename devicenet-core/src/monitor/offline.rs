//! The offline connection set, Group 4.

use cip_core::code::ServiceCode;
use cip_core::codec::Wire;
use cip_core::monitor::{Flaw, Seen};

use super::kind::Kind;
use super::nodes::{AccessState, Roles};
use super::reading::{Detail, Reading};
use super::state::State;
use crate::id::{MacId, Purpose};
use crate::message::{
    CommunicationFaultedRequest, CommunicationFaultedResponse, DeviceIdentity, Direction, NodeSelection,
    OfflineOwnership,
};

/// Reads a frame of Group 4 that has a use.
pub(super) fn observe<const N: usize>(state: &mut State<N>, reading: &mut Reading<'_>, purpose: Purpose) {
    match purpose {
        Purpose::OfflineOwnershipRequest => ownership(state, reading, Direction::Request),
        Purpose::OfflineOwnershipResponse => ownership(state, reading, Direction::Response),
        Purpose::CommunicationFaultedRequest => request(state, reading),
        _ => response(state, reading),
    }
}

fn ownership<const N: usize>(state: &mut State<N>, reading: &mut Reading<'_>, expected: Direction) {
    let frame = reading.frame;
    let data = frame.data();
    reading.kind = match expected {
        Direction::Request => Kind::OfflineOwnershipRequest,
        Direction::Response => Kind::OfflineOwnershipResponse,
    };
    service(reading, 1);
    let message = match OfflineOwnership::parse(data) {
        Ok(message) => message,
        Err(error) => {
            reading.flag(Flaw::of_parse(error, data.len()));
            return;
        }
    };
    reading.src = Some(message.client);
    reading.fields.detail = Detail::Ownership { client: message.client };
    device(reading, message.device);
    state.add_role(message.client, Roles::TOOL);
    match (expected, message.direction) {
        (Direction::Request, Direction::Response) => reading.flag(Flaw::ResponseBitOnRequest),
        (Direction::Response, Direction::Request) => reading.flag(Flaw::RequestBitOnResponse),
        (Direction::Request, Direction::Request) => {
            state.offline.ownership = Some(Seen { n: reading.n, at: reading.at });
        }
        (Direction::Response, Direction::Response) => match state.offline.ownership.take() {
            Some(request) => reading.request = Some(request.answered(reading.at)),
            None => reading.assumed = true,
        },
    }
}

fn request<const N: usize>(state: &mut State<N>, reading: &mut Reading<'_>) {
    let frame = reading.frame;
    let data = frame.data();
    reading.kind = Kind::OfflineFaultRequest;
    service(reading, 1);
    if data.get(1).is_some_and(|&byte| Direction::of(byte) == Direction::Response) {
        reading.flag(Flaw::ResponseBitOnRequest);
        return;
    }
    let nodes = data.first().copied().unwrap_or_default() & 0x7F;
    let seen = Seen { n: reading.n, at: reading.at };
    match CommunicationFaultedRequest::parse(data) {
        Ok(CommunicationFaultedRequest::Who(who)) => {
            reading.fields.detail = Detail::Who { nodes, delay_offset: who.delay_offset.number() };
            reading.dst = selected(who.nodes);
            state.offline.who = Some(seen);
        }
        Ok(CommunicationFaultedRequest::Identify(identify)) => {
            reading.fields.detail = Detail::Identify { nodes };
            reading.dst = selected(identify.nodes);
            state.offline.identify = Some(seen);
        }
        Ok(CommunicationFaultedRequest::IdentifyDevice(identify)) => {
            reading.fields.detail = Detail::Identify { nodes };
            device(reading, identify.device);
            reading.dst = last_known(state, identify.device);
            state.offline.identify = Some(seen);
        }
        Ok(CommunicationFaultedRequest::ChangeMacId(change)) => {
            reading.fields.detail = Detail::ChangeMacId { mac: change.mac };
            device(reading, change.device);
            reading.dst = last_known(state, change.device);
        }
        Err(error) => reading.flag(Flaw::of_parse(error, data.len())),
    }
}

fn response<const N: usize>(state: &mut State<N>, reading: &mut Reading<'_>) {
    let frame = reading.frame;
    let data = frame.data();
    reading.kind = Kind::OfflineFaultResponse;
    let request = match CommunicationFaultedResponse::parse(data) {
        Ok(CommunicationFaultedResponse::Who(who)) => {
            reading.fields.detail = Detail::WhoAnswer;
            reading.fields.port = Some(who.port.number());
            device(reading, who.device);
            reading.src = last_known(state, who.device);
            faulted(state, who.device);
            // Every faulted node answers the same request.
            state.offline.who
        }
        Ok(CommunicationFaultedResponse::Identify(identify)) => {
            service(reading, 1);
            reading.src = selected(identify.nodes);
            let nodes = data.first().copied().unwrap_or_default();
            reading.fields.detail = Detail::Identify { nodes };
            state.offline.identify
        }
        Err(error) => {
            reading.flag(Flaw::of_parse(error, data.len()));
            return;
        }
    };
    match request {
        Some(request) => reading.request = Some(request.answered(reading.at)),
        None => reading.assumed = true,
    }
}

/// The node that is meant, if it is one by its MAC ID.
fn selected(nodes: NodeSelection) -> Option<MacId> {
    match nodes {
        NodeSelection::MacId(mac) => Some(mac),
        NodeSelection::Mask(_) => None,
    }
}

/// The MAC ID under which the device was heard last, if one is known.
fn last_known<const N: usize>(state: &State<N>, device: DeviceIdentity) -> Option<MacId> {
    let known = state.nodes().filter(|(_, node)| node.is(device));
    // A device with two ports is known by two MAC IDs.
    let last = known.max_by_key(|(_, node)| node.access_since);
    // A twin that has met the owner of its MAC ID, which stays on line.
    let twin = || state.nodes().find(|(_, node)| node.rival == Some(device));
    last.or_else(twin).map(|(mac, _)| mac)
}

/// Takes note that the device is faulted.
fn faulted<const N: usize>(state: &mut State<N>, device: DeviceIdentity) {
    let known = state.nodes_mut().filter(|(_, node)| node.is(device));
    if let Some((_, node)) = known.max_by_key(|(_, node)| node.access_since) {
        node.access = AccessState::Faulted;
    }
}

fn device(reading: &mut Reading<'_>, device: DeviceIdentity) {
    reading.fields.vendor = Some(device.vendor);
    reading.fields.serial = Some(device.serial);
}

fn service(reading: &mut Reading<'_>, offset: usize) {
    let frame = reading.frame;
    reading.fields.explicit.service = frame.data().get(offset).map(|&byte| ServiceCode::split(byte).0);
}
