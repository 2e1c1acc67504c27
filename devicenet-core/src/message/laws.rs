//! The laws of every wire type, and golden bytes from the literature.

use cip_core::code::{AdditionalCode, ClassId, GeneralStatus, InstanceId, VendorId};
use cip_core::fragment::{AckStatus, FragmentByte, FragmentKind};
use cip_core::message::{AllocateRequest, AllocateResponse, AllocationChoice, BodyFormat, ReleaseRequest};
use link_core::{frame_laws, samples};
use proptest::prelude::*;
use std::string::ToString;
use std::vec::Vec;

use super::*;
use crate::id::{Identifier, MacId};

fn mac() -> impl Strategy<Value = MacId> + Clone {
    (0_u8..64).prop_map(MacId::from_low_bits)
}

fn device() -> impl Strategy<Value = DeviceIdentity> {
    (any::<u16>(), any::<u32>())
        .prop_map(|(vendor, serial)| DeviceIdentity { vendor: VendorId(vendor), serial })
}

fn port() -> impl Strategy<Value = PortNumber> {
    (0_u8..128).prop_map(|number| PortNumber::new(number).unwrap())
}

fn direction() -> impl Strategy<Value = Direction> {
    prop_oneof![Just(Direction::Request), Just(Direction::Response)]
}

fn nodes() -> impl Strategy<Value = NodeSelection> {
    prop_oneof![
        mac().prop_map(NodeSelection::MacId),
        (0_u8..64).prop_map(|bits| NodeSelection::Mask(Mask::new(bits).unwrap())),
    ]
}

fn message_id() -> impl Strategy<Value = MessageId> {
    (0_u8..16).prop_map(|number| MessageId::new(number).unwrap())
}

fn group() -> impl Strategy<Value = GroupSelect> {
    (0_u8..16).prop_map(|number| GroupSelect::new(number).unwrap())
}

fn fragment() -> impl Strategy<Value = FragmentByte> {
    (prop_oneof![Just(FragmentKind::First), Just(FragmentKind::Middle), Just(FragmentKind::Last)], 0_u8..64)
        .prop_map(|(kind, count)| FragmentByte::new(kind, count))
}

fn free(len: core::ops::RangeInclusive<usize>) -> impl Strategy<Value = &'static [u8]> {
    prop::collection::vec(any::<u8>(), len).prop_map(|bytes| &*bytes.leak())
}

samples! {
    DuplicateMacCheck = (direction(), port(), device())
        .prop_map(|(direction, port, device)| Self { direction, port, device });
    ExplicitHeader = any::<u8>().prop_map(Self::from);
    ExplicitMessage<'static> = (any::<bool>(), mac(), free(1..=7))
        .prop_map(|(xid, mac, body)| Self { xid, mac, body });
    ExplicitFragment<'static> = (any::<bool>(), mac(), fragment(), free(0..=6))
        .prop_map(|(xid, mac, fragment, body)| Self { xid, mac, fragment, body });
    FragmentAcknowledge = (any::<bool>(), mac(), any::<u8>(), any::<u8>())
        .prop_map(|(xid, mac, count, status)| Self::new(xid, mac, count, AckStatus::from(status)));
    ErrorResponse = (any::<bool>(), mac(), any::<u8>(), any::<u8>()).prop_map(|(xid, mac, general, additional)| {
        Self { xid, mac, general: GeneralStatus(general), additional: AdditionalCode(additional) }
    });
    UnconnectedAllocate = (any::<bool>(), mac(), any::<u8>(), any::<u8>())
        .prop_map(|(xid, requester, choice, allocator)| {
            let choice = AllocationChoice::from_bits_retain(choice);
            Self { xid, requester, body: AllocateRequest { choice, allocator } }
        });
    UnconnectedAllocateResponse = (any::<bool>(), mac(), 0_u8..16).prop_map(|(xid, requester, body_format)| {
        Self { xid, requester, body: AllocateResponse::from_code(body_format).unwrap() }
    });
    UnconnectedRelease = (any::<bool>(), mac(), any::<u8>()).prop_map(|(xid, requester, choice)| {
        Self { xid, requester, body: ReleaseRequest { choice: AllocationChoice::from_bits_retain(choice) } }
    });
    UnconnectedReleaseResponse = (any::<bool>(), mac()).prop_map(|(xid, requester)| Self { xid, requester });
    OpenRequest = (any::<bool>(), mac(), any::<u8>(), group(), message_id())
        .prop_map(|(xid, server, format, group, source_message)| {
            Self { xid, server, body_format: FormatByte(format), group, source_message }
        });
    OpenResponse = (any::<bool>(), mac(), any::<u8>(), message_id(), message_id(), any::<u16>()).prop_map(
        |(xid, client, format, destination_message, source_message, connection)| Self {
            xid,
            client,
            body_format: FormatByte(format),
            destination_message,
            source_message,
            connection: InstanceId(connection),
        });
    CloseRequest = (any::<bool>(), mac(), any::<u16>())
        .prop_map(|(xid, server, connection)| Self { xid, server, connection: InstanceId(connection) });
    CloseResponse = (any::<bool>(), mac()).prop_map(|(xid, client)| Self { xid, client });
    Heartbeat = (mac(), any::<u16>(), any::<u8>(), any::<u8>(), any::<u16>()).prop_map(
        |(node, instance, state, flags, configuration_consistency)| Self {
            node,
            instance: InstanceId(instance),
            state: DeviceState(state),
            flags: HeartbeatFlags::from_bits_retain(flags),
            configuration_consistency,
        });
    Shutdown = (mac(), any::<u16>(), any::<u16>(), any::<u16>()).prop_map(|(node, class, instance, code)| {
        Self { node, class: ClassId(class), instance: InstanceId(instance), code: ShutdownCode(code) }
    });
    OfflineOwnership = (direction(), mac(), device())
        .prop_map(|(direction, client, device)| Self { direction, client, device });
    WhoRequest = (nodes(), 0_u8..=6).prop_map(|(nodes, offset)| {
        Self { nodes, delay_offset: DelayOffset::new(offset).unwrap() }
    });
    WhoResponse = (port(), device()).prop_map(|(port, device)| Self { port, device });
    IdentifyRequest = nodes().prop_map(|nodes| Self { nodes });
    IdentifyDeviceRequest = device().prop_map(|device| Self { device });
    IdentifyResponse = nodes().prop_map(|nodes| Self { nodes });
    ChangeMacIdRequest = (mac(), device()).prop_map(|(mac, device)| Self { mac, device });
    CommunicationFaultedRequest = prop_oneof![
        WhoRequest::strategy().prop_map(Self::Who),
        IdentifyRequest::strategy().prop_map(Self::Identify),
        IdentifyDeviceRequest::strategy().prop_map(Self::IdentifyDevice),
        ChangeMacIdRequest::strategy().prop_map(Self::ChangeMacId),
    ];
    CommunicationFaultedResponse = prop_oneof![
        WhoResponse::strategy().prop_map(Self::Who),
        IdentifyResponse::strategy().prop_map(Self::Identify),
    ];
    BitStrobeCommand = any::<u64>().prop_map(Self::from_bits);
    EmptyIo = Just(Self);
    IoFragment<'static> = (fragment(), free(0..=7)).prop_map(|(fragment, data)| Self { fragment, data });
}

/// Bytes that are often accepted: a service byte of a known message in its place, otherwise anything.
fn near_messages() -> impl Strategy<Value = Vec<u8>> {
    let services = prop::sample::select(&[0x4B, 0x4C, 0x4D, 0xCB, 0xCC, 0xCD, 0xCE, 0x94, 0x0E, 0xC1]);
    let start = prop_oneof![any::<u8>(), 0_u8..0x40, Just(0x3F)];
    (start, services, prop_oneof![Just([3, 1]), any::<[u8; 2]>()], any::<[u8; 5]>(), 0_usize..=9).prop_map(
        |(start, service, address, rest, len)| {
            let mut bytes: Vec<u8> = [start, service].into_iter().chain(address).chain(rest).collect();
            bytes.truncate(len);
            bytes
        },
    )
}

crate::for_each_wire_type!(frame_laws);

fn number(number: u8) -> MacId {
    MacId::new(number).unwrap()
}

fn refused<'a, T: Wire<'a> + core::fmt::Debug>(bytes: &'a [u8]) -> ParseError {
    T::parse(bytes).unwrap_err()
}

/// ICP DAS CAN-8124/8224/8424 manual p. 112: master 10 allocates explicit, poll and bit-strobe of slave 9.
#[test]
fn allocate_of_the_icp_das_manual() {
    let request = UnconnectedAllocate {
        xid: false,
        requester: number(10),
        body: AllocateRequest {
            choice: AllocationChoice::EXPLICIT | AllocationChoice::POLL | AllocationChoice::BIT_STROBE,
            allocator: 10,
        },
    };
    let frame = frame(Identifier::group2_unconnected_request(number(9)), &request).unwrap();
    assert_eq!(frame.to_string(), "44E [6] 0A 4B 03 01 07 0A");
}

/// ICP DAS I-7242D manual p. 93: Who, all nodes, delay set by byte 2 of the response.
#[test]
fn who_of_the_icp_das_manual() {
    let request = WhoRequest { nodes: NodeSelection::ALL, delay_offset: DelayOffset::new(2).unwrap() };
    assert_eq!(WhoRequest::parse(&[0x3F, 0x4B, 0x02]), Ok(request));
}

/// CIP Vol. 3, worked example of UCMM: client 2 opens a Group 3 connection to server 20, uses and closes it.
#[test]
fn a_ucmm_connection_from_open_to_close() {
    let (client, server) = (number(2), number(20));
    let open = OpenRequest {
        xid: false,
        server,
        body_format: BodyFormat::Class8Instance8.into(),
        group: GroupSelect::GROUP_3,
        source_message: MessageId::new(1).unwrap(),
    };
    let opened = OpenResponse {
        xid: false,
        client,
        body_format: BodyFormat::Class8Instance8.into(),
        destination_message: MessageId::ZERO,
        source_message: MessageId::new(2).unwrap(),
        connection: InstanceId(7),
    };
    let get = ExplicitMessage { xid: false, mac: server, body: &[0x0E, 0x01, 0x01, 0x01] };
    let got = ExplicitMessage { xid: false, mac: client, body: &[0x8E, 0x22, 0x01] };
    let close = CloseRequest { xid: false, server, connection: InstanceId(7) };
    let closed = CloseResponse { xid: false, client };
    let requests = Identifier::unconnected_request(client);
    let responses = Identifier::unconnected_response(server);
    let trace = [
        frame(requests, &open),
        frame(responses, &opened),
        frame(Identifier::group3(1, client).unwrap(), &get),
        frame(Identifier::group3(2, server).unwrap(), &got),
        frame(requests, &close),
        frame(responses, &closed),
    ]
    .map(|frame| frame.unwrap().to_string());
    assert_eq!(
        trace,
        [
            "782 [4] 14 4B 00 31",
            "754 [6] 02 CB 00 02 07 00",
            "642 [5] 14 0E 01 01 01",
            "694 [4] 02 8E 22 01",
            "782 [4] 14 4C 07 00",
            "754 [2] 02 CC",
        ]
    );
}

/// The byte tables of CIP Vol. 3 for messages of which no example was published; every field differs from its neighbours.
#[test]
fn byte_tables_without_a_published_example() {
    let device = DeviceIdentity { vendor: VendorId(0x1234), serial: 0x89AB_CDEF };
    let heartbeat = Heartbeat {
        node: number(3),
        instance: InstanceId(0x0102),
        state: DeviceState::OPERATIONAL,
        flags: HeartbeatFlags::SYSTEM_FAULT | HeartbeatFlags::DEVICE_FAULT,
        configuration_consistency: 0x5678,
    };
    let sent = [
        frame(Identifier::unconnected_response(number(3)), &heartbeat),
        frame(
            Identifier::COMMUNICATION_FAULTED_REQUEST,
            &IdentifyRequest { nodes: NodeSelection::MacId(number(5)) },
        ),
        frame(Identifier::COMMUNICATION_FAULTED_REQUEST, &IdentifyDeviceRequest { device }),
        frame(Identifier::COMMUNICATION_FAULTED_RESPONSE, &IdentifyResponse { nodes: NodeSelection::ALL }),
        frame(
            Identifier::explicit_response(number(5)),
            &UnconnectedReleaseResponse { xid: true, requester: number(1) },
        ),
        frame(Identifier::bit_strobe_command(number(1)), &BitStrobeCommand::from_bits(0x8000_0000_0000_0001)),
    ]
    .map(|frame| frame.unwrap().to_string());
    assert_eq!(
        sent,
        [
            "743 [8] 03 CD 02 01 03 05 78 56",
            "7ED [2] 45 4C",
            "7ED [8] 3F 4C 34 12 EF CD AB 89",
            "7EC [2] 3F CC",
            "42B [2] 41 CC",
            "408 [8] 01 00 00 00 00 00 00 80",
        ]
    );
}

#[test]
fn a_node_ping_is_an_open_request_that_opens_nothing() {
    let ping = OpenRequest::parse(&[0x14, 0x4B, 0x00, 0xF0]).unwrap();
    assert_eq!(ping.group, GroupSelect::NODE_PING);
    assert_eq!(ping.group.to_string(), "node ping");
    assert_eq!(GroupSelect::new(7).unwrap().to_string(), "reserved group 7");
}

#[test]
fn the_strobe_bits_of_mac_id_0_7_8_and_63() {
    for (slave, byte, bit) in [(0, 0, 0x01), (7, 0, 0x80), (8, 1, 0x01), (63, 7, 0x80)] {
        let mut data = [0; 8];
        data[byte] = bit;
        let strobe = BitStrobeCommand::parse(&data).unwrap();
        assert_eq!(strobe, BitStrobeCommand::default().with(number(slave), true));
        assert!(MacId::all().all(|mac| strobe.bit(mac) == (mac == number(slave))));
        assert_eq!(strobe.with(number(slave), false), BitStrobeCommand::default());
    }
}

/// A faulted node ignores messages with a reserved bit set, and of another length.
#[test]
fn messages_to_faulted_nodes_are_strict() {
    let error = refused::<WhoRequest>(&[0x80, 0x4B, 0x00]);
    assert_eq!(error, ParseError::value("Match and Value", 0, 0x80));
    assert_eq!(refused::<WhoRequest>(&[0x3F, 0x4B, 7]), ParseError::value("time delay byte offset", 2, 7));
    let change = [0x43, 0x4D, 6, 0, 8, 7, 6, 5];
    assert_eq!(refused::<ChangeMacIdRequest>(&change), ParseError::value("new MAC ID", 0, 0x43));
    refused::<CommunicationFaultedRequest>(&[0x3F]);
    refused::<CommunicationFaultedRequest>(&[0x3F, 0x4F]);
    refused::<CommunicationFaultedRequest>(&[0x3F, 0x4C, 0x06, 0x00]);
    refused::<CommunicationFaultedRequest>(&[0x3F, 0xCB, 0x00]);
}

/// Kept and reported, because the rules answer them.
#[test]
fn reserved_bits_that_a_server_must_answer_survive() {
    let open = OpenRequest::parse(&[0x14, 0x4B, 0x95, 0x31]).unwrap();
    assert_eq!((open.body_format.format(), open.body_format.reserved_bits()), (None, 0x90));
    let allocate = UnconnectedAllocate::parse(&[0x0A, 0x4B, 0x03, 0x01, 0x83, 0xCA]).unwrap();
    assert_eq!((allocate.body.choice.bits(), allocate.body.allocator), (0x83, 0xCA));
    let heartbeat = Heartbeat::parse(&[0x03, 0xCD, 1, 0, 3, 0xF1, 0, 0]).unwrap();
    assert_eq!(heartbeat.flags.reserved_bits(), 0xF0);
    assert!(heartbeat.flags.contains(HeartbeatFlags::DEVICE_FAULT));
}

/// FRAG is ignored by the unconnected port and never used by UCMM; the acknowledge type never occurs in I/O.
#[test]
fn what_cannot_be_fragmented_is_refused_as_a_fragment() {
    refused::<UnconnectedAllocate>(&[0x8A, 0x4B, 0x03, 0x01, 0x03, 0x0A]);
    refused::<OpenRequest>(&[0x94, 0x4B, 0x00, 0x31]);
    refused::<ExplicitMessage<'_>>(&[0x80, 0x00]);
    refused::<ExplicitFragment<'_>>(&[0x80, 0xC1, 0x00]);
    refused::<FragmentAcknowledge>(&[0x80, 0x81, 0x00]);
    refused::<IoFragment<'_>>(&[0xC0]);
}
