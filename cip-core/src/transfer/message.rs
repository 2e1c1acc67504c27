use core::hash::{Hash, Hasher};

/// The bytes of an explicit message, from the service byte on. What earlier ones have left behind its end is no part of it.
#[derive(Clone, Debug)]
pub struct Message<const N: usize> {
    /// The room for it.
    pub bytes: [u8; N],
    len: u16,
}

impl<const N: usize> Message<N> {
    /// No bytes.
    pub const EMPTY: Self = Self { bytes: [0; N], len: 0 };

    /// The message.
    // Called from many places: in a small device a copy for each is too much.
    #[inline(never)]
    pub fn body(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or_default()
    }

    /// How many of the [`bytes`](Self::bytes) are the message: less than 64 Ki.
    #[inline]
    pub fn set_len(&mut self, len: usize) {
        self.len = u16::try_from(len).unwrap_or(u16::MAX);
    }

    /// How long it is.
    #[inline]
    pub const fn len(&self) -> u16 {
        self.len
    }

    /// Whether there is none.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }
}

impl<const N: usize> PartialEq for Message<N> {
    fn eq(&self, other: &Self) -> bool {
        self.body() == other.body()
    }
}

impl<const N: usize> Eq for Message<N> {}

impl<const N: usize> Hash for Message<N> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.body().hash(state);
    }
}
