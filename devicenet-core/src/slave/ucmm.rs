//! The Unconnected Message Manager: clients open and close explicit connections.
//!
//! Requests come on 0x780 + client with this node's MAC ID in the header, answers go out on 0x740 + s.
//!
//! | Condition | General / additional |
//! |---|---|
//! | fragment, response, or shorter than its service | ignored |
//! | service other than 0x4B and 0x4C | 0x08 / 0xFF |
//! | shorter than 4 bytes; longer | 0x13 / 0xFF; 0x15 / 0xFF |
//! | Open: node ping (group 15) | success with instance 0, nothing is opened |
//! | Open: reserved group, or a source Message ID above 4 in group 3 | 0x20 / 0xFF |
//! | Open: no free connection | 0x02 / 0xFF |
//! | Open: no free Message ID in group 2, 1 or 3 | 0x02 / 0x01, 0x03 or 0x04 |
//! | Close: no such connection | 0x16 / 0xFF |
//! | Close: a connection of the predefined set, or of another client | 0x0C / 0xFF |
//!
//! A reserved body format is answered with 8/8. A client that opens a connection with the Message ID of one that it has
//! open already has forgotten that one: it is closed. Source: CIP Vol. 3, UCMM.

use cip_core::code::{AdditionalCode, GeneralStatus, ServiceCode};
use cip_core::codec::Writer;
use cip_core::connection::{ExplicitCause, ExplicitState, IoState};
use cip_core::message::BodyFormat;
use cip_core::object::{Failure, exact};
use link_core::{Action, TxOutcome, TxToken};

use super::allocation::{Door, Requester};
use super::application::{Application, IoKind};
use super::config::Options;
use super::dynamic::{Dynamic, FIRST_INSTANCE, Group, indices, instance};
use super::event::{Event, Ignored, count};
use super::lines::{self, Line, Sent};
use super::machine::{DynamicTransfer, Slave};
use super::node::Changed;
use super::unconnected::{UnconnectedPort, complete_request};
use crate::id::{Identifier, MacId, MessageGroup};
use crate::message::{ExplicitHeader, GroupSelect};

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Slave<A, MESSAGE, DYNAMIC> {
    /// Whether a connection that was opened dynamically has its requests there.
    pub(super) fn is_dynamic(&self, id: Identifier) -> bool {
        DYNAMIC > 0 && self.dynamic_of(id).is_some()
    }

    fn dynamic_of(&self, id: Identifier) -> Option<u8> {
        let own = self.node.access.mac_id();
        let at = self.node.dynamic.iter().position(|one| one.is_open() && one.consumed(own) == Some(id))?;
        u8::try_from(at).ok()
    }

    /// A frame that is not for the predefined set.
    #[inline(never)]
    pub(super) fn dynamic_frame(&mut self, id: Identifier, field: &[u8]) {
        let result = match self.dynamic_of(id) {
            Some(index) => self.dynamic_message(index, field),
            None if id.group() == MessageGroup::Group3 && id.message_id() == REQUESTS => {
                let own = self.node.access.mac_id();
                match (field.first(), id.mac_id()) {
                    (Some(&byte), Some(client)) if ExplicitHeader::from(byte).mac == own => {
                        self.ucmm_request(client, field)
                    }
                    _ => return self.foreign(),
                }
            }
            None => return self.foreign(),
        };
        if let Err(why) = result {
            self.node.ignored(id, why);
        }
    }

    fn dynamic_message(&mut self, index: u8, field: &[u8]) -> Result<(), Ignored> {
        let own = self.node.access.mac_id();
        let dynamic = self.node.dynamic.get(usize::from(index)).ok_or(Ignored::NoConnection)?;
        let (client, expected) = (dynamic.client, dynamic.expected_header(own));
        let header = field.first().map(|&byte| ExplicitHeader::from(byte)).ok_or(Ignored::TooShort)?;
        if header.mac != expected {
            return Err(Ignored::ForeignNode);
        }
        self.check_departure()?;
        // It is open: nothing is refused.
        let _ = self.node.dynamic_step(index, ExplicitCause::Message);
        let (rules, format) = (self.rules(), self.format_of(index));
        let at = usize::from(index);
        let gone = Ignored::NoConnection;
        let dynamic = self.transfers.get_mut(at).ok_or(gone)?;
        let timers = self.node.dynamic_timers.get_mut(at).ok_or(gone)?;
        let header = ExplicitHeader { mac: client, ..header }.into();
        if !dynamic.transfer.receive(timers, rules, header, field)? {
            return Ok(());
        }
        let (mut server, _, transfers) =
            self.serving(Requester { mac: client, door: Door::Dynamic(index), format });
        let dynamic = transfers.get_mut(at).ok_or(gone)?;
        dynamic.transfer.answer(header, field, |request, out| server.answer(request, out))
    }

    fn ucmm_request(&mut self, client: MacId, field: &[u8]) -> Result<(), Ignored> {
        let (header, body) = complete_request(field)?;
        self.check_room()?;
        let mut field = [0; 6];
        let mut out = Writer::new(&mut field);
        // There is room for it.
        let _ = out.u8(ExplicitHeader { mac: client, ..header.into() }.into());
        let (service, data) = body.split_first().ok_or(Ignored::TooShort)?;
        let done = match ServiceCode(*service) {
            OPEN => self.open(client, data, &mut out),
            CLOSE => self.close(client, data, &mut out),
            _ => Err(GeneralStatus::SERVICE_NOT_SUPPORTED.into()),
        };
        count::<A>(&mut self.node.events.counters.requests);
        if let Err(failure) = done {
            count::<A>(&mut self.node.events.counters.refused);
            out.truncate(1);
            // Three bytes, for which there is room.
            let _ = failure.emit(&mut out);
        }
        let len = out.len();
        self.queue(UnconnectedPort::Ucmm, field, len);
        Ok(())
    }

    fn open(&mut self, client: MacId, data: &[u8], out: &mut Writer<'_>) -> Result<(), Failure> {
        let [format, group_and_source] = exact(data)?;
        let format = BodyFormat::from_code(format & 0x0F).unwrap_or_default();
        let (select, source) = (GroupSelect::new(group_and_source >> 4), group_and_source & 0x0F);
        let group = match select {
            Some(GroupSelect::NODE_PING) => {
                return Ok(out.bytes(&[OPEN.response_byte(), format.code(), 0, 0, 0])?);
            }
            Some(GroupSelect::GROUP_1) => Group::One,
            Some(GroupSelect::GROUP_2) => Group::Two,
            Some(GroupSelect::GROUP_3) if source <= LAST_OF_GROUP_3 => Group::Three,
            _ => return Err(GeneralStatus::INVALID_PARAMETER.into()),
        };
        let mut opened = Dynamic { client, format, group, request: source, ..Dynamic::CLOSED };
        if group != Group::Two {
            let own = self.node.access.mac_id();
            let forgotten = opened.consumed(own).and_then(|id| self.dynamic_of(id));
            if let Some(index) = forgotten {
                let _ = self.node.dynamic_step(index, ExplicitCause::Released);
                self.drop_transfer(index);
                // What hung on it ends now: the new connection may get its place.
                self.node.settle();
                self.node.changed.insert(Changed::CONNECTIONS);
            }
        }
        let index = self
            .node
            .dynamic
            .iter()
            .position(|one| !one.is_open())
            .and_then(|index| u8::try_from(index).ok())
            .ok_or(Failure::new(GeneralStatus::RESOURCE_UNAVAILABLE))?;
        self.assign(&mut opened)?;
        let destination = if group == Group::Two { opened.request } else { 0 };
        let messages = destination << 4 | opened.response;
        out.bytes(&[OPEN.response_byte(), format.code(), messages, instance(index), 0])?;
        if let Some(slot) = self.node.dynamic.get_mut(usize::from(index)) {
            *slot = opened;
        }
        self.drop_transfer(index);
        // It was not open.
        let _ = self.node.dynamic_step(index, ExplicitCause::Opened);
        Ok(())
    }

    /// What a connection that is closed, or opened anew, has left in its buffers.
    fn drop_transfer(&mut self, index: u8) {
        let at = usize::from(index);
        if let (Some(dynamic), Some(timers)) =
            (self.transfers.get_mut(at), self.node.dynamic_timers.get_mut(at))
        {
            dynamic.transfer.clear(timers);
            dynamic.unwanted = dynamic.in_flight;
        }
    }

    /// Message IDs of our own for a new connection.
    fn assign(&self, opened: &mut Dynamic) -> Result<(), Failure> {
        let open = || self.node.dynamic.iter().filter(|one| one.is_open() && one.group == opened.group);
        let (ids, additional) = match opened.group {
            Group::One => (0..=LAST_OF_GROUP_1, AdditionalCode(0x03)),
            Group::Two => (0..=LAST_OF_GROUP_2, AdditionalCode(0x01)),
            Group::Three => (0..=LAST_OF_GROUP_3, AdditionalCode(0x04)),
        };
        let group_2 = opened.group == Group::Two;
        let predefined = if group_2 { self.node.predefined_message_ids() } else { 0 };
        let is_free = |&id: &u8| {
            let used = open().any(|one| one.response == id || (group_2 && one.request == id));
            !used && predefined & 1_u8.checked_shl(id.into()).unwrap_or(0) == 0
        };
        let mut free = ids.filter(is_free);
        let none = || {
            let failure = Failure::new(GeneralStatus::RESOURCE_UNAVAILABLE);
            if self.node.options.contains(Options::UCMM_ADDITIONAL_CODES) {
                failure.with_additional(additional)
            } else {
                failure
            }
        };
        let (request, response) = if group_2 {
            (free.next().ok_or_else(none)?, free.next().ok_or_else(none)?)
        } else {
            (opened.request, free.next().ok_or_else(none)?)
        };
        (opened.request, opened.response) = (request, response);
        Ok(())
    }

    fn close(&mut self, client: MacId, data: &[u8], out: &mut Writer<'_>) -> Result<(), Failure> {
        let number = u16::from_le_bytes(exact(data)?);
        let gone = Failure::new(GeneralStatus::OBJECT_DOES_NOT_EXIST);
        let conflict = Failure::new(GeneralStatus::OBJECT_STATE_CONFLICT);
        if number < FIRST_INSTANCE.into() {
            return Err(if self.is_predefined(number) { conflict } else { gone });
        }
        let index =
            u8::try_from(number).ok().and_then(|number| number.checked_sub(FIRST_INSTANCE)).ok_or(gone)?;
        let dynamic = self.node.dynamic.get(usize::from(index)).filter(|one| one.is_open()).ok_or(gone)?;
        if dynamic.client != client && self.node.options.contains(Options::CLOSE_BY_OWNER_ONLY) {
            return Err(conflict);
        }
        // It is open.
        let _ = self.node.dynamic_step(index, ExplicitCause::Released);
        Ok(out.u8(CLOSE.response_byte())?)
    }

    fn is_predefined(&self, instance: u16) -> bool {
        match IoKind::of_instance(cip_core::code::InstanceId(instance)) {
            Some(kind) => self.node.io(kind).state() != IoState::NonExistent,
            None => instance == 1 && self.node.explicit.state() != ExplicitState::NonExistent,
        }
    }

    pub(super) fn is_ucmm_due(&self) -> bool {
        self.is_broadcast_due() || self.is_answer_due(UnconnectedPort::Ucmm)
    }

    pub(super) fn send_on_ucmm(&mut self) -> Option<Action<Event>> {
        if !self.node.lines.is_free(Line::UCMM) {
            return None;
        }
        let id = Identifier::unconnected_response(self.node.access.mac_id());
        let (sent, frame) = match self.take_answer(UnconnectedPort::Ucmm) {
            Some(answer) => (Sent::Unconnected, id.frame(answer.field())?),
            None => {
                let (sent, field) = self.take_broadcast()?;
                (sent, id.frame(&field)?)
            }
        };
        self.node.lines.in_flight.insert(Line::UCMM);
        self.node.lines.ucmm = Some(sent);
        Some(Action::Transmit(lines::token(Line::UCMM), frame))
    }

    pub(super) fn is_dynamic_due(&self) -> bool {
        self.transfers
            .iter()
            .any(|dynamic| dynamic.unwanted || (!dynamic.in_flight && dynamic.transfer.is_due()))
    }

    /// The next frame of the connections in a group.
    pub(super) fn send_dynamic(&mut self, group: MessageGroup) -> Option<Action<Event>> {
        let own = self.node.access.mac_id();
        let due = |(index, (dynamic, transfer)): (u8, (&Dynamic, &DynamicTransfer<MESSAGE>))| {
            let id = dynamic.produced(own).filter(|id| id.group() == group)?;
            (!transfer.in_flight && transfer.transfer.is_due()).then_some((id, index))
        };
        let (id, index) =
            indices::<DYNAMIC>().zip(self.node.dynamic.iter().zip(&self.transfers)).filter_map(due).min()?;
        let dynamic = self.transfers.get_mut(usize::from(index))?;
        let (piece, frame) = dynamic.transfer.take(id)?;
        (dynamic.in_flight, dynamic.piece) = (true, Some(piece));
        Some(Action::Transmit(lines::dynamic_token(index), frame))
    }

    /// A frame of a connection that was opened dynamically is with the controller no longer.
    pub(super) fn dynamic_done(&mut self, token: TxToken, outcome: TxOutcome) -> Option<()> {
        let index = lines::dynamic_of(token)?;
        let at = usize::from(index);
        let dynamic = self.transfers.get_mut(at).filter(|dynamic| dynamic.in_flight)?;
        (dynamic.in_flight, dynamic.unwanted) = (false, false);
        if let Some(piece) = dynamic.piece.take() {
            dynamic.transfer.handed(self.node.dynamic_timers.get_mut(at)?, piece);
        }
        if matches!(outcome, TxOutcome::Dropped | TxOutcome::Unknown) && self.node.access.is_online() {
            let own = self.node.access.mac_id();
            if let Some(id) = self.node.dynamic.get(usize::from(index)).and_then(|one| one.produced(own)) {
                self.not_sent(id, outcome);
            }
        }
        Some(())
    }
}

const OPEN: ServiceCode = ServiceCode(0x4B);
const CLOSE: ServiceCode = ServiceCode(0x4C);
/// The Message ID of UCMM requests in group 3.
const REQUESTS: u8 = 6;
const LAST_OF_GROUP_1: u8 = 11;
const LAST_OF_GROUP_2: u8 = 5;
const LAST_OF_GROUP_3: u8 = 4;
