//! Every capture is read, and all formats of the same traffic agree.

use devicenet_cli::recording::{Content, ErrorFrame, FdFrame, Format, Notes, Recording};
use link_core::frame::{extended_id, standard_id};
use link_core::{Frame, Id, Instant};

use super::{capture, read};

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
