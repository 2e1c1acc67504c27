//! What the tests of several modules share.

use link_core::frame::{extended_id, standard_id};
use link_core::{Frame, Id};
use proptest::prelude::*;

/// Frames of all kinds, with bytes of long runs, so that stuffing happens.
pub(crate) fn any_frame() -> impl Strategy<Value = Frame> {
    let id = prop_oneof![
        (0_u16..=0x7FF).prop_map(|raw| Id::from(standard_id(raw))),
        (0_u32..=0x1FFF_FFFF).prop_map(|raw| Id::from(extended_id(raw))),
    ];
    let byte = prop_oneof![Just(0x00), Just(0xFF), Just(0x0F), any::<u8>()];
    prop_oneof![
        (id.clone(), prop::collection::vec(byte, 0..=8))
            .prop_map(|(id, data)| Frame::new(id, &data).unwrap()),
        (id.clone(), 0_u8..=15).prop_map(|(id, dlc)| Frame::remote(id, dlc).unwrap()),
        (id, 8_u8..=15, any::<[u8; 8]>()).prop_map(|(id, dlc, data)| Frame::with_dlc(id, dlc, data).unwrap()),
    ]
}
