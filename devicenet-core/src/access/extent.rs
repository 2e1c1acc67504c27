//! How much of network access is in a program.

use crate::counter;

/// What a node can do without. The compiler drops the code for what is `false`.
pub(crate) trait Extent {
    /// The offline connection set; without it, [`offline_set`](super::Config::offline_set) is off.
    const OFFLINE_SET: bool;
    /// Quick Connect; without it, [`quick_connect`](super::Config::quick_connect) is off.
    const QUICK_CONNECT: bool;
    /// Other choices than the defaults of [`Config`](super::Config).
    const CHOICES: bool;
    /// Events.
    const EVENTS: bool;
    /// [`Counters`](super::Counters).
    const COUNTERS: bool;

    /// One more.
    #[inline]
    fn count(counter: &mut u16) {
        if Self::COUNTERS {
            counter::count(counter);
        }
    }

    /// One more of what is frequent.
    #[inline]
    fn count_wide(counter: &mut u32) {
        if Self::COUNTERS {
            counter::count_wide(counter);
        }
    }
}

/// All of it.
pub(crate) enum Complete {}

impl Extent for Complete {
    const OFFLINE_SET: bool = true;
    const QUICK_CONNECT: bool = true;
    const CHOICES: bool = true;
    const EVENTS: bool = true;
    const COUNTERS: bool = true;
}
