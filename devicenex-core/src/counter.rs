//! Counters stay at their maximum.

/// One more.
pub(crate) const fn count(counter: &mut u16) {
    *counter = counter.saturating_add(1);
}

/// One more of what is frequent.
pub(crate) const fn count_wide(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
