//! The passive decoder: what every frame on the wire means.
//!
//! A [`Monitor`] is shown the frames of a network or of a capture, one after the other, and says of each what it is, who has
//! sent it, what it answers, and what is wrong with it. It keeps in mind:
//!
//! | What | From |
//! |---|---|
//! | state of each node, and the states before; whether one can lead to the next | PRes, IdentResponse, StatusResponse, NMT commands |
//! | identity, limits of process data | IdentResponse |
//! | PReqs without PRes, PRes that come late, how long a PRes takes | PReq, PRes, and what the managing node sends after |
//! | the cycle: intervals of SoCs, SoCs that did not come | SoC, by the time in it or the time of its capture |
//! | to whom the asynchronous slot is given, and who uses it | SoA, ASnd |
//! | the handshake of error signalling | ER in SoA, EC in StatusResponse |
//! | SDO: requests and their responses, transfers in several parts, frames that are missing | sequence and command layer |
//!
//! A capture can start in the middle: what only the frames before could tell is never a [`Problem`]. Frames need not be padded, and
//! may have their CRC at the end, as some analysers capture it. A frame of another protocol is [`Kind::Foreign`], and no problem
//! either. Of a frame that the capture has cut, what its beginning tells is followed: kind, nodes, state.
//!
//! Storage is fixed; what does not fit is counted in [`Lost`].
//!
//! # The words
//!
//! `Display` of a [`Reading`] is one line: sender, receiver, the message as its own `Display` has it; for SDO also the object.
//! A note follows in parentheses, and after ` ! ` the problem.
//!
//! ```
//! use link_core::Instant;
//! use powerlink_core::ethernet::{MAX_FRAME, group};
//! use powerlink_core::monitor::Monitor;
//! use powerlink_core::wire::*;
//! use powerlink_core::{MacAddress, NodeId};
//!
//! let mut monitor = Box::new(Monitor::new());
//! let mut show = |n, destination, node, to, from, body| {
//!     let mut buffer = [0; MAX_FRAME];
//!     let bytes = Frame { destination, source: MacAddress([2, 0, 0, 0, 0, node]), to, from, body }.emit(&mut buffer).unwrap();
//!     monitor.observe(Instant::from_millis(n), n, bytes.into()).to_string()
//! };
//! let poll = Body::Preq(Preq { flags: Flags::DATA_VALID, pdo_version: PdoVersion(0), data: &[0x0F] });
//! assert_eq!(
//!     show(1, MacAddress([2, 0, 0, 0, 0, 1]), 0xF0, NodeId(1), NodeId::MANAGING_NODE, poll),
//!     "MN -> 1  PReq, EA=0 RD=1, 1 byte"
//! );
//! let soc = Body::Soc(Soc::default());
//! assert_eq!(
//!     show(2, group::SOC, 0xF0, NodeId::BROADCAST, NodeId::MANAGING_NODE, soc),
//!     "MN -> all  SoC, net time 0.000000000, relative 0 us  ! no PRes of node 1 to the PReq before"
//! );
//! ```

mod cycle;
mod envelope;
#[cfg(feature = "serde")]
mod json;
mod kind;
mod nodes;
mod problem;
mod reading;
mod sdo;
mod slot;
#[cfg(test)]
mod tests;
mod text;

pub use link_core::recording::Answered;

pub use cycle::Cycle;
pub use envelope::Envelope;
#[cfg(feature = "serde")]
pub use json::IdentityFields;
pub use kind::Kind;
pub use nodes::{MAX_HISTORY, NodeRecord, StateChange};
pub use problem::Problem;
pub use reading::{Captured, Message, Note, Reading};
pub use text::Words;

use link_core::Instant;

use crate::NodeId;
use crate::wire::{Body, FeatureFlags, Flags, NmtStateCode};
use sdo::Connections;
use slot::Slot;

/// A monitor for a whole network: 32 SDO transfers in several parts at a time, of up to 4096 bytes. About 320 kilobytes.
pub type Monitor = SizedMonitor<32, 4096>;

/// The passive decoder. `N` is the number of SDO transfers in several parts at a time whose data are put together, `B` the longest of
/// them, in bytes. [`Monitor`] has sizes for a computer.
///
/// [`observe`](Self::observe) takes bounded time: it looks at the two nodes of a frame, and for SDO at 256 connections, as many as are
/// followed at a time; an NMT command to all looks at all nodes.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct SizedMonitor<const N: usize, const B: usize> {
    /// By node ID.
    nodes: [NodeRecord; NODES],
    cycle: Cycle,
    /// When the last frame came.
    last: Option<Instant>,
    /// Whose PRes is awaited.
    polled: Option<NodeId>,
    slot: Slot,
    connections: Connections<N, B>,
}

/// What did not fit into the storage of a monitor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Lost {
    /// SDO connections that were given up for others.
    pub connections: u64,
    /// SDO transfers whose data were longer than the storage, or for which there were too many at a time.
    pub transfers: u64,
}

impl<const N: usize, const B: usize> SizedMonitor<N, B> {
    /// A monitor that has seen nothing.
    #[must_use]
    pub const fn new() -> Self {
        let mut nodes = [const { NodeRecord::new(NodeId::NONE) }; NODES];
        let mut rest: &mut [NodeRecord] = &mut nodes;
        let mut id: u8 = 0;
        while let Some((first, others)) = rest.split_first_mut() {
            first.node = NodeId(id);
            id = id.wrapping_add(1);
            rest = others;
        }
        Self {
            nodes,
            cycle: Cycle::new(),
            last: None,
            polled: None,
            slot: Slot::Unknown,
            connections: Connections::new(),
        }
    }

    /// Reads frame number `n`, which was on the wire at `at`.
    pub fn observe<'a>(&'a mut self, at: Instant, n: u64, frame: Captured<'a>) -> Reading<'a> {
        let mut reading = Reading::parse(at, n, frame);
        let before = self.last.replace(at).unwrap_or(at);
        if let Some(by) = before.checked_since(at).filter(|by| !by.is_zero()) {
            reading.note.get_or_insert(Note::ClockBack { by });
        }
        if let (Some(envelope), Some(from), Some(to)) = (reading.envelope, reading.src, reading.dst)
            && reading.kind != Kind::Invalid
        {
            reading.check_envelope(&envelope, from);
            if let Some(node) = self.nodes.get_mut(usize::from(from.0)) {
                node.heard(&mut reading, envelope.source);
            }
            reading.message = self.learn(&mut reading, from, to);
        }
        reading
    }

    /// What is known of every node that was heard or polled, by node ID.
    pub fn nodes(&self) -> impl Iterator<Item = &NodeRecord> {
        self.nodes.iter().filter(|node| node.is_known())
    }

    /// What is known of a node, if it was heard or polled.
    #[must_use]
    pub fn node(&self, node: NodeId) -> Option<&NodeRecord> {
        self.nodes.get(usize::from(node.0)).filter(|node| node.is_known())
    }

    /// The cycle.
    #[must_use]
    pub const fn cycle(&self) -> &Cycle {
        &self.cycle
    }

    /// What did not fit into the storage so far.
    #[must_use]
    pub const fn lost(&self) -> Lost {
        Lost { connections: self.connections.evicted, transfers: self.connections.not_stored }
    }
}

impl<const N: usize, const B: usize> Default for SizedMonitor<N, B> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize, const B: usize> SizedMonitor<N, B> {
    fn learn(&mut self, reading: &mut Reading<'_>, from: NodeId, to: NodeId) -> Option<Message<'_>> {
        if reading.kind.is_of_managing_node() || (reading.kind == Kind::Pres && from == NodeId::MANAGING_NODE)
        {
            self.go_on(reading);
        }
        if matches!(reading.kind, Kind::Soc | Kind::Soa) {
            self.end_slot(reading);
        }
        let invitation = if reading.kind.is_asynchronous() { self.use_slot(reading, from) } else { None };
        let state = reading.state();
        match &reading.body {
            Some(Body::Soc(soc)) => {
                let soc = *soc;
                self.slot.close();
                self.cycle.observe(reading, &soc);
            }
            Some(Body::Preq(preq)) => {
                let size = preq.data.len();
                self.polled = Some(to);
                self.node_mut(to)?.polled(reading, Some(size));
            }
            Some(Body::Pres(pres)) => {
                let pres = *pres;
                let node = self.node_mut(from)?;
                node.responded(reading);
                node.check_pres(reading, &pres);
            }
            Some(Body::Soa(soa)) => {
                let soa = *soa;
                self.slot.open(reading, &soa);
                if soa.state == NmtStateCode::PRE_OPERATIONAL_1 {
                    self.cycle.pause();
                }
            }
            Some(Body::IdentResponse(ident)) => {
                let ident = *ident;
                self.node_mut(from)?.ident = Some(ident);
            }
            Some(Body::StatusResponse(status)) => {
                let clear = status.flags.contains(Flags::EXCEPTION_CLEAR);
                if let Some(invitation) = invitation {
                    self.node_mut(from)?.shook_hands(reading, invitation.reset, clear);
                }
            }
            Some(Body::NmtCommand(command)) => {
                for node in self.nodes.iter_mut().filter(|node| to == node.node || to == NodeId::BROADCAST) {
                    node.commanded(command);
                }
            }
            Some(Body::Sdo(sdo)) => {
                let sdo = *sdo;
                return self.connections.observe(reading, (from, to), &sdo);
            }
            Some(Body::NmtRequest(_) | Body::OtherAsnd(..) | Body::Other(..)) => {}
            None => self.learn_cut(reading, from, to)?,
        }
        if let Some(state) = state {
            self.node_mut(from)?.in_state(reading, state);
        }
        None
    }

    /// What a frame tells whose content was not captured, or is too short: that it was sent.
    fn learn_cut(&mut self, reading: &mut Reading<'_>, from: NodeId, to: NodeId) -> Option<()> {
        match reading.kind {
            Kind::Soc => {
                self.slot.close();
                self.cycle.count_cut();
            }
            Kind::Preq => {
                self.polled = Some(to);
                self.node_mut(to)?.polled(reading, None);
            }
            Kind::Pres => self.node_mut(from)?.responded(reading),
            Kind::Soa => self.slot = Slot::Unknown,
            Kind::AsndSdo => self.connections.forget(from, to),
            Kind::AsndIdentResponse
            | Kind::AsndStatusResponse
            | Kind::AsndNmtRequest
            | Kind::AsndNmtCommand
            | Kind::AsndOther
            | Kind::Amni
            | Kind::Ainv
            | Kind::Reserved
            | Kind::Foreign
            | Kind::Invalid => {}
        }
        Some(())
    }

    /// The managing node sends the next frame, whether or not the node that it polled has answered.
    fn go_on(&mut self, reading: &mut Reading<'_>) {
        let Some(node) = self.polled.take() else { return };
        if self.node_mut(node).is_some_and(NodeRecord::is_missed) {
            reading.flag(Problem::PresMissing { node });
        }
    }

    /// Whoever was asked had until now.
    fn end_slot(&mut self, reading: &mut Reading<'_>) {
        let Some((node, service)) = self.slot.unanswered() else { return };
        if let Some(record) = self.node_mut(node).filter(|record| record.is_present()) {
            record.answers_missing = record.answers_missing.saturating_add(1);
            reading.flag(Problem::AnswerMissing { node, service });
        }
    }

    fn use_slot(&mut self, reading: &mut Reading<'_>, from: NodeId) -> Option<slot::Invitation> {
        let node = self.nodes.get(usize::from(from.0))?;
        // Nobody invites where there is no managing node.
        if node.state == Some(NmtStateCode::BASIC_ETHERNET) {
            return None;
        }
        let features = node.ident.map_or(FeatureFlags::empty(), |ident| ident.features);
        self.slot.used(reading, from, features.contains(FeatureFlags::MULTIPLE_ASND))
    }

    fn node_mut(&mut self, node: NodeId) -> Option<&mut NodeRecord> {
        self.nodes.get_mut(usize::from(node.0))
    }
}

/// One for each node ID.
const NODES: usize = 256;
