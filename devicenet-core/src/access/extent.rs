//! How much of network access is in a program.

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
}

/// All of it.
pub(crate) enum Complete {}

impl Extent for Complete {
    const OFFLINE_SET: bool = true;
    const QUICK_CONNECT: bool = true;
    const CHOICES: bool = true;
    const EVENTS: bool = true;
}
