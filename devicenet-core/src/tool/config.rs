//! The choices that a tool's user has.

use core::time::Duration;

use crate::access;

/// Who the tool is, and how long it waits.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// Its own place on the network.
    pub access: access::Config,
    /// For an ownership response, after each of two requests. Default 1 s.
    #[doc(alias = "offline.ownership_wait_ms")]
    pub ownership_wait: Duration,
    /// For answers to Who: nodes delay theirs by up to 2.55 s. Default 3 s.
    pub who_wait: Duration,
    /// For an answer to Identify. Default 1 s.
    pub identify_wait: Duration,
    /// For the first duplicate MAC ID check of a device that was given a MAC ID. Default 3 s.
    pub change_wait: Duration,
}

impl Config {
    /// The defaults.
    #[must_use]
    pub const fn new(access: access::Config) -> Self {
        Self {
            access,
            ownership_wait: Duration::from_millis(1000),
            who_wait: Duration::from_millis(3000),
            identify_wait: Duration::from_millis(1000),
            change_wait: Duration::from_millis(3000),
        }
    }
}
