//! What the node does with what it hears.

use core::time::Duration;

use link_core::codec::{Reader, Wire};
use link_core::ethernet::LinkEvent;

use super::config::VersionCheck;
use super::event::{NodeEvent, count};
use super::machine::{ControlledNode, Reply, Timer};
use super::output::POLL_HEADERS;
use crate::cycle::{CycleEvent, CycleMode, Losses, Supervision};
use crate::dictionary::ObjectSet;
use crate::error::Symptom;
use crate::ethernet::{ETHERTYPE, group};
use crate::nmt::{Cause, NmtState};
use crate::pdo::{Mapping, RECEIVE_CHANNELS};
use crate::wire::{
    ErrorCode, Flags, FrameError, Header, MESSAGE_TYPE, MessageType, POLL_FIELDS, ParseError, PdoVersion,
    Pres, RequestedService, Soa, Soc,
};
use crate::{MacAddress, NodeId};

impl<O: ObjectSet, const PRES: usize, const SDO: usize> ControlledNode<O, PRES, SDO> {
    #[inline(never)]
    pub(super) fn frame(&mut self, bytes: &[u8]) {
        if !self.nmt.state().is_communicating() {
            return self.frame_while_silent(bytes);
        }
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
        let result = match header.message_type {
            MessageType::PREQ => self.preq(&header, &mut reader),
            MessageType::SOC => Soc::read(&mut reader).map(|soc| self.soc(&soc)),
            MessageType::SOA => Soa::read(&mut reader).map(|soa| self.soa(&soa)),
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
        (self.poll.is_due, self.reply) = (false, None);
        self.after_poll();
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
        // The process data of this cycle; the PRes is ready before the PReq.
        let mapping = &self.dictionary.mappings.transmit;
        mapping.pack(&self.objects, &mut self.inputs);
        self.inputs.get_mut(mapping.len()..).unwrap_or_default().fill(0);
    }

    /// MC toggles when a multiplexed cycle is over: a node that is polled in one cycle of many was to be polled in it.
    fn multiplexed_cycle(&mut self, toggle: bool) -> Option<Cause> {
        if core::mem::replace(&mut self.poll.multiplexed_cycle, toggle) == toggle {
            return None;
        }
        let was_polled = core::mem::take(&mut self.poll.in_multiplexed_cycle);
        let is_due = self.active.multiplexed_cycles > 0 && self.is_started();
        if was_polled || !is_due { None } else { self.losses(Losses::PREQ) }
    }

    /// Whether process data are exchanged, so that a PReq is due.
    const fn is_started(&self) -> bool {
        matches!(self.nmt.state(), NmtState::ReadyToOperate | NmtState::Operational)
    }

    /// The distance of two SoCs against the cycle length.
    fn jitter(&mut self) -> Option<Cause> {
        let (expected, range) = (self.timers.at(Timer::Soc)?, self.dictionary.values.jitter_range);
        let tolerance = Duration::from_nanos(self.active.loss_of_soc_tolerance.into());
        let (now, expected) = (self.timers.now(), expected.saturating_sub(tolerance));
        let jitter = now.saturating_since(expected).max(expected.saturating_since(now));
        if jitter <= Duration::from_nanos(range.into()) {
            return None;
        }
        if self.dictionary.counters.symptom(Symptom::SocJitter) {
            self.react(Symptom::SocJitter)
        } else {
            None
        }
    }

    fn supervise_soc(&mut self) {
        let (length, tolerance) = (self.active.cycle_length, self.active.loss_of_soc_tolerance);
        if length == 0 || tolerance == 0 || !self.nmt.state().is_cyclic() {
            return self.timers.clear(Timer::Soc);
        }
        let nanos = u64::from(length).saturating_mul(NANOS_PER_MICRO).saturating_add(tolerance.into());
        self.timers.set_after(Timer::Soc, Duration::from_nanos(nanos));
    }

    /// The SoC is overdue. The next one is expected a cycle later.
    pub(super) fn soc_timeout(&mut self) {
        self.timers.set_after(Timer::Soc, Duration::from_micros(self.active.cycle_length.into()));
        // In `PreOperational2` the cycle length may be unknown yet.
        if self.nmt.state() == NmtState::PreOperational2 {
            return;
        }
        match self.cycle_event(CycleEvent::SocTimeout) {
            // A poll that came at this very moment is answered first.
            Some(cause) if self.poll.is_due => self.poll.then = self.poll.then.or(Some(cause)),
            Some(cause) => {
                self.cause(cause);
            }
            None => {}
        }
    }

    /// A PReq that is not to be answered: that of another node, or in a state without polls.
    fn preq(&mut self, header: &Header, reader: &mut Reader<'_>) -> Result<(), ParseError> {
        if header.to == self.config.node {
            reader.array::<POLL_FIELDS>("PReq header")?;
            self.poll_without_answer(self.nmt.state());
        }
        Ok(())
    }

    /// What a PReq for this node says in front of its process data, in a state in which it is answered. The managing node waits:
    /// it is known by one look at its headers, before any other frame.
    #[inline]
    fn own_poll(&self, headers: &[u8; POLL_HEADERS]) -> Option<PollFields> {
        let (addresses, fields) = headers.split_first_chunk::<MAC_ADDRESSES>()?;
        let &[e0, e1, kind, to, _, _, flags, _, version, _, low, high] = fields.first_chunk()?;
        let [p0, p1] = ETHERTYPE.to_be_bytes();
        let is_own = [e0, e1] == [p0, p1]
            && kind & MESSAGE_TYPE == MessageType::PREQ.0
            && to == self.config.node.0
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
    fn polled<'a>(&mut self, poll: PollFields, data: &'a [u8]) -> Option<ProcessData<'a>> {
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

    fn pres<'a>(&mut self, header: &Header, pres: &Pres<'a>) -> Option<ProcessData<'a>> {
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
                self.cause(Cause::Soa);
            }
            NmtState::NotActive if options.poll_restarts_basic_ethernet => self.wait_for_the_network(),
            NmtState::BasicEthernet if cause == Cause::Preq || options.pres_ends_basic_ethernet => {
                self.cause(cause);
            }
            _ => {}
        }
    }

    /// Gives the objects what a node sent.
    #[inline]
    fn process_data(&mut self, &ProcessData { from, flags, version, data }: &ProcessData<'_>) {
        let is_valid = self.nmt.state() == NmtState::Operational;
        let says_valid = flags.contains(Flags::DATA_VALID);
        // Data that do not count are not used in operation; before, they are taken, and told as what they are.
        if is_valid && !says_valid {
            return;
        }
        for channel in 0..RECEIVE_CHANNELS {
            let Some(mapping) = self.dictionary.mappings.receive.get(channel) else { return };
            if !mapping.is_of(from) {
                continue;
            }
            let error = if !fits(mapping, version, self.config.options.version_check) {
                ErrorCode::PDO_MAP_VERSION
            } else if data.len() < mapping.len() {
                ErrorCode::PDO_SHORT
            } else {
                mapping.unpack(data, &mut self.objects);
                let channel = u8::try_from(channel).unwrap_or(u8::MAX);
                self.raise(NodeEvent::ProcessData { channel, is_valid });
                continue;
            };
            // Who says that its data are not valid promises nothing about their form.
            if says_valid {
                self.pdo_error(error);
            }
        }
    }

    #[cold]
    fn pdo_error(&mut self, code: ErrorCode) {
        count(&mut self.counters.pdo_errors);
        self.error(code);
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
        self.reply = match soa.service {
            RequestedService::IDENT_REQUEST => Some(Reply::Ident),
            RequestedService::STATUS_REQUEST => {
                self.signalling.exception_acknowledge(soa.flags.contains(Flags::EXCEPTION_ACKNOWLEDGE));
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

    /// Tells the cycle what happened, and counts what is missing. Returns what that leads to.
    fn cycle_event(&mut self, event: CycleEvent) -> Option<Cause> {
        let state = self.nmt.state();
        let mode = if state == NmtState::Stopped { CycleMode::Stopped } else { CycleMode::Polled };
        let supervision = Supervision {
            is_timed: state != NmtState::PreOperational2 && self.timers.at(Timer::Soc).is_some(),
            is_preq_due: self.active.multiplexed_cycles == 0 && self.is_started(),
        };
        let losses = self.cycle.apply(mode, event, supervision);
        if losses.is_empty() { None } else { self.losses(losses) }
    }

    fn losses(&mut self, losses: Losses) -> Option<Cause> {
        let symptoms = [
            (Losses::SOC, Symptom::LossOfSoc),
            (Losses::SOA, Symptom::LossOfSoa),
            (Losses::PREQ, Symptom::LossOfPreq),
        ];
        let mut cause = None;
        for (loss, symptom) in symptoms {
            if losses.contains(loss) && self.dictionary.counters.symptom(symptom) {
                cause = self.react(symptom).or(cause);
            }
        }
        cause
    }

    /// A threshold was reached. What is only counted is no error.
    fn react(&mut self, symptom: Symptom) -> Option<Cause> {
        let options = &self.config.options;
        let reacts = match symptom {
            Symptom::LossOfSoc | Symptom::LossOfPreq | Symptom::Crc => true,
            Symptom::LossOfSoa => options.reacts_to_loss_of_soa,
            Symptom::SocJitter => options.reacts_to_jitter,
            Symptom::Collision => options.reacts_to_collisions,
            Symptom::LossOfLink => false,
        };
        if !reacts {
            return None;
        }
        self.error(symptom.code());
        Some(Cause::CycleError)
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

    fn symptom(&mut self, symptom: Symptom) {
        let is_reached = self.dictionary.counters.symptom(symptom);
        if is_reached && let Some(cause) = self.react(symptom) {
            self.cause(cause);
        }
    }

    fn bad_frame(&mut self, error: ParseError) {
        count(&mut self.counters.bad_frames);
        self.raise(NodeEvent::BadFrame(error));
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
struct PollFields {
    flags: Flags,
    version: PdoVersion,
    size: u16,
}

/// What a node sent to be taken into the objects.
struct ProcessData<'a> {
    /// `NONE` for the PReq of the managing node.
    from: NodeId,
    flags: Flags,
    version: PdoVersion,
    data: &'a [u8],
}

/// Destination and source.
const MAC_ADDRESSES: usize = 12;
const NANOS_PER_MICRO: u64 = 1000;
