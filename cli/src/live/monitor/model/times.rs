//! Response times.

use core::time::Duration;

use crate::histogram::Histogram;

/// Response times: p50 and p99 to two digits, the longest exactly.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::live::monitor) struct Times {
    pub(in crate::live::monitor) count: u64,
    pub(in crate::live::monitor) p50: Duration,
    pub(in crate::live::monitor) p99: Duration,
    pub(in crate::live::monitor) max: Duration,
}

impl Times {
    /// `None` without a response.
    pub(super) fn of(histogram: &Histogram) -> Option<Self> {
        (histogram.count() > 0).then(|| Self {
            count: histogram.count(),
            p50: histogram.percentile(50),
            p99: histogram.percentile(99),
            max: histogram.max(),
        })
    }
}
