//! What there is to show at a moment: plain data, which every view draws from.

use core::time::Duration;

use devicenet_core::MacId;
use devicenet_core::doctor::Finding;
use devicenet_core::monitor::{ConnectionName, ConnectionRecord, ConnectionState, NodeRecord, Predefined};
use link_core::Instant;

use super::link::LinkState;
use super::load::{Load, Tally};
use super::problems::Problems;
use super::purpose::Purpose;
use super::times::Times;
use super::{Model, index};
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

impl Model {
    /// What there is to show, with the load of the last second.
    pub(in crate::live::monitor) fn picture(&self) -> Picture {
        let begin = self.begin.unwrap_or(self.now);
        let load = self.window.load(begin, self.now);
        self.picture_with(load, self.now.saturating_since(begin).min(Duration::from_secs(1)))
    }

    /// What there is to report, with the load since the last report.
    pub(in crate::live::monitor) fn report(&mut self) -> Picture {
        let span = self.now.saturating_since(self.interval_began);
        let picture = self.picture_with(self.interval.load(span), span);
        self.interval = Tally::default();
        self.interval_began = self.now;
        picture
    }

    fn picture_with(&self, load: Load, span: Duration) -> Picture {
        let begin = self.begin.unwrap_or(self.now);
        let elapsed = self.now.saturating_since(begin);
        let total = self.total.load(elapsed);
        let mut nodes: Vec<NodePicture> =
            self.monitor.nodes_at(self.now).map(|record| self.node(record, &load, &total)).collect();
        for connection in self.monitor.connections() {
            if let Ok(at) = nodes.binary_search_by_key(&connection.server, NodePicture::mac) {
                nodes[at].connections.push(connection);
            }
        }
        nodes.iter_mut().for_each(|node| node.limit = limit(&node.connections));
        Picture {
            begin,
            at: elapsed,
            bit_rate: self.bit_rate,
            link: self.link,
            counters: self.counters,
            verdict: self.verdict(),
            problems: self.problems.clone(),
            span,
            load,
            total,
            history: self.history.shares(),
            nodes,
            findings: self.doctor.findings().map(|finding| FindingPicture::new(finding, begin)).collect(),
        }
    }

    fn node(&self, record: NodeRecord, load: &Load, total: &Load) -> NodePicture {
        let mac = index(record.mac);
        NodePicture {
            connections: Vec::new(),
            load: load.by_node[mac],
            total: total.by_node[mac],
            io: Times::of(&self.responses[mac].io),
            explicit: Times::of(&self.responses[mac].explicit),
            limit: None,
            silent: record.traffic.last_seen().map(|last| self.now.saturating_since(last)),
            record,
        }
    }
}

/// See [`NodePicture::limit`].
fn limit(connections: &[ConnectionRecord]) -> Option<Duration> {
    let answers = |connection: &&ConnectionRecord| {
        let is_answering = match connection.name {
            ConnectionName::Predefined(
                Predefined::Poll | Predefined::BitStrobe | Predefined::MulticastPoll,
            ) => true,
            ConnectionName::Predefined(Predefined::Explicit | Predefined::CosCyclic)
            | ConnectionName::Dynamic { .. } => false,
        };
        is_answering && connection.state != ConnectionState::NonExistent
    };
    connections.iter().filter(answers).filter_map(|connection| connection.time_out).min()
}

#[cfg(test)]
mod tests {
    use link_core::frame::standard_id;
    use link_core::{Frame, Input};

    use super::*;
    use crate::health;

    /// Polled and bit-strobed slave 10: what of its connections is set, and how long its responses may take after that.
    #[test]
    fn the_limit_is_the_shortest_time_out_of_a_connection_that_answers() {
        let mut model = Model::new(None, health::doctor(None, None, None));
        let mut set = |instance: u8, attribute: u8, value: &[u8]| {
            let request = [&[1, 0x10, 5, instance, attribute], value].concat();
            let frames: [(u16, &[u8]); 2] = [(0x454, &request), (0x453, &[&[1, 0x90], value].concat())];
            for (id, data) in frames {
                model.see(
                    Instant::ZERO,
                    None,
                    Input::Frame(Frame::new(standard_id(id), data).unwrap()),
                    |_| {},
                );
            }
            let limit = model.picture().nodes.iter().find(|node| node.mac().number() == 10)?.limit;
            limit.map(|limit| limit.as_millis())
        };
        const RATE: u8 = 9;
        const MULTIPLIER: u8 = 18;
        assert_eq!(set(1, RATE, &[10, 0]), None, "the explicit connection has no part in it");
        assert_eq!(set(2, RATE, &[100, 0]), Some(400));
        assert_eq!(set(2, MULTIPLIER, &[2]), Some(1_600));
        assert_eq!(set(3, RATE, &[200, 0]), Some(800));
        assert_eq!(set(3, RATE, &[0, 0]), Some(1_600), "without a rate its peers wait for ever");
        assert_eq!(set(2, RATE, &[0, 0]), None);
    }
}
