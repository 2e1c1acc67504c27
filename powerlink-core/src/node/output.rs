//! What the node sends. It follows from the state; there is no queue of frames.

use link_core::codec::{Full, Wire, Writer};
use link_core::ethernet::Action;

use super::event::{NodeEvent, count};
use super::machine::{ControlledNode, Reply, Request};
use crate::dictionary::{FEATURES, ObjectSet};
use crate::ethernet::{ETHERNET_HEADER, MIN_FRAME, POLL_HEADER, group};
use crate::nmt::{Cause, NmtState};
use crate::pdo::PdoFault;
use crate::wire::{
    AsyncRequest, Flags, Header, IdentResponse, IpParameters, MessageType, NmtRequest, POWERLINK_V2, Pres,
    ServiceId, StatusResponse, pad,
};
use crate::{MacAddress, NodeId};

impl<O: ObjectSet, const PRES: usize, const SDO: usize> ControlledNode<O, PRES, SDO> {
    /// Whether there is anything to do.
    #[inline]
    pub(super) fn has_output(&self) -> bool {
        self.poll.is_due
            || self.poll.then.is_some()
            || self.reply.is_some()
            || !self.events.is_empty()
            || self.nmt.state().is_initialisation()
            || self.may_answer_client()
    }

    /// The next thing to do: answers first, because the managing node waits.
    #[inline]
    pub(super) fn output<'b>(&mut self, buffer: &'b mut [u8]) -> Option<Action<'b, NodeEvent>> {
        if core::mem::take(&mut self.poll.is_due) {
            let sent = self.pres_frame(buffer);
            self.after_poll();
            return Some(sent.map_or_else(|| self.not_sent(), Action::Transmit));
        }
        // A driver asks until there is nothing to do; most often that is its first question.
        if self.has_output() { self.other_output(buffer) } else { None }
    }

    /// The next thing to do but the PRes.
    #[inline(never)]
    fn other_output<'b>(&mut self, buffer: &'b mut [u8]) -> Option<Action<'b, NodeEvent>> {
        let mut out = Writer::new(buffer);
        match self.answer(&mut out) {
            Ok(true) => return Some(Action::Transmit(out.into_written())),
            Ok(false) => {}
            Err(Full) => return Some(self.not_sent()),
        }
        if self.events.is_empty() && self.nmt.state().is_initialisation() {
            self.cause(Cause::Done);
        }
        self.events.pop().map(Action::Event)
    }

    #[cold]
    fn not_sent<'b>(&mut self) -> Action<'b, NodeEvent> {
        count(&mut self.counters.not_sent);
        Action::Event(NodeEvent::BufferTooShort)
    }

    /// Writes the frame that is to be sent in the asynchronous phase. Returns whether there is one.
    fn answer(&mut self, out: &mut Writer<'_>) -> Result<bool, Full> {
        let reply = match self.reply.take() {
            None if self.may_answer_client() => Reply::Generic,
            None => return Ok(false),
            Some(reply) => reply,
        };
        match reply {
            Reply::Ident => self.ident_frame(out)?,
            Reply::Status { .. } => {
                let written = self.status_frame(out);
                self.after_reply(reply);
                written?;
            }
            Reply::NmtRequest => {
                let Some(&request) = self.requests.iter().next() else { return Ok(false) };
                self.request_frame(request, out)?;
                self.requests.pop();
            }
            Reply::Generic => {
                let Some((index, client)) = self.server.next() else { return Ok(false) };
                // The time for an acknowledge goes on whatever else is said meanwhile.
                let is_timed = self.server.is_unacknowledged(index);
                self.asnd_header(client, ServiceId::SDO, out)?;
                let is_written = self.server.emit(index, self.config.options.initiate_size, out)?;
                debug_assert!(is_written, "a frame was ready");
                pad(out, MIN_FRAME)?;
                if !is_timed {
                    self.wait_for_client(index);
                }
                self.reset_if_answered();
            }
        }
        Ok(true)
    }

    /// What the SoA leads to, answered or not.
    pub(super) fn after_reply(&mut self, reply: Reply) {
        if let Reply::Status { late_reset: Some(reset) } = reply {
            self.signalling.exception_reset(reset);
        }
    }

    /// What the PReq leads to, now that it is answered.
    pub(super) fn after_poll(&mut self) {
        if let Some(cause) = self.poll.then.take() {
            self.cause(cause);
        }
    }

    /// Where there is no managing node, nobody invites.
    fn may_answer_client(&self) -> bool {
        self.nmt.state() == NmtState::BasicEthernet && self.server.ready() > 0
    }

    /// Takes the process data of this cycle from the objects: the PRes is ready before the PReq.
    pub(super) fn take_inputs(&mut self) {
        let mapping = &self.dictionary.mappings.transmit;
        let read = mapping.pack(&self.objects, &mut self.inputs);
        self.inputs.get_mut(mapping.len()..).unwrap_or_default().fill(0);
        self.are_inputs_read = read.is_ok();
        if let Err(PdoFault { object, code }) = read {
            count(&mut self.counters.pdo_errors);
            self.raise(NodeEvent::ValueUnreadable { object, code });
        }
    }

    /// The PRes: of constant length, whatever is mapped. `None` if the buffer is too short.
    #[inline]
    fn pres_frame<'b>(&self, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
        let (state, request) = (self.nmt.state(), self.async_request());
        let mapping = &self.dictionary.mappings.transmit;
        let limit = self.active.pres_limit;
        // A mapping for a limit that is not in use yet has no place in this PRes.
        let size = Some(mapping.size()).filter(|&size| size <= limit);
        let are_valid = self.are_inputs_valid && self.are_inputs_read;
        let is_valid = state == NmtState::Operational && are_valid && size.is_some();
        let mut flags = self.signalling.exception_new();
        flags.set(Flags::DATA_VALID, is_valid);
        flags.set(Flags::MULTIPLEXED, self.poll.is_multiplexed);
        let size = size.unwrap_or(0);
        let pres = Pres { state: state.code(), flags, request, pdo_version: mapping.version, data: &[] };
        // Behind what is mapped the inputs are zeros.
        let inputs = self.inputs.get(..limit.into()).unwrap_or_default();
        let frame = buffer.get_mut(..inputs.len().saturating_add(POLL_HEADERS))?;
        let (header, rest) = frame.split_first_chunk_mut()?;
        *header = self.header(group::PRES, MessageType::PRES, NodeId::BROADCAST).bytes();
        let (fields, data) = rest.split_first_chunk_mut()?;
        *fields = pres.fields(size);
        data.copy_from_slice(inputs);
        Some(frame)
    }

    fn ident_frame(&mut self, out: &mut Writer<'_>) -> Result<(), Full> {
        let (device, values) = (&self.config.device, &self.dictionary.values);
        let ident = IdentResponse {
            flags: Flags::empty(),
            request: self.async_request(),
            state: self.nmt.state().code(),
            version: POWERLINK_V2,
            features: FEATURES,
            mtu: self.active.async_mtu,
            poll_in_size: self.active.preq_limit,
            poll_out_size: self.active.pres_limit,
            response_time: device.pres_latency,
            device_type: device.device_type,
            identity: device.identity,
            vendor_extension_1: device.vendor_extension_1,
            configuration: values.configuration,
            software: device.software,
            ip: IpParameters::of(self.config.node),
            host_name: values.host_name,
            vendor_extension_2: device.vendor_extension_2,
        };
        self.asnd_header(NodeId::BROADCAST, ServiceId::IDENT_RESPONSE, out)?;
        ident.emit(out)
    }

    fn status_frame(&mut self, out: &mut Writer<'_>) -> Result<(), Full> {
        let mut static_errors = self.static_errors;
        let [register, ..] = &mut static_errors;
        *register = self.dictionary.error_register;
        let status = StatusResponse {
            flags: self.signalling.flags(),
            request: self.async_request(),
            state: self.nmt.state().code(),
            static_errors,
            entries: heapless::Vec::from_slice(self.signalling.entries()).unwrap_or_default(),
        };
        self.asnd_header(NodeId::BROADCAST, ServiceId::STATUS_RESPONSE, out)?;
        status.emit(out)
    }

    fn request_frame(&self, request: Request, out: &mut Writer<'_>) -> Result<(), Full> {
        self.asnd_header(NodeId::MANAGING_NODE, ServiceId::NMT_REQUEST, out)?;
        NmtRequest { command: request.command, target: request.target, data: &[] }.emit(out)?;
        pad(out, MIN_FRAME)
    }

    fn asnd_header(&self, to: NodeId, service: ServiceId, out: &mut Writer<'_>) -> Result<(), Full> {
        self.header(group::ASND, MessageType::ASND, to).emit(out)?;
        out.u8(service.0)
    }

    const fn header(&self, destination: MacAddress, message_type: MessageType, to: NodeId) -> Header {
        Header { destination, source: self.config.mac, message_type, to, from: self.config.node }
    }

    /// RS and PR: NMT requests before everything else.
    fn async_request(&self) -> AsyncRequest {
        if self.requests.is_empty() {
            AsyncRequest::new(AsyncRequest::GENERIC, self.server.ready())
        } else {
            AsyncRequest::new(AsyncRequest::NMT, self.requests.len())
        }
    }
}

/// The headers of a PReq and PRes, with those of Ethernet.
pub(super) const POLL_HEADERS: usize = ETHERNET_HEADER + POLL_HEADER;
