//! Nodes that speak DeviceNeX.

use crate::trace;

trace!(
    of_two_with_one_address_the_lower_identity_keeps_it,
    "devicenex/two-with-one-address",
    "both begin with OA 67 in one bit; the higher one says its two Hellos again with OA 127, and stands by"
);
