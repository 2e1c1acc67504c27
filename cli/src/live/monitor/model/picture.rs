//! What there is to show at a moment: plain data, which every view draws from.

use core::time::Duration;

use devicenet_core::MacId;
use devicenet_core::doctor::Finding;
use devicenet_core::monitor::{ConnectionRecord, ConnectionState, NodeRecord};
use link_core::Instant;

use super::link::LinkState;
use super::load::Load;
use super::problems::Problems;
use super::purpose::Purpose;
use super::times::Times;
use crate::bus_rate::BusRate;
use crate::verdict::Verdict;

/// A bus at a moment.
#[derive(Clone, Debug)]
pub(in crate::live::monitor) struct Picture {
    pub(in crate::live::monitor) begin: Instant,
    /// Since then.
    pub(in crate::live::monitor) at: Duration,
    pub(in crate::live::monitor) bit_rate: BusRate,
    pub(in crate::live::monitor) link: LinkState,
    pub(in crate::live::monitor) counters: Counters,
    pub(in crate::live::monitor) verdict: Verdict,
    pub(in crate::live::monitor) problems: Problems,
    /// The span that `load` is a part of.
    pub(in crate::live::monitor) span: Duration,
    pub(in crate::live::monitor) load: Load,
    /// Since the beginning.
    pub(in crate::live::monitor) total: Load,
    /// A value a second, the oldest first.
    pub(in crate::live::monitor) history: Vec<[f64; Purpose::COUNT]>,
    /// In the order of their MAC IDs.
    pub(in crate::live::monitor) nodes: Vec<NodePicture>,
    /// The oldest first.
    pub(in crate::live::monitor) findings: Vec<FindingPicture>,
}

/// Something that is or was wrong. Times are since the beginning.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(in crate::live::monitor) struct FindingPicture {
    pub(in crate::live::monitor) finding: Finding,
    pub(in crate::live::monitor) since: Duration,
    /// When it was over; `None` as long as it lasts.
    pub(in crate::live::monitor) until: Option<Duration>,
}

impl FindingPicture {
    pub(super) fn new(finding: &Finding, begin: Instant) -> Self {
        let since_begin = |at: Instant| at.saturating_since(begin);
        Self { finding: *finding, since: since_begin(finding.since), until: finding.until.map(since_begin) }
    }

    pub(in crate::live::monitor) const fn is_over(&self) -> bool {
        self.until.is_some()
    }
}

/// Counters since the beginning.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(in crate::live::monitor) struct Counters {
    pub(in crate::live::monitor) frames: u64,
    pub(in crate::live::monitor) error_frames: u64,
    /// Frames that were received, and lost before they were read.
    pub(in crate::live::monitor) lost: u64,
    /// Frames that are wrong or suspicious.
    pub(in crate::live::monitor) problems: u64,
    /// Lines or records of a recording that could not be read.
    pub(in crate::live::monitor) unread: u64,
    /// Error counters of the interface, where it tells them.
    pub(in crate::live::monitor) tec: Option<u16>,
    pub(in crate::live::monitor) rec: Option<u16>,
}

impl Counters {
    /// What a recording of it would have entries of.
    pub(super) const fn entries(&self) -> u64 {
        self.frames + self.error_frames
    }
}

/// A node.
#[derive(Clone, Debug)]
pub(in crate::live::monitor) struct NodePicture {
    pub(in crate::live::monitor) record: NodeRecord,
    /// In the order of their instances, then those made by UCMM and Create.
    pub(in crate::live::monitor) connections: Vec<ConnectionRecord>,
    /// The part of the bus that its frames take, now and since the beginning, 0 to 1.
    pub(in crate::live::monitor) load: f64,
    pub(in crate::live::monitor) total: f64,
    /// How fast it answers I/O commands.
    pub(in crate::live::monitor) io: Option<Times>,
    /// How fast it answers explicit requests.
    pub(in crate::live::monitor) explicit: Option<Times>,
    /// The shortest time-out of its I/O connections that answer commands, as a rule four times the expected packet rate: the
    /// time in which a response must come.
    pub(in crate::live::monitor) limit: Option<Duration>,
    /// Since it was last heard.
    pub(in crate::live::monitor) silent: Option<Duration>,
}

impl NodePicture {
    pub(in crate::live::monitor) const fn mac(&self) -> MacId {
        self.record.mac
    }

    /// The connections that exist.
    pub(in crate::live::monitor) fn live_connections(&self) -> impl Iterator<Item = &ConnectionRecord> {
        let is_live = |state| !matches!(state, ConnectionState::NonExistent);
        self.connections.iter().filter(move |connection| is_live(connection.state))
    }

    /// The part of the limit that its slowest I/O response took, 0 to 1 and more.
    pub(in crate::live::monitor) fn worst(&self) -> Option<f64> {
        Some(self.io?.max.as_secs_f64() / self.limit?.as_secs_f64())
    }
}
