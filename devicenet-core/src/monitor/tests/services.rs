//! Services for more than one attribute, or for less.

use super::*;

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
            &[0x0A, 2, 1, 2, 0, 6, 0, 10, 0, 0x0E, 1, 1, 1, 0x05, 1, 1],
            "Multiple_Service_Packet Message Router 1 Get_Attribute_Single  01 01 01; Reset  01 01",
            &[0x8A, 3, 0, 8, 0, 12, 0, 13, 0, 0x8E, 0x34, 0x12, 0x00, 0x85, 0x94, 0x08, 0xFF],
            "Multiple_Service_Packet: Get_Attribute_Single  34 12 00; Reset ok; error 0x08 Service not supported",
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
