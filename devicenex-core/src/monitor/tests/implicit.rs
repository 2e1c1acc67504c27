//! Implicit messages: polled, multicast, change of state, with 11 and 29 bits, in fragments.

use super::*;

/// One producer, two consumers that are told its identifier (the paper's figures 12 to 18): OA 67 produces with Message ID 2
/// on its multicast connection, 5 and 109 consume it on theirs.
#[test]
fn one_produces_and_two_consume() {
    let mut bus = Bus::new();
    bus.connect(1, 67, &[0x4B, 0xC0, 7, 0, 0xF4, 1, 2], &[0x4B, 0xC2, 0x00, 0xF4, 1]);
    let heard = bus.extended(0x0286_0007, &[3, 0x6B]);
    assert_eq!((&*heard.text, heard.problem), ("multicast 67 -> *  03 6B", None));
    bus.connect(1, 5, &[0x4B, 0xC0, 13, 0, 0x64, 0, 0], &[0x4B, 0xC0, 0x00, 0x64, 0]);
    bus.consume(5, 13, 0x8286_0007);
    let heard = bus.extended(0x0286_0007, &[3, 0x6B]);
    assert_eq!((&*heard.text, heard.dst), ("multicast 67 -> 5  03 6B", Some(5)));
    bus.connect(1, 109, &[0x4B, 0xC0, 13, 0, 0, 0, 0], &[0x4B, 0xC0, 0x00, 0, 0]);
    bus.consume(109, 13, 0x8286_0007);
    assert_eq!(bus.extended(0x0286_0007, &[3, 0x6B]).text, "multicast 67 -> *  03 6B");
    assert_eq!((bus.held(5, 13).frames, bus.held(109, 13).frames, bus.held(67, 7).frames), (2, 1, 3));
    // Four times 100 ms; without a rate there is no watchdog.
    bus.wait(401).standard(0x3FF, &[]);
    assert_eq!(bus.held(5, 13).state, ConnectionState::TimedOut);
    assert_eq!(bus.held(109, 13).state, ConnectionState::Established);
}

#[test]
fn the_consumed_identifier_is_printed_and_checked() {
    let mut bus = Bus::new();
    bus.connect(1, 67, &[0x4B, 0xC0, 7, 0, 0xF4, 1, 2], &[0x4B, 0xC2, 0x00, 0xF4, 1]);
    bus.connect(1, 67, &[0x4B, 0xD0, 1, 0, 0xC4, 0x09, 1], &[0x4B, 0xD0, 0x00, 0xC4, 0x09]);
    let heard = bus.explicit(1, 67, Direction::Request, 1, &[0x10, 5, 13, 5, 0x07, 0x00, 0x86, 0x82]);
    assert_eq!(heard.text, "1 -> 67  Set_Attribute_Single Connection 13 consumed_connection_id 0x02860007");
    bus.explicit(1, 67, Direction::Response, 1, &[0x90]);
    bus.explicit(1, 67, Direction::Request, 2, &[0x0E, 5, 7, 4]);
    let heard = bus.explicit(1, 67, Direction::Response, 2, &[0x8E, 0x07, 0x00, 0x86, 0x83]);
    let (expected, found) = (0x8286_0007.into(), 0x8386_0007.into());
    assert_eq!(heard.problem, Some(Problem::WrongConnectionId { expected, found }));
    bus.explicit(1, 67, Direction::Request, 3, &[0x0E, 5, 7, 4]);
    let heard = bus.explicit(1, 67, Direction::Response, 3, &[0x8E, 0x07, 0x00, 0x86, 0x82]);
    assert_eq!(heard.text, "67 -> 1  Get_Attribute_Single: produced_connection_id 0x02860007");
}

/// Message ID 4 of OA 1 asks, with 1, OA 67 and instance 3 in the place of its own instance; Message ID 2 of OA 67 answers.
#[test]
fn a_poll_is_answered() {
    let mut bus = Bus::new();
    bus.connect(1, 67, &[0x4B, 0xC4, 3, 0, 0x4B, 0, 0], &[0x4B, 0xC2, 0x00, 0x4B, 0]);
    let command = bus.extended(0x0402_C303, &[1]);
    assert_eq!((&*command.text, command.dst), ("polled 67 <- 1  01", Some(67)));
    let heard = bus.extended(0x0286_0003, &[3, 0x6B]);
    assert_eq!((&*heard.text, heard.answers()), ("polled 67 -> 1  03 6B", Some(command.n)));
    assert_eq!(bus.held(67, 3).last_latency, Some(core::time::Duration::from_millis(1)));
    let unanswered = bus.extended(0x0402_C303, &[1]).n;
    assert_eq!(bus.extended(0x0402_C303, &[1]).problem, Some(Flaw::PollUnanswered { n: unanswered }.into()));
    assert_eq!(bus.extended(0x0286_0003, &[3, 0x6B]).problem, None);
    assert_eq!(bus.extended(0x0286_0003, &[3, 0x6B]).problem, Some(Flaw::UnexpectedIoResponse.into()));
}

/// With A = 1 the node that asked for the connection acknowledges: OA 67 and instance 9 stand in the place of its own.
#[test]
fn a_change_of_state_is_acknowledged() {
    let mut bus = Bus::new();
    bus.connect(1, 67, &[0x4B, 0xC4, 9, 0, 0xE8, 3, 0], &[0x4B, 0xC2, 0x00, 0xE8, 3]);
    let data = bus.extended(0x0286_0009, &[3]);
    assert_eq!(data.text, "change of state 67 -> 1  03");
    let heard = bus.extended(0x0403_C309, &[]);
    assert_eq!((heard.kind, heard.answers()), (Kind::ImplicitAck, Some(data.n)));
    assert_eq!(heard.text, "change of state ack 67 <- 1");
    assert_eq!(bus.extended(0x0403_C309, &[]).problem, Some(Flaw::UnexpectedIoResponse.into()));
    let unacknowledged = bus.extended(0x0286_0009, &[4]).n;
    let heard = bus.extended(0x0286_0009, &[5]);
    assert_eq!(heard.problem, Some(Flaw::Unacknowledged { n: unacknowledged }.into()));
}

/// With 11 bits an acknowledge is a frame without data: Message ID 4 of OA 1, Group 1.
#[test]
fn a_change_of_state_is_acknowledged_with_eleven_bits() {
    let mut bus = Bus::new();
    bus.connect(1, 67, &[0x4B, 0x84, 8, 0, 0xE8, 3, 0], &[0x4B, 0x85, 0x00, 0xE8, 3]);
    let data = bus.standard(0x2C3, &[3]);
    assert_eq!(data.text, "change of state 67 -> 1  03");
    let heard = bus.standard(0x201, &[]);
    assert_eq!((heard.kind, heard.answers()), (Kind::ImplicitAck, Some(data.n)));
    assert_eq!(heard.text, "change of state ack 67 <- 1");
}

/// Until attribute 5 says more, a predefined consumer consumes what its requester produces on its own connection 7.
#[test]
fn a_producer_sets_up_its_own_consumer() {
    let mut bus = Bus::new();
    bus.connect(67, 5, &[0x4B, 0xC2, 13, 0, 0x64, 0, 0], &[0x4B, 0xC2, 0x00, 0x64, 0]);
    let heard = bus.extended(0x0286_0007, &[3]);
    assert_eq!((heard.dst, bus.held(5, 13).frames), (Some(5), 1));
}

/// Group Select 0, Message ID 5 of OA 67: `0 101 1000011`.
#[test]
fn eleven_bits_belong_to_the_connection_that_was_granted() {
    let mut bus = Bus::new();
    bus.connect(1, 67, &[0x4B, 0x80, 6, 0, 0xF4, 1, 2], &[0x4B, 0x85, 0x00, 0xF4, 1]);
    let heard = bus.standard(0x2C3, &[3, 0x6B]);
    assert_eq!((&*heard.text, heard.assumed), ("multicast 67 -> *  03 6B", false));
    assert_eq!(bus.held(67, 6).produced.unwrap().to_string(), "2C3");
    let heard = bus.standard(0x243, &[3]);
    assert_eq!(heard.text, "implicit group 1 message 4 67 -> *  03 (assumed)");
}

#[test]
fn a_message_of_known_size_comes_in_fragments() {
    let mut bus = Bus::new();
    bus.connect(1, 67, &[0x4B, 0xC0, 7, 0, 0xF4, 1, 2], &[0x4B, 0xC2, 0x00, 0xF4, 1]);
    bus.monitor.set_io_sizes(oa(67), InstanceId(7), None, Some(10));
    let heard = bus.extended(0x0286_0007, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!(heard.text, "multicast 67 -> *  first fragment 0  01 02 03 04 05 06 07");
    let heard = bus.extended(0x0286_0007, &[0x81, 8, 9, 10]);
    assert_eq!(heard.text, "multicast 67 -> *  last fragment 1 completes  01 02 03 04 05 06 07 08 09 0A");
    assert_eq!(heard.message.map(|data| data.len()), Some(10));
    bus.extended(0x0286_0007, &[0x00, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!(bus.extended(0x0286_0007, &[0x82, 8]).code(), Some("fragment_out_of_sequence"));
}

#[test]
fn what_nothing_has_told_of_is_assumed() {
    let mut bus = Bus::new();
    let heard = bus.extended(0x0286_0080, &[1]);
    assert_eq!((&*heard.text, heard.assumed), ("implicit dynamic 128 67 -> *  01 (assumed)", true));
    assert!(!bus.extended(0x0286_0080, &[1]).assumed);
    assert!(bus.held(67, 128).assumed);
    assert!(bus.extended(0x0403_C309, &[]).assumed);
    let heard = bus.extended(0x0402_C303, &[1]);
    assert_eq!(&*heard.text, "polled 67 <- 1  01 (assumed)");
    assert_eq!(bus.extended(0x02FE_0007, &[1]).code(), Some("no_address"));
}
