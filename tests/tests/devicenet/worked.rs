//! Exchanges that were computed from the rules of the protocol, asserted line by line.

use crate::harness::Observer;

/// Feeds frames a millisecond apart, or at the time before the `@`, and compares the words, which stand behind a `|`.
#[track_caller]
fn assert_reads(trace: &str) {
    let mut observer = Observer::new();
    let mut now = 0;
    for line in trace.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let (frame, expected) = line.split_once('|').expect("a frame and its words");
        let frame = match frame.split_once('@') {
            Some((at, frame)) => {
                now = at.trim().parse().expect("milliseconds");
                frame
            }
            None => frame,
        };
        assert_eq!(observer.line(now, frame).text, expected.trim(), "{line}");
        now += 1;
    }
}

/// Start-up, exchange and release of one slave: master 4, slave 63 (Group 2 only, vendor 0x03E7, one output byte, two
/// input bytes, expected packet rates rounded up to 10 ms).
#[test]
fn a_slave_from_its_power_up_to_its_release() {
    assert_reads(
        "
        5FF: 00 E7 03 44 33 22 11        | dup MAC 63 request  vendor 999 serial 0x11223344
        1000 @ 5FF: 00 E7 03 44 33 22 11 | dup MAC 63 request  vendor 999 serial 0x11223344
        2100 @ 784: 3F 4B 00 31          | 4 -> 63  Open Group 3 Message ID 1, body format 8/8
        3100 @ 784: 3F 4B 00 31          | 4 -> 63  Open Group 3 Message ID 1, body format 8/8
        4100 @ 5FE: 04 4B 03 01 01 04    | 4 -> 63  Allocate explicit, master 4
        5FB: 04 CB 00                    | 63 -> 4  Allocate: body format 8/8
        5FC: 44 10 05 01 0C 03           | 4 -> 63  Set_Attribute_Single Connection 1 watchdog_timeout_action Deferred delete
        5FB: 44 90                       | 63 -> 4  Set_Attribute_Single: ok
        5FC: 04 0E 01 01 01              | 4 -> 63  Get_Attribute_Single Identity 1 Vendor ID
        5FB: 04 8E E7 03                 | 63 -> 4  Get_Attribute_Single: Vendor 999
        5FC: 44 0E 01 01 02              | 4 -> 63  Get_Attribute_Single Identity 1 Device type
        5FB: 44 8E 07 00                 | 63 -> 4  Get_Attribute_Single: Device type 7 (General purpose discrete I/O)
        5FC: 04 0E 01 01 03              | 4 -> 63  Get_Attribute_Single Identity 1 Product code
        5FB: 04 8E 2A 00                 | 63 -> 4  Get_Attribute_Single: Product code 42
        5FC: 44 4B 03 01 02 04           | 4 -> 63  Allocate poll, master 4
        5FB: 44 CB 00                    | 63 -> 4  Allocate: body format 8/8
        5FC: 04 0E 05 02 07              | 4 -> 63  Get_Attribute_Single Connection 2 produced_connection_size
        5FB: 04 8E 02 00                 | 63 -> 4  Get_Attribute_Single: produced_connection_size 2
        5FC: 44 0E 05 02 08              | 4 -> 63  Get_Attribute_Single Connection 2 consumed_connection_size
        5FB: 44 8E 01 00                 | 63 -> 4  Get_Attribute_Single: consumed_connection_size 1
        5FC: 04 10 05 02 09 4B 00        | 4 -> 63  Set_Attribute_Single Connection 2 EPR 75 ms
        5FB: 04 90 50 00                 | 63 -> 4  Set_Attribute_Single: EPR 80 ms (75 ms requested)
        5FD: 03                          | poll 63 <- 4  03
        3FF: 34 12                       | poll 63 -> 4  34 12
        5FD:                             | poll 63 <- 4
        3FF: 34 12                       | poll 63 -> 4  34 12
        5FC: 44 4C 03 01 03              | 4 -> 63  Release explicit + poll
        5FB: 44 CC                       | 63 -> 4  Release: ok
        ",
    );
}

/// Client 2, server 20, Group 3, format 8/8.
#[test]
fn ucmm_opens_a_connection_in_group_3() {
    assert_reads(
        "
        782: 14 4B 00 31       | 2 -> 20  Open Group 3 Message ID 1, body format 8/8
        754: 02 CB 00 02 07 00 | 20 -> 2  Open: instance 7, Message ID 2, body format 8/8
        642: 14 0E 01 01 01    | 2 -> 20  Get_Attribute_Single Identity 1 Vendor ID
        694: 02 8E 22 01       | 20 -> 2  Get_Attribute_Single: Vendor 290
        782: 14 4C 07 00       | 2 -> 20  Close instance 7
        754: 02 CC             | 20 -> 2  Close: instance 7
        ",
    );
}

/// In Group 2 the server chooses both Message IDs, and every header carries the client.
#[test]
fn ucmm_opens_a_connection_in_group_2() {
    assert_reads(
        "
        782: 14 4B 02 10       | 2 -> 20  Open Group 2, body format 16/16
        754: 02 CB 00 45 06 00 | 20 -> 2  Open: instance 6, Message ID 5, requests on 4, body format 8/8
        4A4: 02 0E 01 01 01    | 2 -> 20  Get_Attribute_Single Identity 1 Vendor ID
        4A5: 02 8E 22 01       | 20 -> 2  Get_Attribute_Single: Vendor 290
        ",
    );
}

/// In Group 1 both ends choose their own.
#[test]
fn ucmm_opens_a_connection_in_group_1_with_paths() {
    assert_reads(
        "
        782: 14 4B 04 03                | 2 -> 20  Open Group 1 Message ID 3, body format CIP path
        754: 02 CB 04 05 06 00          | 20 -> 2  Open: instance 6, Message ID 5, body format CIP path
        0C2: 94 00 0E 03 20 01 24 01    | 2 -> 20  first fragment 0  0E 03 20 01 24 01
        154: 82 C0 00                   | 20 -> 2  acknowledge of fragment 0
        0C2: 94 81 30 01                | 2 -> 20  last fragment 1 completes Get_Attribute_Single Identity 1 Vendor ID
        154: 82 C1 00                   | 20 -> 2  acknowledge of fragment 1
        154: 02 8E 22 01                | 20 -> 2  Get_Attribute_Single: Vendor 290
        ",
    );
}

/// Master 4 sets six bytes of an assembly of slave 63: a body of ten bytes.
#[test]
fn an_explicit_message_in_two_fragments() {
    assert_reads(
        "
        5FE: 04 4B 03 01 01 04       | 4 -> 63  Allocate explicit, master 4
        5FB: 04 CB 00                | 63 -> 4  Allocate: body format 8/8
        5FC: 84 00 10 04 66 03 01 02 | 4 -> 63  first fragment 0  10 04 66 03 01 02
        5FB: 84 C0 00                | 63 -> 4  acknowledge of fragment 0
        5FC: 84 81 03 04 05 06       | 4 -> 63  last fragment 1 completes Set_Attribute_Single Assembly 102 Data 01 02 03 04 05 06
        5FB: 84 C1 00                | 63 -> 4  acknowledge of fragment 1
        5FB: 04 90                   | 63 -> 4  Set_Attribute_Single: ok
        ",
    );
}

/// A poll command of ten bytes to slave 63, whose consumed size was read.
#[test]
fn an_io_message_in_two_fragments() {
    assert_reads(
        "
        5FE: 04 4B 03 01 03 04       | 4 -> 63  Allocate explicit + poll, master 4
        5FB: 04 CB 00                | 63 -> 4  Allocate: body format 8/8
        5FC: 44 0E 05 02 08          | 4 -> 63  Get_Attribute_Single Connection 2 consumed_connection_size
        5FB: 44 8E 0A 00             | 63 -> 4  Get_Attribute_Single: consumed_connection_size 10
        5FC: 04 10 05 02 09 4B 00    | 4 -> 63  Set_Attribute_Single Connection 2 EPR 75 ms
        5FB: 04 90 50 00             | 63 -> 4  Set_Attribute_Single: EPR 80 ms (75 ms requested)
        5FD: 00 A1 A2 A3 A4 A5 A6 A7 | poll 63 <- 4  first fragment 0  A1 A2 A3 A4 A5 A6 A7
        5FD: 81 A8 A9 AA             | poll 63 <- 4  last fragment 1 completes  A1 A2 A3 A4 A5 A6 A7 A8 A9 AA
        3FF: 01                      | poll 63 -> 4  01
        5FD: 3F 11 12                | poll 63 <- 4  first and only fragment completes  11 12  ! 10 bytes expected, 2 found
        ",
    );
}
