//! Frames that the interface has lost: an overloaded machine loses some many times a second, and has no time for as many lines.

use core::time::Duration;

use link_core::Instant;

/// What was lost and is not told yet.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(crate) struct Losses {
    /// 0 of those that were not counted.
    untold: Option<u32>,
    told_at: Option<Instant>,
}

impl Losses {
    pub(crate) fn add(&mut self, lost: u32) {
        self.untold = Some(self.untold.unwrap_or_default().saturating_add(lost));
    }

    /// What is to be told now: the first loss at once, and then once a second what has come meanwhile.
    pub(crate) fn due(&mut self, now: Instant) -> Option<u32> {
        if self.told_at.is_some_and(|told_at| now.saturating_since(told_at) < PAUSE) {
            return None;
        }
        let lost = self.rest()?;
        self.told_at = Some(now);
        Some(lost)
    }

    /// What is not told yet, however little time has passed.
    pub(crate) fn rest(&mut self) -> Option<u32> {
        self.untold.take()
    }
}

const PAUSE: Duration = Duration::from_secs(1);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn losses_are_told_at_once_and_then_once_a_second() {
        let at = Instant::from_millis;
        let mut losses = Losses::default();
        assert_eq!(losses.due(at(0)), None);
        losses.add(3);
        assert_eq!(losses.due(at(100)), Some(3));
        losses.add(5);
        losses.add(7);
        assert_eq!(losses.due(at(1_099)), None);
        assert_eq!(losses.due(at(1_100)), Some(12));
        losses.add(0);
        assert_eq!((losses.due(at(2_100)), losses.due(at(4_000))), (Some(0), None), "not counted");
        losses.add(1);
        assert_eq!((losses.due(at(4_000)), losses.rest()), (Some(1), None));
        losses.add(2);
        assert_eq!(
            (losses.due(at(4_999)), losses.rest(), losses.rest()),
            (None, Some(2), None),
            "at the end"
        );
    }
}
