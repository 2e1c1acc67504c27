//! Objects of the nodes are written and read: the configuration, and what the application asks for.

use super::config::{ADDRESS, MOST_MAPPED, NodePlan};
use super::error::MnError;
use super::event::MnEvent;
use super::machine::{ManagingNode, Timer};
use super::state::{NodeCause, NodePhase};
use crate::NodeId;
use crate::dictionary::ObjectAddress;
use crate::sdo::Progress;
use crate::wire::{AbortCode, COMMAND_HEADER, ErrorCode};

/// What the application asks for, and what came of it.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Application<const SDO: usize> {
    request: Option<Request>,
    buffer: [u8; SDO],
    len: usize,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
struct Request {
    node: NodeId,
    at: ObjectAddress,
    is_write: bool,
}

/// A value to be written.
#[derive(Clone, Copy)]
enum Value<'p> {
    Bytes(&'p [u8]),
    Number([u8; 8], usize),
}

impl<const SDO: usize> Application<SDO> {
    pub(super) const fn new() -> Self {
        Self { request: None, buffer: [0; SDO], len: 0 }
    }

    fn data(&self) -> &[u8] {
        self.buffer.get(..self.len).unwrap_or_default()
    }

    fn set(&mut self, data: &[u8]) {
        if let Some(place) = self.buffer.get_mut(..data.len()) {
            place.copy_from_slice(data);
            self.len = data.len();
        }
    }
}

impl<'p, const N: usize, const DATA: usize, const SDO: usize> ManagingNode<'p, N, DATA, SDO> {
    /// Reads an object of a node: [`MnEvent::ObjectRead`] or [`MnEvent::SdoFailed`] tells the end.
    ///
    /// # Errors
    /// [`MnError`] if another transfer is under way, or the node did not answer yet.
    pub fn sdo_read(&mut self, node: NodeId, at: ObjectAddress) -> Result<(), MnError> {
        self.may_transfer(node)?;
        self.application.request = Some(Request { node, at, is_write: false });
        Ok(())
    }

    /// Writes an object of a node: [`MnEvent::ObjectWritten`] or [`MnEvent::SdoFailed`] tells the end.
    ///
    /// # Errors
    /// [`MnError`] if another transfer is under way, the node did not answer yet, or the value is too long.
    pub fn sdo_write(&mut self, node: NodeId, at: ObjectAddress, value: &[u8]) -> Result<(), MnError> {
        self.may_transfer(node)?;
        let room = SDO.saturating_sub(ADDRESS);
        if value.len() > room {
            return Err(MnError::Value { len: value.len(), room });
        }
        self.application.set(value);
        self.application.request = Some(Request { node, at, is_write: true });
        Ok(())
    }

    /// The value that was read last.
    #[must_use]
    pub fn sdo_data(&self) -> &[u8] {
        self.application.data()
    }

    fn may_transfer(&self, node: NodeId) -> Result<(), MnError> {
        let index = self.index_of(node).ok_or(MnError::NoPlan(node))?;
        if self.application.request.is_some() {
            return Err(MnError::Busy);
        }
        let phase = self.stations.get(index).map(|station| station.phase);
        if phase.is_none_or(|phase| matches!(phase, NodePhase::Absent | NodePhase::Restarting)) {
            return Err(MnError::Absent(node));
        }
        Ok(())
    }

    /// Gives the client something to do.
    pub(super) fn feed_client(&mut self) {
        if !self.client.is_idle() {
            return;
        }
        let segment = usize::from(self.config.async_mtu).saturating_sub(ASND_HEADER);
        if let Some(Request { node, at, is_write }) = self.application.request {
            self.is_for_application = true;
            if is_write {
                self.client.write(node, at, self.application.data(), segment);
            } else {
                self.client.read(node, at, segment);
            }
            return;
        }
        let is_configured_now = |index: &usize| {
            self.stations.get(*index).is_some_and(|station| station.phase == NodePhase::Configuring)
        };
        // One after another: each opens a connection once.
        let current = self.index_of(self.client.server()).filter(is_configured_now);
        let Some(index) = current.or_else(|| (0..self.stations.len()).find(is_configured_now)) else {
            return;
        };
        let Some((at, value, _)) = self.write_of(index) else { return };
        let Some(plan) = self.plans.get(index) else { return };
        self.is_for_application = false;
        self.client.write(plan.node, at, value.bytes(), segment);
    }

    /// The object that is written to a node in its present step, and whether the node may refuse it.
    fn write_of(&self, index: usize) -> Option<(ObjectAddress, Value<'p>, bool)> {
        let (plan, station) = (*self.plans.get(index)?, self.stations.get(index)?);
        let is_due = !station.has_configuration;
        let all = configuration(plan, station.limits, self.config.multiplexed_cycles).filter(|_| is_due);
        let last = (CYCLE_LENGTH, number(self.cycle_micros().into(), 4), false);
        all.chain([last]).nth(station.step.into())
    }

    /// Takes note of how a transfer goes.
    pub(super) fn progress(&mut self, progress: Progress) {
        if let Progress::Done(result) = progress {
            if self.is_for_application {
                self.application_done(result);
            } else if let Some(index) = self.index_of(self.client.server()) {
                self.write_done(index, result.map(|_| ()));
            }
        }
        self.supervise_client();
    }

    fn application_done(&mut self, result: Result<usize, AbortCode>) {
        let Some(Request { node, at, is_write }) = self.application.request.take() else { return };
        self.is_for_application = false;
        match result {
            Ok(_) if is_write => self.raise(MnEvent::ObjectWritten { node, at }),
            Ok(len) => {
                self.application.set(self.client.value(len));
                self.raise(MnEvent::ObjectRead { node, at, len });
            }
            Err(code) => self.raise(MnEvent::SdoFailed { node, at, code }),
        }
    }

    fn write_done(&mut self, index: usize, result: Result<(), AbortCode>) {
        let written = self.write_of(index).map(|(at, _, may_fail)| (at, may_fail));
        let (Some((at, may_fail)), Some(plan)) = (written, self.plans.get(index)) else { return };
        let node = plan.node;
        let Some(station) = self.stations.get_mut(index) else { return };
        if station.phase != NodePhase::Configuring {
            return;
        }
        match result {
            Err(AbortCode::TIME_OUT) => return self.lose(index, ErrorCode::BOOT_CONFIGURATION),
            Err(code) if !may_fail => {
                self.raise(MnEvent::ConfigurationAborted { node, at, code });
                return self.refuse(index, ErrorCode::BOOT_CONFIGURATION, NodeCause::WriteRefused);
            }
            Ok(()) | Err(_) => station.step = station.step.saturating_add(1),
        }
        if self.write_of(index).is_none() {
            self.enter_phase(index, NodePhase::Restarting, NodeCause::Written);
        }
    }

    /// A node is gone, and what was to be said to it.
    pub(super) fn drop_transfer(&mut self, node: NodeId) {
        if self.client.server() == node {
            self.client.forget();
            self.supervise_client();
        }
        if self.application.request.is_some_and(|request| request.node == node) {
            self.application_done(Err(AbortCode::TIME_OUT));
        }
    }

    pub(super) fn drop_transfers(&mut self) {
        self.client.forget();
        self.application_done(Err(AbortCode::TIME_OUT));
    }

    pub(super) fn supervise_client(&mut self) {
        if self.client.is_waiting() {
            self.timers.set_after(Timer::Sdo, self.config.sdo_timeout);
        } else {
            self.timers.clear(Timer::Sdo);
        }
    }

    pub(super) fn sdo_timeout(&mut self) {
        let progress = self.client.expired();
        self.progress(progress);
    }
}

impl Value<'_> {
    fn bytes(&self) -> &[u8] {
        match self {
            Self::Bytes(bytes) => bytes,
            Self::Number(bytes, len) => bytes.get(..*len).unwrap_or_default(),
        }
    }
}

/// All that makes a node what its plan says. The stamp is last, so that a node has it only with all the rest.
fn configuration<'p>(
    plan: NodePlan<'p>,
    limits: (u16, u16),
    multiplexed_cycles: u8,
) -> impl Iterator<Item = (ObjectAddress, Value<'p>, bool)> {
    let must =
        |at: (u16, u8), value: u64, len: usize| (ObjectAddress::new(at.0, at.1), number(value, len), false);
    let mappings = [(RECEIVE_MAPPING, plan.outputs), (TRANSMIT_MAPPING, plan.inputs)];
    let mappings = mappings.into_iter().filter(|(_, mapping)| !mapping.is_empty());
    let limits = [(4, plan.preq_limit, limits.0), (5, plan.pres_limit, limits.1)];
    let limits = limits.into_iter().filter(|(_, wanted, is)| wanted != is);
    let stamp = plan.configuration.into_iter().flat_map(|stamp| [(1, stamp.date), (2, stamp.time)]);
    let entries = mappings.clone().flat_map(move |(index, mapping)| {
        (1..=MOST_MAPPED).zip(mapping).map(move |(sub, entry)| must((index, sub), entry.number(), 8))
    });
    mappings
        .clone()
        .map(move |(index, _)| must((index, 0), 0, 1))
        .chain(limits.map(move |(sub, wanted, _)| must((CYCLE_TIMING, sub), wanted.into(), 2)))
        .chain(plan.multiplexed_slot.map(move |_| must((CYCLE_TIMING, 7), multiplexed_cycles.into(), 1)))
        .chain(plan.is_async_only.then(|| must((LOSS_OF_PREQ, 3), 0, 4)))
        .chain(plan.writes.iter().map(|write| (write.at, Value::Bytes(write.data), write.may_fail)))
        .chain(entries)
        .chain(mappings.map(move |(index, mapping)| {
            must((index, 0), u64::try_from(mapping.len()).unwrap_or(u64::MAX), 1)
        }))
        .chain(stamp.map(move |(sub, value)| must((CONFIGURATION, sub), value.into(), 4)))
}

const fn number<'p>(value: u64, len: usize) -> Value<'p> {
    Value::Number(value.to_le_bytes(), len)
}

const CYCLE_LENGTH: ObjectAddress = ObjectAddress::new(0x1006, 0);
const CONFIGURATION: u16 = 0x1020;
const RECEIVE_MAPPING: u16 = 0x1600;
const TRANSMIT_MAPPING: u16 = 0x1A00;
/// Who is never polled must not miss it.
const LOSS_OF_PREQ: u16 = 0x1C0D;
const CYCLE_TIMING: u16 = 0x1F98;
/// POWERLINK header, ServiceID, sequence layer and command header.
const ASND_HEADER: usize = 3 + 1 + 4 + COMMAND_HEADER;

#[cfg(test)]
mod tests {
    extern crate std;
    use std::vec::Vec;

    use super::*;
    use crate::pdo::MappingEntry;

    /// Sub-index 0 is 0 while the entries are written, and their number then: EPSG DS 301, as the recorded managing node does.
    #[test]
    fn the_longest_mapping_is_written_from_the_first_to_the_last_sub_index() {
        let object = ObjectAddress::new(0x6000, 1);
        let entries: Vec<_> = (0..254).map(|offset| MappingEntry { object, offset, length: 1 }).collect();
        let plan = NodePlan { inputs: &entries, ..NodePlan::new(NodeId(1)) };
        let writes: Vec<_> = configuration(plan, (36, 36), 0)
            .map(|(at, value, _)| (at.index, at.sub, value.bytes().to_vec()))
            .collect();
        let numbers = (1..=254)
            .zip(&entries)
            .map(|(sub, entry): (u8, _)| (TRANSMIT_MAPPING, sub, entry.number().to_le_bytes().to_vec()));
        let first = [(TRANSMIT_MAPPING, 0, std::vec![0])];
        let expected: Vec<_> =
            first.into_iter().chain(numbers).chain([(TRANSMIT_MAPPING, 0, std::vec![254])]).collect();
        assert_eq!(writes, expected);
    }
}
