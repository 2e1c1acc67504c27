//! Response times in constant memory.

use core::time::Duration;

/// Counts durations in buckets that are at most 1/128 of their value wide, so that a percentile has two significant digits,
/// the second of which is at most one off.
#[derive(Clone, Debug, Default)]
pub(crate) struct Histogram {
    /// Empty until there is something to count.
    buckets: Vec<u32>,
    count: u64,
    min: Duration,
    max: Duration,
}

impl Histogram {
    pub(crate) fn record(&mut self, span: Duration) {
        if self.buckets.is_empty() {
            self.buckets.resize(BUCKETS, 0);
        }
        let bucket = &mut self.buckets[bucket_of(nanos(span))];
        *bucket = bucket.saturating_add(1);
        self.count += 1;
        self.min = if self.count == 1 { span } else { self.min.min(span) };
        self.max = self.max.max(span);
    }

    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    /// The longest, exactly.
    pub(crate) fn max(&self) -> Duration {
        self.max
    }

    /// The duration that `percent` of all do not exceed, rounded to two significant digits; exactly, if it is the shortest
    /// or the longest.
    pub(crate) fn percentile(&self, percent: u64) -> Duration {
        let rank = (self.count * percent).div_ceil(100).max(1);
        if rank >= self.count {
            return self.max;
        }
        if rank == 1 {
            return self.min;
        }
        let mut seen = 0;
        for (bucket, count) in self.buckets.iter().enumerate() {
            seen += u64::from(*count);
            if seen >= rank {
                return Duration::from_nanos(self.within(rounded(middle_of(bucket))));
            }
        }
        self.max
    }

    /// The nearest of two digits that is not below the shortest or above the longest; if there is none, one of these.
    fn within(&self, rounded: u64) -> u64 {
        let (min, max) = (nanos(self.min), nanos(self.max));
        let (low, high) = (min.checked_next_multiple_of(unit(min)).unwrap_or(min), max - max % unit(max));
        if low <= high { rounded.clamp(low, high) } else { rounded.clamp(min, max) }
    }
}

/// `0.30 ms`: a percentile with its two digits, or what is exact to the microsecond.
pub(crate) fn milliseconds(span: Duration) -> String {
    let decimals = decimals_of_milliseconds(span).unwrap_or(MICROSECONDS);
    format!("{:.decimals$} ms", span.as_secs_f64() * 1000.0)
}

/// `0.300 ms`: to the microsecond.
pub(crate) fn exact_milliseconds(span: Duration) -> String {
    format!("{:.MICROSECONDS$} ms", span.as_secs_f64() * 1000.0)
}

/// The decimals of a number of milliseconds that has two significant digits; `None` if it has more.
fn decimals_of_milliseconds(span: Duration) -> Option<usize> {
    let nanos = nanos(span);
    let second = second_digit(nanos);
    (rounded(nanos) == nanos).then(|| if nanos == 0 { 0 } else { 6_usize.saturating_sub(second as usize) })
}

/// To two significant digits.
fn rounded(nanos: u64) -> u64 {
    let unit = unit(nanos);
    nanos.saturating_add(unit / 2) / unit * unit
}

/// One of the second digit.
fn unit(nanos: u64) -> u64 {
    10_u64.pow(second_digit(nanos))
}

/// The power of ten that the second digit counts.
fn second_digit(nanos: u64) -> u32 {
    nanos.checked_ilog10().unwrap_or(0).saturating_sub(1)
}

/// Values below 128 have a bucket each; above, every power of two has 128.
fn bucket_of(nanos: u64) -> usize {
    let exponent = (u64::BITS - nanos.leading_zeros()).saturating_sub(SUB_BITS + 1);
    let mantissa = (nanos >> exponent) as usize;
    (exponent as usize * SUB_BUCKETS + mantissa).min(BUCKETS - 1)
}

fn middle_of(bucket: usize) -> u64 {
    let exponent = (bucket / SUB_BUCKETS).saturating_sub(1) as u32;
    let mantissa = (bucket - exponent as usize * SUB_BUCKETS) as u64;
    (mantissa << exponent) + ((1 << exponent) >> 1)
}

fn nanos(span: Duration) -> u64 {
    u64::try_from(span.as_nanos()).unwrap_or(u64::MAX)
}

/// Decimals of milliseconds.
const MICROSECONDS: usize = 3;
const SUB_BITS: u32 = 7;
const SUB_BUCKETS: usize = 1 << SUB_BITS;
/// Up to 2^37 ns, which is over two minutes; what is longer counts as that.
const BUCKETS: usize = SUB_BUCKETS * 31;

#[cfg(test)]
mod tests {
    use super::*;

    /// With two digits, the second of which is at most one off.
    #[test]
    fn percentiles_have_the_digits_that_they_are_right_to() {
        for scale in 1..50 {
            let mut histogram = Histogram::default();
            for micros in 1..=1_000 {
                histogram.record(Duration::from_micros(micros * scale));
            }
            assert_eq!((histogram.count(), histogram.max()), (1_000, Duration::from_micros(1_000 * scale)));
            for percent in [50, 90, 97, 99] {
                let (found, exact) = (nanos(histogram.percentile(percent)), percent * 10_000 * scale);
                assert_eq!(rounded(found), found, "p{percent} has more than two digits: {found}");
                let one = unit(exact);
                assert!(found.abs_diff(exact) <= one, "p{percent}: {found} instead of {exact}");
            }
        }
    }

    #[test]
    fn buckets_cover_every_value_without_a_gap() {
        for nanos in (0..100_000).chain([u64::from(u32::MAX), 1 << 36, (1 << 37) - 1]) {
            let bucket = bucket_of(nanos);
            let error = middle_of(bucket).abs_diff(nanos);
            assert!(
                error <= nanos / 256 + 1,
                "{nanos} is in bucket {bucket}, which stands for {}",
                middle_of(bucket)
            );
        }
        assert_eq!(bucket_of((1 << 37) - 1), BUCKETS - 1);
        assert_eq!(bucket_of(u64::MAX), BUCKETS - 1);
    }

    #[test]
    fn two_digits_in_milliseconds() {
        let text = |nanos| {
            let span = Duration::from_nanos(nanos);
            decimals_of_milliseconds(span).map(|decimals| format!("{:.decimals$}", span.as_secs_f64() * 1e3))
        };
        for (nanos, expected) in [
            (0, "0"),
            (300_000, "0.30"),
            (1_200_000, "1.2"),
            (12_000_000, "12"),
            (1_300_000_000, "1300"),
            (25_000, "0.025"),
        ] {
            assert_eq!(text(nanos).as_deref(), Some(expected));
        }
        assert_eq!(text(301_000), None);
        assert_eq!([96_500, 95_400, 99_600, 5, 0].map(rounded), [97_000, 95_000, 100_000, 5, 0]);
    }

    #[test]
    fn a_single_value_is_every_percentile() {
        let mut histogram = Histogram::default();
        histogram.record(Duration::from_micros(300));
        for percent in [1, 50, 99, 100] {
            assert_eq!(histogram.percentile(percent), Duration::from_micros(300));
        }
    }

    /// A damaged time in a recording must not end the summary.
    #[test]
    fn no_duration_is_too_long() {
        let mut histogram = Histogram::default();
        (0..3).for_each(|_| histogram.record(Duration::from_nanos(u64::MAX)));
        assert_eq!(histogram.percentile(50), Duration::from_nanos(u64::MAX));
        assert_eq!(decimals_of_milliseconds(histogram.max()), None);
    }

    #[test]
    fn a_percentile_is_within_what_was_seen() {
        let percentile = |micros: &[u64], percent| {
            let mut histogram = Histogram::default();
            micros.iter().for_each(|&micros| histogram.record(Duration::from_micros(micros)));
            histogram.percentile(percent).as_micros()
        };
        assert_eq!(percentile(&[300, 300, 301], 50), 300);
        assert_eq!(percentile(&[300, 300, 301], 99), 301, "the longest, exactly");
        assert_eq!(percentile(&[301, 310, 400], 1), 301, "the shortest, exactly");
        // 367 is about 370, but nothing was that long.
        assert_eq!(percentile(&[100, 200, 367, 369], 75), 360);
        // No number of two digits is between them.
        assert!((301..=309).contains(&percentile(&[301, 304, 307, 309], 50)));
    }
}
