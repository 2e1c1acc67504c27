//! Recordings: every capture is read, formats agree, what is written is read back, bad files give typed errors.
#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test may panic"
)]

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use devicenet_cli::recording::{
    Content, ErrorFrame, FdFrame, Format, Notes, Place, RecordedFrame, Recording, RecordingError,
    WriteFormat, Writer,
};
use link_core::frame::{extended_id, standard_id};
use link_core::{Frame, Id, Instant};
use proptest::prelude::*;

fn capture(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../tests/captures").join(name)
}

/// Format and frames of a capture that has no bad line.
fn read(name: &str) -> (Format, Vec<RecordedFrame>) {
    let recording = Recording::open(&capture(name)).unwrap();
    (
        recording.format(),
        recording.map(|frame| frame.unwrap_or_else(|error| panic!("{name}: {error}"))).collect(),
    )
}

fn read_bytes(bytes: &[u8]) -> Result<Vec<Result<RecordedFrame, RecordingError>>, RecordingError> {
    Ok(Recording::from_reader(std::io::Cursor::new(bytes.to_vec()))?.collect())
}

#[test]
fn every_capture_is_read_to_its_end() {
    let expected = [
        ("bei-mhk5-cos.log", Format::CandumpLog, 4),
        ("candump-L-mixed.log", Format::CandumpLog, 10),
        ("candump-ta.txt", Format::CandumpScreen, 20),
        ("icpdas-can8124-poll.log", Format::CandumpLog, 4),
        ("icpdas-i7242d-cyclic.log", Format::CandumpLog, 4),
        ("inficon-get-set-assembly-path.log", Format::CandumpLog, 6),
        ("mks-baratron-explicit.log", Format::CandumpLog, 2),
        ("session-two-slaves-on-vcan.log", Format::CandumpLog, 30),
        ("slave-01-startup-poll.log", Format::CandumpLog, 30),
        ("slave-04-fragmented-response.log", Format::CandumpLog, 51),
        ("socketcan-le-usec.pcap", Format::Pcap, 24),
        ("socketcan.pcapng", Format::PcapNg, 24),
    ];
    for (name, format, frames) in expected {
        let (found, all) = read(name);
        assert_eq!((found, all.len()), (format, frames), "{name}");
        assert!(all.iter().zip(1..).all(|(frame, n)| frame.n == n), "{name} is numbered from 1");
    }
}

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

/// The text log, the screen output, pcap and pcapng hold the same 20 frames at the same times.
#[test]
fn four_formats_of_the_same_traffic_agree() {
    let same = |name| {
        let frames = read(name).1.into_iter().take(20);
        frames.map(|frame| (frame.n, frame.at, frame.content)).collect::<Vec<_>>()
    };
    let log = same("slave-01-startup-poll.log");
    assert_eq!(log[0].1, Instant::from_micros(1_700_000_002_500_300));
    assert_eq!(same("candump-ta.txt"), log);
    assert_eq!(same("socketcan-le-usec.pcap"), log);
    assert_eq!(same("socketcan.pcapng"), log);
}

/// And the two binary ones four special frames, written out here.
#[test]
fn binary_formats_hold_every_kind_of_frame() {
    let expected = [
        Content::Classic(Frame::new(extended_id(0x18FE_F1FE), &[0, 1, 2, 3, 4, 5, 6, 7]).unwrap()),
        Content::Classic(Frame::remote(standard_id(0x456), 0).unwrap()),
        Content::Error(ErrorFrame { class: 4, data: [0, 4, 0, 0, 0, 0, 0, 0] }),
        Content::Fd(Box::new(
            FdFrame::new(Id::Standard(standard_id(0x453)), &[0; 12], false, false).unwrap(),
        )),
    ];
    for name in ["socketcan-le-usec.pcap", "socketcan.pcapng"] {
        let (_, frames) = read(name);
        let special: Vec<_> = frames[20..].iter().map(|frame| frame.content.clone()).collect();
        assert_eq!(special, expected, "{name}");
        assert!(frames.iter().all(|frame| frame.digits == 6), "{name} is in microseconds");
    }
}

/// One run of traffic, recorded by candump with each of its options.
#[test]
fn every_form_of_the_candump_screen_agrees_with_its_log() {
    let log = read("candump/log.log").1;
    let start = log[0].at;
    let without_rate_switch = |content: &Content| match content {
        Content::Fd(fd) => Content::Fd(Box::new(FdFrame::new(fd.id(), fd.data(), false, false).unwrap())),
        other => other.clone(),
    };
    let names = [
        "plain", "ta", "ta-c", "ta-c-c-c", "ta-c-c-i", "ta-c-x", "ta-e", "ta-i", "ta-i-S", "ta-S", "ta-S-a",
        "ta-x-a", "tA", "tz", "td",
    ];
    for name in names {
        let (format, frames) = read(&format!("candump/{name}.txt"));
        let mut recording = Recording::open(&capture(&format!("candump/{name}.txt"))).unwrap();
        assert_eq!(recording.by_ref().count(), log.len(), "{name}");
        assert_eq!(recording.channels().iter().collect::<Vec<_>>(), ["vcan0"], "{name}");
        assert_eq!(format, Format::CandumpScreen, "{name}");
        assert_eq!(frames.len(), log.len(), "{name}");
        for (found, logged) in frames.iter().zip(&log) {
            let time = match name {
                "plain" => Instant::ZERO,
                "tz" | "td" => Instant::ZERO + logged.at.saturating_since(start),
                _ => logged.at,
            };
            assert_eq!(found.at, time, "{name}, frame {}", logged.n);
            match name {
                "ta-x-a" | "ta-c-x" => assert_eq!(found.content, logged.content, "{name}"),
                _ => assert_eq!(found.content, without_rate_switch(&logged.content), "{name}"),
            }
        }
    }
}

/// Two interfaces with names of different lengths, frames of error-passive senders, lost frames; in the log, and on the
/// screen with `-td -c -x`.
#[test]
fn two_interfaces_and_lost_frames() {
    let open = |name| {
        let mut recording = Recording::open(&capture(name)).unwrap();
        let frames: Vec<_> = recording.by_ref().map(Result::unwrap).collect();
        let names = recording.channels();
        let named = frames.into_iter().map(|frame| {
            (frame.at, frame.channel.map(|channel| names.name(channel).to_owned()).unwrap(), frame.content)
        });
        (named.collect::<Vec<_>>(), recording.notes())
    };
    let (log, log_notes) = open("candump/two.log");
    let (screen, screen_notes) = open("candump/two-td-c-x-d.txt");
    assert_eq!(log_notes, Notes { dropped: 4, foreign: 0 });
    assert_eq!(screen_notes, log_notes);
    assert_eq!(log.len(), 7);
    let channels: Vec<_> = log.iter().map(|(_, channel, _)| &**channel).collect();
    assert_eq!(channels, ["vcan0", "vcan12", "vcan0", "vcan12", "vcan0", "vcan12", "vcan0"]);
    let bytes = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
    let fd = FdFrame::new(Id::Standard(standard_id(0x453)), &bytes, true, true).unwrap();
    assert_eq!(log[4].2, Content::Fd(Box::new(fd)));
    let start = log[0].0;
    for ((at, channel, content), shown) in log.into_iter().zip(screen) {
        assert_eq!((Instant::ZERO + at.saturating_since(start), channel, content), shown);
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

/// A name ends at a blank there.
#[test]
fn a_candump_log_has_names_of_one_word() {
    let content = Content::Classic(Frame::new(standard_id(0x123), &[1]).unwrap());
    let names = ["CAN 1", "can0", "CAN 1", "", "a\tb\n"];
    let file = Shared::default();
    let mut writer = Writer::new(file.clone(), WriteFormat::CandumpLog).unwrap();
    for name in names {
        writer.write(Instant::from_millis(1000), 6, name, &content).unwrap();
    }
    let renamed: Vec<_> = writer.renamed().iter().map(|it| (&*it.name, &*it.written)).collect();
    assert_eq!(renamed, [("CAN 1", "CAN_1"), ("", "_"), ("a\tb\n", "a_b_")]);
    writer.finish().unwrap();
    let bytes = file.0.lock().unwrap().clone();
    let mut recording = Recording::from_reader(std::io::Cursor::new(bytes)).unwrap();
    assert_eq!(recording.by_ref().map(Result::unwrap).filter(|frame| frame.content == content).count(), 5);
    assert_eq!(recording.channels().iter().collect::<Vec<_>>(), ["CAN_1", "can0", "_", "a_b_"]);
}

/// The same run as can-utils' `log2asc` converts it, which keeps no class of an error.
#[test]
fn asc_agrees_with_the_log_it_was_made_from() {
    let log = read("candump/log.log").1;
    let (format, frames) = read("candump/log2asc.asc");
    assert_eq!((format, frames.len()), (Format::Asc, log.len()));
    for (found, logged) in frames.iter().zip(&log) {
        assert_eq!(found.at, Instant::ZERO + logged.at.saturating_since(log[0].at));
        match &logged.content {
            Content::Error(_) => assert_eq!(found.content, Content::Error(ErrorFrame::UNSPECIFIED)),
            content => assert_eq!(found.content, *content),
        }
    }
}

#[test]
fn interfaces_keep_their_names() {
    let mut recording = Recording::open(&capture("candump-L-mixed.log")).unwrap();
    let ids: Vec<_> = recording.by_ref().map(|frame| frame.unwrap().channel.unwrap()).collect();
    let names: Vec<_> = ids.iter().map(|id| recording.channels().name(*id)).collect();
    assert_eq!(names[..4], ["can0", "can0", "vcan12", "can0"]);
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

#[test]
fn every_byte_order_and_resolution_of_pcap() {
    let packet: &[u8] = &[0, 0, 4, 0x55, 2, 0, 0, 0, 0xAB, 0xCD];
    let build = |magic: u32, number: fn(u32) -> [u8; 4]| {
        let mut file = number(magic).to_vec();
        // Version 2.4 as two half words, swapped like the rest.
        let [a, b, c, d] = number(0x0002_0004);
        file.extend(if number(1) == [0, 0, 0, 1] { [a, b, c, d] } else { [c, d, a, b] });
        for field in [0, 0, 65_535, 227, 1, 500, packet.len() as u32, packet.len() as u32] {
            file.extend(number(field));
        }
        file.extend(packet);
        file
    };
    let files = [
        (build(0xA1B2_C3D4, u32::to_le_bytes), 1_000_500_000, 6),
        (build(0xA1B2_C3D4, u32::to_be_bytes), 1_000_500_000, 6),
        (build(0xA1B2_3C4D, u32::to_le_bytes), 1_000_000_500, 9),
        (build(0xA1B2_3C4D, u32::to_be_bytes), 1_000_000_500, 9),
    ];
    for (file, nanos, digits) in files {
        let frame = read_bytes(&file).unwrap().remove(0).unwrap();
        assert_eq!((frame.at.as_nanos(), frame.digits), (nanos, digits));
        assert_eq!(frame.content, Content::Classic(Frame::new(standard_id(0x455), &[0xAB, 0xCD]).unwrap()));
    }
}

#[test]
fn a_file_that_is_cut_off_gives_its_frames_and_then_says_so() {
    for name in ["socketcan-le-usec.pcap", "socketcan.pcapng"] {
        let bytes = std::fs::read(capture(name)).unwrap();
        let mut entries = read_bytes(&bytes[..bytes.len() - 3]).unwrap();
        assert!(matches!(entries.pop(), Some(Err(RecordingError::Truncated { after: 23 }))), "{name}");
        assert_eq!(entries.len(), 23, "{name}");
    }
}

#[test]
fn another_link_type_is_named() {
    let mut bytes = std::fs::read(capture("socketcan-le-usec.pcap")).unwrap();
    bytes[20] = 1;
    let Err(error) = read_bytes(&bytes) else { panic!("Ethernet is read as CAN") };
    assert!(matches!(error, RecordingError::LinkType { number: 1, name: "Ethernet" }));
}

#[test]
fn a_broken_record_in_a_binary_file_is_a_bad_record() {
    let mut bytes = std::fs::read(capture("socketcan-le-usec.pcap")).unwrap();
    // The length of the first packet, which starts at 24 + 16.
    bytes[44] = 99;
    let entries = read_bytes(&bytes).unwrap();
    let Some(Err(RecordingError::Bad(bad))) = entries.first() else { panic!("{:?}", entries.first()) };
    assert_eq!(bad.place, Place::Record { record: 1, byte: 16 });
    assert_eq!(entries.len(), 24, "the rest is read");
}

/// Anything at all, and anything behind a valid beginning, is read without a panic and comes to an end.
#[test]
fn damaged_files_end_in_an_error_and_never_in_a_panic() {
    for name in ["socketcan-le-usec.pcap", "socketcan.pcapng", "candump-ta.txt", "candump-L-mixed.log"] {
        let whole = std::fs::read(capture(name)).unwrap();
        for at in 0..whole.len() {
            for value in [0x00, 0x7F, 0xFF, whole[at] ^ 0x01] {
                let mut bytes = whole.clone();
                bytes[at] = value;
                let _ = read_bytes(&bytes);
            }
        }
    }
}

fn id() -> impl Strategy<Value = Id> {
    prop_oneof![
        (0u16..0x800).prop_map(|raw| Id::Standard(standard_id(raw))),
        (0u32..0x2000_0000).prop_map(|raw| Id::Extended(extended_id(raw))),
    ]
}

fn content() -> impl Strategy<Value = Content> {
    let data = (id(), proptest::collection::vec(any::<u8>(), 0..=8))
        .prop_map(|(id, bytes)| Content::Classic(Frame::new(id, &bytes).unwrap()));
    let long = (id(), 9u8..=15, any::<[u8; 8]>())
        .prop_map(|(id, dlc, bytes)| Content::Classic(Frame::with_dlc(id, dlc, bytes).unwrap()));
    let remote = (id(), 0u8..=15).prop_map(|(id, dlc)| Content::Classic(Frame::remote(id, dlc).unwrap()));
    let error = (0u32..0x2000_0000, any::<[u8; 8]>())
        .prop_map(|(class, data)| Content::Error(ErrorFrame { class, data }));
    let fd =
        (id(), 0usize..16, any::<[u8; 64]>(), any::<[bool; 2]>()).prop_map(|(id, dlc, bytes, [brs, esi])| {
            let length = usize::from(FdFrame::LENGTHS[dlc]);
            Content::Fd(Box::new(FdFrame::new(id, &bytes[..length], brs, esi).unwrap()))
        });
    prop_oneof![4 => data, 1 => long, 1 => remote, 1 => error, 1 => fd]
}

/// An output that stays reachable after the writer took it.
#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Vec<u8>>>);

impl std::io::Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

proptest! {
    #[test]
    fn what_is_written_is_read_back(
        frames in proptest::collection::vec((0u64..1 << 62, content(), 0usize..3), 1..20),
        binary in any::<bool>(),
    ) {
        let names = ["can0", "vcan12", "x"];
        let file = Shared::default();
        let format = if binary { WriteFormat::PcapNg } else { WriteFormat::CandumpLog };
        let mut writer = Writer::new(file.clone(), format).unwrap();
        for (nanos, content, name) in &frames {
            writer.write(Instant::from_nanos(*nanos), 9, names[*name], content).unwrap();
        }
        writer.finish().unwrap();
        let bytes = file.0.lock().unwrap().clone();
        let mut recording = Recording::from_reader(std::io::Cursor::new(bytes)).unwrap();
        let read: Vec<_> = recording.by_ref().map(Result::unwrap).collect();
        prop_assert_eq!(read.len(), frames.len());
        for (read, (nanos, content, name)) in read.iter().zip(&frames) {
            prop_assert_eq!((read.at.as_nanos(), read.digits), (*nanos, 9));
            prop_assert_eq!(&read.content, content);
            prop_assert_eq!(recording.channels().name(read.channel.unwrap()), names[*name]);
        }
    }

    #[test]
    fn noise_never_panics(bytes in proptest::collection::vec(any::<u8>(), 0..300), start in 0usize..6) {
        let starts: [&[u8]; 6] =
            [b"", b"(1.0) can0 1#\n", b"base hex\n", b"\x0A\x0D\x0D\x0A", b"\xD4\xC3\xB2\xA1", b" can0  1 [0]\n"];
        let _ = read_bytes(&[starts[start], &bytes].concat());
    }
}
