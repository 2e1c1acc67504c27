//! A piece of a message.

/// Where a value stands in its message: so that a reading of a message need not borrow it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Span {
    start: u16,
    len: u16,
}

impl Span {
    /// The last `len` of `total` bytes; `None` if there are none.
    #[must_use]
    pub fn tail(total: usize, len: usize) -> Option<Self> {
        let start = u16::try_from(total.saturating_sub(len)).ok()?;
        let len = u16::try_from(len).ok().filter(|&len| len != 0)?;
        Some(Self { start, len })
    }

    /// The piece of the message.
    #[must_use]
    pub fn of(self, data: &[u8]) -> &[u8] {
        let (start, len) = (usize::from(self.start), usize::from(self.len));
        data.get(start..).and_then(|rest| rest.get(..len)).unwrap_or_default()
    }
}
