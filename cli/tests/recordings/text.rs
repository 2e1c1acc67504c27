//! Lines of text, good and bad.

use devicenet_cli::recording::{RecordedFrame, Recording, RecordingError};
use link_core::Instant;

use super::read_bytes;

#[test]
fn a_byte_order_mark_is_skipped() {
    for text in ["(1.000000) can0 455#01\n", "base hex  timestamps absolute\n 1.000000 1  455  Rx   d 1 01\n"]
    {
        let plain = read_bytes(text.as_bytes()).unwrap();
        let marked = read_bytes(format!("\u{FEFF}{text}").as_bytes()).unwrap();
        let frames = |all: Vec<Result<RecordedFrame, RecordingError>>| -> Vec<_> {
            all.into_iter().map(|frame| frame.unwrap().content).collect()
        };
        let plain = frames(plain);
        assert_eq!(plain.len(), 1);
        assert_eq!(frames(marked), plain);
    }
}

/// The distance of a bad line counts: the next one is from that line.
#[test]
fn a_bad_line_among_distances_takes_its_time() {
    let line = |time: &str, rest: &str| format!(" ({time})  can0  456   {rest}\n");
    let text = [
        line("000.000000", "[1]  01"),
        line("000.500000", "[1]  0"),
        line("000.250000", "[1]  02"),
        line("000.100000", "[1]  03"),
    ];
    let entries = read_bytes(text.concat().as_bytes()).unwrap();
    let times: Vec<_> =
        entries.iter().filter_map(|entry| entry.as_ref().ok()).map(|frame| frame.at).collect();
    assert_eq!(times, [0, 750, 850].map(Instant::from_millis));
}

#[test]
fn blanks_are_no_bad_line() {
    for blank in ["", " ", " \t ", "\r"] {
        let text = format!("(1.0) can0 123#00\n{blank}\n(2.0) can0 123#\n");
        let entries = read_bytes(text.as_bytes()).unwrap();
        assert_eq!(entries.into_iter().filter(Result::is_ok).count(), 2, "{blank:?}");
    }
}

#[test]
fn only_a_whole_drop_count_is_one() {
    let text = b"(1.0) can0 123#00\nDROPCOUNT: dropped many CAN frames\nDROPCOUNT: dropped 2 CAN frames on 'can0' socket (total drops 2)\n";
    let mut recording = Recording::from_reader(&text[..]).unwrap();
    let entries: Vec<_> = recording.by_ref().collect();
    assert_eq!(entries.len(), 2);
    assert_eq!(
        entries[1].as_ref().unwrap_err().to_string(),
        "2:1: \"(\" and a time expected, \"DROPCOUNT:\" found"
    );
    assert_eq!(recording.notes().dropped, 2);
}

#[test]
fn a_bad_line_says_where_and_the_rest_is_read() {
    let log = b"(1.0) can0 123#00\n(2.0) can0 123#0\nnonsense\n\n(3.0) can0 123#\n";
    let mut entries = read_bytes(log).unwrap();
    assert_eq!(entries.len(), 4);
    assert_eq!(entries.pop().unwrap().unwrap().n, 2, "bad lines do not count as frames");
    let messages: Vec<_> = entries[1..].iter().map(|entry| entry.as_ref().unwrap_err().to_string()).collect();
    assert_eq!(
        messages,
        [
            "2:16: two hexadecimal digits expected, \"0\" found",
            "3:1: \"(\" and a time expected, \"nonsense\" found"
        ]
    );
}

/// Else its frames would be those of a second bus, with a name that nobody gave.
#[test]
fn a_damaged_line_names_no_channel() {
    for damaged in ["(1.0) cZn0 4", "(1.0) cZn0 123#0", "(1.0) cZn0 123#00 x"] {
        let text = format!("{damaged}\n(2.0) can0 123#00\n");
        let mut recording = Recording::from_reader(std::io::Cursor::new(text)).unwrap();
        let entries: Vec<_> = recording.by_ref().collect();
        assert!(entries[0].is_err() && entries[1].is_ok(), "{damaged}");
        assert_eq!(recording.channels().iter().collect::<Vec<_>>(), ["can0"], "{damaged}");
    }
}
