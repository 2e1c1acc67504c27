//! What the doctor takes for healthy.

use core::time::Duration;

use link_core::BitRate;

use crate::id::MacId;
use crate::master::ElectronicKey;

/// Thresholds. The defaults suit most networks; `docs/decisions.md` says where they come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct DoctorConfig {
    /// The bit rate, from which the bus load is computed; `None`: the load is not judged.
    pub bit_rate: Option<BitRate>,
    /// The bus load that is too much, in percent: 70.
    pub load_percent: u8,
    /// The window over which it is computed: 1 s.
    pub load_window: Duration,
    /// How much of the time after which its peer gives up (expected packet rate x 4) an answer may take, in percent: 70.
    pub slow_percent: u8,
    /// How long a node may leave commands unanswered whose expected packet rate is not known or 0: 1 s.
    pub unknown_patience: Duration,
    /// So many errors on the bus in [`error_window`](Self::error_window) are too many: 10. Ten times as many are an error.
    pub error_frames: u32,
    /// 10 s.
    pub error_window: Duration,
    /// A fault that a node reports again so long after the first time is one that it is stuck in: 10 s.
    pub stuck_after: Duration,
    /// What only happens, such as a refusal or a foreign frame, is over when it has not happened for so long: 60 s.
    pub quiet_after: Duration,
    /// Whether nodes and allocations that do not belong here are told.
    pub intrusion: Intrusion,
}

impl Default for DoctorConfig {
    fn default() -> Self {
        Self {
            bit_rate: None,
            load_percent: 70,
            load_window: Duration::from_secs(1),
            slow_percent: 70,
            unknown_patience: Duration::from_secs(1),
            error_frames: 10,
            error_window: Duration::from_secs(10),
            stuck_after: Duration::from_secs(10),
            quiet_after: Duration::from_secs(60),
            intrusion: Intrusion::Allowed,
        }
    }
}

/// Which nodes belong to the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Intrusion {
    /// All.
    #[default]
    Allowed,
    /// Those that the doctor was told to [expect](super::SizedDoctor::expect).
    Expected,
    /// Those, and what is heard in so long from the first frame on.
    Learned(Duration),
}

/// What is known beforehand of a node, from a scan list, an Electronic Data Sheet or a type plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct ExpectedNode {
    /// What its identity must be.
    pub key: ElectronicKey,
    /// Its serial number, if only that one device will do.
    pub serial: Option<u32>,
    /// Its master.
    pub master: Option<MacId>,
}
