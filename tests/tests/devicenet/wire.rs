//! The vectors that a wire type decodes without knowing what came before: value and bytes must agree in both
//! directions.

use cip_core::code::{AdditionalCode, ClassId, GeneralStatus, InstanceId, ServiceCode, VendorId};
use cip_core::codec::laws::round_trip;
use cip_core::fragment::{AckStatus, FragmentByte, FragmentKind};
use cip_core::message::{
    AllocateRequest, AllocateResponse, AllocationChoice, BodyFormat, ReleaseRequest, Request,
};
use devicenet_core::MacId;
use devicenet_core::id::{Identifier, Purpose};
use devicenet_core::message::*;
use link_core::Frame;

use crate::vectors::{Kind, VECTORS, by_number};

fn mac(number: u8) -> MacId {
    MacId::new(number).unwrap()
}

/// The vector decodes to this message, and the message encodes to the vector, on this identifier.
#[track_caller]
fn is<T: Wire<'static> + PartialEq + core::fmt::Debug>(number: u16, id: Identifier, message: &T) {
    let vector = by_number(number);
    assert_eq!(T::parse(vector.data).as_ref(), Ok(message), "no. {number}: {}", vector.meaning);
    assert_eq!(
        frame(id, message),
        Identifier::new(vector.id).unwrap().frame(vector.data),
        "no. {number}: {}, {} {}",
        vector.meaning,
        vector.source,
        vector.place
    );
}

#[test]
fn duplicate_mac_id_check() {
    let device = DeviceIdentity { vendor: VendorId(8), serial: 0x1289_F506 };
    let direction = Direction::Request;
    let check = DuplicateMacCheck { direction, port: PortNumber::ZERO, device };
    is(38, Identifier::duplicate_mac_check(mac(1)), &check);
}

#[test]
fn allocate_and_release() {
    let allocate = UnconnectedAllocate {
        xid: false,
        requester: mac(10),
        body: AllocateRequest {
            choice: AllocationChoice::EXPLICIT | AllocationChoice::POLL | AllocationChoice::BIT_STROBE,
            allocator: 10,
        },
    };
    is(2, Identifier::group2_unconnected_request(mac(9)), &allocate);

    let body = AllocateResponse::new(BodyFormat::Class8Instance8);
    let response = |xid, requester| UnconnectedAllocateResponse { xid, requester: mac(requester), body };
    is(40, Identifier::explicit_response(mac(2)), &response(true, 1));
    is(60, Identifier::explicit_response(mac(2)), &response(false, 0));

    let release = |requester, choice| UnconnectedRelease {
        xid: false,
        requester: mac(requester),
        body: ReleaseRequest { choice },
    };
    let with_reserved_bit =
        AllocationChoice::EXPLICIT | AllocationChoice::CHANGE_OF_STATE | AllocationChoice::ACK_SUPPRESSION;
    is(22, Identifier::group2_unconnected_request(mac(3)), &release(10, with_reserved_bit));
    is(62, Identifier::group2_unconnected_request(mac(2)), &release(0, AllocationChoice::EXPLICIT));
}

#[test]
fn error_response() {
    let general = GeneralStatus::RESOURCE_UNAVAILABLE;
    let additional = AdditionalCode::INVALID_UNCONNECTED_SERVICE;
    let error = ErrorResponse { xid: false, mac: mac(10), general, additional };
    is(114, Identifier::explicit_response(mac(3)), &error);
}

#[test]
fn ucmm() {
    let open = OpenRequest {
        xid: false,
        server: mac(63),
        body_format: BodyFormat::Class16Instance16.into(),
        group: GroupSelect::GROUP_3,
        source_message: MessageId::new(4).unwrap(),
    };
    is(78, Identifier::unconnected_request(mac(0)), &open);
    is(96, Identifier::unconnected_response(mac(63)), &CloseResponse { xid: false, client: mac(0) });
    let close = CloseRequest { xid: false, server: mac(5), connection: InstanceId(2) };
    is(116, Identifier::unconnected_request(mac(0)), &close);
    is(118, Identifier::unconnected_response(mac(5)), &CloseResponse { xid: false, client: mac(0) });
}

#[test]
fn offline_connection_set() {
    let who = WhoRequest { nodes: NodeSelection::ALL, delay_offset: DelayOffset::new(2).unwrap() };
    is(10, Identifier::COMMUNICATION_FAULTED_REQUEST, &CommunicationFaultedRequest::Who(who));

    let device = DeviceIdentity { vendor: VendorId(6), serial: 0x0506_0708 };
    let ownership = |direction| OfflineOwnership { direction, client: mac(1), device };
    is(104, Identifier::OFFLINE_OWNERSHIP_REQUEST, &ownership(Direction::Request));
    is(106, Identifier::OFFLINE_OWNERSHIP_RESPONSE, &ownership(Direction::Response));
    let change = ChangeMacIdRequest { mac: mac(3), device };
    is(108, Identifier::COMMUNICATION_FAULTED_REQUEST, &CommunicationFaultedRequest::ChangeMacId(change));
    let who = WhoResponse { port: PortNumber::ZERO, device };
    is(110, Identifier::COMMUNICATION_FAULTED_RESPONSE, &CommunicationFaultedResponse::Who(who));
}

#[test]
fn shutdown() {
    let shutdown = Shutdown {
        node: mac(3),
        class: ClassId::ASSEMBLY,
        instance: InstanceId(2),
        code: ShutdownCode(0x0201),
    };
    is(112, Identifier::explicit_response(mac(3)), &shutdown);
    assert_eq!(shutdown.code.to_string(), "vendor-specific code 0x0201");
}

#[test]
fn fragments_and_their_acknowledges() {
    let ack = |xid, to, count| FragmentAcknowledge::new(xid, mac(to), count, AckStatus::Success);
    let request_3 = Identifier::explicit_request(mac(3));
    let response_3 = Identifier::explicit_response(mac(3));
    is(24, response_3, &ack(false, 10, 1));
    is(28, response_3, &ack(false, 0, 1));
    is(32, request_3, &ack(false, 0, 1));
    is(70, Identifier::explicit_request(mac(2)), &ack(false, 0, 1));
    is(88, Identifier::group3(4, mac(63)).unwrap(), &ack(false, 0, 0));

    let fragment = |xid, to, fragment, body| ExplicitFragment { xid, mac: mac(to), fragment, body };
    let last_1 = FragmentByte::new(FragmentKind::Last, 1);
    is(26, request_3, &fragment(false, 0, FragmentByte::FIRST, &[0x32, 0x64, 0x01, 0x93, 0x05, 0x00]));
    is(30, response_3, &fragment(false, 0, FragmentByte::FIRST, &[0xB2, 0xC2, 0x05, 0x00, 0x05, 0x09]));
    is(68, Identifier::explicit_response(mac(2)), &fragment(false, 0, last_1, b"-DRT"));
    is(90, Identifier::group3(4, mac(0)).unwrap(), &fragment(false, 63, last_1, &[75, 0]));
}

/// Which of them belong to connections of more than eight bytes is known from the sources.
#[test]
fn io_messages() {
    is(34, Identifier::poll_command(mac(5)), &EmptyIo);
    let part = |kind, count, data| IoFragment { fragment: FragmentByte::new(kind, count), data };
    is(12, Identifier::poll_command(mac(9)), &part(FragmentKind::Last, 1, &[0x08, 0x09, 0x0A]));
    is(56, Identifier::poll_command(mac(2)), &part(FragmentKind::Last, 1, &[0x7F, 0, 0, 0, 0]));
    is(58, Identifier::poll_response(mac(2)), &part(FragmentKind::First, 0, &[0x40, 0, 0, 0x08, 0, 0, 0]));
    let poll_63 = Identifier::poll_command(mac(63));
    is(98, poll_63, &part(FragmentKind::First, 0, &[0, 0x80, 0, 0, 0, 0, 0]));
    is(100, poll_63, &part(FragmentKind::Middle, 3, &[0, 0x11, 2, 1, 0, 0x11, 2]));
    is(102, poll_63, &part(FragmentKind::Last, 4, &[1, 0, 0x11, 2]));
}

/// Explicit messages in one frame: header and service. The rest depends on the body format of the connection.
#[test]
fn complete_explicit_messages() {
    let get = ServiceCode::GET_ATTRIBUTE_SINGLE.request_byte();
    let got = ServiceCode::GET_ATTRIBUTE_SINGLE.response_byte();
    let set = ServiceCode::SET_ATTRIBUTE_SINGLE.request_byte();
    let done = ServiceCode::SET_ATTRIBUTE_SINGLE.response_byte();
    for (number, slave, purpose, xid, header, service) in [
        (4, 9, Purpose::ExplicitResponse, false, 10, done),
        (6, 9, Purpose::ExplicitRequest, false, 10, set),
        (8, 9, Purpose::ExplicitRequest, false, 10, set),
        (14, 9, Purpose::ExplicitRequest, false, 10, set),
        (16, 3, Purpose::ExplicitRequest, false, 10, set),
        (18, 3, Purpose::ExplicitRequest, false, 10, set),
        (20, 3, Purpose::ExplicitRequest, false, 10, set),
        (42, 2, Purpose::ExplicitRequest, true, 1, set),
        (44, 2, Purpose::ExplicitResponse, false, 1, got),
        (46, 2, Purpose::ExplicitRequest, true, 1, get),
        (48, 2, Purpose::ExplicitResponse, true, 1, got),
        (50, 2, Purpose::ExplicitRequest, true, 1, 0x4B),
        (52, 2, Purpose::ExplicitRequest, true, 1, get),
        (54, 2, Purpose::ExplicitRequest, false, 1, set),
        (64, 2, Purpose::ExplicitResponse, false, 0, got),
        (66, 2, Purpose::ExplicitRequest, false, 0, get),
        (72, 2, Purpose::ExplicitRequest, false, 0, set),
        (74, 2, Purpose::ExplicitResponse, false, 0, done),
        (76, 2, Purpose::ExplicitResponse, false, 0, 0x85),
        (80, 63, Purpose::Dynamic, false, 0, 0xCB),
        (82, 0, Purpose::Dynamic, false, 63, get),
        (84, 63, Purpose::Dynamic, false, 0, got),
        (86, 0, Purpose::Dynamic, false, 63, get),
        (92, 0, Purpose::Dynamic, false, 63, get),
        (94, 63, Purpose::Dynamic, false, 0, got),
    ] {
        let vector = by_number(number);
        let id = Identifier::new(vector.id).unwrap();
        assert_eq!((id.purpose(), id.mac_id()), (purpose, Some(mac(slave))), "no. {number}");
        let body = vector.data.get(1..).unwrap();
        is(number, id, &ExplicitMessage { xid, mac: mac(header), body });
        assert_eq!(body.first(), Some(&service), "no. {number}");
    }
}

/// No. 72, as far as the request body goes.
#[test]
fn set_expected_packet_rate() {
    let message = ExplicitMessage::parse(by_number(72).data).unwrap();
    let request = Request::parse(BodyFormat::Class8Instance8, message.body).unwrap();
    assert_eq!(request.service, ServiceCode::SET_ATTRIBUTE_SINGLE);
    assert_eq!(request.target.class(), Some(ClassId::CONNECTION));
    assert_eq!(request.target.instance(), Some(InstanceId(1)));
    assert_eq!(request.data, [9, 130, 0]);
}

/// No. 36: the bytes of a poll response under an explicit-response identifier. As what the identifier says, they are a
/// first fragment whose fragmentation byte is an acknowledge.
#[test]
fn the_misprint_reads_as_what_its_bytes_say() {
    let vector = by_number(36);
    assert_eq!(vector.kind, Kind::Misprint);
    assert_eq!(Identifier::new(vector.id).unwrap().purpose(), Purpose::ExplicitResponse);
    let acknowledge = FragmentAcknowledge::new(false, mac(0), 0x3F, AckStatus::Reserved(0x3F));
    assert_eq!(FragmentAcknowledge::parse(vector.data), Ok(acknowledge));
    assert!(ExplicitMessage::parse(vector.data).is_err());
    assert!(ExplicitFragment::parse(vector.data).is_err());
    assert_eq!(Identifier::poll_response(mac(5)).raw(), 0x3C5);
}

/// Every vector fits some wire type, and comes out of it again byte for byte; every number is used once.
#[test]
fn every_vector_survives_a_wire_type() {
    assert!(VECTORS.is_sorted_by(|a, b| a.number < b.number));
    for vector in VECTORS {
        let mut fits = 0;
        macro_rules! try_each {
            ($($Type:ident),*) => {$(
                if let Ok(message) = $Type::parse(vector.data) {
                    let mut buffer = [0; Frame::MAX_DATA + 1];
                    assert_eq!(round_trip(&message, &mut buffer), vector.data, "no. {}", vector.number);
                    fits += 1;
                }
            )*};
        }
        devicenet_core::for_each_wire_type!(try_each);
        assert!(fits > 0, "no. {}", vector.number);
    }
}
