//! Response times in constant memory.

use core::time::Duration;

/// Counts durations in buckets that are 1/32 of their value wide, so that a percentile is right to about 3 %.
#[derive(Clone, Debug)]
pub(super) struct Histogram {
    buckets: Box<[u32; BUCKETS]>,
    count: u64,
    min: Duration,
    max: Duration,
}

impl Histogram {
    pub(super) fn record(&mut self, span: Duration) {
        let bucket = &mut self.buckets[bucket_of(nanos(span))];
        *bucket = bucket.saturating_add(1);
        self.count += 1;
        self.min = if self.count == 1 { span } else { self.min.min(span) };
        self.max = self.max.max(span);
    }

    pub(super) fn count(&self) -> u64 {
        self.count
    }

    /// The longest, exactly.
    pub(super) fn max(&self) -> Duration {
        self.max
    }

    /// The duration that `percent` of all do not exceed, never below the shortest or above the longest.
    pub(super) fn percentile(&self, percent: u64) -> Duration {
        let rank = (self.count * percent).div_ceil(100).max(1);
        let mut seen = 0;
        for (bucket, count) in self.buckets.iter().enumerate() {
            seen += u64::from(*count);
            if seen >= rank {
                return Duration::from_nanos(middle_of(bucket)).clamp(self.min, self.max);
            }
        }
        self.max
    }
}

impl Default for Histogram {
    fn default() -> Self {
        Self { buckets: Box::new([0; BUCKETS]), count: 0, min: Duration::ZERO, max: Duration::ZERO }
    }
}

/// Values below 32 have a bucket each; above, every power of two has 32.
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

const SUB_BITS: u32 = 5;
const SUB_BUCKETS: usize = 1 << SUB_BITS;
/// Up to 2^37 ns, which is over two minutes; what is longer counts as that.
const BUCKETS: usize = SUB_BUCKETS * 33;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_right_to_three_percent() {
        let mut histogram = Histogram::default();
        for micros in 1..=10_000 {
            histogram.record(Duration::from_micros(micros));
        }
        assert_eq!((histogram.count(), histogram.max()), (10_000, Duration::from_millis(10)));
        for (percent, exact) in [(50, 5_000.0), (99, 9_900.0), (100, 10_000.0)] {
            let found = histogram.percentile(percent).as_secs_f64() * 1e6;
            assert!((found / exact - 1.0).abs() < 0.03, "p{percent}: {found} instead of {exact}");
        }
    }

    #[test]
    fn buckets_cover_every_value_without_a_gap() {
        for nanos in (0..10_000).chain([u64::from(u32::MAX), 1 << 36]) {
            let bucket = bucket_of(nanos);
            let error = middle_of(bucket).abs_diff(nanos);
            assert!(
                error <= nanos / 32,
                "{nanos} is in bucket {bucket}, which stands for {}",
                middle_of(bucket)
            );
        }
        assert_eq!(bucket_of(u64::MAX), BUCKETS - 1);
    }

    #[test]
    fn a_single_value_is_every_percentile() {
        let mut histogram = Histogram::default();
        histogram.record(Duration::from_micros(300));
        for percent in [1, 50, 99, 100] {
            assert_eq!(histogram.percentile(percent), Duration::from_micros(300));
        }
    }

    #[test]
    fn a_percentile_is_within_what_was_seen() {
        let mut histogram = Histogram::default();
        for micros in [300, 300, 301] {
            histogram.record(Duration::from_micros(micros));
        }
        assert!(histogram.percentile(50) >= Duration::from_micros(300), "{:?}", histogram.percentile(50));
        assert!(histogram.percentile(99) <= Duration::from_micros(301));
    }
}
