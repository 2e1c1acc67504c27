//! ASnd: NMT commands and SDO.

use link_core::codec::{Reader, Wire};

use super::event::{NodeEvent, count};
use super::machine::{ControlledNode, Timer};
use crate::NodeId;
use crate::dictionary::{Effect, ObjectAddress, ObjectSet, Objects};
use crate::nmt::{Cause, NmtState};
use crate::sdo::{Outcome, Received};
use crate::wire::{COMMAND_HEADER, Header, NmtCommand, NmtCommandId, ParseError, Sdo, ServiceId};

impl<O: ObjectSet, const PRES: usize, const SDO: usize> ControlledNode<O, PRES, SDO> {
    pub(super) fn asnd(&mut self, header: &Header, reader: &mut Reader<'_>) -> Result<(), ParseError> {
        let is_for_this_node = header.to == self.config.node;
        match ServiceId(reader.u8("ServiceID")?) {
            ServiceId::NMT_COMMAND if is_for_this_node || header.to == NodeId::BROADCAST => {
                let command = NmtCommand::read(reader)?;
                if !command.is_for(self.config.node) {
                    return Ok(());
                }
                if header.from == NodeId::MANAGING_NODE {
                    self.command(&command);
                } else {
                    self.foreign_frame(header);
                }
            }
            ServiceId::SDO if is_for_this_node && self.serves_objects() && self.is_client(header.from) => {
                let sdo = Sdo::read_as(reader, self.config.options.initiate_size)?;
                self.sdo(header.from, &sdo);
            }
            // For others, of others, or not to be served in this state.
            ServiceId::NMT_COMMAND
            | ServiceId::SDO
            | ServiceId::IDENT_RESPONSE
            | ServiceId::STATUS_RESPONSE
            | ServiceId::NMT_REQUEST => {}
            _ => count(&mut self.counters.unknown),
        }
        Ok(())
    }

    const fn serves_objects(&self) -> bool {
        self.nmt.state().is_powerlink_mode() || matches!(self.nmt.state(), NmtState::BasicEthernet)
    }

    /// An answer can be sent to one other node.
    fn is_client(&self, node: NodeId) -> bool {
        ![NodeId::NONE, NodeId::BROADCAST, self.config.node].contains(&node)
    }

    fn command(&mut self, command: &NmtCommand<'_>) {
        let may_start = self.poll.had_valid_data || !self.config.options.start_needs_valid_data;
        let cause = Cause::of_command(command.command);
        let cause = cause.filter(|_| command.command.plain() != NmtCommandId::START_NODE || may_start);
        if let Some(reason) = command.reason() {
            self.raise(NodeEvent::ResetReason { command: command.command, reason });
        }
        if !cause.is_some_and(|cause| self.cause(cause)) {
            count(&mut self.counters.commands_ignored);
        }
    }

    fn sdo(&mut self, from: NodeId, sdo: &Sdo<'_>) {
        let segment = usize::from(self.active.async_mtu).saturating_sub(ASND_HEADER);
        let mapped = self.dictionary.mappings.transmit.size();
        let mut objects = Objects { standard: &mut self.dictionary, application: &mut self.objects };
        let received = self.server.receive(from, sdo, segment, &mut objects);
        let Received { connection, is_progress, outcome } = received;
        if let Some(index) = connection.filter(|_| is_progress) {
            self.wait_for_client(index);
        }
        // The inputs are those of the mapping at the last SoC. One that is refused is out of use.
        let is_mapped_anew = matches!(outcome, Outcome::Written(TRANSMIT_MAPPING, _));
        if is_mapped_anew || mapped != self.dictionary.mappings.transmit.size() {
            self.are_inputs_read = false;
        }
        match outcome {
            Outcome::Nothing => {}
            Outcome::Opened => self.raise(NodeEvent::SdoOpened { client: from }),
            Outcome::Closed => self.raise(NodeEvent::SdoClosed { client: from, by_timeout: false }),
            Outcome::Refused => {
                count(&mut self.counters.sdo_refused);
                self.raise(NodeEvent::SdoRefused { client: from });
            }
            Outcome::Ignored => count(&mut self.counters.sdo_ignored),
            Outcome::Written(at, effect) => {
                self.raise(NodeEvent::ObjectWritten(at));
                if let (Effect::Reset(cause), Some(index)) = (effect, connection) {
                    self.reset_after_answer = Some((index, cause));
                }
            }
            Outcome::Aborted(command, code) => self.raise(NodeEvent::SdoAborted { command, code }),
        }
        self.reset_if_answered();
    }

    /// A client that resets the node is answered first; one that closes its connection does not wait for that.
    pub(super) fn reset_if_answered(&mut self) {
        if let Some((index, cause)) = self.reset_after_answer
            && !self.server.is_answering(index)
        {
            self.reset_after_answer = None;
            self.cause(cause);
        }
    }

    pub(super) fn wait_for_client(&mut self, index: usize) {
        let timer = if index == 0 { Timer::Sdo0 } else { Timer::Sdo1 };
        match self.server.patience(index, self.dictionary.values.sequence_timeout) {
            Some(wait) => self.timers.set_after_millis(timer, wait),
            None => self.timers.clear(timer),
        }
    }

    pub(super) fn client_timeout(&mut self, index: usize) {
        if let Some(client) = self.server.expired(index) {
            self.raise(NodeEvent::SdoClosed { client, by_timeout: true });
        }
        self.wait_for_client(index);
        self.reset_if_answered();
    }
}

/// How many entries of the PRes count.
const TRANSMIT_MAPPING: ObjectAddress = ObjectAddress::new(0x1A00, 0);
/// POWERLINK header, ServiceID, sequence layer and command header.
const ASND_HEADER: usize = 3 + 1 + 4 + COMMAND_HEADER;
