//! Frames of nobody who is there.

use powerlink_core::ethernet::group;
use powerlink_core::wire::{
    Body, Con, Flags, Frame, MessageType, NmtCommand, NmtCommandId, NmtStateCode, POWERLINK_V2, PdoVersion,
    Pres, RequestedService, Sdo, SdoCommand, SdoCommandId, SdoSequence, SequenceHalf, ServiceId, Soa, Soc,
};
use powerlink_core::{MacAddress, NodeId};

/// What a stranger says, by a byte: bits 3-0 what, bits 5-4 to or as which node, bits 7-6 how.
pub(super) fn frame(argument: u8, nodes: u8) -> Vec<u8> {
    let node = NodeId((argument >> 4 & 3) % nodes + 1);
    let how = argument >> 6;
    let (mn, all) = (NodeId::MANAGING_NODE, NodeId::BROADCAST);
    let soa = |service| {
        let (state, flags) = (NmtStateCode::PRE_OPERATIONAL_1, Flags::from_bits_retain(how << 1));
        Body::Soa(Soa { state, flags, service, target: node, version: POWERLINK_V2 })
    };
    let command = |command| Body::NmtCommand(NmtCommand { command, data: &[0x80, 0x84] });
    let half = |connection| SequenceHalf::new(how, connection);
    let con = match how {
        0 => SdoSequence { receive: half(Con::None), send: half(Con::Initialisation) },
        1 => SdoSequence { receive: half(Con::Initialisation), send: half(Con::Valid) },
        _ => SdoSequence { receive: half(Con::Valid), send: half(Con::Request) },
    };
    let sdo = SdoCommand::request(how, SdoCommandId::WRITE_BY_INDEX, &[0x06, 0x10, 0, 0, 1, 2, 3, 4]);
    let pres = Pres {
        state: NmtStateCode::OPERATIONAL,
        flags: Flags::from_bits_retain(how | 0x11),
        request: powerlink_core::wire::AsyncRequest(0x3F),
        pdo_version: PdoVersion(how),
        data: &[0xEE; 3],
    };
    // A cycle of the managing node, or under another number.
    let cyclic = if how == 2 { NodeId(250) } else { mn };
    let (destination, to, from, body) = match argument & 15 {
        0 => (group::SOC, all, cyclic, Body::Soc(Soc::default())),
        1 => (group::SOA, all, cyclic, soa(RequestedService::NO_SERVICE)),
        2 => (group::SOA, all, cyclic, soa(RequestedService::IDENT_REQUEST)),
        3 => (group::SOA, all, cyclic, soa(RequestedService::STATUS_REQUEST)),
        4 => (group::SOA, all, cyclic, soa(RequestedService::UNSPECIFIED_INVITE)),
        5 => (group::ASND, node, mn, command(NmtCommandId::STOP_NODE)),
        6 => (group::ASND, all, mn, command(NmtCommandId::RESET_NODE)),
        7 => (group::ASND, all, mn, command(NmtCommandId(how << 6 | 0x21))),
        8 => (group::PRES, all, node, Body::Pres(pres)),
        9 => (group::PRES, all, NodeId(77), Body::Pres(pres)),
        10 => (group::ASND, node, mn, Body::Sdo(Sdo { sequence: con, command: Some(sdo) })),
        11 => (group::ASND, mn, node, Body::Sdo(Sdo { sequence: con, command: None })),
        12 => (group::ASND, all, node, Body::OtherAsnd(ServiceId::STATUS_RESPONSE, &[0xFF; 60])),
        13 => (group::ASND, all, node, Body::OtherAsnd(ServiceId::IDENT_RESPONSE, &[0xEE; 160])),
        14 => (group::ASND, all, node, Body::OtherAsnd(ServiceId(how << 4 | 0x0A), &[how])),
        _ => (MacAddress::BROADCAST, all, node, Body::Other(MessageType(how << 3 | 0x05), &[how; 2])),
    };
    let source = MacAddress([2, 0, 0, 0, 0x57, argument]);
    let mut buffer = [0; 256];
    let bytes =
        Frame { destination, source, to, from, body }.emit(&mut buffer).expect("there is room").to_vec();
    // One in four is cut.
    if how == 3 { bytes[..usize::from(argument & 15) + 10].to_vec() } else { bytes }
}
