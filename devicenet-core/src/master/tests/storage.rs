//! What a master takes of memory.

use super::super::Master;

/// A change shows here first. Most of it are the buffers of each slave: request, response, input and output data.
#[test]
#[cfg(target_pointer_width = "64")]
fn the_size_of_a_master_is_known() {
    let sizes = [size_of::<Master<1, 16>>(), size_of::<Master<8, 64>>(), size_of::<Master<63, 256>>()];
    assert_eq!(sizes, [2856, 14_416, 268_568]);
}
