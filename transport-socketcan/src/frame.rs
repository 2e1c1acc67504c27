//! Frames as the kernel has them, and as a machine has them.

use link_core::{ExtendedId, Frame, Id, StandardId};
use socketcan::CanFrame;

/// A data or remote frame of the kernel; `None` for an error frame, or one that no bus can carry.
///
/// `len8_dlc` is the data length code on the wire where that is above 8.
pub(crate) fn from_kernel(raw: &libc::can_frame) -> Option<Frame> {
    if raw.can_id & libc::CAN_ERR_FLAG != 0 {
        return None;
    }
    let id: Id = if raw.can_id & libc::CAN_EFF_FLAG != 0 {
        ExtendedId::new(raw.can_id & libc::CAN_EFF_MASK)?.into()
    } else {
        StandardId::new(u16::try_from(raw.can_id & libc::CAN_SFF_MASK).ok()?)?.into()
    };
    let code = if raw.can_dlc == 8 && raw.len8_dlc > 8 { raw.len8_dlc } else { raw.can_dlc };
    if raw.can_id & libc::CAN_RTR_FLAG != 0 {
        return Frame::remote(id, code);
    }
    match code {
        0..=8 => Frame::new(id, raw.data.get(..usize::from(code))?),
        _ => Frame::with_dlc(id, code, raw.data),
    }
}

/// A frame as it will be on the bus, and in the echo: with a data length code of at most 8.
pub(crate) fn as_sent(frame: &Frame) -> Frame {
    let shorter = match frame.is_remote() {
        true if frame.dlc() > 8 => Frame::remote(frame.id(), 8),
        false if frame.dlc() > 8 => Frame::new(frame.id(), frame.data()),
        _ => None,
    };
    shorter.unwrap_or(*frame)
}

/// The frame for the kernel.
pub(crate) fn to_kernel(frame: &Frame) -> Option<CanFrame> {
    frame.to_can()
}

/// A frame as a socket takes it, `struct can_frame` of linux/can.h:
///
/// | bytes | field |
/// |---|---|
/// | 0-3 | identifier and flags, in the byte order of the machine |
/// | 4 | length |
/// | 5-7 | 0 |
/// | 8-15 | data |
pub(crate) fn bytes(frame: &CanFrame) -> [u8; 16] {
    let raw: &libc::can_frame = frame.as_ref();
    let [i0, i1, i2, i3] = raw.can_id.to_ne_bytes();
    let [d0, d1, d2, d3, d4, d5, d6, d7] = raw.data;
    [i0, i1, i2, i3, raw.can_dlc, 0, 0, 0, d0, d1, d2, d3, d4, d5, d6, d7]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use socketcan::frame::can_frame_default;

    fn raw(can_id: u32, can_dlc: u8, len8_dlc: u8) -> libc::can_frame {
        let mut raw = can_frame_default();
        (raw.can_id, raw.can_dlc, raw.len8_dlc, raw.data) =
            (can_id, can_dlc, len8_dlc, [1, 2, 3, 4, 5, 6, 7, 8]);
        raw
    }

    // linux/can.h: bit 31 extended, bit 30 remote, bit 29 error.
    #[test]
    fn the_upper_bits_say_what_it_is() {
        assert_eq!(from_kernel(&raw(0x52F, 2, 0)).unwrap().to_string(), "52F [2] 01 02");
        assert_eq!(from_kernel(&raw(0x8000_052F, 1, 0)).unwrap().to_string(), "0000052F [1] 01");
        assert_eq!(from_kernel(&raw(0x4000_052F, 8, 0)).unwrap().to_string(), "52F [8] remote");
        assert_eq!(from_kernel(&raw(0x2000_0004, 8, 0)), None);
    }

    #[test]
    fn a_length_code_above_eight_is_kept() {
        assert_eq!(from_kernel(&raw(0x52F, 8, 15)).unwrap().dlc(), 15);
        assert_eq!(from_kernel(&raw(0x52F, 7, 15)).unwrap().dlc(), 7, "it counts for eight bytes only");
        assert_eq!(from_kernel(&raw(0x52F, 8, 16)), None);
    }

    #[test]
    fn a_length_code_above_eight_is_sent_as_eight() {
        let long = Frame::with_dlc(StandardId::new(0x52F).unwrap(), 15, [1, 2, 3, 4, 5, 6, 7, 8]).unwrap();
        assert_eq!(as_sent(&long).to_string(), "52F [8] 01 02 03 04 05 06 07 08");
        let remote = Frame::remote(StandardId::new(0x52F).unwrap(), 15).unwrap();
        assert_eq!(as_sent(&remote).to_string(), "52F [8] remote");
        let short = Frame::remote(StandardId::new(0x52F).unwrap(), 3).unwrap();
        assert_eq!(as_sent(&short), short);
    }

    #[test]
    fn the_bytes_of_a_frame() {
        let bytes_of = |frame: Frame| bytes(&to_kernel(&frame).unwrap());
        let extended = Frame::new(ExtendedId::new(0x0102_0304).unwrap(), &[0xAB, 0xCD]).unwrap();
        let mut expected = [0; 16];
        expected[..4].copy_from_slice(&0x8102_0304_u32.to_ne_bytes());
        (expected[4], expected[8], expected[9]) = (2, 0xAB, 0xCD);
        assert_eq!(bytes_of(extended), expected);
        let remote = Frame::remote(StandardId::new(0x52F).unwrap(), 8).unwrap();
        let mut expected = [0; 16];
        expected[..4].copy_from_slice(&0x4000_052F_u32.to_ne_bytes());
        expected[4] = 8;
        assert_eq!(bytes_of(remote), expected);
    }

    proptest! {
        #[test]
        fn there_and_back(id in 0..0x2000_0000_u32, extended: bool, remote: bool, data in prop::collection::vec(any::<u8>(), 0..=8)) {
            let id: Id = if extended {
                ExtendedId::new(id).unwrap().into()
            } else {
                StandardId::new(u16::try_from(id & 0x7FF).unwrap()).unwrap().into()
            };
            let frame = if remote { Frame::remote(id, u8::try_from(data.len()).unwrap()) } else { Frame::new(id, &data) };
            let raw: libc::can_frame = match to_kernel(&frame.unwrap()).unwrap() {
                CanFrame::Data(frame) => *frame.as_ref(),
                CanFrame::Remote(frame) => *frame.as_ref(),
                CanFrame::Error(_) => unreachable!(),
            };
            prop_assert_eq!(from_kernel(&raw), frame);
        }
    }
}
