//! Rules that every run is checked against.

use std::fmt;

use link_core::{Frame, Id, Instant, StandardId};

use crate::bus::SenderOutcome;
use crate::network::NodeId;
use crate::record::{FrameRecord, Record};

/// A rule was broken.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Violation {
    /// By which node.
    pub node: NodeId,
    /// When, on the clock of the network.
    pub at: Instant,
    /// Which rule, in words.
    pub rule: &'static str,
    /// What happened.
    pub what: String,
}

/// `0.001 node 3: one identifier, two producers: 40A [2] 01 02, before by node 1`
impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}: {}: {}", self.at, self.node, self.rule, self.what)
    }
}

/// A rule that a caller adds, for example "no frame before its wait is over".
pub trait Rule<E> {
    /// Sees a record, and reports what is wrong with it.
    fn see(&mut self, record: &Record<'_, E>, report: &mut dyn FnMut(Violation));
}

/// The last producer of each 11-bit identifier on each segment, which is a network of its own.
#[derive(Clone, Debug)]
pub(crate) struct Producers {
    by_id: Vec<Option<(NodeId, Frame)>>,
    shared: fn(StandardId) -> bool,
}

impl Producers {
    pub(crate) fn new(shared: fn(StandardId) -> bool) -> Self {
        Self { by_id: vec![None; IDENTIFIERS], shared }
    }

    /// A node is gone, so another may take its place.
    pub(crate) fn forget(&mut self, node: NodeId) {
        self.by_id
            .iter_mut()
            .filter(|last| last.is_some_and(|(who, _)| who == node))
            .for_each(|last| *last = None);
    }

    /// The segments have become one.
    pub(crate) fn join(&mut self) {
        self.by_id.truncate(IDENTIFIERS);
    }

    pub(crate) fn see(&mut self, record: &FrameRecord<'_>, report: &mut dyn FnMut(Violation)) {
        for sender in record.senders {
            if matches!(sender.outcome, SenderOutcome::LostArbitration { .. }) {
                continue;
            }
            let Id::Standard(id) = sender.frame.id() else { continue };
            let place = record.segment * IDENTIFIERS + usize::from(id.as_raw());
            if place >= self.by_id.len() {
                self.by_id.resize((record.segment + 1) * IDENTIFIERS, None);
            }
            let Some(last) = self.by_id.get_mut(place) else { continue };
            let (node, frame) = (sender.node, sender.frame);
            if let Some((other, before)) = last.replace((node, frame))
                && other != node
                && before != frame
                && !frame.is_remote()
                && !before.is_remote()
                && !(self.shared)(id)
            {
                report(Violation {
                    node,
                    at: record.start,
                    rule: ONE_PRODUCER,
                    what: format!("{frame}, before by {other}: {before}"),
                });
            }
        }
    }
}

/// How many 11-bit identifiers there are.
const IDENTIFIERS: usize = 0x800;

/// Two nodes produced one identifier with different data.
pub const ONE_PRODUCER: &str = "one identifier, two producers";
/// A machine wants to send while its controller only listens.
pub const LISTEN_ONLY: &str = "transmits while listen-only";
/// A machine wants to send while it has no link.
pub const LINK_DOWN: &str = "transmits while the link is down";
/// A machine wants to send while it is bus-off.
pub const BUS_OFF: &str = "transmits while bus-off";
/// A machine has more frames in flight than it said.
pub const IN_FLIGHT: &str = "more frames in flight than max_in_flight";
/// A machine uses a token that is not answered yet.
pub const TOKEN_REUSED: &str = "token used again while in flight";
/// A machine's deadline stays in the past, or its output never ends.
pub const STUCK: &str = "stuck";
