//! The server against clients by hand: the dialogues of openPOWERLINK 2.7.2, loss, and long values.

use std::vec::Vec;

use link_core::codec::{Reader, Wire, Writer};

use super::*;
use crate::dictionary::{
    Access, Device, Dictionary, Effect, Entry, ObjectAddress, ObjectSet, ObjectType, Objects, Values,
};
use crate::pdo::Mappings;
use crate::wire::{
    AbortCode, Con, Identity, InitiateSize, Sdo, SdoCommand, SdoCommandId, SdoSequence, Segmentation,
    SequenceHalf,
};
use crate::{MacAddress, NodeId};

/// A value longer than a frame.
#[derive(Clone, Debug, Default)]
struct Long(Vec<u8>);

impl ObjectSet for Long {
    const ENTRIES: &'static [Entry] =
        &[Entry::new(0x2000, 0, "long", ObjectType::Bytes(200), Access::ReadWrite)];

    fn read(&self, _: ObjectAddress, out: &mut Writer<'_>) -> Result<(), AbortCode> {
        out.bytes(&self.0).map_err(|_| AbortCode::OUT_OF_MEMORY)
    }

    fn write(&mut self, _: ObjectAddress, data: &[u8]) -> Result<(), AbortCode> {
        self.0 = data.to_vec();
        Ok(())
    }

    fn restore(&mut self) {}
}

struct Bench {
    server: Server<256>,
    dictionary: Dictionary,
    long: Long,
    initiate: InitiateSize,
}

/// The most data in a frame of the server.
const SEGMENT: usize = 16;
const MN: NodeId = NodeId::MANAGING_NODE;

impl Bench {
    fn new() -> Self {
        let identity = Identity { vendor_id: 0x0123, product_code: 7, revision: 1, serial_number: 2 };
        let mac = MacAddress([2, 0, 0, 0, 0, 1]);
        let device = Device::new(identity);
        let dictionary = Dictionary::new(device, NodeId(1), mac, Values::default(), Mappings::new(), 36);
        Self { server: Server::new(), dictionary, long: Long::default(), initiate: InitiateSize::Counted }
    }

    fn open() -> Self {
        let mut bench = Self::new();
        assert_eq!(bench.hears("00 01"), Outcome::Nothing);
        bench.says("01 01 00 00");
        assert_eq!(bench.hears("01 02"), Outcome::Opened);
        bench.says("02 02 00 00");
        bench
    }

    /// A frame of the managing node, from the sequence layer on.
    fn hears(&mut self, hex: &str) -> Outcome {
        let mut given = bytes(hex);
        given.resize(given.len().max(42), 0);
        self.hears_bytes(MN, &given)
    }

    fn hears_bytes(&mut self, from: NodeId, given: &[u8]) -> Outcome {
        self.receives(from, given).outcome
    }

    fn receives(&mut self, from: NodeId, given: &[u8]) -> Received {
        let sdo = Sdo::read_as(&mut Reader::new(given), self.initiate).unwrap();
        let mut objects = Objects { standard: &mut self.dictionary, application: &mut self.long };
        self.server.receive(from, &sdo, SEGMENT, &mut objects)
    }

    /// Whether the wait for the managing node begins anew with a frame.
    fn waits_anew(&mut self, hex: &str) -> bool {
        self.receives(MN, &bytes(hex)).is_progress
    }

    fn hears_command(&mut self, receive: u8, send: u8, con: Con, command: SdoCommand<'_>) -> Outcome {
        let sequence = SdoSequence {
            receive: SequenceHalf::new(receive, Con::Valid),
            send: SequenceHalf::new(send, con),
        };
        let mut buffer = [0; 64];
        let mut out = Writer::new(&mut buffer);
        sequence.emit(&mut out).unwrap();
        command.emit_as(&mut out, self.initiate).unwrap();
        let given = out.written().to_vec();
        self.hears_bytes(MN, &given)
    }

    #[track_caller]
    fn next(&mut self) -> Option<Vec<u8>> {
        let (index, _) = self.server.next()?;
        let mut buffer = [0xA5; 64];
        let mut out = Writer::new(&mut buffer);
        assert!(self.server.emit(index, self.initiate, &mut out).unwrap());
        Some(out.written().to_vec())
    }

    #[track_caller]
    fn says(&mut self, hex: &str) {
        assert_eq!(self.next().as_deref(), Some(&*bytes(hex)), "{hex}");
    }

    #[track_caller]
    fn says_nothing(&mut self) {
        assert_eq!((self.server.ready(), self.next()), (0, None));
    }
}

fn bytes(hex: &str) -> Vec<u8> {
    hex.split(' ').map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect()
}

/// Recorded from openPOWERLINK 2.7.2: the opening, a write, a read, and how they are answered.
#[test]
fn the_dialogue_of_a_managing_node() {
    let mut bench = Bench::open();
    // 0x1006/0 = 50000
    let written = Outcome::Written(ObjectAddress::new(0x1006, 0), Effect::None);
    assert_eq!(bench.hears("02 06 00 00 00 03 00 01 08 00 00 00 06 10 00 00 50 c3 00 00"), written);
    bench.says("06 06 00 00 00 03 80 01 00 00 00 00");
    assert_eq!(bench.dictionary.values.cycle_length, 50_000);
    // The acknowledge, and the next command: 0x1018/0.
    assert_eq!(bench.hears("06 06"), Outcome::Nothing);
    bench.says_nothing();
    bench.hears("06 0a 00 00 00 04 00 02 04 00 00 00 18 10 00 00");
    bench.says("0a 0a 00 00 00 04 80 02 01 00 00 00 04");
    // Without an acknowledge between: 0x2FFF/0.
    let aborted = Outcome::Aborted(SdoCommandId::READ_BY_INDEX, AbortCode::NO_OBJECT);
    assert_eq!(bench.hears("0a 0e 00 00 00 08 00 02 04 00 00 00 ff 2f 00 00"), aborted);
    bench.says("0e 0e 00 00 00 08 c0 02 04 00 00 00 00 00 02 06");
    // Closed: no answer.
    assert_eq!(bench.hears("00 00"), Outcome::Closed);
    bench.says_nothing();
    assert_eq!(bench.hears("0e 12"), Outcome::Ignored);
}

/// Abort codes that openPOWERLINK 2.7.2 gave.
#[test]
fn commands_that_fail() {
    let cases = [
        ("00 02 04 00 00 00 18 10 09 00", AbortCode::NO_SUB_INDEX),
        ("00 01 08 00 00 00 18 10 01 00 00 00 00 00", AbortCode::READ_ONLY),
        ("00 01 06 00 00 00 99 1f 00 00 00 00", AbortCode::LENGTH),
        ("00 01 06 00 00 00 98 1f 04 00 23 00", AbortCode::VALUE_TOO_LOW),
        ("00 55 00 00 00 00", AbortCode::UNKNOWN_COMMAND),
        ("00 02 02 00 00 00 18 10", AbortCode::LENGTH),
    ];
    for (command, code) in cases {
        let mut bench = Bench::open();
        let outcome = bench.hears(&std::format!("02 06 00 00 00 09 {command}"));
        assert!(matches!(outcome, Outcome::Aborted(_, found) if found == code), "{command}: {outcome:?}");
        let [a, b, c, d] = code.0.to_le_bytes();
        let id = &command[3..5];
        bench.says(&std::format!("06 06 00 00 00 09 c0 {id} 04 00 00 00 {a:02x} {b:02x} {c:02x} {d:02x}"));
    }
}

#[test]
fn repeated_and_missing_frames() {
    const READ: &str = "00 00 00 04 00 02 04 00 00 00 18 10 00 00";
    let mut bench = Bench::open();
    bench.hears(&std::format!("02 06 {READ}"));
    bench.says("06 06 00 00 00 04 80 02 01 00 00 00 04");
    // The same again: acknowledged only when that is asked for.
    assert_eq!(bench.hears(&std::format!("02 06 {READ}")), Outcome::Nothing);
    bench.says_nothing();
    bench.hears(&std::format!("02 07 {READ}"));
    bench.says("06 06 00 00");
    // One is missing: send again.
    assert_eq!(bench.hears(&std::format!("02 0e {READ}")), Outcome::Ignored);
    bench.says("07 06 00 00");
    // The answer got lost, the client asks for it.
    bench.hears("03 06");
    bench.says("06 06 00 00 00 04 80 02 01 00 00 00 04");
}

#[test]
fn an_answer_without_an_acknowledge_is_sent_twice_more() {
    let mut bench = Bench::open();
    let timeout = 15_000;
    assert_eq!(bench.server.patience(0, timeout), Some(timeout));
    bench.hears("02 06 00 00 00 04 00 02 04 00 00 00 18 10 00 00");
    bench.says("06 06 00 00 00 04 80 02 01 00 00 00 04");
    for _ in 0..2 {
        assert_eq!(bench.server.patience(0, timeout), Some(5_000));
        assert_eq!(bench.server.expired(0), None);
        bench.says("06 07 00 00 00 04 80 02 01 00 00 00 04");
    }
    // A client that goes on without it gets the next answer as often.
    bench.hears("02 0a 00 00 00 05 00 02 04 00 00 00 18 10 00 00");
    bench.says("0a 0a 00 00 00 05 80 02 01 00 00 00 04");
    for _ in 0..2 {
        assert_eq!(bench.server.expired(0), None);
        bench.says("0a 0b 00 00 00 05 80 02 01 00 00 00 04");
    }
    assert_eq!(bench.server.expired(0), Some(MN));
    assert_eq!(bench.server.patience(0, timeout), None);
    bench.says_nothing();
}

/// What says nothing new does not put off that the answer is sent again.
#[test]
fn the_wait_for_an_acknowledge_begins_anew_with_progress_alone() {
    const READ: &str = "00 00 00 04 00 02 04 00 00 00 18 10 00 00";
    let mut bench = Bench::open();
    assert!(bench.waits_anew(&std::format!("02 06 {READ}")));
    assert!(bench.waits_anew("02 06 00 00"), "the answer is not sent yet: the client is there");
    bench.says("06 06 00 00 00 04 80 02 01 00 00 00 04");
    assert!(bench.server.is_unacknowledged(0));
    let read_again = std::format!("02 07 {READ}");
    for (what, frame) in [
        ("again", &*read_again),
        ("no news", "02 06 00 00"),
        ("one missing", "02 0e 00 00"),
        ("a nil", "02 0a 00 00"),
    ] {
        assert!(!bench.waits_anew(frame), "{what}");
        bench.next();
        assert!(bench.server.is_unacknowledged(0), "{what}");
    }
    assert!(bench.waits_anew("03 0a 00 00"), "the answer is asked for");
    bench.next();
    assert!(bench.waits_anew("06 0a 00 00"), "the acknowledge");
    assert!(bench.waits_anew("06 0a 00 00"), "nothing is under way: the client is there");
    assert!(!bench.waits_anew("06 16 00 00"), "out of order");
    assert!(bench.waits_anew("00 00 00 00"), "closed");
    assert!(!bench.waits_anew("06 0a 00 00"), "no connection");
}

/// The client need not wait until it finds out by time.
#[test]
fn a_command_before_the_answer_to_the_last_is_asked_for_again_behind_it() {
    const READ: &str = "00 00 00 05 00 02 04 00 00 00 18 10 00 00";
    let mut bench = Bench::open();
    bench.hears("02 06 00 00 00 04 00 02 04 00 00 00 18 10 00 00");
    assert_eq!(bench.hears(&std::format!("02 0a {READ}")), Outcome::Ignored);
    assert_eq!(bench.hears("02 07 00 00"), Outcome::Nothing, "an acknowledge is wanted as well");
    assert_eq!(bench.server.ready(), 2);
    bench.says("06 06 00 00 00 04 80 02 01 00 00 00 04");
    bench.says("07 06 00 00");
    bench.says_nothing();
    assert_eq!(bench.hears(&std::format!("06 0a {READ}")), Outcome::Nothing);
    bench.says("0a 0a 00 00 00 05 80 02 01 00 00 00 04");
}

/// Four frames are under way. Two are acknowledged when all four are about to be sent again.
#[test]
fn what_arrived_after_all_is_not_sent_again() {
    let mut bench = Bench::open();
    bench.long.0 = (0..100).collect();
    bench.hears("02 06 00 00 00 09 00 02 04 00 00 00 00 20 00 00");
    (0..4).for_each(|_| assert!(bench.next().is_some()));
    assert_eq!((bench.server.ready(), bench.server.patience(0, 15_000)), (0, Some(5_000)));
    assert_eq!(bench.server.expired(0), None);
    assert_eq!((bench.server.ready(), bench.server.patience(0, 15_000)), (4, Some(15_000)));
    bench.hears("0a 06 00 00");
    let numbers: Vec<u8> = core::iter::from_fn(|| bench.next()).map(|frame| frame[1] >> 2).collect();
    assert_eq!(numbers, [3, 4, 5, 6], "with two further ones, as many as may be under way");
}

/// Lengths around those of one, two and several frames.
#[test]
fn long_values_are_read_in_segments() {
    for initiate in [InitiateSize::Counted, InitiateSize::NotCounted] {
        for len in [0, 1, 15, 16, 17, 28, 29, 44, 45, 100, 200] {
            let mut bench = Bench { initiate, ..Bench::open() };
            bench.long.0 = (0..len).collect();
            let request = SdoCommand::request(9, SdoCommandId::READ_BY_INDEX, &[0x00, 0x20, 0, 0]);
            bench.hears_command(0, 1, Con::Valid, request);
            let mut value = Vec::new();
            for number in 1.. {
                let frame = bench.next().expect("a frame");
                let Sdo { sequence, command: Some(command) } =
                    Sdo::read_as(&mut Reader::new(&frame), initiate).unwrap()
                else {
                    panic!("a command")
                };
                assert_eq!((sequence.send.number, command.transaction), (number, 9));
                assert!(frame.len() <= 12 + SEGMENT);
                value.extend_from_slice(command.data);
                if sequence.send.connection == Con::Request {
                    assert_eq!(bench.server.ready(), 0, "it waits for the acknowledge");
                    bench.hears(&std::format!("{:02x} 06", (number << 2) | 2));
                }
                match command.segmentation {
                    Segmentation::Initiate { total } => assert_eq!(total, u32::from(len)),
                    Segmentation::Segment => {}
                    Segmentation::Expedited | Segmentation::Complete => break,
                }
            }
            assert_eq!(value, bench.long.0, "{len} bytes");
            bench.says_nothing();
        }
    }
}

#[test]
fn long_values_are_written_in_segments_with_either_total() {
    for counts_address in [false, true] {
        let mut bench = Bench::open();
        let value: Vec<u8> = (0..100).collect();
        let total = 100 + if counts_address { 4 } else { 0 };
        let first = [&[0x00, 0x20, 0, 0], &value[..20]].concat();
        let parts = [
            (Segmentation::Initiate { total }, &first[..]),
            (Segmentation::Segment, &value[20..60]),
            (Segmentation::Complete, &value[60..]),
        ];
        let mut outcome = Outcome::Nothing;
        for (number, (segmentation, data)) in (1..).zip(parts) {
            let command =
                SdoCommand { segmentation, ..SdoCommand::request(5, SdoCommandId::WRITE_BY_INDEX, data) };
            outcome = bench.hears_command(0, number, Con::Request, command);
            if number < 3 {
                assert_eq!(bench.next(), Some(std::vec![(number << 2) | 2, 2, 0, 0]), "an acknowledge");
            }
        }
        assert_eq!(outcome, Outcome::Written(ObjectAddress::new(0x2000, 0), Effect::None));
        bench.says("0e 06 00 00 00 05 80 01 00 00 00 00");
        assert_eq!(bench.long.0, value);
    }
}

#[test]
fn a_write_that_is_longer_than_the_buffer_or_than_it_said_is_aborted() {
    let mut bench = Bench::open();
    let initiate = |total| SdoCommand {
        segmentation: Segmentation::Initiate { total },
        ..SdoCommand::request(5, SdoCommandId::WRITE_BY_INDEX, &[0x00, 0x20, 0, 0])
    };
    let outcome = bench.hears_command(0, 1, Con::Valid, initiate(1000));
    assert_eq!(outcome, Outcome::Aborted(SdoCommandId::WRITE_BY_INDEX, AbortCode::OUT_OF_MEMORY));
    bench.next();
    bench.hears_command(1, 2, Con::Valid, initiate(3));
    let complete = SdoCommand {
        segmentation: Segmentation::Complete,
        ..SdoCommand::request(5, SdoCommandId::WRITE_BY_INDEX, &[1, 2])
    };
    let outcome = bench.hears_command(1, 3, Con::Valid, complete);
    assert_eq!(outcome, Outcome::Aborted(SdoCommandId::WRITE_BY_INDEX, AbortCode::LENGTH));
}

#[test]
fn clients_take_turns_and_a_third_is_refused() {
    let mut bench = Bench::open();
    let opening = bytes("00 01 00 00");
    assert_eq!(bench.hears_bytes(NodeId::DIAGNOSTIC, &opening), Outcome::Nothing);
    assert_eq!(bench.hears_bytes(NodeId(9), &opening), Outcome::Refused);
    assert_eq!(bench.hears_bytes(NodeId(9), &bytes("02 06 00 00")), Outcome::Ignored);
    assert_eq!(bench.hears_bytes(MN, &opening), Outcome::Closed, "its old connection");
    assert_eq!(bench.hears_bytes(MN, &opening), Outcome::Nothing, "that was never open");
    assert_eq!(bench.server.ready(), 2);
    let first = bench.server.next().unwrap().1;
    bench.next();
    let second = bench.server.next().unwrap().1;
    assert_ne!(first, second);
}

/// A server that opens connections and acknowledges commands, and never answers one.
#[test]
fn a_client_gives_up_a_server_that_acknowledges_and_never_answers() {
    let mut client = Client::<64>::new();
    client.read(NodeId(1), ObjectAddress::new(0x1018, 0), 32);
    let hears = |client: &mut Client<64>, frame: &[u8]| {
        let sdo = Sdo::read_as(&mut Reader::new(frame), InitiateSize::Counted).unwrap();
        client.receive(NodeId(1), &sdo)
    };
    for expired in 0..20 {
        let mut buffer = [0; 64];
        let mut out = Writer::new(&mut buffer);
        while client.emit(InitiateSize::Counted, &mut out).unwrap() {
            let [receive, send, ..] = *out.written() else { panic!("a sequence layer") };
            let answer = match (receive & 3, send & 3) {
                (0, 1) => [1, 1, 0, 0],
                (1, 2) => [2, 2, 0, 0],
                _ => [send & 0xFC | 2, 2, 0, 0],
            };
            assert_eq!(hears(&mut client, &answer), Progress::Nothing);
            out = Writer::new(&mut buffer);
        }
        if let Progress::Done(result) = client.expired() {
            assert_eq!((result, expired > 2), (Err(AbortCode::TIME_OUT), true));
            return;
        }
    }
    panic!("it goes on for ever");
}
