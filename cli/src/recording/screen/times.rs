//! The times of candump's screen output.
//!
//! | option | form | meaning |
//! |---|---|---|
//! | `-ta` | `(1700000006.000000)` | since 1970 |
//! | `-tA` | `(2023-11-14 22:13:20.000000)` | a date, taken for UTC: the file does not say |
//! | `-tz` | `(006.000000)` | since the first line |
//! | `-td` | `(000.010000)` | since the line before |
//!
//! The last two look the same, and are told apart by how they run.

use core::time::Duration;
use std::io::{self, Read};

use link_core::Instant;

use super::super::error::Fault;
use super::super::scan::{Scanner, Sum};
use super::super::window::Window;
use super::visible;

/// What the times of the lines mean.
#[derive(Clone, Debug)]
pub(super) enum Times {
    /// Not known yet, after so many times and with this sum of them.
    Unknown { read: u8, sum: Sum },
    /// The moment itself.
    Moments,
    /// Distances with this sum.
    Distances { sum: Sum },
}

impl Default for Times {
    fn default() -> Self {
        Self::Unknown { read: 0, sum: Sum::default() }
    }
}

impl Times {
    /// Learns from the lines to come whether times are distances, if that makes a difference now: at the latest from
    /// the third time on. Distances fall at every other line or so; times since the start fall only where candump
    /// changes from one interface to another. For a verdict so many lines are waited for, or the end.
    pub(super) fn learn<R: Read>(&mut self, window: &mut Window<R>) -> io::Result<()> {
        let sum = match *self {
            // The first is 0 with either option, and so the second means the same.
            Self::Unknown { read: 1, sum } if sum.at() > Instant::ZERO => sum,
            Self::Unknown { read: 2.., sum } => sum,
            Self::Unknown { .. } | Self::Moments | Self::Distances { .. } => return Ok(()),
        };
        let are_distances = loop {
            if let Some(verdict) = are_distances(sum.at(), window.ahead(), !window.can_fill()) {
                break verdict;
            }
            window.fill()?;
        };
        *self = if are_distances { Self::Distances { sum } } else { Self::Moments };
        Ok(())
    }

    /// The moment of the next line, which gives this time; both with their decimals. `None` when a sum is too large.
    pub(super) fn moment(&mut self, time: (Instant, u8), is_relative: bool) -> Option<(Instant, u8)> {
        match self {
            Self::Unknown { .. } | Self::Distances { .. } if !is_relative => *self = Self::Moments,
            Self::Unknown { read, sum } => {
                *read = read.saturating_add(1);
                sum.add(time)?;
            }
            Self::Distances { sum } => return sum.add(time),
            Self::Moments => {}
        }
        Some(time)
    }
}

/// Whether the relative times in the lines to come are distances: at least a quarter of the steps from one to the next
/// fall. `None` when more is to come that could tell.
fn are_distances(last: Instant, ahead: &[u8], is_all: bool) -> Option<bool> {
    let whole_lines = match ahead.iter().rposition(|byte| *byte == b'\n') {
        Some(end) if !is_all => &ahead[..end],
        None if !is_all => return None,
        _ => ahead,
    };
    let (mut last, mut steps, mut falls, mut rises) = (last, 0, 0, 0);
    for (at, is_relative) in whole_lines.split(|byte| *byte == b'\n').filter_map(time_of).take(STEPS) {
        if !is_relative {
            return Some(false);
        }
        steps += 1;
        falls += usize::from(at < last);
        rises += usize::from(at > last);
        last = at;
    }
    // Of times that stay the same, a clock that stands still is the unlikelier explanation.
    (steps == STEPS || is_all).then_some(steps > 0 && falls * 4 >= falls + rises)
}

/// The time of a line, and whether it [is relative](is_relative).
fn time_of(line: &[u8]) -> Option<(Instant, bool)> {
    let mut plain = visible(line).map(|(_, byte)| byte).skip_while(u8::is_ascii_whitespace);
    let mut beginning = [0; LONGEST];
    let mut length = 0;
    for (slot, byte) in beginning.iter_mut().zip(&mut plain) {
        *slot = byte;
        length += 1;
    }
    let mut scan = Scanner::new(&beginning[..length]);
    let is_relative = scan.eat(b'(').then(|| is_relative(scan))?;
    let (at, _) = read(&mut scan).ok()?;
    scan.eat(b')').then_some((at, is_relative))
}

/// Whether this is a time of `-tz` or `-td`: those have three digits before the point or a few more, others ten, or the
/// year of a date.
pub(super) fn is_relative(scan: Scanner<'_>) -> bool {
    let rest = scan.rest();
    let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    digits < 10 && rest.get(digits) != Some(&b'-')
}

/// Seconds, or a date and a time of day (`-tA`), which is taken for UTC: the file does not say.
pub(super) fn read(scan: &mut Scanner<'_>) -> Result<(Instant, u8), Fault> {
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
    // 60 is a leap second.
    if day > days_in_month(year, month) || seconds >= Instant::from_millis(61_000) {
        return Err(date());
    }
    let minutes = (days_since_1970(year, month, day) * 24 + hour) * 60 + minute;
    Ok((seconds + Duration::from_secs(minutes * 60), digits))
}

fn days_in_month(year: u64, month: u64) -> u64 {
    let (next_year, next_month) = if month == 12 { (year + 1, 1) } else { (year, month + 1) };
    days_since_1970(next_year, next_month, 1) - days_since_1970(year, month, 1)
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
/// So many steps from time to time tell what the times mean: of 16 steps between distances at random, fewer than four
/// fall in one file of 20,000.
const STEPS: usize = 16;
/// The longest time: a date and a time of day with 9 decimals, in parentheses.
const LONGEST: usize = 31;

#[cfg(test)]
mod tests {
    use super::*;

    /// The milliseconds that lines with these times mean, when a pipe gives one line after the other.
    fn milliseconds(times: &[&str]) -> Vec<u128> {
        let text: String = times.iter().map(|time| format!(" ({time})  can0  456   [0] \n")).collect();
        let mut window = Window::new(OneLine(text.as_bytes()));
        let mut meaning = Times::default();
        let mut read = Vec::new();
        loop {
            meaning.learn(&mut window).unwrap();
            if window.ahead().is_empty() {
                window.fill().unwrap();
            }
            let Some(end) = window.ahead().iter().position(|byte| *byte == b'\n') else { return read };
            let (at, is_relative) = time_of(window.take(end, 1)).unwrap();
            let (at, _) = meaning.moment((at, 6), is_relative).unwrap();
            read.push(at.saturating_since(Instant::ZERO).as_millis());
        }
    }

    /// A line with every read.
    struct OneLine<'a>(&'a [u8]);

    impl Read for OneLine<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let length = self.0.iter().position(|byte| *byte == b'\n').map_or(0, |end| end + 1);
            let (line, rest) = self.0.split_at(length);
            buffer[..length].copy_from_slice(line);
            self.0 = rest;
            Ok(length)
        }
    }

    fn date(text: &str) -> Result<(Instant, u8), Fault> {
        read(&mut Scanner::new(text.as_bytes()))
    }

    #[test]
    fn a_date_is_taken_for_utc() {
        let at = Instant::from_micros(1_700_000_000_000_250);
        assert_eq!(date("2023-11-14 22:13:20.000250"), Ok((at, 6)));
        assert_eq!(days_since_1970(2024, 2, 29), 19_782);
    }

    #[test]
    fn a_date_must_exist() {
        assert!(date("2024-02-29 23:59:60.5").is_ok());
        for wrong in ["2023-13-14 22:13:20.0", "2023-02-29 00:00:00.0", "2023-11-14 22:13:61.0"] {
            assert_eq!(date(wrong).unwrap_err().at, 0, "{wrong}");
        }
    }

    #[test]
    fn times_that_keep_falling_are_distances() {
        assert_eq!(milliseconds(&["000.000000", "000.500000", "000.250000"]), [0, 500, 750]);
        assert_eq!(milliseconds(&["000.000000", "000.500000", "000.600000"]), [0, 500, 600]);
        assert_eq!(milliseconds(&["000.000000", "000.500000"]), [0, 500]);
        assert_eq!(milliseconds(&["000.500000", "000.200000"]), [500, 700], "the beginning is cut off");
        assert_eq!(milliseconds(&["000.000000"; 1]), [0]);
    }

    #[test]
    fn times_that_stay_the_same_are_distances() {
        assert_eq!(milliseconds(&["000.000000", "000.010000", "000.010000"]), [0, 10, 20]);
    }

    /// candump asks one interface after the other, so their times may cross.
    #[test]
    fn a_time_that_falls_now_and_then_is_a_time() {
        let mut times: Vec<String> = (0..40).map(|n| format!("000.{:03}000", n * 10)).collect();
        times[3] = "000.019000".to_owned();
        let times: Vec<&str> = times.iter().map(String::as_str).collect();
        let read = milliseconds(&times);
        assert_eq!((read[2], read[3], read[4], read[39]), (20, 19, 40, 390));
    }

    /// A digit of the first line is lost.
    #[test]
    fn one_time_that_looks_relative_does_not_make_distances() {
        let times = ["170000002.500000", "1700000003.500000", "1700000006.000000"];
        assert_eq!(milliseconds(&times), [170_000_002_500, 1_700_000_003_500, 1_700_000_006_000]);
        let times = ["000.000000", "170000002.500000", "1700000006.000000", "1700000001.000000"];
        assert_eq!(milliseconds(&times), [0, 170_000_002_500, 1_700_000_006_000, 1_700_000_001_000]);
    }

    #[test]
    fn ten_digits_are_a_moment() {
        let mut times = Times::default();
        let time = date("1700000000.5").unwrap();
        assert_eq!(times.moment(time, is_relative(Scanner::new(b"1700000000.5"))), Some(time));
        let mut window = Window::new(io::empty());
        times.learn(&mut window).unwrap();
        let time = (Instant::from_millis(1000), 0);
        assert_eq!(times.moment(time, true), Some(time));
        assert!(!is_relative(Scanner::new(b"2023-11-14 22:13:20.0")) && is_relative(Scanner::new(b"000.5")));
    }

    /// Whoever writes the sum needs the decimals of the finest distance.
    #[test]
    fn a_sum_has_the_decimals_of_all_that_is_in_it() {
        let mut sum = Sum::default();
        sum.add((Instant::from_nanos(100), 7));
        assert_eq!(sum.add((Instant::from_micros(1), 6)), Some((Instant::from_nanos(1100), 7)));
        assert_eq!(sum.add((Instant::MAX, 6)), None);
    }
}
