//! What is emitted is read back, and what is read is emitted again.

use super::*;

fn formats() -> impl Strategy<Value = BodyFormat> {
    prop::sample::select(&BodyFormat::ALL[..])
}

proptest! {
    #[test]
    fn requests_survive(format in formats(), service in 0..0x80_u8, class: u16, instance: u16, data in vec(any::<u8>(), 0..40)) {
        prop_assume!(format.can_address(ClassId(class), InstanceId(instance)));
        let request = Request::new(ServiceCode(service), ClassId(class), InstanceId(instance), &data);
        let body = emitted(&request, format);
        let read = Request::parse(format, &body).unwrap();
        prop_assert_eq!((read.service, read.data), (request.service, request.data));
        prop_assert_eq!((read.target.class(), read.target.instance()), (Some(ClassId(class)), Some(InstanceId(instance))));
        let mut buffer = [0; 64];
        laws::round_trip_by(
            &read,
            Tail::Open,
            &mut buffer,
            |bytes| Request::parse(format, bytes),
            |request, out| request.emit(format, out),
            |request| request.wire_len(format),
        );
    }

    #[test]
    fn accepted_requests_are_emitted_again(format in formats(), body in vec(any::<u8>(), 0..40)) {
        if let Ok(request) = Request::parse(format, &body) {
            let _ = request.to_string();
            let _ = request.attribute_access();
            prop_assert_eq!(emitted(&request, format), body);
        }
    }

    #[test]
    fn fixed_bodies_keep_the_laws(byte: u8, number: u16, numbers in vec(any::<u16>(), 0..8), data in vec(any::<u8>(), 0..8)) {
        match AllocateResponse::from_code(byte) {
            Some(response) => { laws::round_trip(&response, &mut [0; 2]); }
            None => prop_assert!(byte > 0x0F),
        }
        laws::round_trip(&FindNextRequest { max: byte }, &mut [0; 2]);
        laws::round_trip(&MemberId(number), &mut [0; 3]);
        laws::round_trip(&MemberRequest { attribute: byte, member: number, value: &data }, &mut [0; 16]);
        laws::round_trip(&CreateResponse { instance: InstanceId(number), data: &data }, &mut [0; 16]);

        let items: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let count = u8::try_from(numbers.len()).unwrap();
        let instances = [&[count], &items[..]].concat();
        laws::round_trip(&InstanceList::parse(&instances).unwrap(), &mut [0; 32]);
        let statuses = [&[count / 2, 0], &items[..usize::from(count / 2) * 4]].concat();
        laws::round_trip(&AttributeStatusList::parse(&statuses).unwrap(), &mut [0; 32]);
    }

    #[test]
    fn any_response_can_be_told(bytes in vec(any::<u8>(), 1..12), class in prop::sample::select(ClassId::NAMED), attribute in proptest::option::of(0..20_u16)) {
        let subject = Some(Subject { class, instance: InstanceId(1), attribute: attribute.map(AttributeId) });
        if let Ok(response) = Response::parse(&bytes) {
            let text = Answer { subject, response }.to_string();
            prop_assert_eq!(text.starts_with("error"), matches!(response, Response::Error { .. }));
        }
    }

    /// What is written is read as the same entries, and nothing of it fits into less room.
    #[test]
    fn lists_that_are_written_are_read(ids in vec((any::<u16>(), 1..=u8::MAX), 0..8), value in vec(any::<u8>(), 0..4)) {
        let mut buffer = [0; 80];
        let len = |_: AttributeId, _: &[u8]| Some(value.len());

        let instances: Vec<InstanceId> = ids.iter().map(|&(id, _)| InstanceId(id)).collect();
        let mut out = Writer::new(&mut buffer);
        InstanceList::emit_instances(&instances, &mut out).unwrap();
        prop_assert!(InstanceList::parse(out.written()).unwrap().iter().eq(instances.iter().copied()));

        let statuses: Vec<_> = ids.iter().map(|&(id, status)| (AttributeId(id), GeneralStatus(status))).collect();
        let mut out = Writer::new(&mut buffer);
        AttributeStatusList::emit_statuses(&statuses, &mut out).unwrap();
        let expected = statuses.iter().map(|&(id, status)| (id, u16::from(status.0)));
        prop_assert!(AttributeStatusList::parse(out.written()).unwrap().iter().eq(expected));

        let settings: Vec<_> = ids.iter().map(|&(id, _)| (AttributeId(id), &value[..])).collect();
        let mut out = Writer::new(&mut buffer);
        AttributeSettings::emit_settings(&settings, &mut out).unwrap();
        let read = AttributeSettings::parse(out.written()).unwrap();
        prop_assert!(read.iter(len).map(Result::unwrap).eq(settings.iter().copied()));

        let replies: Vec<_> = statuses.iter().map(|&(attribute, status)| AttributeReply {
            attribute,
            value: if status.0 % 2 == 0 { Ok(&value[..]) } else { Err(status) },
        }).collect();
        let mut out = Writer::new(&mut buffer);
        AttributeReplies::emit_replies(&replies, &mut out).unwrap();
        let last = out.len().saturating_sub(1);
        let read = AttributeReplies::parse(out.written()).unwrap();
        prop_assert!(read.iter(len).map(Result::unwrap).eq(replies.iter().copied()));
        let short = AttributeReplies::emit_replies(&replies, &mut Writer::new(&mut [0; 80][..last]));
        prop_assert_eq!(short, Err(ListError::Full(Full)));
    }

    #[test]
    fn lists_keep_the_laws(numbers in vec(any::<u16>(), 0..20)) {
        let mut buffer = [0; 64];
        let mut out = Writer::new(&mut buffer);
        UintList::emit_numbers(&numbers, &mut out).unwrap();
        let list = UintList::parse(out.written()).unwrap();
        prop_assert!(list.iter().eq(numbers.iter().copied()));
        laws::round_trip(&list, &mut [0; 64]);
    }
}
