//! Recordings.

use std::io::{Cursor, Read};

use arbitrary::Unstructured;
use devicenet_cli::recording::{
    Content, ErrorFrame, FdFrame, Format, Notes, Place, RecordedFrame, Recording, RecordingError,
    WriteFormat, Writer,
};
use link_core::Instant;

use crate::input;

/// Reads `data` as a recording, whole and in pieces; and writes frames made from it.
pub(super) fn check(data: &[u8]) {
    let whole = read(Cursor::new(data.to_vec()));
    if whole.format.is_some() {
        let pieces = read(Pieces { rest: data.to_vec(), at: 0 });
        // The format is judged by what a pipe gives at first.
        if pieces.format == whole.format {
            assert_eq!(pieces, whole, "the same, whatever pieces a pipe gives");
        }
    }
    check_places(data, &whole);
    check_written(&whole.frames);
    check_written(&made_up(&mut Unstructured::new(data)));
}

/// What a recording holds, in a form that can be compared.
#[derive(Debug, PartialEq, Eq)]
struct Reading {
    format: Option<Format>,
    frames: Vec<Entry>,
    /// The text of each error and the place in it.
    errors: Vec<(String, Option<Place>)>,
    notes: Notes,
}

/// A frame without its number, which follows from the order, and with the name of its channel.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Entry {
    at: Instant,
    digits: u8,
    channel: String,
    content: Content,
}

fn read(source: impl Read + 'static) -> Reading {
    let mut reading =
        Reading { format: None, frames: Vec::new(), errors: Vec::new(), notes: Notes::default() };
    let mut recording = match Recording::from_reader(source) {
        Ok(recording) => recording,
        Err(error) => {
            assert!(error.is_fatal());
            reading.errors.push(described(&error));
            return reading;
        }
    };
    reading.format = Some(recording.format());
    let mut ended = false;
    while let Some(item) = recording.next() {
        assert!(!ended, "nothing comes after a fatal error");
        match item {
            Ok(RecordedFrame { n, at, digits, channel, content }) => {
                assert!(digits <= 9, "nanoseconds at most");
                let channel = channel.map_or_else(String::new, |id| recording.channels().name(id).to_owned());
                reading.frames.push(Entry { at, digits, channel, content });
                assert_eq!(n, reading.frames.len() as u64);
            }
            Err(error) => {
                ended = error.is_fatal();
                reading.errors.push(described(&error));
            }
        }
    }
    reading.notes = recording.notes();
    reading
}

fn described(error: &RecordingError) -> (String, Option<Place>) {
    let text = error.to_string();
    assert!(!text.is_empty());
    let place = if let RecordingError::Bad(bad) = error { Some(bad.place) } else { None };
    (text, place)
}

/// Every place lies within the file, and there are no more entries than the file has room for.
fn check_places(data: &[u8], reading: &Reading) {
    assert!(reading.frames.len() + reading.errors.len() <= data.len() + 1);
    let lines: Vec<_> = data.split(|&byte| byte == b'\n').collect();
    for (text, place) in &reading.errors {
        match *place {
            Some(Place::Line { line, column }) => {
                let content =
                    lines.get((line - 1) as usize).unwrap_or_else(|| panic!("no such line: {text}"));
                // A file may end where something was expected.
                assert!((1..=content.len() + 1).contains(&column), "no such column: {text}");
            }
            Some(Place::Record { record, byte }) => {
                assert!(record >= 1 && (1..=data.len() + 1).contains(&byte), "no such place: {text}");
            }
            None => {}
        }
    }
}

/// What the writers write is read back: the frames, their times, and their channels.
fn check_written(frames: &[Entry]) {
    if frames.is_empty() {
        return;
    }
    for format in [WriteFormat::CandumpLog, WriteFormat::PcapNg] {
        let mut bytes = Vec::new();
        let mut writer = Writer::new(&mut bytes, format).expect("a vector takes everything");
        for Entry { at, digits, channel, content } in frames {
            writer.write(*at, *digits, channel_of(channel), content).expect("a vector takes everything");
        }
        writer.finish().expect("a vector takes everything");
        let Reading { frames: read, errors, notes, .. } = read(Cursor::new(bytes));
        assert_eq!(notes, Notes::default(), "a recording that is written tells only frames");
        assert_eq!(errors, [], "{format:?} of {frames:?}");
        assert_eq!(read.len(), frames.len(), "{format:?}");
        for (read, written) in read.iter().zip(frames) {
            assert_eq!(read.content, written.content, "{format:?}");
            assert_eq!(read.at, written.at, "{format:?}");
            let name = channel_of(&written.channel);
            let name = if format == WriteFormat::CandumpLog {
                name.replace(|it: char| it == ' ' || it.is_ascii_control(), "_")
            } else {
                name.to_owned()
            };
            assert_eq!(read.channel, name, "{format:?}");
        }
    }
}

/// A pcap file does not name its interface, a candump log must.
fn channel_of(name: &str) -> &str {
    if name.is_empty() { "can0" } else { name }
}

/// Frames of every kind, at times that rise.
fn made_up(input: &mut Unstructured<'_>) -> Vec<Entry> {
    let mut frames = Vec::new();
    let mut at = Instant::from_millis(1_700_000_000_000);
    while !input.is_empty() && frames.len() < MADE_UP {
        let Ok((span, content)) = entry(input) else { break };
        at += input::span(span);
        frames.push(Entry { at, digits: 6, channel: "can0".to_owned(), content });
    }
    frames
}

/// The span since the last one, then a frame; bits 7-6 of its byte 0 make it an error frame (01) or CAN FD (10).
fn entry(input: &mut Unstructured<'_>) -> arbitrary::Result<(u8, Content)> {
    let (span, head): (u8, u8) = (input.arbitrary()?, input.arbitrary()?);
    let content = match head >> 6 {
        0b01 => Content::Error(ErrorFrame {
            class: input.arbitrary::<u32>()? & 0x1FFF_FFFF,
            data: input.arbitrary()?,
        }),
        0b10 => {
            let frame = input::frame_after(head & 0x20, input)?;
            let len = usize::from(FdFrame::LENGTHS[usize::from(head & 0x0F)]);
            let mut data = [0; FdFrame::MAX_DATA];
            input.fill_buffer(&mut data[..len])?;
            let fd = FdFrame::new(frame.id(), &data[..len], head & 0x10 != 0, input.arbitrary()?);
            Content::Fd(Box::new(fd.expect("a length that CAN FD has")))
        }
        _ => Content::Classic(input::frame_after(head, input)?),
    };
    Ok((span, content))
}

/// A pipe whose writer is slow: one byte, then two, then up to seven.
struct Pieces {
    rest: Vec<u8>,
    at: usize,
}

impl Read for Pieces {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let len = (self.at % 7 + 1).min(buffer.len()).min(self.rest.len() - self.at);
        buffer[..len].copy_from_slice(&self.rest[self.at..self.at + len]);
        self.at += len;
        Ok(len)
    }
}

const MADE_UP: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_candump_log_with_a_bad_line() {
        let log = b"(1700000000.000000) can0 456#014B03010301\n(1700000000.0001) can0 45\n";
        let reading = read(Cursor::new(log.to_vec()));
        assert_eq!(reading.frames.len(), 1);
        assert_eq!(reading.errors[0].1, Some(Place::Line { line: 2, column: 26 }));
        check(log);
    }

    /// With distances for times, colours, and a name of two words: pcapng, the first interface described as `CAN 1`.
    #[test]
    fn what_only_some_formats_have() {
        check(b" (000.000000)  \x1B[34mcan0\x1B[0m  456   [1]  01\n (000.5)  can0  456   [1]\n (000.25)  can0  456   [0]\n");
        check(b"(1.0) can0 456#\nDROPCOUNT: dropped 2 CAN frames on 'can0' socket (total drops 2)\n \n");
        let block = |kind: u32, body: &[u8]| {
            let length = (12 + body.len() as u32).to_le_bytes();
            [&kind.to_le_bytes(), &length, body, &length].concat()
        };
        let section =
            block(0x0A0D_0D0A, &[0x4D, 0x3C, 0x2B, 0x1A, 1, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255]);
        let interface = block(1, b"\xE3\0\0\0\0\0\0\0\x02\0\x05\0CAN 1\0\0\0");
        let packet =
            block(6, &[&[0; 12][..], &[8, 0, 0, 0, 8, 0, 0, 0], &[0, 0, 4, 0x56, 0, 0, 0, 0]].concat());
        let file = [section, interface, packet].concat();
        assert_eq!(read(Cursor::new(file.clone())).frames[0].channel, "CAN 1");
        check(&file);
    }

    #[test]
    fn made_up_frames_are_of_every_kind() {
        let mut input = vec![0, 0x02, 0x2F, 0x05, 1, 2];
        input.extend([0x41, 0x40, 0x88, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
        input.extend([0x41, 0x89, 0x2F, 0x05]);
        let frames = made_up(&mut Unstructured::new(&input));
        assert!(matches!(frames[0].content, Content::Classic(_)));
        assert!(matches!(frames[1].content, Content::Error(_)));
        assert!(matches!(frames[2].content, Content::Fd(_)));
        check(&input);
    }
}
