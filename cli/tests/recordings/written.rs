//! What is written is read back.

use std::sync::{Arc, Mutex};

use devicenet_cli::recording::{Content, ErrorFrame, FdFrame, Recording, WriteFormat, Writer};
use link_core::frame::{extended_id, standard_id};
use link_core::{Frame, Id, Instant};
use proptest::prelude::*;

use super::read_bytes;

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
