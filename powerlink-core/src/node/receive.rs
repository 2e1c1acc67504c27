//! What the node hears: which frames are for it, the frames of the cycle but the poll, and what its adapter tells.

use link_core::codec::{Reader, Wire};
use link_core::ethernet::LinkEvent;

use super::event::{NodeEvent, count};
use super::machine::{ControlledNode, Reply};
use super::poll::ProcessData;
use crate::cycle::CycleEvent;
use crate::dictionary::ObjectSet;
use crate::error::Symptom;
use crate::ethernet::group;
use crate::nmt::Cause;
use crate::wire::{
    ErrorCode, Flags, FrameError, Header, MessageType, ParseError, Pres, RequestedService, Soa, Soc,
};
use crate::{MacAddress, NodeId};

impl<O: ObjectSet, const PRES: usize, const SDO: usize> ControlledNode<O, PRES, SDO> {
    #[inline(never)]
    pub(super) fn frame(&mut self, bytes: &[u8]) {
        if self.poll.is_due || self.reply.is_some() {
            self.forget_answers();
        }
        let data = if let Some((headers, data)) = bytes.split_first_chunk()
            && let Some(poll) = self.own_poll(headers)
        {
            self.polled(poll, data)
        } else {
            self.other_than_poll(bytes)
        };
        if let Some(data) = data {
            self.process_data(&data);
        }
    }

    /// Every frame but the PReq that is to be answered. Returns the process data of other nodes.
    #[inline(never)]
    fn other_than_poll<'a>(&mut self, bytes: &'a [u8]) -> Option<ProcessData<'a>> {
        if !self.nmt.state().is_communicating() {
            self.frame_while_silent(bytes);
            return None;
        }
        let mut reader = Reader::new(bytes);
        let header = match Header::read(&mut reader) {
            Ok(header) => header,
            Err(FrameError::OtherProtocol(_)) => {
                self.other_frame();
                return None;
            }
            Err(FrameError::Malformed(error)) => {
                self.bad_frame(error);
                return None;
            }
        };
        if header.source == self.config.mac {
            count(&mut self.counters.echoes);
            return None;
        }
        if !self.is_for_this_adapter(&header) {
            count(&mut self.counters.other_destinations);
            return None;
        }
        if header.from == self.config.node {
            self.address_conflict(&header);
        }
        let is_of_managing_node = header.from == NodeId::MANAGING_NODE;
        let result = match header.message_type {
            MessageType::PREQ => self.preq(&header, &mut reader),
            MessageType::SOC => Soc::read(&mut reader).map(|soc| match is_of_managing_node {
                true => self.soc(&soc),
                false => self.foreign_frame(&header),
            }),
            MessageType::SOA => Soa::read(&mut reader).map(|soa| match is_of_managing_node {
                true => self.soa(&soa),
                false => self.foreign_frame(&header),
            }),
            MessageType::PRES => match Pres::read(&mut reader) {
                Ok(pres) => return self.pres(&header, &pres),
                Err(error) => Err(error),
            },
            MessageType::ASND => {
                self.other_frame();
                self.asnd(&header, &mut reader)
            }
            _ => {
                count(&mut self.counters.unknown);
                Ok(())
            }
        };
        if let Err(error) = result {
            self.bad_frame(error);
        }
        None
    }

    /// What only the managing node sends, of another node.
    #[cold]
    pub(super) fn foreign_frame(&mut self, header: &Header) {
        count(&mut self.counters.foreign_frames);
        self.raise(NodeEvent::ForeignFrame { message: header.message_type, from: header.from });
    }

    /// A frame under the ID of this node from another MAC address. What it means for the cycle it means nevertheless.
    #[cold]
    fn address_conflict(&mut self, header: &Header) {
        if matches!(header.message_type, MessageType::PRES | MessageType::ASND) {
            count(&mut self.counters.address_conflicts);
            self.raise(NodeEvent::AddressConflict { source: header.source });
        }
    }

    /// In the initialisation the node only hears that it is to be reset once more.
    #[cold]
    fn frame_while_silent(&mut self, bytes: &[u8]) {
        let mut reader = Reader::new(bytes);
        if self.nmt.state().is_powered()
            && let Ok(header) = Header::read(&mut reader)
            && header.message_type == MessageType::ASND
            && header.source != self.config.mac
            && self.is_for_this_adapter(&header)
            && let Err(error) = self.asnd(&header, &mut reader)
        {
            self.bad_frame(error);
        }
    }

    /// An answer that nobody fetched before the next frame came would come too late. What it was to lead to still counts.
    #[cold]
    fn forget_answers(&mut self) {
        count(&mut self.counters.not_sent);
        self.poll.is_due = false;
        self.after_poll();
        if let Some(reply) = self.reply.take() {
            self.after_reply(reply);
        }
    }

    /// Every message has its address; an ASnd may come at the node's own and at that of all as well.
    fn is_for_this_adapter(&self, header: &Header) -> bool {
        let destination = header.destination;
        match header.message_type {
            MessageType::PREQ => destination == self.config.mac,
            MessageType::SOC => destination == group::SOC,
            MessageType::SOA => destination == group::SOA,
            MessageType::PRES => destination == group::PRES,
            _ => {
                destination == group::ASND
                    || destination == self.config.mac
                    || destination == MacAddress::BROADCAST
            }
        }
    }

    fn soc(&mut self, soc: &Soc) {
        self.cause(Cause::Soc);
        // The SoC that ends `NotActive` or `BasicEthernet` has done its work by that.
        if !self.nmt.state().is_cyclic() {
            return;
        }
        (self.net_time, self.relative_time) = (soc.net_time, soc.relative_time);
        let jitter = self.jitter();
        self.supervise_soc();
        let multiplexed = self.multiplexed_cycle(soc.flags.contains(Flags::MULTIPLEXED_CYCLE));
        let order = self.cycle_event(CycleEvent::Soc);
        if let Some(cause) = jitter.or(multiplexed).or(order) {
            self.cause(cause);
        }
        self.take_inputs();
    }

    fn soa(&mut self, soa: &Soa) {
        if self.cause(Cause::Soa) {
            return;
        }
        let state = self.nmt.state();
        if state.is_cyclic() {
            let cause = self.cycle_event(CycleEvent::Soa);
            self.dictionary.counters.end_of_cycle();
            if let Some(cause) = cause {
                self.cause(cause);
            }
        }
        if !state.is_powerlink_mode() || soa.target != self.config.node {
            return;
        }
        self.signalling.exception_acknowledge(soa.flags.contains(Flags::EXCEPTION_ACKNOWLEDGE));
        self.reply = match soa.service {
            RequestedService::IDENT_REQUEST => Some(Reply::Ident),
            RequestedService::STATUS_REQUEST => {
                let reset = soa.flags.contains(Flags::EXCEPTION_RESET);
                let is_early = self.config.options.clears_before_answer;
                if is_early {
                    self.signalling.exception_reset(reset);
                }
                Some(Reply::Status { late_reset: (!is_early).then_some(reset) })
            }
            RequestedService::NMT_REQUEST_INVITE => Some(Reply::NmtRequest),
            RequestedService::UNSPECIFIED_INVITE => Some(Reply::Generic),
            _ => None,
        };
    }

    /// An ASnd, or a frame of another protocol: it belongs behind the SoA.
    fn other_frame(&mut self) {
        if self.nmt.state().is_cyclic()
            && let Some(cause) = self.cycle_event(CycleEvent::Asnd)
        {
            self.cause(cause);
        }
    }

    pub(super) fn link(&mut self, event: LinkEvent) {
        if !self.nmt.state().is_powered() {
            return;
        }
        match event {
            LinkEvent::Up => {}
            LinkEvent::Down => {
                self.dictionary.counters.symptom(Symptom::LossOfLink);
                self.error(ErrorCode::LOSS_OF_LINK);
            }
            LinkEvent::CrcError => self.symptom(Symptom::Crc),
            LinkEvent::Collision => self.symptom(Symptom::Collision),
            LinkEvent::FramesLost { count } => {
                self.counters.frames_lost = self.counters.frames_lost.saturating_add(count.max(1));
            }
            LinkEvent::NotSent => count(&mut self.counters.not_sent),
        }
    }

    fn bad_frame(&mut self, error: ParseError) {
        count(&mut self.counters.bad_frames);
        self.raise(NodeEvent::BadFrame(error));
    }
}
