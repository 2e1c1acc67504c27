use super::*;
extern crate std;
use std::{format, vec, vec::Vec};

#[test]
fn refuses_what_does_not_fit() {
    assert_eq!(Frame::new(StandardId::ZERO, &[0; 9]), None);
    assert_eq!(Frame::remote(StandardId::ZERO, 16), None);
    assert_eq!(Frame::with_dlc(StandardId::ZERO, 7, [0; 8]), None);
}

/// What stands behind the data is not part of the frame, so that equal frames are equal.
#[test]
fn of_eight_bytes_the_first_ones_are_the_data() {
    let id = StandardId::new(0x3FF).unwrap();
    let bytes = [1, 2, 3, 4, 5, 6, 7, 8];
    for len in 0..=8 {
        assert_eq!(Frame::first_of(id, bytes, len), Frame::new(id, &bytes[..len]));
    }
    assert_eq!(Frame::first_of(id, bytes, 9), None);
}

#[test]
fn a_dlc_above_eight_means_eight_bytes() {
    let frame = Frame::with_dlc(StandardId::ZERO, 15, [1; 8]).unwrap();
    assert_eq!((frame.dlc(), frame.data().len()), (15, 8));
    assert_ne!(frame, Frame::new(StandardId::ZERO, &[1; 8]).unwrap());
}

#[test]
fn arbitration_order_at_equal_eleven_bits() {
    let base = standard_id(0x123);
    let same = extended_id(0x123 << 18);
    let order = [
        Frame::new(base, &[]).unwrap(),
        Frame::remote(base, 0).unwrap(),
        Frame::new(same, &[]).unwrap(),
        Frame::remote(same, 0).unwrap(),
        Frame::new(standard_id(0x124), &[]).unwrap(),
    ];
    let keys: Vec<u32> = order.iter().map(Frame::arbitration_key).collect();
    assert!(keys.is_sorted_by(|a, b| a < b), "{keys:x?}");
}

#[test]
fn converts_to_and_from_other_frames() {
    for frame in [
        Frame::new(standard_id(0x52F), &[0, 0x34, 0x12]).unwrap(),
        Frame::remote(extended_id(0x1FFE_4433), 8).unwrap(),
    ] {
        assert_eq!(Frame::from_can(&frame), Some(frame));
        assert_eq!(frame.to_can::<Frame>(), Some(frame));
    }
}

#[cfg(feature = "serde")]
#[test]
fn a_serialised_frame_is_read_again_and_an_impossible_one_refused() {
    for frame in [
        Frame::new(standard_id(0x52F), &[0, 0x34]).unwrap(),
        Frame::with_dlc(extended_id(0x1FFE_4433), 15, [7; 8]).unwrap(),
        Frame::remote(standard_id(0x7FF), 9).unwrap(),
    ] {
        let text = serde_json::to_string(&frame).unwrap();
        assert_eq!(serde_json::from_str::<Frame>(&text).unwrap(), frame, "{text}");
    }
    let text = serde_json::to_string(&Frame::new(standard_id(0x52F), &[0, 0x34]).unwrap()).unwrap();
    assert_eq!(text, r#"{"id":1327,"extended":false,"remote":false,"dlc":2,"data":[0,52]}"#);
    for (from, to) in [("1327", "2048"), (":2", ":3"), (":2", ":16"), ("\"remote\":false", "\"remote\":true")]
    {
        let wrong = text.replace(from, to);
        assert!(serde_json::from_str::<Frame>(&wrong).is_err(), "{wrong}");
    }
}

/// A frame as a driver might have it: `dlc` and `data` say what they like.
struct Foreign {
    dlc: usize,
    data: Vec<u8>,
}

impl embedded_can_types::Frame for Foreign {
    fn new(_: impl Into<Id>, data: &[u8]) -> Option<Self> {
        Some(Self { dlc: data.len(), data: data.to_vec() })
    }
    fn new_remote(_: impl Into<Id>, _: usize) -> Option<Self> {
        None
    }
    fn is_extended(&self) -> bool {
        false
    }
    fn is_remote_frame(&self) -> bool {
        false
    }
    fn id(&self) -> Id {
        StandardId::ZERO.into()
    }
    fn dlc(&self) -> usize {
        self.dlc
    }
    fn data(&self) -> &[u8] {
        &self.data
    }
}

#[test]
fn a_frame_of_can_fd_is_refused_and_not_cut() {
    for (dlc, len) in [(9, 12), (12, 12), (64, 64), (16, 8), (8, 7)] {
        let foreign = Foreign { dlc, data: vec![0xAA; len] };
        assert_eq!(Frame::from_can(&foreign), None, "DLC {dlc}, {len} bytes");
    }
}

#[test]
fn a_driver_that_tells_a_dlc_above_eight_is_believed() {
    let frame = Frame::from_can(&Foreign { dlc: 11, data: vec![0xAA; 8] });
    assert_eq!(frame, Frame::with_dlc(StandardId::ZERO, 11, [0xAA; 8]));
    let short = Frame::from_can(&Foreign { dlc: 2, data: vec![1, 2, 0, 0] });
    assert_eq!(short, Frame::new(StandardId::ZERO, &[1, 2]), "a driver that hands out its whole buffer");
}

#[test]
fn shows_itself_as_candump_does() {
    let frame = Frame::new(standard_id(0x52F), &[0, 0x34, 0xAB]).unwrap();
    assert_eq!(format!("{frame}"), "52F [3] 00 34 AB");
    assert_eq!(format!("{}", Frame::remote(extended_id(0x123), 8).unwrap()), "00000123 [8] remote");
}
