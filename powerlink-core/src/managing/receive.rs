//! What the managing node does with what it hears.

use link_core::codec::{Reader, Wire};

use super::event::{MnEvent, count};
use super::machine::{ManagingNode, Opening, Step, Timer};
use super::schedule::Slot;
use super::state::{MnCause, MnState, NodePhase};
use super::station::Station;
use crate::NodeId;
use crate::sdo::Progress;
use crate::wire::{
    AsyncRequest, ErrorCode, Flags, FrameError, Header, IdentResponse, MessageType, NmtCommandId, NmtRequest,
    NmtStateCode, ParseError, Pres, Sdo, ServiceId, StatusResponse,
};

impl<const N: usize, const DATA: usize, const SDO: usize> ManagingNode<'_, N, DATA, SDO> {
    pub(super) fn frame(&mut self, bytes: &[u8]) {
        if self.state == MnState::Off {
            return;
        }
        let mut reader = Reader::new(bytes);
        let header = match Header::read(&mut reader) {
            Ok(header) => header,
            Err(FrameError::OtherProtocol(_)) => return,
            Err(FrameError::Malformed(error)) => return self.bad_frame(error),
        };
        if header.source == self.config.mac {
            return count(&mut self.counters.echoes);
        }
        let result = match header.message_type {
            MessageType::SOC | MessageType::SOA | MessageType::PREQ => {
                self.other_managing_node(&header);
                Ok(())
            }
            MessageType::PRES => Pres::read(&mut reader).map(|pres| self.pres(&header, &pres)),
            MessageType::ASND => self.asnd(&header, &mut reader),
            _ => Ok(()),
        };
        if let Err(error) = result {
            self.bad_frame(error);
        }
    }

    /// There can be one only: it gives way, and listens until the other is quiet. Of two that have just begun, that with the lower
    /// MAC address goes on.
    fn other_managing_node(&mut self, header: &Header) {
        let has_just_begun = self.state == MnState::PreOperational1 && self.opening == Opening::Quiet;
        if has_just_begun && self.config.mac < header.source {
            return self.raise(MnEvent::OtherManagingNode(header.source));
        }
        // Told once while it listens.
        if self.state != MnState::NotActive || self.rounds == 0 {
            self.raise(MnEvent::OtherManagingNode(header.source));
        }
        if self.state == MnState::NotActive {
            self.timers.set_after(Timer::State, self.config.wait_not_active);
        } else if self.state != MnState::Off {
            self.enter(MnState::NotActive, MnCause::OtherManagingNode);
        }
        self.rounds = 1;
    }

    /// The node that a frame is of, if it is of the network.
    fn sender(&mut self, node: NodeId) -> Option<usize> {
        let index = self.index_of(node);
        if index.is_none() && self.state.is_active() {
            count(&mut self.counters.unknown_nodes);
            self.raise(MnEvent::UnknownNode(node));
        }
        index.filter(|_| self.state.is_active())
    }

    /// Of two nodes with one ID the one that was identified counts, until it is lost.
    fn is_of_another(&mut self, index: usize, header: &Header) -> bool {
        let is_known = |station: &Station<DATA>| station.phase != NodePhase::Absent;
        let mac = self.stations.get(index).filter(|station| is_known(station)).map(|station| station.mac);
        if mac.is_none_or(|mac| mac == header.source) {
            return false;
        }
        count(&mut self.counters.address_conflicts);
        self.raise(MnEvent::AddressConflict { node: header.from, source: header.source });
        true
    }

    fn pres(&mut self, header: &Header, pres: &Pres<'_>) {
        let Some(index) = self.sender(header.from) else { return };
        if self.is_of_another(index, header) {
            return;
        }
        if self.step != Step::Poll(index) || self.due.is_some() {
            count(&mut self.counters.late_pres);
            return self.raise(MnEvent::PresLate { node: header.from });
        }
        let Some(station) = self.stations.get_mut(index) else { return };
        station.loss_of_pres.good();
        station.has_answered_poll = true;
        station.request = pres.request;
        station.shown = pres.state;
        station.exception_new = pres.flags.contains(Flags::EXCEPTION_NEW);
        let is_valid = pres.flags.contains(Flags::DATA_VALID)
            && pres.state == NmtStateCode::OPERATIONAL
            && station.phase == NodePhase::Operational
            && self.state == MnState::Operational;
        if is_valid && station.inputs.set(pres.data) {
            (station.inputs_valid, station.told_inputs) = (true, true);
            self.raise(MnEvent::Inputs { node: header.from, is_valid: true });
        } else {
            if is_valid {
                count(&mut self.counters.pres_too_long);
            }
            self.end_inputs(index);
        }
        self.follow_state(index);
        self.poll_after(Some(index));
    }

    /// A poll was not answered in time.
    pub(super) fn pres_is_lost(&mut self, index: usize) {
        let (Some(station), Some(plan)) = (self.stations.get_mut(index), self.plans.get(index)) else {
            return;
        };
        count(&mut self.counters.lost_pres);
        let (node, is_too_often) = (plan.node, station.loss_of_pres.symptom());
        self.raise(MnEvent::PresLost { node });
        self.end_inputs(index);
        if is_too_often {
            self.lose(index, ErrorCode::LOSS_OF_PRES_THRESHOLD);
        }
    }

    fn asnd(&mut self, header: &Header, reader: &mut Reader<'_>) -> Result<(), ParseError> {
        let service = ServiceId(reader.u8("ServiceID")?);
        if header.from == NodeId::MANAGING_NODE {
            if service == ServiceId::NMT_COMMAND {
                self.other_managing_node(header);
            }
            return Ok(());
        }
        // Nodes may speak to one another.
        if header.to != NodeId::MANAGING_NODE && header.to != NodeId::BROADCAST {
            self.is_answered(header.from, service);
            return Ok(());
        }
        if header.from == NodeId::DIAGNOSTIC && self.index_of(header.from).is_none() {
            self.is_answered(header.from, service);
            return Ok(());
        }
        let Some(index) = self.sender(header.from) else { return Ok(()) };
        if self.is_of_another(index, header) {
            return Ok(());
        }
        let is_invited = self.is_answered(header.from, service);
        match service {
            ServiceId::IDENT_RESPONSE => self.ident(index, header.source, &IdentResponse::read(reader)?),
            ServiceId::STATUS_RESPONSE => self.status(index, &StatusResponse::read(reader)?),
            // Twice the same is asked for once.
            ServiceId::NMT_REQUEST if is_invited => self.nmt_request(header.from, &NmtRequest::read(reader)?),
            ServiceId::SDO => {
                let sdo = Sdo::read_as(reader, self.config.initiate_size)?;
                let progress = self.client.receive(header.from, &sdo);
                if progress == Progress::Ignored {
                    count(&mut self.counters.sdo_ignored);
                }
                // What the client does not wait for does not put off its time-out.
                if progress != Progress::Ignored || !self.client.is_waiting() {
                    self.progress(progress);
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Whether the frame is what the slot is for; then the slot is over with it.
    fn is_answered(&mut self, from: NodeId, service: ServiceId) -> bool {
        let is_of = |index: usize| self.plans.get(index).is_some_and(|plan| plan.node == from);
        let is_invited = self.step == Step::Slot
            && self.due.is_none()
            && match (self.slot, service) {
                (Slot::Ident(node), ServiceId::IDENT_RESPONSE) => node == from,
                (Slot::Status(index), ServiceId::STATUS_RESPONSE)
                | (Slot::Request(index), ServiceId::NMT_REQUEST) => is_of(index),
                (Slot::Invite(index), _) => is_of(index),
                _ => false,
            };
        if !is_invited {
            count(&mut self.counters.uninvited);
            return false;
        }
        if let Slot::Request(index) | Slot::Invite(index) = self.slot
            && let Some(station) = self.stations.get_mut(index)
        {
            let (priority, left) = (station.request.priority(), station.request.count().saturating_sub(1));
            station.request = AsyncRequest::new(priority, left.into());
        }
        self.end_slot();
        true
    }

    fn nmt_request(&mut self, from: NodeId, request: &NmtRequest<'_>) {
        let (command, target) = (request.command, request.target);
        self.raise(MnEvent::NmtRequested { from, command, target });
        if !self.config.follows_requests {
            return;
        }
        let followed = match command {
            NmtCommandId::IDENT_REQUEST => self.index_of(target).is_some(),
            NmtCommandId::STATUS_REQUEST => {
                let station = self.index_of(target).and_then(|index| self.stations.get_mut(index));
                station.map(|station| station.status_in = 0).is_some()
            }
            _ if target == NodeId::BROADCAST => self.command_all(command).is_ok(),
            _ => self.command(target, command).is_ok(),
        };
        if !followed {
            self.invalid_request = Some(from);
        }
    }

    fn bad_frame(&mut self, error: ParseError) {
        count(&mut self.counters.bad_frames);
        self.raise(MnEvent::BadFrame(error));
    }
}
