//! Cutting messages into fragments.

use super::{
    COUNT_MASK, EXPLICIT_FRAGMENT_LEN, EXPLICIT_UNFRAGMENTED_LEN, FragmentByte, FragmentKind,
    IO_FRAGMENT_LEN, IO_MESSAGE_MAX,
};

/// One fragment: what stands in the data field, for explicit messages after the header byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Fragment<'a> {
    /// The fragmentation byte.
    pub byte: FragmentByte,
    /// The piece of the message.
    pub data: &'a [u8],
}

/// True if the body of an explicit message is too long for one frame.
pub const fn is_fragmented_explicit(body: &[u8]) -> bool {
    body.len() > EXPLICIT_UNFRAGMENTED_LEN
}

/// The longest body that needs no fragments: a frame that is none has no fragmentation byte.
pub(super) const fn unfragmented_len(piece: usize, prefix: usize) -> usize {
    piece.saturating_add(1).saturating_sub(prefix)
}

/// Fragment number `index` of an explicit message, counted from 0; `None` after the last.
///
/// A sender keeps the index instead of an iterator: to repeat a fragment is to ask for the same index again. A body
/// of up to seven bytes needs no fragmentation and is cut all the same when asked for: a body of at most six bytes
/// has no second piece and is `None` altogether, because there is no "first and only" fragment in explicit messages.
pub fn explicit_fragment(body: &[u8], index: usize) -> Option<Fragment<'_>> {
    explicit_piece::<EXPLICIT_FRAGMENT_LEN, 0>(body, index)
}

/// The same for a network whose frames have another room for a message: `PIECE` bytes in each, of which `PREFIX` in the
/// first are something else.
///
/// ```
/// use cip_core::fragment::explicit_piece;
///
/// // Eight bytes in each frame; the first byte of the first one is a transaction ID.
/// let body = [0x8E, 1, 2, 3, 4, 5, 6, 7, 8];
/// assert_eq!(explicit_piece::<8, 1>(&body, 0).unwrap().data, [0x8E, 1, 2, 3, 4, 5, 6]);
/// assert_eq!(explicit_piece::<8, 1>(&body, 1).unwrap().data, [7, 8]);
/// assert_eq!(explicit_piece::<8, 1>(&body, 2), None);
/// ```
pub fn explicit_piece<const PIECE: usize, const PREFIX: usize>(
    body: &[u8],
    index: usize,
) -> Option<Fragment<'_>> {
    let first = PIECE.saturating_sub(PREFIX);
    let start = index.checked_mul(PIECE)?.saturating_sub(PREFIX);
    let room = if index == 0 { first } else { PIECE };
    let rest = body.get(start..).filter(|rest| !rest.is_empty() && body.len() > first)?;
    let data = rest.get(..room).unwrap_or(rest);
    let kind = match (index, rest.len() > room) {
        (0, _) => FragmentKind::First,
        (_, true) => FragmentKind::Middle,
        (_, false) => FragmentKind::Last,
    };
    Some(Fragment { byte: FragmentByte::new(kind, count_of(index)), data })
}

/// The count of a fragment: its index modulo 64.
pub(super) const fn count_of(index: usize) -> u8 {
    let [low, ..] = index.to_le_bytes();
    low & COUNT_MASK
}

/// The fragments of an explicit message in their order.
///
/// ```
/// use cip_core::fragment::ExplicitFragments;
///
/// let body = [0x10, 0x04, 0x66, 0x03, 1, 2, 3, 4, 5, 6];
/// let bytes: Vec<u8> = ExplicitFragments::new(&body).map(|fragment| fragment.byte.into()).collect();
/// assert_eq!(bytes, [0x00, 0x81]);
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ExplicitFragments<'a> {
    body: &'a [u8],
    next: usize,
}

impl<'a> ExplicitFragments<'a> {
    /// Cuts `body`, which starts with the service byte.
    pub const fn new(body: &'a [u8]) -> Self {
        Self { body, next: 0 }
    }
}

impl<'a> Iterator for ExplicitFragments<'a> {
    type Item = Fragment<'a>;

    fn next(&mut self) -> Option<Self::Item> {
        let fragment = explicit_fragment(self.body, self.next)?;
        self.next = self.next.saturating_add(1);
        Some(fragment)
    }
}

/// How an I/O message without data is sent on a connection that fragments. Receivers accept both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum EmptyMessage {
    /// A frame with an empty data field.
    #[default]
    NoData,
    /// The single byte 0x3F.
    FirstAndOnly,
}

/// The data fields of the frames that carry an I/O message on a connection that fragments.
///
/// ```
/// use cip_core::fragment::{EmptyMessage, IoFragments};
///
/// let fields: Vec<_> = IoFragments::new(&[1, 2, 3, 4, 5, 6, 7, 8], EmptyMessage::NoData).unwrap().collect();
/// assert_eq!(fields[0], [0x00, 1, 2, 3, 4, 5, 6, 7]);
/// assert_eq!(fields[1], [0x81, 8]);
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct IoFragments<'a> {
    rest: &'a [u8],
    next: Next,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Next {
    Empty(EmptyMessage),
    Only,
    First,
    Following(u8),
    Done,
}

impl<'a> IoFragments<'a> {
    /// Cuts `message`; `None` if it is longer than [`IO_MESSAGE_MAX`].
    pub const fn new(message: &'a [u8], empty: EmptyMessage) -> Option<Self> {
        let next = match message.len() {
            0 => Next::Empty(empty),
            1..=IO_FRAGMENT_LEN => Next::Only,
            len if len <= IO_MESSAGE_MAX => Next::First,
            _ => return None,
        };
        Some(Self { rest: message, next })
    }

    fn take(&mut self, byte: FragmentByte) -> Option<heapless::Vec<u8, 8>> {
        let (data, rest) = self.rest.split_at_checked(IO_FRAGMENT_LEN).unwrap_or((self.rest, &[]));
        self.rest = rest;
        let mut field = heapless::Vec::new();
        field.push(byte.into()).ok()?;
        field.extend_from_slice(data).ok()?;
        Some(field)
    }
}

impl Iterator for IoFragments<'_> {
    type Item = heapless::Vec<u8, 8>;

    fn next(&mut self) -> Option<Self::Item> {
        match self.next {
            Next::Empty(EmptyMessage::NoData) => {
                self.next = Next::Done;
                Some(heapless::Vec::new())
            }
            Next::Empty(EmptyMessage::FirstAndOnly) | Next::Only => {
                self.next = Next::Done;
                self.take(FragmentByte::FIRST_AND_ONLY)
            }
            Next::First => {
                self.next = Next::Following(1);
                self.take(FragmentByte::FIRST)
            }
            Next::Following(count) if self.rest.len() > IO_FRAGMENT_LEN => {
                self.next = Next::Following(count.saturating_add(1));
                self.take(FragmentByte::new(FragmentKind::Middle, count))
            }
            Next::Following(count) => {
                self.next = Next::Done;
                self.take(FragmentByte::new(FragmentKind::Last, count))
            }
            Next::Done => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn explicit(body: &[u8]) -> Vec<Vec<u8>> {
        ExplicitFragments::new(body)
            .map(|fragment| [&[u8::from(fragment.byte)], fragment.data].concat())
            .collect()
    }

    /// Konvolucio.DeviceNet unit-test logs, Omron GRT1-DRT: the product name as the slave sends it. The logs hold the
    /// last fragment (header 80); the first follows from the body.
    #[test]
    fn product_name_of_an_omron_terminal() {
        let body = b"\x8E\x08GRT1-DRT";
        assert_eq!(
            explicit(body),
            [&[0x00, 0x8E, 0x08, 0x47, 0x52, 0x54, 0x31][..], &[0x81, 0x2D, 0x44, 0x52, 0x54]]
        );
    }

    /// Rockwell 1760-UM003A-EN-P, p. 4-11 and 4-12: first fragments of service 0x32 and of its response.
    #[test]
    fn first_fragments_of_a_pico_controller() {
        let request = [0x32, 0x64, 0x01, 0x93, 0x05, 0x00, 0x00];
        assert_eq!(explicit(&request)[0], [0x00, 0x32, 0x64, 0x01, 0x93, 0x05, 0x00]);
        let response = [0xB2, 0xC2, 0x05, 0x00, 0x05, 0x09, 0x00, 0x00];
        assert_eq!(explicit(&response)[0], [0x00, 0xB2, 0xC2, 0x05, 0x00, 0x05, 0x09]);
    }

    #[test]
    fn explicit_counts_wrap_and_only_the_end_is_last() {
        let body = [0; 6 * 66];
        let bytes: Vec<u8> = ExplicitFragments::new(&body).map(|fragment| fragment.byte.into()).collect();
        assert_eq!(bytes.len(), 66);
        assert_eq!(bytes[62..], [0x40 | 62, 0x40 | 63, 0x40, 0x81]);
    }

    #[test]
    fn a_body_that_fits_needs_no_fragments() {
        assert!(!is_fragmented_explicit(&[0; 7]));
        assert!(is_fragmented_explicit(&[0; 8]));
        assert_eq!(explicit_fragment(&[0; 6], 0), None);
        assert_eq!(explicit_fragment(&[0; 12], 2), None);
        assert_eq!(explicit_fragment(&[0; 12], usize::MAX), None);
    }

    fn io(message: &[u8]) -> Vec<Vec<u8>> {
        IoFragments::new(message, EmptyMessage::NoData).unwrap().map(|field| field.to_vec()).collect()
    }

    /// ICP DAS I-7242D User Manual v1.1, p. 95: ten output bytes end in `81 08 09 0A`.
    #[test]
    fn ten_output_bytes() {
        assert_eq!(
            io(&[1, 2, 3, 4, 5, 6, 7, 8, 9, 10]),
            [&[0x00, 1, 2, 3, 4, 5, 6, 7][..], &[0x81, 0x08, 0x09, 0x0A]]
        );
    }

    /// IAI controller capture, 5FD: a 32-byte output image in five fragments. Fragments 0, 3 and 4 are in the capture.
    #[test]
    fn a_32_byte_output_image() {
        let mut image = [0; 32];
        image[1] = 0x80;
        image[21..].copy_from_slice(&[0x00, 0x11, 0x02, 0x01, 0x00, 0x11, 0x02, 0x01, 0x00, 0x11, 0x02]);
        let fields = io(&image);
        assert_eq!(fields.len(), 5);
        assert_eq!(fields[0], [0x00, 0x00, 0x80, 0x00, 0x00, 0x00, 0x00, 0x00]);
        assert_eq!(fields[3], [0x43, 0x00, 0x11, 0x02, 0x01, 0x00, 0x11, 0x02]);
        assert_eq!(fields[4], [0x84, 0x01, 0x00, 0x11, 0x02]);
    }

    #[test]
    fn short_and_empty_messages() {
        assert_eq!(io(&[]), [&[][..]]);
        assert_eq!(io(&[9]), [[0x3F, 9]]);
        assert_eq!(io(&[0; 8]).len(), 2);
        let single = IoFragments::new(&[], EmptyMessage::FirstAndOnly).unwrap().next().unwrap();
        assert_eq!(single, [0x3F]);
    }

    #[test]
    fn the_count_of_an_io_message_never_wraps() {
        let fields = io(&[0; IO_MESSAGE_MAX]);
        assert_eq!((fields.len(), fields[63][0]), (64, 0xBF));
        assert_eq!(IoFragments::new(&[0; IO_MESSAGE_MAX + 1], EmptyMessage::NoData), None);
    }
}
