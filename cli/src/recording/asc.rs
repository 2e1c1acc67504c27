//! Vector ASC, the text log of CANalyzer and CANoe.
//!
//! ```text
//! date Tue Nov 14 22:13:20.000 2023
//! base hex  timestamps absolute
//!    0.015991 1  456             Rx   d 6 01 4B 03 01 03 01
//!    0.016200 1  18FEF1FEx       Tx   r 8
//!    0.017000 1  ErrorFrame
//!    0.018000 CANFD   1 Rx   453  Name  1 0 9 12 00 01 02 03 04 05 06 07 08 09 0A 0B  ...
//! ```
//! `x` marks 29 bits, `r` a remote frame, whose length may be missing. Of a `CANFD` line the flags after the data tell a
//! classic frame from one in the CAN FD format. Times count from the start of the measurement; with `timestamps relative`
//! each counts from the line before. Other events (bus statistics, triggers, other buses, comments) are skipped, and the
//! date is not used, because it comes in the language of the program that wrote it.

use link_core::{ExtendedId, Frame, Id, StandardId};

use super::Parsed;
use super::error::Fault;
use super::frame::{Channels, Content, ErrorFrame, FdFrame};
use super::scan::{Scanner, Sum};

/// Reads line after line; the header changes how the others are read.
#[derive(Clone, Debug)]
pub(super) struct Asc {
    radix: u32,
    /// With relative times, the sum of those so far.
    distances: Option<Sum>,
}

impl Default for Asc {
    fn default() -> Self {
        Self { radix: 16, distances: None }
    }
}

impl Asc {
    /// Whether a line can only be in the header of such a file.
    pub(super) fn is_header(line: &[u8]) -> bool {
        let line = line.trim_ascii();
        [&b"date "[..], b"base hex", b"base dec", b"// version "].iter().any(|start| line.starts_with(start))
    }

    /// Reads one line; `None` for one that holds no frame.
    pub(super) fn parse(&mut self, line: &[u8], channels: &mut Channels) -> Result<Option<Parsed>, Fault> {
        let mut scan = Scanner::new(line);
        scan.skip_blanks();
        if !scan.peek().is_some_and(|byte| byte.is_ascii_digit()) {
            return self.header(scan);
        }
        let start = scan;
        let time = scan.seconds()?;
        let moment = self.distances.as_mut().map_or(Some(time), |sum| sum.add(time));
        let (at, digits) = moment.ok_or_else(|| start.fault(Sum::LIMIT))?;
        scan.skip_blanks();
        let channel = scan;
        let (name, content) = match scan.word() {
            b"CANFD" => {
                scan.skip_blanks();
                let name = scan.word();
                (name, self.fd(&mut scan)?)
            }
            name if !name.is_empty() && name.iter().all(u8::is_ascii_digit) => {
                (name, self.classic(&mut scan)?)
            }
            _ => return Ok(None),
        };
        let Some(content) = content else { return Ok(None) };
        let channel = channels.intern(name).ok_or_else(|| channel.fault(Channels::LIMIT))?;
        Ok(Some(Parsed { at, digits, channel: Some(channel), content }))
    }

    /// A line without a time.
    fn header(&mut self, mut scan: Scanner<'_>) -> Result<Option<Parsed>, Fault> {
        let start = scan;
        match scan.word() {
            b"base" => {
                scan.skip_blanks();
                self.radix = match scan.peek_word() {
                    b"hex" => 16,
                    b"dec" => 10,
                    _ => return Err(scan.fault("\"hex\" or \"dec\"")),
                };
                scan.word();
                scan.skip_blanks();
                if scan.word() == b"timestamps" {
                    self.distances = (scan.peek_word() == b"relative").then(Sum::default);
                }
                Ok(None)
            }
            word if word.is_empty() || word.starts_with(b"//") => Ok(None),
            word if HEADER.iter().any(|known| word.eq_ignore_ascii_case(known)) => Ok(None),
            _ => Err(start.fault("a time in seconds, or a line of the header")),
        }
    }

    /// After time and channel: identifier, direction, `d` or `r`, length, data.
    fn classic(&self, scan: &mut Scanner<'_>) -> Result<Option<Content>, Fault> {
        scan.skip_blanks();
        match scan.peek_word() {
            b"ErrorFrame" => return Ok(Some(Content::Error(ErrorFrame::UNSPECIFIED))),
            b"OverloadFrame" | b"Statistic:" | b"J1939TP" => return Ok(None),
            _ => {}
        }
        let id = self.id(scan)?;
        direction(scan)?;
        scan.skip_blanks();
        let kind = *scan;
        let remote = match scan.word() {
            b"d" => false,
            b"r" => true,
            _ => return Err(kind.fault("\"d\" (data) or \"r\" (remote)")),
        };
        scan.skip_blanks();
        let start = *scan;
        let dlc = match scan.word() {
            // The length of a remote frame may be missing; what comes then is how long it took.
            b"" | b"Length" if remote => 0,
            word => length_code(word).ok_or_else(|| start.fault("a length, 0 to F"))?,
        };
        if remote {
            return Ok(Frame::remote(id, dlc).map(Content::Classic));
        }
        let data = self.bytes::<{ Frame::MAX_DATA }>(scan, usize::from(dlc.min(8)))?;
        Ok(frame(id, dlc, data).map(Content::Classic))
    }

    /// After `CANFD` and the channel: direction, identifier, perhaps its name, BRS, ESI, length code, length, data, and
    /// duration, bit count, flags of the message.
    fn fd(&self, scan: &mut Scanner<'_>) -> Result<Option<Content>, Fault> {
        direction(scan)?;
        scan.skip_blanks();
        if scan.peek_word() == b"ErrorFrame" {
            return Ok(Some(Content::Error(ErrorFrame::UNSPECIFIED)));
        }
        let id = self.id(scan)?;
        scan.skip_blanks();
        if !matches!(scan.peek_word(), b"0" | b"1") {
            scan.word();
        }
        let bit_rate_switch = flag(scan)?;
        let error_passive = flag(scan)?;
        scan.skip_blanks();
        let start = *scan;
        let dlc = length_code(scan.word()).ok_or_else(|| start.fault("a data length code, 0 to F"))?;
        scan.skip_blanks();
        let start = *scan;
        let length = number(scan.word(), 10).filter(|length| *length <= 64);
        let length = length.ok_or_else(|| start.fault("a length, 0 to 64"))? as usize;
        let data = self.bytes::<{ FdFrame::MAX_DATA }>(scan, length)?;
        let mut flags = None;
        for _ in 0..3 {
            scan.skip_blanks();
            flags = number(scan.word(), 16);
        }
        let has = |flag| flags.is_some_and(|flags| flags & flag != 0);
        if has(FLAG_REMOTE) {
            return Ok(Frame::remote(id, dlc).map(Content::Classic));
        }
        // Some writers leave the flags 0. What no classic frame can have tells as well.
        let is_fd = flags.is_none() || has(FLAG_FD) || bit_rate_switch || length > Frame::MAX_DATA;
        let of_code = if is_fd { FdFrame::LENGTHS[usize::from(dlc)] } else { dlc.min(8) };
        if length != usize::from(of_code) {
            return Err(start.fault("the length that the data length code before it means"));
        }
        if is_fd {
            let frame = FdFrame::new(id, &data[..length], bit_rate_switch, error_passive);
            return Ok(frame.map(|frame| Content::Fd(Box::new(frame))));
        }
        let data = *data.first_chunk::<8>().unwrap_or(&[0; 8]);
        Ok(frame(id, dlc, data).map(Content::Classic))
    }

    fn id(&self, scan: &mut Scanner<'_>) -> Result<Id, Fault> {
        let start = *scan;
        let word = scan.word();
        let (digits, extended) = match word {
            [digits @ .., b'x' | b'X'] => (digits, true),
            digits => (digits, false),
        };
        let raw =
            number(digits, self.radix).ok_or_else(|| start.fault("an identifier in the base of the file"))?;
        let id = match extended {
            true => ExtendedId::new(raw).map(Id::Extended),
            false => u16::try_from(raw).ok().and_then(StandardId::new).map(Id::Standard),
        };
        id.ok_or_else(|| start.fault("an identifier of 11 bits, or of 29 bits with an x"))
    }

    fn bytes<const MAX: usize>(&self, scan: &mut Scanner<'_>, length: usize) -> Result<[u8; MAX], Fault> {
        let mut data = [0; MAX];
        for slot in &mut data[..length] {
            scan.skip_blanks();
            let start = *scan;
            let byte = number(scan.word(), self.radix).and_then(|byte| u8::try_from(byte).ok());
            *slot = byte.ok_or_else(|| start.fault("a byte in the base of the file"))?;
        }
        Ok(data)
    }
}

fn frame(id: Id, dlc: u8, data: [u8; 8]) -> Option<Frame> {
    if dlc > 8 { Frame::with_dlc(id, dlc, data) } else { Frame::new(id, &data[..usize::from(dlc)]) }
}

fn direction(scan: &mut Scanner<'_>) -> Result<(), Fault> {
    scan.skip_blanks();
    let start = *scan;
    match scan.word() {
        b"Rx" | b"Tx" | b"TxRq" => Ok(()),
        _ => Err(start.fault("Rx, Tx or TxRq")),
    }
}

fn flag(scan: &mut Scanner<'_>) -> Result<bool, Fault> {
    scan.skip_blanks();
    let start = *scan;
    match scan.word() {
        b"0" => Ok(false),
        b"1" => Ok(true),
        _ => Err(start.fault("0 or 1")),
    }
}

/// One hexadecimal digit, or 10 to 15, as some write it in a decimal file.
fn length_code(word: &[u8]) -> Option<u8> {
    let code = if word.len() == 1 { number(word, 16)? } else { number(word, 10)? };
    u8::try_from(code).ok().filter(|code| *code <= 15)
}

fn number(word: &[u8], radix: u32) -> Option<u32> {
    // `from_str_radix` takes a sign.
    if !word.first().is_some_and(u8::is_ascii_alphanumeric) {
        return None;
    }
    u32::from_str_radix(core::str::from_utf8(word).ok()?, radix).ok()
}

/// How the lines of the header begin, apart from `base` and comments.
const HEADER: [&[u8]; 6] = [b"date", b"internal", b"no", b"begin", b"end", b"previous"];

/// Flags of a CANFD line: a remote frame, a frame in the CAN FD format.
const FLAG_REMOTE: u32 = 0x10;
const FLAG_FD: u32 = 0x1000;

#[cfg(test)]
mod tests {
    use super::*;
    use link_core::Instant;
    use link_core::frame::{extended_id, standard_id};

    fn all(text: &str) -> Vec<Parsed> {
        let (mut asc, mut channels) = (Asc::default(), Channels::default());
        text.lines().filter_map(|line| asc.parse(line.as_bytes(), &mut channels).unwrap()).collect()
    }

    #[test]
    fn reads_frames_and_skips_the_rest() {
        let frames = all("date Tue Nov 14 22:13:20.000 2023
base hex  timestamps absolute
internal events logged
// version 9.0.0
Begin Triggerblock Tue Nov 14 22:13:20.000 2023
   0.000000 Start of measurement
   0.015991 1  456             Rx   d 6 01 4B 03 01 03 01  Length = 244000 BitCount = 126 ID = 1110
   0.016200 2  18FEF1FEx       Tx   r 8
   0.016250 1  J1939TP FEE3p        6    0  0   -   Rx   d 2 23 A0
   0.016300 1  456             TxRq d 9 00 01 02 03 04 05 06 07
   0.017000 1  ErrorFrame	ECC: 10100010
   0.017500 1  Statistic: D 1 R 0 XD 0 XR 0 E 0 O 0 B 0.00%
   0.018000 CANFD   1 Rx        453  Name_of_it  1 0 9 12 00 01 02 03 04 05 06 07 08 09 0A 0B 0 0 3000 0
   0.019000 CANFD   1 Rx        453  0 0 2 2 01 02 0 0 0 0
   0.020000 CANFD   1 Rx        453  0 0 2 0 0 0 10 0
   0.021000 CAN 1 Status:chip status error active
End TriggerBlock
");
        let contents: Vec<_> = frames.iter().map(|frame| frame.content.clone()).collect();
        let fd_bytes = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
        let expected = [
            Content::Classic(Frame::new(standard_id(0x456), &[1, 0x4B, 3, 1, 3, 1]).unwrap()),
            Content::Classic(Frame::remote(extended_id(0x18FE_F1FE), 8).unwrap()),
            Content::Classic(Frame::with_dlc(standard_id(0x456), 9, [0, 1, 2, 3, 4, 5, 6, 7]).unwrap()),
            Content::Error(ErrorFrame::UNSPECIFIED),
            Content::Fd(Box::new(FdFrame::new(standard_id(0x453).into(), &fd_bytes, true, false).unwrap())),
            Content::Classic(Frame::new(standard_id(0x453), &[1, 2]).unwrap()),
            Content::Classic(Frame::remote(standard_id(0x453), 2).unwrap()),
        ];
        assert_eq!(contents, expected);
        assert_eq!((frames[0].at, frames[0].digits), (Instant::from_micros(15_991), 6));
        assert_ne!(frames[0].channel, frames[1].channel);
    }

    #[test]
    fn the_header_chooses_base_and_kind_of_time() {
        let frames = all("base dec timestamps relative
   0.500000 1  1110            Rx   d 2 10 255
   0.500000 log trigger event
   0.250000 1  1110            Rx   d 0
");
        let first = Content::Classic(Frame::new(standard_id(1110), &[10, 255]).unwrap());
        assert_eq!(frames[0].content, first);
        assert_eq!(frames[1].at, Instant::from_millis(1250));
    }

    /// Lines of python-can's `test/data` (test_CanFdMessage64.asc, test_CanFdMessage.asc, test_CanFdRemoteMessage.asc),
    /// which come from Vector's own examples; the first has a data length of 64 and the flags 0.
    #[test]
    fn a_line_of_canfd_is_of_that_format_when_its_flags_or_its_length_say_so() {
        let zeros = "00 ".repeat(59);
        let frames = all(&format!(
            "  30.506898 CANFD   4 Rx        4EE                                   0 1 f 64 A1 02 03 04 {zeros}64 1331984 11 0 46500250 460a0250 20011736 20010205
  30.005021 CANFD   1 Rx        300                                   1 0 8  8 11 c2 03 04 05 06 07 08   102203  133   303000 e0006659 46500250 4b140250 20011736 2001040d
  30.300981 CANFD   3 Tx     50005x                                0 1 5 0 140000 73 200050 7a60 46500250 460a0250 20011736 20010205
"
        ));
        let mut long = [0; 64];
        long[..4].copy_from_slice(&[0xA1, 2, 3, 4]);
        long[63] = 0x64;
        let fd = |id: u16, bytes: &[u8], brs, esi| {
            Content::Fd(Box::new(FdFrame::new(standard_id(id).into(), bytes, brs, esi).unwrap()))
        };
        assert_eq!(frames[0].content, fd(0x4EE, &long, false, true));
        assert_eq!(frames[1].content, fd(0x300, &[0x11, 0xC2, 3, 4, 5, 6, 7, 8], true, false));
        let remote = Frame::remote(extended_id(0x5_0005), 5).unwrap();
        assert_eq!(frames[2].content, Content::Classic(remote));
    }

    /// Lines of python-can's `test/data` (test_CanRemoteMessage.asc, issue_1299.asc).
    #[test]
    fn a_remote_frame_may_have_no_length_and_a_data_frame_a_code_above_8() {
        let frames = all("   2.510001 2 100 Rx r
   2.520002 3 200 Tx r Length = 1704000 BitCount = 145 ID = 88888888x
   2.584921 4 300 Rx r 8 Length = 1704000 BitCount = 145 ID = 88888888x
  13.258671 1  3FF             Tx   d D 55 AA 01 02 03 04 05 06  Length = 232016 BitCount = 119 ID = 1023
");
        let contents: Vec<_> = frames.into_iter().map(|frame| frame.content).collect();
        let remote = |id, dlc| Content::Classic(Frame::remote(standard_id(id), dlc).unwrap());
        let long = Frame::with_dlc(standard_id(0x3FF), 13, [0x55, 0xAA, 1, 2, 3, 4, 5, 6]).unwrap();
        assert_eq!(contents, [remote(0x100, 0), remote(0x200, 0), remote(0x300, 8), Content::Classic(long)]);
    }

    #[test]
    fn a_second_header_ends_relative_times() {
        let frames = all("base hex timestamps relative
   0.500000 1  456             Rx   d 0
base hex timestamps absolute
   0.250000 1  456             Rx   d 0
");
        assert_eq!(frames[1].at, Instant::from_millis(250));
    }

    #[test]
    fn a_sum_of_times_must_be_a_time() {
        let (mut asc, mut channels) = (Asc::default(), Channels::default());
        let mut parse = |line: &str| asc.parse(line.as_bytes(), &mut channels);
        assert_eq!(parse("base hex timestamps relative"), Ok(None));
        assert!(parse("10000000000.0 1  456 Rx d 0").is_ok_and(|parsed| parsed.is_some()));
        assert_eq!(parse(" 10000000000.0 1  456 Rx d 0"), Err(Fault { at: 1, expected: Sum::LIMIT }));
        assert!(parse(" 1.0 1  456 Rx d 0").is_ok_and(|parsed| parsed.is_some()), "the sum stays as it was");
    }

    #[test]
    fn a_length_code_of_a_decimal_file_may_have_two_digits() {
        let frames = all("base dec timestamps absolute
   0.5 1  1110            Rx   d 15 1 2 3 4 5 6 7 8
");
        let long = Frame::with_dlc(standard_id(1110), 15, [1, 2, 3, 4, 5, 6, 7, 8]).unwrap();
        assert_eq!(frames[0].content, Content::Classic(long));
    }

    #[test]
    fn says_where_a_line_goes_wrong() {
        let fault = |line: &str| {
            let fault = Asc::default().parse(line.as_bytes(), &mut Channels::default()).unwrap_err();
            (fault.at + 1, fault.expected)
        };
        assert_eq!(fault("hello"), (1, "a time in seconds, or a line of the header"));
        assert_eq!(fault("0.1 1 456 up d 0"), (11, "Rx, Tx or TxRq"));
        assert_eq!(fault("0.1 1 456 Rx q 0"), (14, "\"d\" (data) or \"r\" (remote)"));
        assert_eq!(fault("0.1 1 456 Rx d 2 01"), (20, "a byte in the base of the file"));
        assert_eq!(fault("0.1 1 800 Rx d 0"), (7, "an identifier of 11 bits, or of 29 bits with an x"));
        assert_eq!(fault("0.1 CANFD 1 Rx 453 0 2 0 0"), (22, "0 or 1"));
        assert_eq!(fault("0.1 1 456 Rx d +1 01"), (16, "a length, 0 to F"));
        let length = "the length that the data length code before it means";
        assert_eq!(fault("0.1 CANFD 1 Rx 453 0 0 9 8 1 2 3 4 5 6 7 8 0 0 1000"), (26, length));
        assert_eq!(fault("0.1 CANFD 1 Rx 453 0 0 8 2 1 2 0 0 0"), (26, length));
    }
}
