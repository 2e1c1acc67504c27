//! A network of a scenario that is driven by hand, and what was seen of it.

use core::time::Duration;
use std::path::Path;

use link_core::{BitRate, Frame, Instant};
use transport_mock::bus::SenderOutcome;
use transport_mock::record::Outcome;
use transport_mock::{ErrorState, Network, NodeId, Record};

use super::Plan;
use crate::scenario::Scenario;
use crate::simulate::{self, NodeEvent};

/// The network, and its past.
pub(super) struct Bench {
    pub(super) network: Network<NodeEvent>,
    /// Every frame that was sent to its end.
    pub(super) sent: Vec<Sent>,
    /// When attempts to send ended in an error.
    pub(super) errors: Vec<Instant>,
    /// What the nodes told.
    pub(super) told: Vec<(Instant, NodeId, NodeEvent)>,
    names: Vec<String>,
    bit_rate: BitRate,
}

/// A frame that was sent to its end.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Sent {
    pub(super) start: Instant,
    pub(super) end: Instant,
    pub(super) by: NodeId,
    pub(super) frame: Frame,
}

/// Frames, and the time that they take on the wire, each with the intermission after it.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Traffic {
    pub(super) frames: usize,
    pub(super) wire: Duration,
}

impl Traffic {
    pub(super) fn and(self, other: Self) -> Self {
        Self { frames: self.frames + other.frames, wire: self.wire + other.wire }
    }
}

impl Bench {
    /// The bus of the plan with these nodes.
    #[expect(clippy::panic, reason = "the scenarios of a comparison are its own")]
    pub(super) fn new(plan: &Plan, nodes: &str) -> Self {
        let text = plan.bus() + nodes;
        let mut scenario = Scenario::parse("comparison", &text, Path::new(""))
            .unwrap_or_else(|error| panic!("{error}\n{text}"));
        // A number of TOML has not room for every seed.
        scenario.bus.seed = plan.seed;
        Self {
            network: simulate::network(&scenario),
            sent: Vec::new(),
            errors: Vec::new(),
            told: Vec::new(),
            names: scenario.nodes.iter().map(|node| node.name.clone()).collect(),
            bit_rate: scenario.bus.bit_rate,
        }
    }

    /// Runs on to a moment, and keeps what is seen.
    pub(super) fn run_to(&mut self, to: Instant) {
        let Self { network, sent, errors, told, .. } = self;
        network.run_until(to, &mut |record: &Record<'_, NodeEvent>| match record {
            Record::Frame(attempt) if attempt.outcome == Outcome::Ok => {
                let is_sender = |outcome| matches!(outcome, SenderOutcome::Sent);
                let by = attempt.senders.iter().find(|sender| is_sender(sender.outcome));
                sent.extend(by.map(|sender| Sent {
                    start: attempt.start,
                    end: attempt.end,
                    by: sender.node,
                    frame: *attempt.frame,
                }));
            }
            Record::Frame(attempt) => errors.push(attempt.end),
            Record::Event { at, node, event } => told.push((*at, *node, (*event).clone())),
            _ => {}
        });
    }

    /// Runs on until something is so, and looks now and then; whether it has become so in time.
    pub(super) fn run_until(&mut self, at_most: Instant, is_so: impl Fn(&Self) -> bool) -> bool {
        while !is_so(self) {
            if self.network.now() >= at_most {
                return false;
            }
            self.run_to((self.network.now() + LOOK).min(at_most));
        }
        true
    }

    /// The node of that name.
    #[expect(clippy::expect_used, reason = "the scenarios of a comparison are its own")]
    pub(super) fn node(&self, name: &str) -> NodeId {
        let place = self.names.iter().position(|own| own == name);
        self.network.nodes().nth(place.expect("a name of the scenario")).expect("its node")
    }

    /// The nodes whose names begin so.
    pub(super) fn nodes(&self, prefix: &str) -> Vec<NodeId> {
        let is_one = |place: &(NodeId, &String)| place.1.starts_with(prefix);
        self.network.nodes().zip(&self.names).filter(is_one).map(|(node, _)| node).collect()
    }

    /// Which of them are bus-off.
    pub(super) fn bus_off(&self, nodes: &[NodeId]) -> usize {
        let is_off = |node: &&NodeId| self.network.error_state(**node) == Some(ErrorState::BusOff);
        nodes.iter().filter(is_off).count()
    }

    /// When a node first told something from a moment on.
    pub(super) fn first_told(
        &self,
        from: Instant,
        node: NodeId,
        is_it: impl Fn(&NodeEvent) -> bool,
    ) -> Option<Instant> {
        let told = self.told.iter().find(|(at, by, event)| *at >= from && *by == node && is_it(event));
        told.map(|(at, ..)| *at)
    }

    /// What some of the frames come to.
    pub(super) fn traffic<'a>(&self, frames: impl Iterator<Item = &'a Sent>) -> Traffic {
        let bit = Duration::from_nanos(self.bit_rate.bit_time_nanos().unwrap_or(0));
        let add = |sum: Traffic, sent: &Sent| Traffic {
            frames: sum.frames + 1,
            wire: sum.wire + bit * (sent.frame.bit_len() + INTERMISSION),
        };
        frames.fold(Traffic::default(), add)
    }
}

/// Between two looks at a network that runs.
const LOOK: Duration = Duration::from_millis(20);
/// Bits between two frames.
const INTERMISSION: u32 = 3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_seed_can_be_had() {
        let plan = Plan { bit_rate: BitRate::K500, devices: 3, seed: u64::MAX };
        assert!(Bench::new(&plan, "").sent.is_empty());
    }
}
