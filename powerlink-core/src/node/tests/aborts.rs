//! Why an object is not read or written: each code that the server gives, from the request to the bytes of the answer.
//!
//! The transaction of a command is its number in the sequence, so that the rows 8, 9, 11 and 15 are the frames that openPOWERLINK
//! 2.7.2's controlled node sent on its eighth, ninth, eleventh and fifteenth command. 0x05040000, a time-out, is no answer: a
//! client that falls silent is forgotten.

use std::format;
use std::string::String;
use std::vec;
use std::vec::Vec;

use super::bench::*;
use crate::nmt::NmtState;
use crate::node::NodeEvent;
use crate::pdo::MappingEntry;
use crate::wire::{AbortCode, SdoCommand, SdoCommandId, Segmentation};

const READ: SdoCommandId = SdoCommandId::READ_BY_INDEX;
const WRITE: SdoCommandId = SdoCommandId::WRITE_BY_INDEX;

/// Index, sub-index, a reserved byte and a value.
fn object(index: u16, sub: u8, value: &[u8]) -> Vec<u8> {
    let [low, high] = index.to_le_bytes();
    [&[low, high, sub, 0], value].concat()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The answer to a command that fails: an ASnd of 60 bytes to node 240, by the table of its fields.
fn abort_frame(number: u8, command: SdoCommandId, code: u32) -> String {
    let sequence = number << 2 | 2;
    let headers = format!("01111e000004{}88ab06f00105", hex(&MAC.0));
    let answer = format!("{sequence:02x}{sequence:02x}000000{number:02x}c0{:02x}04000000", command.0);
    let frame = format!("{headers}{answer}{}", hex(&code.to_le_bytes()));
    format!("{frame:0<120}")
}

/// Sends commands in order, and demands the abort code of each.
fn all_fail(bench: &mut Bench, rows: &[(SdoCommandId, Vec<u8>, u32)]) {
    for (number, (command, data, code)) in (1..).zip(rows) {
        bench.sends_command(SdoCommand::request(0, *command, data));
        let row = format!("row {number}: {command}, {}", hex(data));
        assert_eq!(hex(&bench.last), abort_frame(number, *command, *code), "{row}");
        let told = NodeEvent::SdoAborted { command: *command, code: AbortCode(*code) };
        assert!(bench.events.contains(&told), "{row}: {:?}", bench.events);
        assert!(!bench.events.iter().any(|event| matches!(event, NodeEvent::ObjectWritten(_))), "{row}");
        bench.forget();
    }
}

fn rows() -> Vec<(SdoCommandId, Vec<u8>, u32)> {
    let unknown = SdoCommandId(0x55);
    let others = [0x03, 0x04, 0x05, 0x06, 0x20, 0x21, 0x31, 0x32, 0x70, 0x71, 0xFF].map(SdoCommandId);
    let mut rows = vec![
        (WRITE, object(0x1018, 1, &[0; 4]), 0x0601_0002),
        (READ, object(0x2001, 0, &[]), 0x0601_0001),
        (WRITE, object(0x1F98, 4, &35_u16.to_le_bytes()), 0x0609_0032),
        (WRITE, object(0x1F98, 4, &1491_u16.to_le_bytes()), 0x0609_0031),
        (WRITE, object(0x1F98, 5, &37_u16.to_le_bytes()), 0x0609_0031),
        (WRITE, object(0x2002, 0, &[2]), 0x0609_0031),
        (WRITE, object(0x1003, 0, &[1]), 0x0609_0031),
        (READ, object(0x2FFF, 0, &[]), 0x0602_0000),
        (READ, object(0x1018, 9, &[]), 0x0609_0011),
        (READ, object(0x1003, 1, &[]), 0x0609_0011),
        (WRITE, object(0x1F99, 0, &[0; 2]), 0x0607_0010),
        (WRITE, object(0x1F9A, 0, &[b'a'; 33]), 0x0607_0012),
        (WRITE, object(0x1F9A, 0, b"under_score"), 0x0609_0030),
        (WRITE, object(0x1F9E, 0, &[0x21]), 0x0609_0030),
        (unknown, object(0x1018, 1, &[]), 0x0504_0001),
        (READ, vec![0x18, 0x10, 1], 0x0607_0010),
        (WRITE, vec![], 0x0607_0010),
        (WRITE, object(0x2FFF, 0, &[0]), 0x0602_0000),
        (WRITE, object(0x1006, 1, &[0; 4]), 0x0609_0011),
        // In use.
        (WRITE, object(0x1600, 1, &[0; 8]), 0x0601_0000),
        (WRITE, object(0x1400, 1, &[2]), 0x0601_0000),
        (WRITE, object(0x1A00, 0, &[33]), 0x0609_0031),
        // What the application says.
        (READ, object(0x2003, 0, &[]), 0x0800_0022),
        (WRITE, object(0x2003, 0, &[0]), 0x0800_0022),
    ];
    rows.extend(others.map(|command| (command, object(0x1018, 1, &[]), 0x0504_0001)));
    rows
}

#[test]
fn every_abort_in_the_bytes_of_its_answer() {
    for state in
        [NmtState::PreOperational1, NmtState::PreOperational2, NmtState::Operational, NmtState::Stopped]
    {
        let mut bench = Bench::in_state(state, config());
        all_fail(&mut bench, &rows());
        assert_eq!(bench.reads(0x1018, 1), Ok(vec![0x23, 0x01, 0, 0]), "the connection goes on");
        bench.is(state);
    }
}

/// Frames of openPOWERLINK 2.7.2's controlled node, recorded.
#[test]
fn four_rows_are_recorded_frames() {
    let recorded = [
        (
            8,
            "01111e00000402000000000188ab06f00105222200000008c00204000000000002060000000000000000000000000000000000000000000000000000",
        ),
        (
            9,
            "01111e00000402000000000188ab06f00105262600000009c00204000000110009060000000000000000000000000000000000000000000000000000",
        ),
        (
            11,
            "01111e00000402000000000188ab06f001052e2e0000000bc00104000000100007060000000000000000000000000000000000000000000000000000",
        ),
        (
            15,
            "01111e00000402000000000188ab06f001053e3e0000000fc00104000000010004050000000000000000000000000000000000000000000000000000",
        ),
    ];
    let rows = rows();
    for (number, frame) in recorded {
        let (command, _, code) = &rows[usize::from(number) - 1];
        // The recorded node answers an unknown command in the name of WriteByIndex; the request's own is what the others echo.
        let command = if number == 15 { WRITE } else { *command };
        assert_eq!(abort_frame(number, command, *code), frame, "row {number}");
    }
}

/// 0x1600 out of use, an entry of it, and into use again.
#[test]
fn aborts_of_a_mapping() {
    let entry = |index: u16, offset: u16, length: u16| {
        let object = crate::dictionary::ObjectAddress::new(index, 1);
        MappingEntry { object, offset, length }.number().to_le_bytes()
    };
    let cases = [
        (entry(0x6200, 4, 8), AbortCode(0x0604_0041), true),
        (entry(0x6200, 0, 4), AbortCode(0x0604_0041), true),
        (entry(0x6200, 0, 16), AbortCode(0x0604_0041), false),
        (entry(0x6000, 0, 8), AbortCode(0x0604_0041), false),
        (entry(0x6300, 0, 8), AbortCode(0x0602_0000), false),
        (entry(0x2000, 0, 8), AbortCode(0x0609_0011), false),
        (entry(0x6200, 36 * 8, 8), AbortCode(0x0604_0042), false),
    ];
    for (entry, code, is_told_at_once) in cases {
        let mut bench = Bench::in_state(NmtState::PreOperational1, config());
        assert_eq!(bench.writes(0x1600, 0, &[0]), Ok(()));
        assert_eq!(bench.writes(0x1600, 1, &entry), if is_told_at_once { Err(code) } else { Ok(()) });
        if !is_told_at_once {
            assert_eq!(bench.writes(0x1600, 0, &[1]), Err(code), "{entry:02X?}");
            assert_eq!(bench.reads(0x1600, 0), Ok(vec![0]), "it stays out of use");
        }
    }
}

/// Segments without a beginning, more than was said, less than was said, and more than there is room for.
#[test]
fn aborts_of_a_segmented_write() {
    let first = |total| (Segmentation::Initiate { total }, object(0x2000, 0, &[1, 2, 3]));
    let next = |len| (Segmentation::Segment, vec![0; len]);
    let last = |len| (Segmentation::Complete, vec![0; len]);
    let room = u32::try_from(VALUE).unwrap();
    let cases = [
        (vec![next(5)], 0x0800_0000),
        (vec![last(5)], 0x0800_0000),
        (vec![first(9), last(5)], 0x0607_0010),
        (vec![first(9), next(2), last(5)], 0x0607_0010),
        (vec![first(room + 5)], 0x0504_0005),
        (vec![first(room), next(1400), next(1400)], 0x0504_0005),
    ];
    for (parts, code) in cases {
        let mut bench = Bench::in_state(NmtState::PreOperational1, config());
        for (segmentation, data) in &parts {
            assert!(!bench.events.iter().any(|event| matches!(event, NodeEvent::SdoAborted { .. })));
            bench.sends_command(SdoCommand {
                segmentation: *segmentation,
                ..SdoCommand::request(0x77, WRITE, data)
            });
        }
        bench.tells(NodeEvent::SdoAborted { command: WRITE, code: AbortCode(code) });
        assert_eq!(bench.last[24..34], [&[0xC0, 0x01, 4, 0, 0, 0][..], &code.to_le_bytes()].concat());
        assert_eq!(bench.node.objects().long, [0; 0]);
        bench.forget();
        assert_eq!(bench.reads(0x1018, 1), Ok(vec![0x23, 0x01, 0, 0]), "the connection goes on");
    }
}

/// A value of the application that is longer than the node has room for.
#[test]
fn a_value_that_is_too_long_to_read() {
    let mut bench = Bench::in_state(NmtState::PreOperational1, config());
    bench.node.objects_mut().long = vec![7; VALUE + 1];
    assert_eq!(bench.reads(0x2000, 0), Err(AbortCode(0x0504_0005)));
}
