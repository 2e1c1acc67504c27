//! Two nodes that send the same identifier with different data in the same bit.
//!
//! Arbitration does not part them: at the first bit that differs one sees an error, its error flag destroys the frame of the
//! other, and both controllers begin again together, until they are bus-off. So each takes its frame back at the first error
//! and hands it out again after a pause that is not the other's.

use core::time::Duration;

use link_core::{BusErrorKind, LinkEvent};

use crate::id::MacId;

/// Whether an event may be that of a collision. A frame that nobody acknowledges collides with none.
pub(crate) fn is_collision(event: LinkEvent) -> bool {
    matches!(event, LinkEvent::BusError(kind) if kind != BusErrorKind::Ack)
}

/// How long a node waits after so many collisions before: 10 to 640 ms.
///
/// The MAC ID is multiplied by an odd number, another one after each collision. Two nodes on line have different MAC IDs, so
/// they never wait equally long, and are now closer to each other and now farther apart.
pub(crate) fn pause(own: MacId, collisions: u16) -> Duration {
    let factor = u64::from(collisions).wrapping_mul(2).wrapping_add(1);
    let turn = u64::from(own.number()).wrapping_mul(factor) & 0x3F;
    Duration::from_millis(turn.saturating_add(1).saturating_mul(10))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_nodes_never_wait_equally_long() {
        for collisions in 0..100 {
            let mut pauses: std::vec::Vec<_> = MacId::all().map(|own| pause(own, collisions)).collect();
            pauses.sort_unstable();
            let expected = (1..=64).map(|turn| Duration::from_millis(turn * 10));
            assert!(pauses.into_iter().eq(expected), "{collisions}");
        }
        assert_ne!(
            pause(MacId::MAX, 0).abs_diff(pause(MacId::MIN, 0)),
            pause(MacId::MAX, 1).abs_diff(pause(MacId::MIN, 1))
        );
    }
}
