//! Whatever is on the bus: the monitor reads on, says nothing that was not sent, and finds its way again.

use devicenet_core::monitor::{Monitor, MonitorConfig, SizedMonitor};
use devicenet_tests::notation::frame;
use link_core::{
    Frame, Id, Instant,
    frame::{extended_id, standard_id},
};
use proptest::prelude::*;
use proptest::sample::Index;

use crate::harness::{Line, Observer, capture};

/// Few nodes and plausible bytes, so that frames meet each other's state.
fn any_frame() -> impl Strategy<Value = Frame> {
    let mac = prop_oneof![4 => Just(1_u16), 4 => Just(2), 2 => 0..64_u16];
    let identifier = prop_oneof![
        8 => (mac.clone(), 0..8_u16).prop_map(|(mac, message)| 0x400 | mac << 3 | message),
        4 => (mac.clone(), 0..16_u16).prop_map(|(mac, message)| message << 6 | mac),
        4 => (mac, 0..7_u16).prop_map(|(mac, message)| 0x600 | message << 6 | mac),
        1 => 0..0x800_u16,
    ];
    let byte = prop_oneof![
        4 => prop::sample::select(&[0x00, 0x01, 0x02, 0x03, 0x04, 0x05, 0x07, 0x09, 0x0E, 0x10, 0x3F][..]),
        2 => prop::sample::select(&[0x40, 0x41, 0x42, 0x4B, 0x4C, 0x80, 0x81, 0x82, 0x8E, 0x90, 0x94][..]),
        2 => prop::sample::select(&[0xC0, 0xC1, 0xCB, 0xCC, 0xCD, 0xCE][..]),
        1 => any::<u8>(),
    ];
    let data = prop::collection::vec(byte, 0..=8);
    prop_oneof![
        40 => (identifier, data.clone()).prop_map(|(id, data)| Frame::new(standard_id(id), &data).unwrap()),
        1 => (0..0x2000_0000_u32, data).prop_map(|(id, data)| Frame::new(extended_id(id), &data).unwrap()),
        1 => (0..0x800_u16, 0..=15_u8).prop_map(|(id, dlc)| Frame::remote(standard_id(id), dlc).unwrap()),
        1 => (0..0x800_u16, 9..=15_u8, any::<[u8; 8]>())
            .prop_map(|(id, dlc, data)| Frame::with_dlc(standard_id(id), dlc, data).unwrap()),
    ]
}

fn any_pause() -> impl Strategy<Value = u64> {
    prop_oneof![8 => 0..2_000_u64, 2 => 0..2_000_000_u64, 1 => 0..20_000_000_u64]
}

#[derive(Debug, Clone)]
enum Mutation {
    Drop(Index),
    Repeat(Index),
    Swap(Index, Index),
    Byte(Index, Index, u8),
    Cut(Index, Index),
    Insert(Index, Frame),
    Late(Index, u64),
}

fn any_mutation() -> impl Strategy<Value = Mutation> {
    let index = any::<Index>;
    prop_oneof![
        index().prop_map(Mutation::Drop),
        index().prop_map(Mutation::Repeat),
        (index(), index()).prop_map(|(a, b)| Mutation::Swap(a, b)),
        (index(), index(), any::<u8>()).prop_map(|(at, byte, value)| Mutation::Byte(at, byte, value)),
        (index(), index()).prop_map(|(at, len)| Mutation::Cut(at, len)),
        (index(), any_frame()).prop_map(|(at, frame)| Mutation::Insert(at, frame)),
        (index(), any_pause()).prop_map(|(at, pause)| Mutation::Late(at, pause)),
    ]
}

fn mutate(frames: &mut Vec<(Instant, Frame)>, mutation: &Mutation) {
    if frames.is_empty() {
        return;
    }
    let len = frames.len();
    match mutation {
        Mutation::Drop(at) => {
            frames.remove(at.index(len));
        }
        Mutation::Repeat(at) => frames.insert(at.index(len), frames[at.index(len)]),
        Mutation::Swap(a, b) => frames.swap(a.index(len), b.index(len)),
        Mutation::Byte(at, byte, value) => change(&mut frames[at.index(len)].1, |data| {
            if !data.is_empty() {
                let byte = byte.index(data.len());
                data[byte] = *value;
            }
        }),
        Mutation::Cut(at, keep) => change(&mut frames[at.index(len)].1, |data| {
            data.truncate(keep.index(data.len() + 1));
        }),
        Mutation::Insert(at, frame) => {
            let at = at.index(len);
            frames.insert(at, (frames[at].0, *frame));
        }
        Mutation::Late(at, pause) => {
            let pause = core::time::Duration::from_micros(*pause);
            frames[at.index(len)..].iter_mut().for_each(|(at, _)| *at += pause);
        }
    }
}

fn change(frame: &mut Frame, edit: impl FnOnce(&mut Vec<u8>)) {
    if let Id::Standard(id) = frame.id() {
        let mut data = frame.data().to_vec();
        edit(&mut data);
        *frame = Frame::new(id, &data).unwrap();
    }
}

/// A whole message must be made of the data of frames that were sent on its identifier, one after the other.
fn assert_sent(sent: &[Line], line: &Line) {
    let Some(message) = line.json.get("message") else { return };
    let data = message["data"].as_str().expect("hexadecimal digits");
    let is_io = line.json["kind"] != "fragment";
    let skipped = if is_io { 1 } else { 2 };
    let mut rest = data;
    // From the last fragment back to the first.
    for earlier in sent.iter().rev().filter(|earlier| earlier.frame.id() == line.frame.id()) {
        let piece = earlier.frame.data().get(skipped..).unwrap_or_default();
        let piece: String = piece.iter().map(|byte| format!("{byte:02x}")).collect();
        if let Some(before) = rest.strip_suffix(piece.as_str()) {
            rest = before;
        }
        if rest.is_empty() {
            return;
        }
    }
    panic!("frame {}: {data} was not sent: {}", line.n, line.text);
}

fn assert_sane(sent: &[Line], line: &Line) {
    assert_sent(sent, line);
    assert!(!line.text.is_empty() && !line.text.contains("  !  "), "{}", line.text);
    assert!(line.text.is_ascii() || line.text.chars().all(|c| !c.is_control()), "{:?}", line.text);
    let object = line.json.as_object().expect("an object");
    assert!(object.values().all(|value| !value.is_null()), "absent fields are left out: {object:?}");
    assert_eq!(object["kind"] == "foreign", object["protocol"] == "unknown");
    if let Some(request) = object.get("request") {
        assert!(request["n"].as_u64().expect("a number") < line.n, "an answer comes later");
    }
    if let Some(value) = object.get("value") {
        let all: String = line.frame.data().iter().map(|byte| format!("{byte:02x}")).collect();
        assert!(
            all.ends_with(value.as_str().expect("digits")),
            "the value is the end of the data: {object:?}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn random_frames_are_read(frames in prop::collection::vec((any_pause(), any_frame()), 0..120)) {
        let mut observer = Observer::new();
        let mut now = 0;
        let mut lines = Vec::new();
        for (pause, frame) in frames {
            now += pause;
            let line = observer.observe(Instant::from_micros(now), &frame);
            lines.push(line.clone());
            assert_sane(&lines, &line);
        }
        prop_assert_eq!(observer.monitor.nodes().count() <= 64, true);
        prop_assert!(observer.monitor.connections().count() <= 64 * 5 + 32);
    }

    /// A broken recording of real traffic is read to its end, and what follows it is read as if nothing had been.
    #[test]
    fn a_broken_recording_is_read_and_left_behind(
        name in prop::sample::select(&[
            "session-two-slaves-on-vcan.log",
            "slave-01-startup-poll.log",
            "slave-04-fragmented-response.log",
            "inficon-get-set-assembly-path.log",
        ][..]),
        mutations in prop::collection::vec(any_mutation(), 1..12),
    ) {
        let mut frames = capture(name);
        mutations.iter().for_each(|mutation| mutate(&mut frames, mutation));
        let mut observer = Observer::new();
        let mut lines: Vec<Line> = Vec::new();
        let mut last = Instant::ZERO;
        for (at, frame) in &frames {
            last = last.max(*at);
            let line = observer.observe(*at, frame);
            lines.push(line.clone());
            assert_sane(&lines, &line);
        }
        let later = |seconds| last + core::time::Duration::from_secs(seconds);
        for (text, expected) in RESYNCHRONISED {
            let line = observer.observe(later(60), &frame(text));
            if !expected.is_empty() {
                prop_assert_eq!(&line.text, expected);
            }
        }
    }

    /// The smallest monitor does the same work as far as it has room, and never more.
    #[test]
    fn a_small_monitor_tells_what_it_loses(frames in prop::collection::vec(any_frame(), 0..200)) {
        let mut small = SizedMonitor::<1, 8>::new(MonitorConfig::default());
        let mut large = Box::new(Monitor::new(MonitorConfig::default()));
        for (n, frame) in (1_u64..).zip(&frames) {
            let at = Instant::from_millis(n);
            let whole = large.observe(at, n, frame).message.map(|message| message.data.to_vec());
            let reading = small.observe(at, n, frame);
            let short = reading.message.map(|message| message.data.to_vec());
            prop_assert!(short.as_ref().is_none_or(|short| short.len() <= 8));
            if short != whole {
                let lost = small.lost();
                prop_assert!(lost.evicted_messages + lost.long_messages + lost.connections > 0, "{:?}", lost);
            }
        }
    }
}

/// A new allocation settles what is known of slave 10. The first two frames may have to do with what was before.
const RESYNCHRONISED: &[(&str, &str)] = &[
    ("456: 05 4B 03 01 01 05", ""),
    ("453: 05 CB 00", ""),
    ("454: 45 0E 01 01 07", "5 -> 10  Get_Attribute_Single Identity 1 Product name"),
    ("453: C5 00 8E 08 47 52 54 31", "10 -> 5  first fragment 0  8E 08 47 52 54 31"),
    ("454: C5 C0 00", "5 -> 10  acknowledge of fragment 0"),
    (
        "453: C5 81 2D 44 52 54",
        "10 -> 5  last fragment 1 completes Get_Attribute_Single: Product name \"GRT1-DRT\"",
    ),
    ("454: C5 C1 00", "5 -> 10  acknowledge of fragment 1"),
];
