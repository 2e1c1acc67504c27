//! Lists of attributes, and requests inside of a request.

use super::*;

#[test]
fn replies_of_get_attribute_list() {
    let bytes = [3, 0, 1, 0, 0, 0, 0x2F, 0x00, 9, 0, 0x14, 0, 7, 0, 0, 0, 2, b'D', b'N'];
    let replies = AttributeReplies::parse(&bytes).unwrap();
    let len = |id: AttributeId, data: &[u8]| match id.0 {
        1 => Some(2),
        7 => Some(usize::from(*data.first()?) + 1),
        _ => None,
    };
    let found: Vec<_> = replies.iter(len).map(|reply| reply.unwrap().value).collect();
    assert_eq!(found, [Ok(&[0x2F, 0x00][..]), Err(GeneralStatus::ATTRIBUTE_NOT_SUPPORTED), Ok(b"\x02DN")]);
    assert_eq!(replies.iter(|_, _| None).count(), 1);

    let impossible = AttributeReplies::parse(&[1, 0, 9, 0, 0x00, 0x01]).unwrap();
    assert_eq!(impossible.iter(|_, _| Some(0)).next().unwrap().unwrap_err().field, "status");
}

#[test]
fn settings_of_set_attribute_list() {
    let settings = AttributeSettings::parse(&[2, 0, 9, 0, 0x4B, 0x00, 12, 0, 1]).unwrap();
    let len = |id: AttributeId, _: &[u8]| Some(if id.0 == 9 { 2 } else { 1 });
    let found: Vec<_> = settings.iter(len).map(Result::unwrap).collect();
    assert_eq!(found, [(AttributeId(9), &[0x4B, 0x00][..]), (AttributeId(12), &[1])]);

    let longer = AttributeSettings::parse(&[1, 0, 12, 0, 1, 0xFF]).unwrap();
    assert_eq!(longer.iter(len).last().unwrap().unwrap_err().kind, ParseErrorKind::Trailing { found: 1 });
    let shorter = AttributeSettings::parse(&[3, 0, 12, 0]).unwrap();
    assert!(shorter.iter(len).map(|entry| entry.unwrap_err().field).eq(["value"]));
}

/// A list that its reader could not take apart is not written, not even in part.
#[test]
fn lists_that_cannot_be_read_are_refused() {
    let mut buffer = std::vec![0; 200_000];
    let mut out = Writer::new(&mut buffer);
    let absent = AttributeReply { attribute: AttributeId(7), value: Err(GeneralStatus::SUCCESS) };
    let present = AttributeReply { attribute: AttributeId(1), value: Ok(&[1, 2]) };
    let error = AttributeReplies::emit_replies(&[present, absent], &mut out).unwrap_err();
    assert_eq!(error, ListError::NoValue(AttributeId(7)));
    assert_eq!(error.to_string(), "attribute 7: a reply without a value needs a status other than success");
    assert_eq!(InstanceList::emit_instances(&[InstanceId(1); 256], &mut out), Err(ListError::TooLong));
    assert_eq!(UintList::emit_numbers(&[0; 0x1_0000], &mut out), Err(ListError::TooLong));
    let long = [0; 0xFFFF];
    assert_eq!(emit_packets(&[&long, &[]], &mut out), Err(ListError::TooLong));
    assert!(out.is_empty());
    let mut short = [0; 5];
    let mut out = Writer::new(&mut short);
    assert_eq!(UintList::emit_numbers(&[1, 2], &mut out), Err(ListError::Full(Full)));
    assert!(out.is_empty());
}

#[test]
fn multiple_service_packets_survive() {
    let services: [&[u8]; 3] = [&[0x0E, 1, 1, 1], &[], &[0x05, 1, 1]];
    let mut buffer = [0; 40];
    let mut out = Writer::new(&mut buffer);
    emit_packets(&services, &mut out).unwrap();
    let packet = MultipleServicePacket::parse(out.written()).unwrap();
    assert!(packet.services().eq(services));

    for bad in [&[1, 0, 3, 0][..], &[1, 0, 5, 0, 0], &[2, 0, 6, 0, 5, 0], &[2, 0, 6, 0, 7, 0], &[0, 0, 1]] {
        assert!(MultipleServicePacket::parse(bad).is_err(), "{bad:02X?}");
    }
    assert_eq!(MultipleServicePacket::parse(&[0, 0]).unwrap().services().count(), 0);
}
