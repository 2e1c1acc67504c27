//! Errors on the bus, by kind.

use core::fmt;

use link_core::BusErrorKind;

/// How many errors of each kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct ErrorCounts([u32; ErrorCounts::KINDS]);

impl ErrorCounts {
    /// So many kinds there are.
    pub(super) const KINDS: usize = KINDS.len();

    /// By [`index`].
    pub(super) const fn new(counts: [u32; Self::KINDS]) -> Self {
        Self(counts)
    }

    /// Those of a kind.
    #[must_use]
    pub fn of(&self, kind: BusErrorKind) -> u32 {
        self.0.get(index(kind)).copied().unwrap_or_default()
    }

    /// All of them.
    #[must_use]
    pub fn total(&self) -> u32 {
        self.0.iter().fold(0, |sum, &count| sum.saturating_add(count))
    }

    /// The kinds that there are, the most frequent first.
    pub fn iter(&self) -> impl Iterator<Item = (BusErrorKind, u32)> {
        let mut counts = KINDS.map(|kind| (kind, self.of(kind)));
        counts.sort_unstable_by_key(|&(kind, count)| (core::cmp::Reverse(count), kind));
        counts.into_iter().filter(|(_, count)| *count > 0)
    }
}

/// `10 form errors, 2 stuff errors`.
impl fmt::Display for ErrorCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, (kind, count)) in self.iter().enumerate() {
            let separator = if place == 0 { "" } else { ", " };
            let plural = if count == 1 { "" } else { "s" };
            write!(f, "{separator}{count} {kind}{plural}")?;
        }
        Ok(())
    }
}

/// An object with one entry for each kind that there is: `{"form":10,"stuff":2}`.
#[cfg(feature = "serde")]
impl serde::Serialize for ErrorCounts {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.iter())
    }
}

/// The place of a kind.
pub(super) const fn index(kind: BusErrorKind) -> usize {
    match kind {
        BusErrorKind::Bit => 0,
        BusErrorKind::Stuff => 1,
        BusErrorKind::Crc => 2,
        BusErrorKind::Form => 3,
        BusErrorKind::Ack => 4,
        BusErrorKind::Other => 5,
    }
}

/// In the order of [`index`].
const KINDS: [BusErrorKind; 6] = [
    BusErrorKind::Bit,
    BusErrorKind::Stuff,
    BusErrorKind::Crc,
    BusErrorKind::Form,
    BusErrorKind::Ack,
    BusErrorKind::Other,
];
