//! How long frames take.

use core::time::Duration;

use super::config::{Config, NodePlan};
use crate::ethernet::{ETHERNET_HEADER, MIN_FRAME, POLL_HEADER};

/// The time of a frame at 100 Mbit/s, with preamble, CRC and the gap behind it; `len` counts what is handed to an adapter.
pub(super) fn wire_time(len: usize) -> Duration {
    let bytes = len.max(MIN_FRAME).saturating_add(PREAMBLE).saturating_add(CRC).saturating_add(GAP);
    Duration::from_nanos(u64::try_from(bytes).unwrap_or(u64::MAX).saturating_mul(NANOSECONDS_A_BYTE))
}

/// From PReq to the end of the PRes, at most.
pub(super) fn poll_time(plan: &NodePlan<'_>) -> Duration {
    let header = ETHERNET_HEADER.saturating_add(POLL_HEADER);
    let preq = wire_time(header.saturating_add(plan.preq_limit.into()));
    let pres = wire_time(header.saturating_add(plan.pres_limit.into()));
    preq.saturating_add(plan.pres_timeout).saturating_add(pres)
}

/// From SoA to the end of the answer, at most.
pub(super) fn slot_time(config: &Config) -> Duration {
    let answer = wire_time(ETHERNET_HEADER.saturating_add(config.async_mtu.into()));
    wire_time(0).saturating_add(config.async_slot).saturating_add(answer)
}

const PREAMBLE: usize = 8;
const CRC: usize = 4;
const GAP: usize = 12;
const NANOSECONDS_A_BYTE: u64 = 80;

#[cfg(test)]
mod tests {
    use super::*;

    /// openPOWERLINK 2.7.2, `dll.h`: preamble 640 ns, gap 960 ns, shortest frame 5120 ns.
    #[test]
    fn the_shortest_frame_takes_what_the_sources_say() {
        assert_eq!(wire_time(0), Duration::from_nanos(640 + 960 + 5120));
    }
}
