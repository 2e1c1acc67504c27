//! The laws of every wire type.

use core::net::Ipv4Addr;

use link_core::codec::Writer;
use link_core::codec::laws::round_trip;
use link_core::samples;
use proptest::prelude::*;
use std::vec::Vec;

use super::*;
use crate::ethernet::{MAX_FRAME, MIN_FRAME};
use crate::{MacAddress, NodeId};

fn flags() -> impl Strategy<Value = Flags> {
    any::<u8>().prop_map(Flags::from_bits_retain)
}

fn free(most: usize) -> impl Strategy<Value = &'static [u8]> {
    prop::collection::vec(any::<u8>(), 0..=most).prop_map(|bytes| &*bytes.leak())
}

fn net_time() -> impl Strategy<Value = NetTime> {
    (any::<u32>(), any::<u32>()).prop_map(|(seconds, nanoseconds)| NetTime { seconds, nanoseconds })
}

fn stamp() -> impl Strategy<Value = ConfigurationStamp> {
    (any::<u32>(), any::<u32>()).prop_map(|(date, time)| ConfigurationStamp { date, time })
}

fn half() -> impl Strategy<Value = SequenceHalf> {
    (0_u8..64, prop::sample::select(&[Con::None, Con::Initialisation, Con::Valid, Con::Request]))
        .prop_map(|(number, connection)| SequenceHalf::new(number, connection))
}

fn segmentation() -> impl Strategy<Value = Segmentation> {
    prop_oneof![
        Just(Segmentation::Expedited),
        any::<u32>().prop_map(|total| Segmentation::Initiate { total }),
        Just(Segmentation::Segment),
        Just(Segmentation::Complete),
    ]
}

fn is_padding(command: &SdoCommand<'_>) -> bool {
    *command == SdoCommand::request(command.transaction, SdoCommandId::NIL, &[])
}

samples! {
    Soc = (flags(), net_time(), any::<u64>())
        .prop_map(|(flags, net_time, relative_time)| Self { flags, net_time, relative_time });
    Preq<'static> = (flags(), any::<u8>(), free(40))
        .prop_map(|(flags, version, data)| Self { flags, pdo_version: PdoVersion(version), data });
    Pres<'static> = (any::<[u8; 3]>(), flags(), free(40)).prop_map(|([state, request, version], flags, data)| Self {
        state: NmtStateCode(state),
        flags,
        request: AsyncRequest(request),
        pdo_version: PdoVersion(version),
        data,
    });
    Soa = (any::<[u8; 4]>(), flags()).prop_map(|([state, service, target, version], flags)| Self {
        state: NmtStateCode(state),
        flags,
        service: RequestedService(service),
        target: NodeId(target),
        version,
    });
    IdentResponse = (
        (any::<[u8; 3]>(), flags(), any::<[u16; 3]>(), any::<[u32; 7]>(), any::<u64>()),
        (stamp(), stamp(), any::<[u32; 3]>(), any::<[u8; 32]>(), prop::collection::vec(any::<u8>(), 48)),
    )
        .prop_map(|((bytes, flags, sizes, numbers, vendor_extension_1), (configuration, software, ip, host_name, last))| {
            let [request, state, version] = bytes;
            let [mtu, poll_in_size, poll_out_size] = sizes;
            let [features, response_time, device_type, vendor_id, product_code, revision, serial_number] = numbers;
            let [address, subnet_mask, gateway] = ip.map(Ipv4Addr::from);
            Self {
                flags,
                request: AsyncRequest(request),
                state: NmtStateCode(state),
                version,
                features: FeatureFlags::from_bits_retain(features),
                mtu,
                poll_in_size,
                poll_out_size,
                response_time,
                device_type,
                identity: Identity { vendor_id, product_code, revision, serial_number },
                vendor_extension_1,
                configuration,
                software,
                ip: IpParameters { address, subnet_mask, gateway },
                host_name,
                vendor_extension_2: last.try_into().unwrap(),
            }
        });
    ErrorEntry = (any::<[u16; 2]>(), net_time(), any::<u64>()).prop_map(|([kind, code], time, additional)| Self {
        kind: EntryType(kind),
        code: ErrorCode(code),
        time,
        additional,
    });
    StatusResponse = (any::<[u8; 2]>(), flags(), any::<[u8; 8]>(), prop::collection::vec(ErrorEntry::strategy(), 2..=13))
        .prop_map(|([request, state], flags, static_errors, entries)| Self {
            flags,
            request: AsyncRequest(request),
            state: NmtStateCode(state),
            static_errors,
            entries: entries.into_iter().collect(),
        });
    NmtCommand<'static> = (any::<u8>(), free(MAX_COMMAND_DATA))
        .prop_map(|(command, data)| Self { command: NmtCommandId(command), data });
    NmtRequest<'static> = (any::<u8>(), any::<u8>(), free(MAX_COMMAND_DATA))
        .prop_map(|(command, target, data)| Self { command: NmtCommandId(command), target: NodeId(target), data });
    SdoSequence = (half(), half()).prop_map(|(receive, send)| Self { receive, send });
    SdoCommand<'static> = (any::<[u8; 2]>(), any::<[bool; 2]>(), segmentation(), free(40)).prop_map(
        |([transaction, command], [is_response, is_abort], segmentation, data)| {
            Self { transaction, is_response, is_abort, segmentation, command: SdoCommandId(command), data }
        });
    Sdo<'static> = (SdoSequence::strategy(), prop::option::of(SdoCommand::strategy())).prop_map(|(sequence, command)| {
        Self { sequence, command: command.filter(|command| !is_padding(command)) }
    });
}

/// What is accepted is written as it was read, reserved bits and padding as zeros.
#[track_caller]
fn accepted_bytes_survive<'a, T: Wire<'a> + PartialEq + core::fmt::Debug>(
    bytes: &'a [u8],
    buffer: &'a mut [u8],
) {
    let Ok(value) = T::parse(bytes) else { return };
    let mut writer = Writer::new(buffer);
    value.emit(&mut writer).unwrap();
    let emitted = writer.into_written();
    assert_eq!(T::parse(emitted).as_ref(), Ok(&value));
    assert!(emitted.len() <= bytes.len());
    for (index, (ours, theirs)) in emitted.iter().zip(bytes).enumerate() {
        assert_eq!(ours & theirs, *ours, "byte {index} of {value:?}");
    }
}

/// Sizes that fit, so that much of it is accepted.
fn near_messages() -> impl Strategy<Value = Vec<u8>> {
    let lengths = prop_oneof![0_usize..=24, Just(54_usize), Just(74), Just(158)];
    (lengths, 0_usize..12, any::<bool>()).prop_flat_map(|(len, at, is_sparse)| {
        let byte =
            if is_sparse { prop_oneof![4 => Just(0), 1 => any::<u8>()].boxed() } else { any::<u8>().boxed() };
        prop::collection::vec(byte, len).prop_map(move |mut bytes| {
            let size = bytes.len().saturating_sub(at + 2);
            if let Some([low, high]) = bytes.get_mut(at..at + 2) {
                [*low, *high] = u16::try_from(size).unwrap().to_le_bytes();
            }
            bytes
        })
    })
}

macro_rules! test_laws {
    ($($Type:ident),*) => {
        proptest! {
            $(
                #[test]
                #[expect(non_snake_case, reason = "named after the type")]
                fn $Type(value in $Type::strategy(), bytes in near_messages()) {
                    round_trip(&value, &mut [0; 400]);
                    accepted_bytes_survive::<$Type>(&bytes, &mut [0; 400]);
                }
            )*
        }
    };
}

crate::for_each_wire_type!(test_laws);

fn body() -> impl Strategy<Value = Body<'static>> {
    prop_oneof![
        Soc::strategy().prop_map(Body::Soc),
        Preq::strategy().prop_map(Body::Preq),
        Pres::strategy().prop_map(Body::Pres),
        Soa::strategy().prop_map(Body::Soa),
        IdentResponse::strategy().prop_map(Body::IdentResponse),
        StatusResponse::strategy().prop_map(Body::StatusResponse),
        Sdo::strategy().prop_map(Body::Sdo),
    ]
}

proptest! {
    /// Padding is not part of a message: the commands and requests, whose data nothing tells from it, are left out.
    #[test]
    fn frames_are_padded_and_read_as_they_were_written(
        body in body(),
        macs in any::<[[u8; 6]; 2]>(),
        [to, from] in any::<[u8; 2]>(),
        more in 0_usize..20,
    ) {
        let [destination, source] = macs.map(MacAddress);
        let frame = Frame { destination, source, to: NodeId(to), from: NodeId(from), body };
        let mut buffer = [0; MAX_FRAME];
        let len = frame.emit(&mut buffer).unwrap().len();
        prop_assert!(len >= MIN_FRAME);
        prop_assert_eq!(Frame::parse(&buffer[..len]), Ok(frame.clone()));
        let is_list = matches!(frame.body, Body::StatusResponse(_));
        if !is_list {
            prop_assert_eq!(Frame::parse(&buffer[..len + more]), Ok(frame.clone()));
        }
    }

    #[test]
    fn no_bytes_break_the_parser(bytes in prop::collection::vec(any::<u8>(), 0..200), kind in 0_u8..8) {
        let mut bytes = bytes;
        if let Some(ethertype) = bytes.get_mut(12..15) {
            ethertype.copy_from_slice(&[0x88, 0xAB, kind]);
        }
        let _ = Frame::parse(&bytes);
    }

    /// The two readings of SegmentSize, each with itself.
    #[test]
    fn both_readings_of_segment_size_read_what_they_wrote(command in SdoCommand::strategy(), counted in any::<bool>()) {
        let initiate = if counted { InitiateSize::Counted } else { InitiateSize::NotCounted };
        let mut buffer = [0; 100];
        let mut out = Writer::new(&mut buffer);
        command.emit_as(&mut out, initiate).unwrap();
        let mut reader = link_core::codec::Reader::new(out.into_written());
        prop_assert_eq!(SdoCommand::read_as(&mut reader, initiate), Ok(command));
        prop_assert!(reader.is_empty());
    }
}
