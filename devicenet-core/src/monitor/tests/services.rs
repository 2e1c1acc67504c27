//! Services for more than one attribute, or for less.

use super::*;
use cip_core::code::{InstanceId, ServiceCode};

impl Bus {
    /// A message of master 1 to a slave or of the slave, in as many fragments as it takes; the reading of the last frame.
    fn message(&mut self, slave: u8, message: u8, body: &[u8]) -> Heard {
        if body.len() <= 7 {
            return self.group2(slave, message, &[&[0x01], body].concat());
        }
        let last = (body.len() - 1) / 6;
        let mut heard = None;
        for (index, piece) in body.chunks(6).enumerate() {
            let kind = if index == 0 {
                0x00
            } else if index == last {
                0x80
            } else {
                0x40
            };
            let byte = kind | u8::try_from(index).unwrap();
            heard = Some(self.group2(slave, message, &[&[0x81, byte], piece].concat()));
            self.group2(slave, 7 - message, &[0x81, 0xC0 | u8::try_from(index).unwrap(), 0]);
        }
        heard.unwrap()
    }

    /// The words of a request and of its response, without those of a fragment.
    fn exchange(&mut self, request: &[u8], response: &[u8]) -> (String, String) {
        let words = |heard: Heard| {
            assert_eq!(heard.problem, None, "{}", heard.text);
            let (_, words) = heard.text.split_once("  ").unwrap();
            words.rsplit("completes ").next().unwrap().to_string()
        };
        let asked = words(self.message(10, 4, request));
        (asked, words(self.message(10, 3, response)))
    }
}

#[test]
fn services_with_a_layout_in_words() {
    let cases: &[(&[u8], &str, &[u8], &str)] = &[
        (
            &[0x03, 1, 1, 3, 0, 1, 0, 7, 0, 99, 0],
            "Get_Attribute_List Identity 1 Vendor ID, Product name, attribute 99",
            &[0x83, 3, 0, 1, 0, 0, 0, 0x34, 0x12, 7, 0, 0, 0, 2, b'a', b'b', 99, 0, 0x14, 0],
            "Get_Attribute_List: Vendor 4660, Product name \"ab\", attribute 99 error 0x14 Attribute not supported",
        ),
        // The length of an attribute that is not known: nothing can be told apart behind it.
        (
            &[0x03, 0x64, 1, 1, 0, 1, 0],
            "Get_Attribute_List class 0x64 1 attribute 1",
            &[0x83, 1, 0, 1, 0, 0, 0, 5],
            "Get_Attribute_List: 01 00 01 00 00 00 05",
        ),
        (
            &[0x04, 5, 2, 2, 0, 9, 0, 75, 0, 12, 0, 1],
            "Set_Attribute_List Connection 2 EPR 75 ms, watchdog_timeout_action Auto delete",
            &[0x84, 2, 0, 9, 0, 0, 0, 12, 0, 9, 0],
            "Set_Attribute_List: expected_packet_rate ok, watchdog_timeout_action error 0x09 Invalid attribute value",
        ),
        (
            &[
                0x0A, 2, 1, 4, 0, 10, 0, 14, 0, 20, 0, 23, 0, 0x0E, 1, 1, 1, 0x10, 5, 2, 9, 75, 0, 0x05, 1,
                1, 0x0A, 2, 1, 0, 0,
            ],
            "Multiple_Service_Packet Message Router 1 Get_Attribute_Single Identity 1 Vendor ID; \
             Set_Attribute_Single Connection 2 EPR 75 ms; Reset Identity 1; Multiple_Service_Packet  00 00",
            &[
                0x8A, 4, 0, 10, 0, 13, 0, 16, 0, 19, 0, 0x8E, 0x34, 0x12, 0x90, 80, 0, 0x94, 0x08, 0xFF,
                0x8A, 0, 0,
            ],
            "Multiple_Service_Packet: Get_Attribute_Single: Vendor 4660; \
             Set_Attribute_Single: EPR 80 ms (75 ms requested); \
             Reset: error 0x08 Service not supported; Multiple_Service_Packet: 00 00",
        ),
        (
            &[0x18, 4, 101, 3, 2, 0],
            "Get_Member Assembly 101 Data member 2",
            &[0x98, 7, 8],
            "Get_Member: Data 07 08",
        ),
        (
            &[0x1A, 4, 101, 2, 3, 0, 9],
            "Insert_Member Assembly 101 Member list member 3  09",
            &[0x9A, 3, 0],
            "Insert_Member: Member list member 3",
        ),
        (&[0x05, 1, 1, 1], "Reset Identity 1 out-of-box configuration", &[0x85], "Reset: ok"),
        (
            &[0x11, 5, 0, 4],
            "Find_Next_Object_Instance Connection class at most 4",
            &[0x91, 2, 1, 0, 2, 0],
            "Find_Next_Object_Instance: instance 1, instance 2",
        ),
        (&[0x08, 5, 0], "Create Connection class", &[0x88, 7, 0], "Create: instance 7"),
    ];
    for &(request, asked, response, answered) in cases {
        let mut bus = Bus::with_slave(10, 0x01);
        assert_eq!(bus.exchange(request, response), (asked.into(), answered.into()));
    }
}

#[test]
fn a_list_of_attributes_teaches_like_the_single_ones() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.exchange(
        &[0x03, 5, 2, 3, 0, 7, 0, 8, 0, 9, 0],
        &[0x83, 3, 0, 7, 0, 0, 0, 3, 0, 8, 0, 0, 0, 1, 0, 9, 0, 0, 0, 75, 0],
    );
    let record = bus.connection(10, Predefined::Poll);
    assert_eq!((record.produced_size, record.consumed_size, record.epr), (Some(3), Some(1), Some(75)));
}

/// The values of what was set stand in the request, which the response does not repeat.
#[test]
fn what_a_list_has_set_is_learned() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.exchange(
        &[0x04, 5, 2, 5, 0, 9, 0, 75, 0, 12, 0, 1, 17, 0, 10, 0, 14, 0, 0x20, 4, 0x24, 101, 0x30, 3],
        &[0x84, 3, 0, 9, 0, 0, 0, 12, 0, 0, 0, 17, 0, 9, 0],
    );
    let record = bus.connection(10, Predefined::Poll);
    assert_eq!((record.state, record.epr), (ConnectionState::Established, Some(75)));
    assert_eq!((record.watchdog_action, record.inhibit), (Some(1), None), "attribute 17 was refused");
}

/// A status of two bytes whose low one is zero is not a success.
#[test]
fn a_status_that_does_not_exist_is_no_success() {
    let mut bus = Bus::with_slave(10, 0x03);
    let (_, answer) = bus.exchange(&[0x04, 5, 2, 1, 0, 9, 0, 75, 0], &[0x84, 1, 0, 9, 0, 0, 1]);
    assert_eq!(answer, "Set_Attribute_List: expected_packet_rate error 0x0100");
    assert_eq!(bus.connection(10, Predefined::Poll).epr, Some(0));
}

#[test]
fn a_path_that_was_set_is_known() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.monitor.set_io_sizes(mac(10), Predefined::Poll, Some(1), Some(2));
    bus.exchange(&[0x10, 5, 2, 14, 0x20, 4, 0x24, 101, 0x30, 3], &[0x90]);
    let record = bus.connection(10, Predefined::Poll);
    assert_eq!((record.produced_path, record.produced_size), (Some(InstanceId(101)), None));
    assert_eq!((record.consumed_path, record.consumed_size), (None, Some(1)));
}

/// Nobody says in which order the attributes stand: what was known of them is not known any more.
#[test]
fn all_attributes_set_at_once_are_learned_again() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.monitor.set_io_sizes(mac(10), Predefined::Poll, Some(1), Some(2));
    bus.establish(10, 2, 75);
    bus.exchange(&[0x02, 5, 2, 1, 2, 3], &[0x82]);
    let record = bus.connection(10, Predefined::Poll);
    assert_eq!((record.consumed_size, record.produced_size, record.epr), (None, None, None));
    bus.wait(60_000).frame(0x7C0, &[]);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::Established, "no watchdog");
}

#[test]
fn requests_in_a_packet_teach_like_single_ones() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.exchange(
        &[0x0A, 2, 1, 3, 0, 8, 0, 14, 0, 18, 0, 0x10, 5, 2, 9, 75, 0, 0x0E, 1, 1, 3, 0x10, 5, 2, 12, 1],
        &[0x8A, 3, 0, 8, 0, 11, 0, 14, 0, 0x90, 80, 0, 0x8E, 0x6C, 0x05, 0x94, 0x09, 0xFF],
    );
    let record = bus.connection(10, Predefined::Poll);
    assert_eq!((record.state, record.epr), (ConnectionState::Established, Some(80)));
    assert_eq!(record.watchdog_action, Some(0), "refused");
    assert_eq!(bus.node(10).product, Some(1388));
}

#[test]
fn what_is_wrong_inside_of_a_packet() {
    let mut bus = Bus::with_slave(10, 0x01);
    let short = bus.message(10, 4, &[0x0A, 2, 1, 1, 0, 4, 0, 0x0E, 1]);
    assert_eq!(
        short.problem,
        Some(Problem::Flaw(Flaw::TooShort { at_least: 3, found: 2 })),
        "{}",
        short.text
    );
    let beyond = bus.message(10, 4, &[0x0A, 2, 1, 1, 0, 9, 0, 0x05, 1, 1]);
    assert_eq!(beyond.problem, Some(Problem::Flaw(Flaw::ReservedValue { field: "offset", found: 9 })));
    bus.message(10, 4, &[0x0A, 2, 1, 1, 0, 4, 0, 0x0E, 1, 1, 1]);
    let other = bus.message(10, 3, &[0x8A, 1, 0, 4, 0, 0x85]);
    assert_eq!(
        other.problem,
        Some(Problem::Flaw(Flaw::ServiceMismatch { expected: ServiceCode::GET_ATTRIBUTE_SINGLE }))
    );
    bus.message(10, 4, &[0x0A, 2, 1, 1, 0, 4, 0, 0x05, 1, 1]);
    let more = bus.message(10, 3, &[0x8A, 2, 0, 6, 0, 7, 0, 0x85, 0x85]);
    assert_eq!(more.problem, Some(Problem::Flaw(Flaw::UnexpectedResponse)));
}

/// Reset of the class resets every connection.
#[test]
fn a_reset_of_the_class_brings_back_what_has_timed_out() {
    let mut bus = Bus::with_slave(10, 0x03);
    bus.establish(10, 2, 1000);
    bus.group2(10, 4, &[0x01, 0x10, 5, 1, 9, 0, 0]);
    bus.group2(10, 3, &[0x01, 0x90, 0, 0]);
    bus.wait(20_000).group2(10, 5, &[]);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::TimedOut);
    bus.exchange(&[0x05, 5, 0], &[0x85]);
    assert_eq!(bus.state(10, Predefined::Poll), ConnectionState::Established);
    let strobe = ConnectionName::Predefined(Predefined::BitStrobe);
    assert!(bus.monitor.connections().all(|held| held.name != strobe), "it does not exist");
}
