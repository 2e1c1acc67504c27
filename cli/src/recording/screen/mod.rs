//! The screen form of candump, with any of its time stamps.
//!
//! ```text
//!  (1700000006.000000)  can0  456   [6]  01 4B 03 01 03 01
//!  (2023-11-14 22:13:20.000000)  can0  456   [5]  remote request
//!   can0  20000004   [8]  00 04 00 00 00 00 00 00   ERRORFRAME
//!   can0  453  [12]  00 01 02 03 04 05 06 07 08 09 0A 0B
//!   can0  RX - -  456   [2]  01 4B   '.K'
//! ```
//! Two digits in the brackets mean CAN FD, braces a raw data length code (`-8`). Colours (`-c`), binary (`-i`) and
//! swapped data (`-S`) are read as well. What follows the data, such as the text column of `-a`, is ignored, as are the
//! lines that explain an error frame (`-e`), which begin with a tab.

mod times;

use std::io::{self, Read};

use link_core::{Frame, Instant};
use memchr::memchr;

use super::Parsed;
use super::error::Fault;
use super::frame::{Channels, Content, ErrorFrame, FdFrame};
use super::scan::{CanId, Scanner, Sum};
use super::window::Window;
use times::Times;

/// Reads line after line.
#[derive(Clone, Debug, Default)]
pub(super) struct Screen {
    times: Times,
    /// A line without its colours.
    plain: Vec<u8>,
}

impl Screen {
    /// Learns from the lines to come whether times are distances, if that makes a difference now.
    pub(super) fn learn<R: Read>(&mut self, window: &mut Window<R>) -> io::Result<()> {
        self.times.learn(window)
    }

    /// Reads one line; `None` for one that holds no frame.
    pub(super) fn parse(&mut self, line: &[u8], channels: &mut Channels) -> Result<Option<Parsed>, Fault> {
        if memchr(ESCAPE, line).is_none() {
            return self.parse_plain(line, channels);
        }
        let mut plain = core::mem::take(&mut self.plain);
        plain.clear();
        plain.extend(visible(line).map(|(_, byte)| byte));
        let parsed = self.parse_plain(&plain, channels);
        self.plain = plain;
        parsed.map_err(|fault| {
            let at = visible(line).nth(fault.at).map_or(line.len(), |(at, _)| at);
            Fault { at, ..fault }
        })
    }

    fn parse_plain(&mut self, line: &[u8], channels: &mut Channels) -> Result<Option<Parsed>, Fault> {
        if line.first() == Some(&b'\t') || line.trim_ascii().is_empty() {
            return Ok(None);
        }
        let mut scan = Scanner::new(line);
        scan.skip_blanks();
        let (mut at, mut digits) = (Instant::ZERO, 0);
        if scan.eat(b'(') {
            let start = scan;
            let time = times::read(&mut scan)?;
            scan.expect(b')', "\")\" after the time")?;
            // Even if the rest of the line is bad: the next distance is from this line.
            let moment = self.times.moment(time, times::is_relative(start));
            (at, digits) = moment.ok_or_else(|| start.fault(Sum::LIMIT))?;
            scan.skip_blanks();
        }
        let interface = scan;
        let name = scan.word();
        if name.is_empty() {
            return Err(scan.fault("an interface name"));
        }
        scan.skip_blanks();
        let fd_flags = fd_flags(&mut scan);
        let id = scan.can_id()?;
        scan.skip_blanks();
        let content = content(&mut scan, id, fd_flags)?;
        // Only a whole line may name a channel: prose begins with a word as well.
        let channel = channels.intern(name).ok_or_else(|| interface.fault(Channels::LIMIT))?;
        Ok(Some(Parsed { at, digits, channel: Some(channel), content }))
    }
}

/// The bytes of a line that are not part of a control sequence such as `ESC [ 34 m`, each with its place.
fn visible(line: &[u8]) -> impl Iterator<Item = (usize, u8)> + '_ {
    let mut at = 0;
    core::iter::from_fn(move || {
        while let Some(&[ESCAPE, b'[', ref sequence @ ..]) = line.get(at..)
            && let Some(length) = sequence.iter().position(|byte| !matches!(byte, 0x20..=0x3F))
            && matches!(sequence[length], 0x40..=0x7E)
        {
            at += 2 + length + 1;
        }
        let byte = *line.get(at)?;
        at += 1;
        Some((at - 1, byte))
    })
}

/// The direction, `B` or `-` for the bit rate switch, `E` or `-` for the error state (`-x`).
fn fd_flags(scan: &mut Scanner<'_>) -> [bool; 2] {
    if !matches!(scan.peek_word(), b"RX" | b"TX") {
        return [false; 2];
    }
    let mut word = || {
        let word = scan.word();
        scan.skip_blanks();
        word
    };
    word();
    [word() == b"B", word() == b"E"]
}

fn content(scan: &mut Scanner<'_>, id: CanId, fd_flags: [bool; 2]) -> Result<Content, Fault> {
    let start = *scan;
    let close = match scan.peek() {
        Some(b'[') => b']',
        Some(b'{') => b'}',
        _ => return Err(scan.fault("the length in brackets")),
    };
    scan.eat(if close == b']' { b'[' } else { b'{' });
    let digits = *scan;
    let (length, raw_dlc) = if close == b'}' {
        let dlc = scan.hex_digit().ok_or_else(|| digits.fault("a data length code"))?;
        (u64::from(dlc.min(8)), Some(dlc))
    } else {
        (scan.decimal().ok_or_else(|| digits.fault("a length"))?, None)
    };
    let is_fd = close == b']' && digits.rest().get(1).is_some_and(u8::is_ascii_digit);
    scan.expect(close, "the closing bracket")?;
    let length = usize::try_from(length).ok().filter(|length| *length <= if is_fd { 64 } else { 8 });
    let length = length.ok_or_else(|| start.fault("a length of at most 8, of CAN FD at most 64"))?;
    scan.skip_blanks();
    if scan.peek_word().starts_with(b"remote") {
        let CanId::Frame { id, .. } = id else { return Err(scan.fault("data of an error frame")) };
        let dlc = raw_dlc.unwrap_or(length as u8);
        return Frame::remote(id, dlc)
            .map(Content::Classic)
            .ok_or_else(|| start.fault("a length of at most 8"));
    }
    let data = data(scan, length)?;
    let eight = || *data.first_chunk::<8>().unwrap_or(&[0; 8]);
    match id {
        CanId::Error { class } => Ok(Content::Error(ErrorFrame { class, data: eight() })),
        CanId::Frame { id, .. } if is_fd => {
            let frame = FdFrame::new(id, &data[..length], fd_flags[0], fd_flags[1]);
            let frame = frame.ok_or_else(|| start.fault("a length that CAN FD has"))?;
            Ok(Content::Fd(Box::new(frame)))
        }
        CanId::Frame { id, .. } => {
            let frame = match raw_dlc {
                Some(dlc @ 9..) => Frame::with_dlc(id, dlc, eight()),
                _ => Frame::new(id, &data[..length]),
            };
            frame.map(Content::Classic).ok_or_else(|| start.fault("a length of at most 8"))
        }
    }
}

/// Bytes in hexadecimal or binary (`-i`); with grave accents between them they are from the last to the first (`-S`).
fn data(scan: &mut Scanner<'_>, length: usize) -> Result<[u8; FdFrame::MAX_DATA], Fault> {
    let mut data = [0; FdFrame::MAX_DATA];
    let is_bit = |byte: &u8| matches!(byte, b'0' | b'1');
    let is_binary = scan.peek_word().iter().take_while(|byte| is_bit(byte)).count() == 8;
    let mut is_swapped = false;
    for (index, slot) in data[..length].iter_mut().enumerate() {
        match index {
            0 => {}
            1 => is_swapped = scan.eat(b'`'),
            _ if is_swapped => scan.expect(b'`', "\"`\" between the bytes")?,
            _ => {}
        }
        scan.skip_blanks();
        *slot = if is_binary { binary_byte(scan) } else { scan.hex_byte() }.ok_or_else(|| {
            scan.fault(if is_binary { "eight binary digits" } else { "two hexadecimal digits" })
        })?;
        if !matches!(scan.peek(), None | Some(b' ' | b'\t' | b'`')) {
            return Err(scan.fault("a blank or \"`\" after the byte"));
        }
    }
    if is_swapped {
        data[..length].reverse();
    }
    let after = scan.peek_word();
    let is_byte = if is_binary { after.len() == 8 && after.iter().all(is_bit) } else { is_hex_byte(after) };
    match is_byte || length > 0 && scan.peek() == Some(b'`') {
        true => Err(scan.fault("as many bytes as the length says")),
        false => Ok(data),
    }
}

/// Eight binary digits, or none consumed.
fn binary_byte(scan: &mut Scanner<'_>) -> Option<u8> {
    let byte = scan.rest().first_chunk::<8>()?.iter().try_fold(0u8, |byte, bit| match bit {
        b'0' | b'1' => Some(byte << 1 | (bit - b'0')),
        _ => None,
    })?;
    (0..8).for_each(|_| scan.skip());
    Some(byte)
}

fn is_hex_byte(word: &[u8]) -> bool {
    word.len() == 2 && word.iter().all(u8::is_ascii_hexdigit)
}

const ESCAPE: u8 = 0x1B;

#[cfg(test)]
mod tests {
    use super::*;
    use link_core::frame::standard_id;

    fn read(line: &str) -> Parsed {
        Screen::default().parse(line.as_bytes(), &mut Channels::default()).unwrap().unwrap()
    }

    #[test]
    fn reads_every_form_of_a_frame() {
        let data = |bytes: &[u8]| Content::Classic(Frame::new(standard_id(0x456), bytes).unwrap());
        assert_eq!(read(" (1700000006.000000)  can0  456   [2]  01 4B").content, data(&[0x01, 0x4B]));
        assert_eq!(read("  can0  456   [0]").content, data(&[]));
        assert_eq!(read("  can0  456   [2]  01 4B   '.K'").content, data(&[0x01, 0x4B]));
        assert_eq!(read("  can0  RX - -  456   [1]  01").content, data(&[0x01]));
        let remote = Frame::remote(standard_id(0x456), 5).unwrap();
        assert_eq!(read("  can0  456   [5]  remote request").content, Content::Classic(remote));
        let long = Frame::with_dlc(standard_id(0x456), 0xF, [1; 8]).unwrap();
        assert_eq!(read("  can0  456   {F}  01 01 01 01 01 01 01 01").content, Content::Classic(long));
        let fd = FdFrame::new(standard_id(0x456).into(), &[1; 12], false, false).unwrap();
        let line = format!("  can0  456  [12]  {}", "01 ".repeat(12));
        assert_eq!(read(&line).content, Content::Fd(Box::new(fd)));
        let error = ErrorFrame { class: 4, data: [0, 4, 0, 0, 0, 0, 0, 0] };
        let line = "  can0  20000004   [8]  00 04 00 00 00 00 00 00   ERRORFRAME";
        assert_eq!(read(line).content, Content::Error(error));
        let explanation = b"\tcontroller-problem{rx-error-warning}";
        assert_eq!(Screen::default().parse(explanation, &mut Channels::default()), Ok(None));
    }

    #[test]
    fn says_where_a_line_goes_wrong() {
        let fault = |line: &str| {
            let fault = Screen::default().parse(line.as_bytes(), &mut Channels::default()).unwrap_err();
            (fault.at + 1, fault.expected)
        };
        assert_eq!(fault("  can0  456   6  01"), (15, "the length in brackets"));
        assert_eq!(fault("  can0  456   [9]  01"), (15, "a length of at most 8, of CAN FD at most 64"));
        assert_eq!(fault("  can0  456   [2]  01"), (22, "two hexadecimal digits"));
        assert_eq!(fault("  can0  456   [1]  XX"), (20, "two hexadecimal digits"));
        assert_eq!(fault("  can0  456   [2]  014B"), (22, "a blank or \"`\" after the byte"));
        assert_eq!(fault("  can0  456   [1]  01 4B"), (22, "as many bytes as the length says"));
        assert_eq!(fault("  can0  456   [1]  01`4B"), (22, "as many bytes as the length says"));
        assert_eq!(fault("  can0  456   [3]  01`4B 03"), (25, "\"`\" between the bytes"));
        assert_eq!(fault("  can0  456   [1]  00000001 00000001"), (28, "as many bytes as the length says"));
        assert_eq!(fault("  can0  456   [2]  00000001 0001"), (29, "eight binary digits"));
        // The place counts the colours.
        assert_eq!(fault("  \x1B[1m\x1B[34mcan0\x1B[0m  456   6  01"), (28, "the length in brackets"));
        assert_eq!(fault("  \x1B[34mcan0  456   [2]  01\x1B[0m"), (31, "two hexadecimal digits"));
    }
}
