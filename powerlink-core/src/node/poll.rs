//! Polls: PReq for this node, and the process data of it and of other nodes' PRes.

use link_core::codec::Reader;

use super::config::VersionCheck;
use super::event::{NodeEvent, count};
use super::machine::ControlledNode;
use super::output::POLL_HEADERS;
use crate::NodeId;
use crate::cycle::CycleEvent;
use crate::dictionary::ObjectSet;
use crate::ethernet::ETHERTYPE;
use crate::nmt::{Cause, NmtState};
use crate::pdo::{Mapping, PdoFault};
use crate::wire::{
    ErrorCode, Flags, Header, MESSAGE_TYPE, MessageType, POLL_FIELDS, ParseError, PdoVersion, Pres,
};

impl<O: ObjectSet, const PRES: usize, const SDO: usize> ControlledNode<O, PRES, SDO> {
    /// What a PReq for this node says in front of its process data, in a state in which it is answered. The managing node waits:
    /// it is known by one look at its headers, before any other frame.
    #[inline]
    pub(super) fn own_poll(&self, headers: &[u8; POLL_HEADERS]) -> Option<PollFields> {
        let (addresses, fields) = headers.split_first_chunk::<MAC_ADDRESSES>()?;
        let &[e0, e1, kind, to, from, _, flags, _, version, _, low, high] = fields.first_chunk()?;
        let [p0, p1] = ETHERTYPE.to_be_bytes();
        let is_own = [e0, e1] == [p0, p1]
            && kind & MESSAGE_TYPE == MessageType::PREQ.0
            && to == self.config.node.0
            && from == NodeId::MANAGING_NODE.0
            && addresses.first_chunk() == Some(&self.config.mac.0)
            && addresses.last_chunk() != Some(&self.config.mac.0)
            && self.nmt.state().answers_poll();
        is_own.then_some(PollFields {
            flags: Flags::from_bits_retain(flags),
            version: PdoVersion(version),
            size: u16::from_le_bytes([low, high]),
        })
    }

    #[inline]
    pub(super) fn polled<'a>(&mut self, poll: PollFields, data: &'a [u8]) -> Option<ProcessData<'a>> {
        let PollFields { flags, version, size } = poll;
        self.poll.is_due = true;
        self.poll.is_multiplexed = flags.contains(Flags::MULTIPLEXED) && self.active.multiplexed_cycles > 0;
        self.poll.in_multiplexed_cycle = true;
        self.poll.had_valid_data = flags.contains(Flags::DATA_VALID);
        // What the answer shows stays as it is until it is sent.
        self.poll.then = self.cycle_event(CycleEvent::Preq);
        self.signalling.exception_acknowledge(flags.contains(Flags::EXCEPTION_ACKNOWLEDGE));
        if self.nmt.state() == NmtState::PreOperational2 {
            self.dictionary.counters.preq();
            return None;
        }
        let data = data.get(..size.into()).filter(|_| size <= self.active.preq_limit);
        let Some(data) = data else {
            self.wrong_size();
            return None;
        };
        self.dictionary.counters.preq();
        Some(ProcessData { from: NodeId::NONE, flags, version, data })
    }

    #[cold]
    fn wrong_size(&mut self) {
        self.error(ErrorCode::INVALID_FORMAT);
        self.poll.then = Some(Cause::InternalError);
    }

    /// A PReq that is not to be answered: for another node, not of the managing node, or in a state without polls.
    pub(super) fn preq(&mut self, header: &Header, reader: &mut Reader<'_>) -> Result<(), ParseError> {
        if header.to != self.config.node {
            return Ok(());
        }
        reader.array::<POLL_FIELDS>("PReq header")?;
        if header.from == NodeId::MANAGING_NODE {
            self.poll_without_answer(self.nmt.state());
        } else {
            self.foreign_frame(header);
        }
        Ok(())
    }

    /// A stopped node is not polled, but sees where in the cycle a PReq comes.
    fn poll_without_answer(&mut self, state: NmtState) {
        if state != NmtState::Stopped {
            self.poll_outside_of_the_cycle(Cause::Preq);
        } else if let Some(cause) = self.cycle_event(CycleEvent::Preq) {
            self.cause(cause);
        }
    }

    /// PReq and PRes where there is no cycle for the node.
    fn poll_outside_of_the_cycle(&mut self, cause: Cause) {
        let options = self.config.options;
        match self.nmt.state() {
            NmtState::NotActive if options.poll_ends_not_active => {
                self.cause(cause);
            }
            NmtState::NotActive if options.poll_restarts_basic_ethernet => self.wait_for_the_network(),
            NmtState::BasicEthernet if cause == Cause::Preq || options.pres_ends_basic_ethernet => {
                self.cause(cause);
            }
            _ => {}
        }
    }

    pub(super) fn pres<'a>(&mut self, header: &Header, pres: &Pres<'a>) -> Option<ProcessData<'a>> {
        if !self.nmt.state().is_cyclic() {
            self.poll_outside_of_the_cycle(Cause::Pres);
            return None;
        }
        if let Some(cause) = self.cycle_event(CycleEvent::Pres) {
            self.cause(cause);
        }
        let Pres { flags, pdo_version: version, data, .. } = *pres;
        let data = ProcessData { from: header.from, flags, version, data };
        (self.is_started() && header.from != NodeId::NONE).then_some(data)
    }

    /// Gives the objects what a node sent.
    #[inline]
    pub(super) fn process_data(&mut self, &ProcessData { from, flags, version, data }: &ProcessData<'_>) {
        let is_valid = self.nmt.state() == NmtState::Operational;
        let says_valid = flags.contains(Flags::DATA_VALID);
        // Data that do not count are not used in operation; before, they are taken, and told as what they are.
        if is_valid && !says_valid {
            return;
        }
        let Some((channel, mapping)) = self.dictionary.mappings.channel_of(from) else { return };
        let error = if !fits(mapping, version, self.config.options.version_check) {
            ErrorCode::PDO_MAP_VERSION
        } else if data.len() < mapping.len() {
            ErrorCode::PDO_SHORT
        } else {
            if let Err(fault) = mapping.unpack(data, &mut self.objects) {
                return self.refused(channel, fault, says_valid);
            }
            return self.raise(NodeEvent::ProcessData { channel, is_valid });
        };
        // Who says that its data are not valid promises nothing about their form.
        if says_valid {
            self.pdo_error(error);
        }
    }

    /// The other objects took their values. It is no error of the network, which the managing node would be told.
    #[cold]
    fn refused(&mut self, channel: u8, PdoFault { object, code }: PdoFault, says_valid: bool) {
        self.raise(NodeEvent::ProcessData { channel, is_valid: self.nmt.state() == NmtState::Operational });
        if says_valid {
            count(&mut self.counters.pdo_errors);
            self.raise(NodeEvent::ValueRefused { channel, object, code });
        }
    }

    #[cold]
    fn pdo_error(&mut self, code: ErrorCode) {
        count(&mut self.counters.pdo_errors);
        self.error(code);
    }
}

const fn fits(mapping: &Mapping, version: PdoVersion, check: VersionCheck) -> bool {
    match check {
        VersionCheck::Main => mapping.fits(version),
        VersionCheck::Exact => mapping.version.0 == version.0,
        VersionCheck::None => true,
    }
}

/// What a PReq says of itself.
pub(super) struct PollFields {
    flags: Flags,
    version: PdoVersion,
    size: u16,
}

/// What a node sent to be taken into the objects.
pub(super) struct ProcessData<'a> {
    /// `NONE` for the PReq of the managing node.
    from: NodeId,
    flags: Flags,
    version: PdoVersion,
    data: &'a [u8],
}

/// Destination and source.
const MAC_ADDRESSES: usize = 12;
