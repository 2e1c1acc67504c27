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

use core::time::Duration;

use link_core::{Frame, Instant};

use super::Parsed;
use super::error::Fault;
use super::frame::{Channels, Content, ErrorFrame, FdFrame};
use super::scan::{CanId, Scanner};

/// Reads line after line.
#[derive(Clone, Debug, Default)]
pub(super) struct Screen {
    /// The times are distances (`-td`), and this is their sum.
    distances: Option<Duration>,
}

impl Screen {
    /// Learns from the beginning of the file whether its times are distances from line to line (`-td`): they look
    /// like times since the start (`-tz`), but do not grow.
    pub(super) fn detect(beginning: &[u8]) -> Self {
        let mut times = beginning.split(|byte| *byte == b'\n').filter_map(|line| {
            let mut scan = Scanner::new(line);
            scan.skip_blanks();
            let (at, _) = scan.eat(b'(').then(|| scan.seconds().ok())??;
            // Otherwise the year of a date.
            scan.eat(b')').then_some(at)
        });
        let mut last = times.next().unwrap_or(Instant::ZERO);
        let starts_at_zero = last == Instant::ZERO;
        let shrink = times.any(|at| core::mem::replace(&mut last, at) > at);
        Self { distances: (starts_at_zero && shrink).then_some(Duration::ZERO) }
    }

    /// Reads one line; `None` for one that holds no frame.
    pub(super) fn parse(&mut self, line: &[u8], channels: &mut Channels) -> Result<Option<Parsed>, Fault> {
        if line.first() == Some(&b'\t') {
            return Ok(None);
        }
        let mut scan = Scanner::new(line);
        scan.skip_blanks();
        let (mut at, mut digits) = (Instant::ZERO, 0);
        if scan.eat(b'(') {
            (at, digits) = time(&mut scan)?;
            scan.expect(b')', "\")\" after the time")?;
            scan.skip_blanks();
        }
        skip_colours(&mut scan);
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
        if let Some(sum) = &mut self.distances {
            *sum += Duration::from_nanos(at.as_nanos());
            at = Instant::ZERO + *sum;
        }
        Ok(Some(Parsed { at, digits, channel: Some(channel), content }))
    }
}

/// `ESC [ 34 m`, which `-c` puts before the interface.
fn skip_colours(scan: &mut Scanner<'_>) {
    while scan.eat(0x1B) {
        while scan.peek().is_some_and(|byte| byte != b'm') {
            scan.skip();
        }
        scan.skip();
    }
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

/// Bytes in hexadecimal, in hexadecimal and from the last to the first with grave accents between them (`-S`), or in
/// binary (`-i`).
fn data(scan: &mut Scanner<'_>, length: usize) -> Result<[u8; FdFrame::MAX_DATA], Fault> {
    let mut data = [0; FdFrame::MAX_DATA];
    let is_binary =
        scan.peek_word().len() == 8 && scan.peek_word().iter().all(|bit| matches!(bit, b'0' | b'1'));
    let mut is_swapped = false;
    for (index, slot) in data[..length].iter_mut().enumerate() {
        is_swapped |= index > 0 && scan.eat(b'`');
        scan.skip_blanks();
        if is_binary {
            let bits = *scan;
            let word = scan.word();
            let byte = word.iter().try_fold(0u8, |byte, bit| match bit {
                b'0' | b'1' => Some(byte << 1 | (bit - b'0')),
                _ => None,
            });
            *slot = byte.filter(|_| word.len() == 8).ok_or_else(|| bits.fault("eight binary digits"))?;
        } else {
            *slot = scan.hex_byte().ok_or_else(|| scan.fault("two hexadecimal digits"))?;
        }
    }
    if is_swapped {
        data[..length].reverse();
    }
    Ok(data)
}

/// Seconds, or a date and a time of day (`-tA`), which is taken for UTC: the file does not say.
fn time(scan: &mut Scanner<'_>) -> Result<(Instant, u8), Fault> {
    let start = *scan;
    let year = scan.decimal();
    if scan.peek() != Some(b'-') {
        *scan = start;
        return scan.seconds();
    }
    let date = || start.fault("a date and time, YYYY-MM-DD hh:mm:ss");
    let mut field = |separator: u8, range: core::ops::RangeInclusive<u64>| {
        let value = scan.eat(separator).then(|| scan.decimal()).flatten();
        value.filter(|value| range.contains(value)).ok_or_else(date)
    };
    let year = year.filter(|year| (1970..2500).contains(year)).ok_or_else(date)?;
    let (month, day) = (field(b'-', 1..=12)?, field(b'-', 1..=31)?);
    let (hour, minute) = (field(b' ', 0..=23)?, field(b':', 0..=59)?);
    scan.expect(b':', "\":\" and the seconds")?;
    let (seconds, digits) = scan.seconds()?;
    let minutes = (days_since_1970(year, month, day) * 24 + hour) * 60 + minute;
    Ok((seconds + Duration::from_secs(minutes * 60), digits))
}

/// Days from 1970-01-01 to a date of the Gregorian calendar.
fn days_since_1970(year: u64, month: u64, day: u64) -> u64 {
    // Years that begin in March have the leap day at their end, and months of 30.6 days on average.
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let days = year * 365 + year / 4 - year / 100 + year / 400 + (month * 153 + 2) / 5 + day - 1;
    days - DAYS_FROM_MARCH_0_TO_1970
}

/// From 1 March of the year 0 to 1 January 1970.
const DAYS_FROM_MARCH_0_TO_1970: u64 = 719_468;

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
    fn a_date_is_taken_for_utc() {
        let parsed = read(" (2023-11-14 22:13:20.000250)  can0  456   [0]");
        assert_eq!((parsed.at, parsed.digits), (Instant::from_micros(1_700_000_000_000_250), 6));
        assert_eq!(days_since_1970(2024, 2, 29), 19_782);
        assert!(
            Screen::default()
                .parse(b" (2023-13-14 22:13:20.0)  can0  456   [0]", &mut Channels::default())
                .is_err()
        );
    }

    #[test]
    fn distances_are_summed_when_the_beginning_shows_that_they_are_distances() {
        let text = b" (000.000000)  can0  456   [0]\n (000.500000)  can0  456   [0]\n (000.250000)  can0  456   [0]\n";
        let mut screen = Screen::detect(text);
        let mut channels = Channels::default();
        let times: Vec<_> = text
            .split(|byte| *byte == b'\n')
            .filter(|line| !line.is_empty())
            .map(|line| screen.parse(line, &mut channels).unwrap().unwrap().at)
            .collect();
        assert_eq!(times, [0, 500, 750].map(Instant::from_millis));
        assert!(Screen::detect(&text[..62]).distances.is_none(), "times that grow are times");
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
    }
}
