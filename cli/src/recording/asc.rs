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
//! `x` marks 29 bits, `r` a remote frame. Times count from the start of the measurement; with `timestamps relative`
//! each counts from the line before. Other events (bus statistics, triggers, other buses, comments) are skipped, and the
//! date is not used, because it comes in the language of the program that wrote it.

use core::time::Duration;

use link_core::{ExtendedId, Frame, Id, Instant, StandardId};

use super::Parsed;
use super::error::Fault;
use super::frame::{Channels, Content, ErrorFrame, FdFrame};
use super::scan::Scanner;

/// Reads line after line; the header changes how the others are read.
#[derive(Clone, Debug)]
pub(super) struct Asc {
    radix: u32,
    /// With relative times, the sum of those so far.
    distances: Option<Duration>,
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
        let (mut at, digits) = scan.seconds()?;
        if let Some(sum) = &mut self.distances {
            *sum += Duration::from_nanos(at.as_nanos());
            at = Instant::ZERO + *sum;
        }
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
        let channel = channels.intern(name).ok_or_else(|| channel.fault("at most 255 channels"))?;
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
                if scan.word() == b"timestamps" && scan.peek_word() == b"relative" {
                    self.distances = Some(Duration::ZERO);
                }
                Ok(None)
            }
            b"" | b"date" | b"internal" | b"no" | b"Begin" | b"End" | b"previous" => Ok(None),
            comment if comment.starts_with(b"//") => Ok(None),
            _ => Err(start.fault("a time in seconds, or a line of the header")),
        }
    }

    /// After time and channel: identifier, direction, `d` or `r`, length, data.
    fn classic(&self, scan: &mut Scanner<'_>) -> Result<Option<Content>, Fault> {
        scan.skip_blanks();
        match scan.peek_word() {
            b"ErrorFrame" => return Ok(Some(Content::Error(ErrorFrame::UNSPECIFIED))),
            b"OverloadFrame" | b"Statistic:" => return Ok(None),
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
        // A remote frame may come without its length.
        let dlc = match scan.word() {
            b"" if remote => 0,
            word => number(word, 16)
                .filter(|dlc| *dlc <= 15)
                .ok_or_else(|| start.fault("a length, 0 to F"))? as u8,
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
        let dlc = number(scan.word(), 16).filter(|dlc| *dlc <= 15);
        let dlc = dlc.ok_or_else(|| start.fault("a data length code, 0 to F"))? as u8;
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
        let is_classic = flags.is_some_and(|flags| flags & FLAG_FD == 0);
        if !is_classic {
            let frame = FdFrame::new(id, &data[..length], bit_rate_switch, error_passive);
            let frame = frame.ok_or_else(|| start.fault("a length that CAN FD has"))?;
            return Ok(Some(Content::Fd(Box::new(frame))));
        }
        if flags.is_some_and(|flags| flags & FLAG_REMOTE != 0) {
            return Ok(Frame::remote(id, dlc).map(Content::Classic));
        }
        let data = *data.first_chunk::<8>().unwrap_or(&[0; 8]);
        Ok(frame(id, dlc, data).map(Content::Classic))
    }

    fn id(&self, scan: &mut Scanner<'_>) -> Result<Id, Fault> {
        let start = *scan;
        let word = scan.word();
        let (digits, extended) = match word.strip_suffix(b"x") {
            Some(digits) => (digits, true),
            None => (word, false),
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

fn number(word: &[u8], radix: u32) -> Option<u32> {
    u32::from_str_radix(core::str::from_utf8(word).ok()?, radix).ok()
}

/// Flags of a CANFD line: a remote frame, a frame in the CAN FD format.
const FLAG_REMOTE: u32 = 0x10;
const FLAG_FD: u32 = 0x1000;

#[cfg(test)]
mod tests {
    use super::*;
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
    }
}
