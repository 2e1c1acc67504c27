//! Frames from manuals, captures and other implementations: what a decoder must make of them, and an encoder produce.
//!
//! A vector is never changed to fit the code: if a test with it fails, the code is wrong. The numbers are stable names;
//! they are even and have gaps. Frames of one source belong together, but messages are missing between them, so
//! they show as well whether a stateful decoder finds its way again.

/// One frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vector {
    pub(crate) number: u16,
    /// The 11-bit identifier.
    pub(crate) id: u16,
    pub(crate) data: &'static [u8],
    pub(crate) kind: Kind,
    pub(crate) meaning: &'static str,
    /// The document or capture.
    pub(crate) source: &'static str,
    /// Where in it; empty for a capture.
    pub(crate) place: &'static str,
}

/// How much a vector can be relied on, and what for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Kind {
    /// Printed in a vendor's manual: decoder and encoder must agree with it.
    Printed,
    /// A line of a capture: the decoder must agree with it.
    Logged,
    /// From the tests of another implementation.
    Fixture,
    /// Printed, and evidently wrong: the decoder must say so, or show what the bytes really mean.
    Misprint,
}

/// The vector of that number.
#[track_caller]
pub(crate) fn by_number(number: u16) -> Vector {
    *VECTORS.iter().find(|vector| vector.number == number).expect("a vector of that number")
}

const fn vector(
    number: u16,
    id: u16,
    data: &'static [u8],
    kind: Kind,
    meaning: &'static str,
    source: &'static str,
    place: &'static str,
) -> Vector {
    Vector { number, id, data, kind, meaning, source, place }
}

/// Slave 9, master 10.
const ICP_DAS_CAN_8124: &str = "ICP DAS CAN-8124/8224/8424 User Manual v2.0";
/// Slave 9, master 10.
const ICP_DAS_I_7242D: &str = "ICP DAS I-7242D User Manual v1.1";
/// Slave 3, master 10.
const POSITAL_MHK5: &str = "BEI Ideacod/POSITAL MHK5 manual UME-OCD-D2";
/// Slave 3, master 0.
const ROCKWELL_PICO: &str = "Rockwell 1760-UM003A-EN-P";
/// Slave 5, master 1.
const MKS_BARATRON: &str = "MKS Baratron DMA manual, appendix D";
/// Slave 2, master 1.
const JASIC: &str = "Jasic NBM-500R DeviceNet protocol V100";
/// Slave 2, master 0.
const KONVOLUCIO: &str = "Konvolucio.DeviceNet unit test logs of an Omron GRT1-DRT, 250 kbit/s, 2016";
/// Slave 63, master 0, UCMM, body format 16/16.
const IAI: &str = "capture of an IAI controller in a public ROS DeviceNet master";
const ANALYZER: &str = "AnlangA/devicenet-identifier-analyzer, tests";

/// All vectors, in the order of their numbers.
#[rustfmt::skip]
pub(crate) const VECTORS: &[Vector] = &[
    vector(2, 0x44E, &[0x0A, 0x4B, 0x03, 0x01, 0x07, 0x0A], Kind::Printed, "allocate explicit+poll+bit-strobe, slave 9, master 10, via Group 2 Only unconnected port", ICP_DAS_CAN_8124, "p. 112"),
    vector(4, 0x44B, &[0x0A, 0x90, 0x10, 0x0E], Kind::Printed, "set EPR response, value actually used 3600 ms", ICP_DAS_CAN_8124, "p. 113"),
    vector(6, 0x44C, &[0x0A, 0x10, 0x05, 0x04, 0x09, 0x0A, 0x0E], Kind::Printed, "set EPR of COS/cyclic connection (instance 4) to 3594 ms", ICP_DAS_I_7242D, "p. 83"),
    vector(8, 0x44C, &[0x0A, 0x10, 0x03, 0x01, 0x02, 0x01], Kind::Printed, "set DeviceNet object attribute 2 (baud rate) to 1 = 250 kbit/s", ICP_DAS_I_7242D, "p. 88"),
    vector(10, 0x7ED, &[0x3F, 0x4B, 0x02], Kind::Printed, "Who, Communication Faulted request, match bit 0, value 0x3F, time delay byte offset 2", ICP_DAS_I_7242D, "p. 93"),
    vector(12, 0x44D, &[0x81, 0x08, 0x09, 0x0A], Kind::Printed, "fragmented poll command, last fragment, count 1", ICP_DAS_I_7242D, "p. 95"),
    vector(14, 0x44C, &[0x0A, 0x10, 0x65, 0x01, 0x01, 0x01, 0x46, 0x00], Kind::Printed, "Set_Attribute_Single class 0x65 instance 1 attribute 1, data 01 46 00", ICP_DAS_I_7242D, "p. 101"),
    vector(16, 0x41C, &[0x0A, 0x10, 0x05, 0x01, 0x09, 0x00, 0x00], Kind::Printed, "set explicit connection EPR to 0 (no timeout)", POSITAL_MHK5, "p. 8"),
    vector(18, 0x41C, &[0x0A, 0x10, 0x05, 0x02, 0x09, 0x00, 0x00], Kind::Printed, "set poll connection EPR to 0", POSITAL_MHK5, "p. 8"),
    vector(20, 0x41C, &[0x0A, 0x10, 0x05, 0x04, 0x09, 0x00, 0x00], Kind::Printed, "set COS connection EPR to 0", POSITAL_MHK5, "p. 10"),
    vector(22, 0x41E, &[0x0A, 0x4C, 0x03, 0x01, 0x51], Kind::Printed, "release with choice 0x51 (bit 6 set although reserved in Release)", POSITAL_MHK5, "p. 10"),
    vector(24, 0x41B, &[0x8A, 0xC1, 0x00], Kind::Printed, "fragment acknowledge, count 1, status 0", POSITAL_MHK5, "p. 15"),
    vector(26, 0x41C, &[0x80, 0x00, 0x32, 0x64, 0x01, 0x93, 0x05, 0x00], Kind::Printed, "first fragment of service 0x32 class 0x64 instance 1 data 93 05 00, slave 3, master 0", ROCKWELL_PICO, "p. 4-11"),
    vector(28, 0x41B, &[0x80, 0xC1, 0x00], Kind::Printed, "acknowledge of fragment 1 by slave 3", ROCKWELL_PICO, "p. 4-12"),
    vector(30, 0x41B, &[0x80, 0x00, 0xB2, 0xC2, 0x05, 0x00, 0x05, 0x09], Kind::Printed, "first fragment of the response to service 0x32 (0xB2)", ROCKWELL_PICO, "p. 4-12"),
    vector(32, 0x41C, &[0x80, 0xC1, 0x00], Kind::Printed, "acknowledge by master 0 of response fragment 1", ROCKWELL_PICO, "p. 4-12"),
    vector(34, 0x42D, &[], Kind::Printed, "poll command without data, slave 5", MKS_BARATRON, "p. 119"),
    vector(36, 0x42B, &[0x80, 0xFF, 0x3F], Kind::Misprint, "printed as a poll response, with an explicit-response identifier; right for slave 5 would be 0x3C5", MKS_BARATRON, "p. 119"),
    vector(38, 0x40F, &[0x00, 0x08, 0x00, 0x06, 0xF5, 0x89, 0x12], Kind::Printed, "duplicate MAC ID check request of the master, MAC 1, port 0, vendor 8, serial 0x1289F506 (sent twice)", JASIC, "section 3"),
    vector(40, 0x413, &[0x41, 0xCB, 0x00], Kind::Fixture, "allocate response, XID 1 echoed", JASIC, "fixture"),
    vector(42, 0x414, &[0x41, 0x10, 0x05, 0x01, 0x0C, 0x03], Kind::Printed, "set watchdog_timeout_action of explicit connection to 3 (deferred delete)", JASIC, "section 3"),
    vector(44, 0x413, &[0x01, 0x8E, 0x6C, 0x00], Kind::Fixture, "vendor ID 0x006C (108)", JASIC, "fixture"),
    vector(46, 0x414, &[0x41, 0x0E, 0x01, 0x01, 0x02], Kind::Printed, "get Device Type (XID 1)", JASIC, "section 3"),
    vector(48, 0x413, &[0x41, 0x8E, 0x82, 0x14], Kind::Fixture, "product Code 0x1482 (XID 1 as in the fixture)", JASIC, "fixture"),
    vector(50, 0x414, &[0x41, 0x4B, 0x03, 0x01, 0x02, 0x01], Kind::Printed, "allocate poll through the explicit connection (Message ID 4, not 6)", JASIC, "section 3"),
    vector(52, 0x414, &[0x41, 0x0E, 0x05, 0x02, 0x08], Kind::Printed, "get consumed_connection_size of poll connection", JASIC, "section 3"),
    vector(54, 0x414, &[0x01, 0x10, 0x05, 0x02, 0x09, 0xFA, 0x00], Kind::Printed, "set poll EPR to 250 ms", JASIC, "section 3"),
    vector(56, 0x415, &[0x81, 0x7F, 0x00, 0x00, 0x00, 0x00], Kind::Printed, "poll command last fragment, 5 bytes; total 12", JASIC, "poll example"),
    vector(58, 0x3C2, &[0x00, 0x40, 0x00, 0x00, 0x08, 0x00, 0x00, 0x00], Kind::Printed, "poll response first fragment (13-byte input image)", JASIC, "poll example"),
    vector(60, 0x413, &[0x00, 0xCB, 0x00], Kind::Logged, "allocate response", KONVOLUCIO, ""),
    vector(62, 0x416, &[0x00, 0x4C, 0x03, 0x01, 0x01], Kind::Logged, "release explicit", KONVOLUCIO, ""),
    vector(64, 0x413, &[0x00, 0x8E, 0x6C, 0x05], Kind::Logged, "product Code 0x056C (1388)", KONVOLUCIO, ""),
    vector(66, 0x414, &[0x00, 0x0E, 0x01, 0x01, 0x07], Kind::Logged, "get Product Name", KONVOLUCIO, ""),
    vector(68, 0x413, &[0x80, 0x81, 0x2D, 0x44, 0x52, 0x54], Kind::Logged, "last fragment \"-DRT\"; complete name GRT1-DRT", KONVOLUCIO, ""),
    vector(70, 0x414, &[0x80, 0xC1, 0x00], Kind::Logged, "master acknowledges fragment 1", KONVOLUCIO, ""),
    vector(72, 0x414, &[0x00, 0x10, 0x05, 0x01, 0x09, 0x82, 0x00], Kind::Logged, "set explicit EPR to 130 ms", KONVOLUCIO, ""),
    vector(74, 0x413, &[0x00, 0x90, 0x82, 0x00], Kind::Logged, "set EPR response echoes the value used, 130 ms", KONVOLUCIO, ""),
    vector(76, 0x413, &[0x00, 0x85], Kind::Logged, "reset response, sent before the device resets", KONVOLUCIO, ""),
    vector(78, 0x780, &[0x3F, 0x4B, 0x02, 0x34], Kind::Logged, "UCMM open request from MAC 0 to MAC 63: format 16/16, Group 3, source message ID 4", IAI, ""),
    vector(80, 0x73F, &[0x00, 0xCB, 0x02], Kind::Logged, "allocate response, message body format 2 (16/16)", IAI, ""),
    vector(82, 0x700, &[0x3F, 0x0E, 0x01, 0x00, 0x01, 0x00, 0x01], Kind::Logged, "get vendor ID, 16/16 addressing", IAI, ""),
    vector(84, 0x73F, &[0x00, 0x8E, 0x00, 0x00], Kind::Logged, "device Type 0, generic", IAI, ""),
    vector(86, 0x700, &[0x3F, 0x0E, 0x01, 0x00, 0x01, 0x00, 0x03], Kind::Logged, "get Product Code, 16/16", IAI, ""),
    vector(88, 0x73F, &[0x80, 0xC0, 0x00], Kind::Logged, "slave acknowledges fragment 0", IAI, ""),
    vector(90, 0x700, &[0xBF, 0x81, 0x4B, 0x00], Kind::Logged, "last fragment: EPR value 75 ms", IAI, ""),
    vector(92, 0x700, &[0x3F, 0x0E, 0x05, 0x00, 0x02, 0x00, 0x07], Kind::Logged, "get produced_connection_size of poll connection, 16/16", IAI, ""),
    vector(94, 0x73F, &[0x00, 0x8E, 0x20, 0x00], Kind::Logged, "size 32", IAI, ""),
    vector(96, 0x77F, &[0x00, 0xCC], Kind::Logged, "UCMM close response", IAI, ""),
    vector(98, 0x5FD, &[0x00, 0x00, 0x80, 0x00, 0x00, 0x00, 0x00, 0x00], Kind::Logged, "poll command fragment 0 of 5, first (32-byte output image)", IAI, ""),
    vector(100, 0x5FD, &[0x43, 0x00, 0x11, 0x02, 0x01, 0x00, 0x11, 0x02], Kind::Logged, "poll command fragment 3, middle", IAI, ""),
    vector(102, 0x5FD, &[0x84, 0x01, 0x00, 0x11, 0x02], Kind::Logged, "poll command fragment 4, last, 4 data bytes; total 32", IAI, ""),
    vector(104, 0x7EF, &[0x01, 0x4B, 0x06, 0x00, 0x08, 0x07, 0x06, 0x05], Kind::Fixture, "Offline Ownership request, client MAC 1, vendor 6, serial 0x05060708", ANALYZER, ""),
    vector(106, 0x7EE, &[0x01, 0xCB, 0x06, 0x00, 0x08, 0x07, 0x06, 0x05], Kind::Fixture, "Offline Ownership response, client MAC 1", ANALYZER, ""),
    vector(108, 0x7ED, &[0x03, 0x4D, 0x06, 0x00, 0x08, 0x07, 0x06, 0x05], Kind::Fixture, "Change_MAC_ID to 3 for the faulted node with vendor 6, serial 0x05060708", ANALYZER, ""),
    vector(110, 0x7EC, &[0x00, 0x06, 0x00, 0x08, 0x07, 0x06, 0x05], Kind::Fixture, "Who response: port 0, vendor 6, serial 0x05060708", ANALYZER, ""),
    vector(112, 0x41B, &[0x03, 0xCE, 0x04, 0x00, 0x02, 0x00, 0x01, 0x02], Kind::Fixture, "device Shutdown of MAC 3: class 4, instance 2, code 0x0201", ANALYZER, ""),
    vector(114, 0x41B, &[0x0A, 0x94, 0x02, 0x03], Kind::Fixture, "error 0x02/0x03: invalid service on the Group 2 Only unconnected port", ANALYZER, ""),
    vector(116, 0x780, &[0x05, 0x4C, 0x02, 0x00], Kind::Fixture, "UCMM close of instance 2 at MAC 5", ANALYZER, ""),
    vector(118, 0x745, &[0x00, 0xCC], Kind::Fixture, "UCMM close response of MAC 5", ANALYZER, ""),
];
