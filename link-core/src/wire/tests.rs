use super::*;
use crate::frame::{extended_id, standard_id};
use proptest::prelude::*;
extern crate std;
use std::vec::Vec;

/// The textbook bit-by-bit register of the Bosch specification, 3.1.1.
fn slow_crc(bits: &[bool]) -> u16 {
    bits.iter().fold(0, |crc: u16, &bit| {
        let next = bit != (crc & 0x4000 != 0);
        let shifted = crc << 1 & 0x7FFF;
        if next { shifted ^ 0x4599 } else { shifted }
    })
}

fn any_frame() -> impl Strategy<Value = Frame> {
    let id = prop_oneof![
        (0_u16..=0x7FF).prop_map(|raw| Id::from(standard_id(raw))),
        (0_u32..=0x1FFF_FFFF).prop_map(|raw| Id::from(extended_id(raw))),
    ];
    // Bytes of long runs, so that stuffing happens.
    let byte = prop_oneof![Just(0x00), Just(0xFF), Just(0x0F), any::<u8>()];
    prop_oneof![
        (id.clone(), prop::collection::vec(byte, 0..=8))
            .prop_map(|(id, data)| Frame::new(id, &data).unwrap()),
        (id.clone(), 0_u8..=15).prop_map(|(id, dlc)| Frame::remote(id, dlc).unwrap()),
        (id, 8_u8..=15, any::<[u8; 8]>()).prop_map(|(id, dlc, data)| Frame::with_dlc(id, dlc, data).unwrap()),
    ]
}

proptest! {
    #[test]
    fn the_length_is_the_number_of_bits(frame in any_frame()) {
        prop_assert_eq!(usize::try_from(bit_len(&frame)).unwrap(), bits(&frame).count());
    }

    #[test]
    fn never_six_equal_bits_where_bits_are_stuffed(frame in any_frame()) {
        let stuffed: Vec<bool> =
            bits(&frame).take_while(|bit| bit.field <= Field::Crc).map(|bit| bit.recessive).collect();
        prop_assert!(stuffed.windows(6).all(|six| six.iter().any(|&bit| bit != six[0])));
    }

    #[test]
    fn a_stuff_bit_follows_five_equal_bits_and_differs(frame in any_frame()) {
        let bits: Vec<Bit> = bits(&frame).collect();
        for (place, bit) in bits.iter().enumerate().filter(|(_, bit)| bit.stuff) {
            let before = &bits[place.checked_sub(5).unwrap()..place];
            prop_assert!(before.iter().all(|other| other.recessive != bit.recessive), "bit {}", place);
        }
    }

    #[test]
    fn the_crc_of_message_and_crc_is_zero(frame in any_frame()) {
        let unstuffed: Vec<bool> = bits(&frame)
            .filter(|bit| !bit.stuff && bit.field <= Field::Crc)
            .map(|bit| bit.recessive)
            .collect();
        prop_assert_eq!(slow_crc(&unstuffed), 0);
    }
}

#[test]
fn the_crc_is_of_the_low_bits_only() {
    assert_eq!(crc15(0xFFF5, 4), slow_crc(&[false, true, false, true]));
    assert_eq!(crc15(u128::MAX, 0), 0);
    assert_eq!(crc15(u128::MAX, 200), slow_crc(&[true; 128]));
}

/// Networking with DeviceNet (Circuit Cellar 98, 1998): "a frame can range from 44 to 108 bits".
#[test]
fn a_standard_frame_has_44_to_108_bits_before_stuffing() {
    for (len, expected) in [(0, 44), (8, 108)] {
        let frame = Frame::new(standard_id(0x555), &[0x55; 8][..len]).unwrap();
        assert_eq!(bits(&frame).filter(|bit| !bit.stuff).count(), expected);
    }
}

#[test]
fn an_extended_frame_has_20_bits_more() {
    let frame = Frame::new(extended_id(0x1555_5555), &[0x55; 8]).unwrap();
    assert_eq!(bits(&frame).filter(|bit| !bit.stuff).count(), 128);
}

#[test]
fn the_worst_case_of_stuffing_is_not_exceeded() {
    for len in 0..=8_usize {
        let worst = (0..=0x7FF_u16)
            .flat_map(|id| [0x00, 0xFF, 0x0F, 0xF0, 0x1F, 0x3C, 0x78].map(|byte| (id, byte)))
            .map(|(id, byte)| bit_len(&Frame::new(standard_id(id), &[byte; 8][..len]).unwrap()))
            .max()
            .unwrap();
        let n = u32::try_from(len).unwrap();
        assert!(worst <= 44 + 8 * n + (34 + 8 * n - 1) / 4, "{worst} bits with {len} bytes");
    }
}

/// All dominant up to the CRC, so the stuffing can be counted by hand: identifier 0, DLC 0 is 19 zero bits, and the
/// CRC of zeros is 0: 34 dominant bits, and after every fifth of them a recessive stuff bit: 6.
#[test]
fn a_frame_of_zeros_counted_by_hand() {
    assert_eq!(bit_len(&Frame::new(standard_id(0), &[]).unwrap()), 44 + 6);
}

#[test]
fn fields_come_in_order_and_in_full() {
    let frame = Frame::new(standard_id(0x52F), &[1, 2]).unwrap();
    let count = |field| bits(&frame).filter(|bit| !bit.stuff && bit.field == field).count();
    assert!(bits(&frame).is_sorted_by_key(|bit| bit.field));
    assert_eq!(
        [
            Field::StartOfFrame,
            Field::Arbitration,
            Field::Control,
            Field::Data,
            Field::Crc,
            Field::CrcDelimiter,
            Field::AckSlot,
            Field::AckDelimiter,
            Field::EndOfFrame
        ]
        .map(count),
        [1, 13, 5, 16, 15, 1, 1, 1, 7]
    );
}
