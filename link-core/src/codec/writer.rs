//! Bounded little-endian writing.

use super::Full;

/// Writes little-endian fields into a slice, never past its end. A field that does not fit is not written at all.
#[derive(Debug, PartialEq, Eq)]
pub struct Writer<'a> {
    buffer: &'a mut [u8],
    len: usize,
}

macro_rules! numbers {
    ($($number:ident)*) => {$(
        #[doc = concat!("Writes a little-endian `", stringify!($number), "`.")]
        pub fn $number(&mut self, value: $number) -> Result<(), Full> {
            self.bytes(&value.to_le_bytes())
        }
    )*};
}

impl<'a> Writer<'a> {
    /// A writer that starts at the front of `buffer`.
    pub const fn new(buffer: &'a mut [u8]) -> Self {
        Self { buffer, len: 0 }
    }

    /// The number of bytes written so far.
    pub const fn len(&self) -> usize {
        self.len
    }

    /// True if nothing was written yet.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The number of bytes for which there is room.
    pub const fn remaining(&self) -> usize {
        self.buffer.len().saturating_sub(self.len)
    }

    /// What was written so far.
    pub fn written(&self) -> &[u8] {
        self.buffer.get(..self.len).unwrap_or_default()
    }

    /// What was written, for as long as the buffer lives.
    pub fn into_written(self) -> &'a [u8] {
        self.buffer.get(..self.len).unwrap_or_default()
    }

    numbers!(u8 u16 u32 u64 i8 i16 i32 i64 f32 f64);

    /// Writes `bytes` as they are.
    pub fn bytes(&mut self, bytes: &[u8]) -> Result<(), Full> {
        let end = self.len.checked_add(bytes.len()).ok_or(Full)?;
        let room = self.buffer.get_mut(self.len..end).ok_or(Full)?;
        // Their lengths are equal, which a check would only ask once more.
        room.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
        self.len = end;
        Ok(())
    }

    /// Overwrites bytes written earlier, for a count that is known only at the end of its list.
    pub fn patch(&mut self, at: usize, bytes: &[u8]) -> Result<(), Full> {
        let end = at.checked_add(bytes.len()).filter(|&end| end <= self.len).ok_or(Full)?;
        self.buffer.get_mut(at..end).ok_or(Full)?.copy_from_slice(bytes);
        Ok(())
    }

    /// Takes back everything after the first `len` bytes, so that a failed message leaves no half of itself.
    pub fn truncate(&mut self, len: usize) {
        self.len = self.len.min(len);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_without_room_leaves_the_buffer_untouched() {
        let mut buffer = [0xA5; 3];
        let mut writer = Writer::new(&mut buffer);
        writer.u16(0x1234).unwrap();
        assert_eq!(writer.u16(0x5678), Err(Full));
        assert_eq!(writer.written(), [0x34, 0x12]);
        assert_eq!(writer.remaining(), 1);
        assert_eq!(buffer, [0x34, 0x12, 0xA5]);
    }

    #[test]
    fn a_patch_reaches_only_what_was_written() {
        let mut buffer = [0; 4];
        let mut writer = Writer::new(&mut buffer);
        writer.bytes(&[1, 2]).unwrap();
        assert_eq!(writer.patch(1, &[9, 9]), Err(Full));
        assert_eq!(writer.patch(0, &[7]), Ok(()));
        assert_eq!(writer.written(), [7, 2]);
        writer.truncate(1);
        assert_eq!(writer.into_written(), [7]);
    }
}
