//! What a frame takes of the bus.

use link_core::Frame;
use link_core::wire::INTERMISSION_BITS;

/// The bits of a frame on the bus: stuff bits and the intermission that follows are included.
pub(crate) fn bits(frame: &Frame) -> u32 {
    frame.bit_len() + INTERMISSION_BITS
}

/// The least that an error frame takes: error flag 6, error delimiter 8, intermission 3. How much was sent of the frame that it
/// ended, and how far the flags of others make it longer, no controller tells.
pub(crate) const ERROR_FRAME: u32 = 17;
