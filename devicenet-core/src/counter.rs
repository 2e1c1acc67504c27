//! Counters stay at their maximum.

/// One more. A call is shorter than the code, and there are many counters.
#[inline(never)]
pub(crate) const fn count(counter: &mut u16) {
    *counter = counter.saturating_add(1);
}

/// One more of what is frequent.
#[inline]
pub(crate) const fn count_wide(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
