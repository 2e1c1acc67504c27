//! The monitor as a whole.

use super::*;

/// A growth is a decision: the documentation of [`Monitor`] names the size.
#[test]
fn the_size_of_a_monitor_is_known() {
    assert_eq!(core::mem::size_of::<Monitor>(), 96_392);
}
