//! The connection request server.
//!
//! | Request | Answer |
//! |---|---|
//! | from OA 127 | none **\[P\]** |
//! | shorter than two bytes, or three to six | 0x13, not enough data **\[D\]** |
//! | longer than seven bytes | 0x15, too much data **\[D\]** |
//! | another service than 0x4B | 0x08, service not supported |
//! | two bytes with P, or P does not fit the instance **\[D\]** | 0x20, invalid parameter |
//! | a reserved instance, or one that the device does not offer **\[D\]** | 0x05, path destination unknown |
//! | a group that is reserved or that the connection cannot be in, a Message ID that the group does not have **\[D\]** | 0x20 |
//! | an expected packet rate or a watchdog action that the connection cannot have **\[D\]** | 0x20 |
//! | a connection that another node has asked for, unless that one timed out **\[D\]** | 0x0C, object state conflict |
//! | no room, or with 11 bits no Message ID left to produce with **\[D\]** | 0x02, resource unavailable |
//!
//! Errors are `94 general additional`, with 0xFF for no additional code. A request from whoever asked for the connection before is
//! granted, and the connection begins anew: the response may have been lost, or the requester's memory of it. A broadcast or
//! multicast connection that produces already is everybody's: the request changes nothing, and is answered with where and how often it
//! produces **\[D\]**.

use cip_core::code::GeneralStatus;
use cip_core::codec::{Wire, Writer};
use cip_core::connection::{
    ExplicitCause, ExplicitConnection, IoCause, IoConnection, IoMode, IoState, Production,
    TransportClassTrigger, WatchdogAction,
};
use link_core::Frame;

use super::application::Application;
use super::event::{DeviceEvent, Ignored};
use super::machine::Device;
use super::slot::{Body, Explicit, Io, Pipe, Reply, Slot};
use crate::connection::{DYNAMIC_TRIGGER, GroupMessage};
use crate::counter::count;
use crate::id::{Direction, Identifier, OperationalAddress, Route};
use crate::message::{
    ConnectionInstance, ConnectionRequest, ConnectionResponse, ErrorResponse, FormatByte, Granted,
    GroupSelect, IdentifierLength, Predefined, Production as Kind, Target,
};

/// What a request that can be read asks for.
#[derive(Clone, Copy)]
struct Wish {
    requester: OperationalAddress,
    connection: ConnectionInstance,
    at: GroupMessage,
    target: Option<Target>,
}

impl<A: Application, const MESSAGE: usize, const CONNECTIONS: usize> Device<A, MESSAGE, CONNECTIONS> {
    pub(super) fn connection_request(
        &mut self,
        route: Route,
        transaction: u8,
        field: &[u8],
    ) -> Result<(), Ignored> {
        self.check_room()?;
        let requester = route.source;
        let request = ConnectionRequest::parse(field);
        let named = request.as_ref().ok().and_then(|request| request.target);
        let granted = request
            .map_err(|error| ConnectionRequest::status_of(&error))
            .and_then(|request| self.wish(requester, &request))
            .and_then(|wish| self.grant(wish));
        let mut field = [0; Frame::MAX_DATA];
        let mut out = Writer::new(&mut field);
        // There is room for five bytes, and for three.
        let _ = match granted {
            Ok(response) => {
                count(&mut self.counters.connections);
                response.emit(&mut out)
            }
            Err(status) => {
                count(&mut self.counters.connections_refused);
                let connection = named.map(|target| ConnectionInstance::of(target.instance));
                self.raise(DeviceEvent::Refused { requester, connection, status });
                ErrorResponse::new(status).emit(&mut out)
            }
        };
        let back =
            Route { destination: requester, direction: Direction::Response, source: route.destination };
        self.answer(Identifier::connection(back, transaction), out.written());
        Ok(())
    }

    /// What the request asks for, if it is one that this device could grant at some time.
    fn wish(
        &self,
        requester: OperationalAddress,
        request: &ConnectionRequest,
    ) -> Result<Wish, GeneralStatus> {
        if let Some(status) = request.refusal() {
            return Err(status);
        }
        let at = GroupMessage::new(request.group, request.source_message).map_err(|_| INVALID)?;
        let connection = match request.target {
            Some(target) => ConnectionInstance::of(target.instance),
            None => self.next_dynamic().ok_or(GeneralStatus::RESOURCE_UNAVAILABLE)?,
        };
        let is_explicit = request.group == GroupSelect::EXPLICIT_29;
        let is_offered = match connection {
            ConnectionInstance::Dynamic(_) if is_explicit => true,
            connection => self.application.offered().has(connection),
        };
        if !is_offered {
            return Err(GeneralStatus::PATH_DESTINATION_UNKNOWN);
        }
        let fits = match connection {
            ConnectionInstance::Predefined(Predefined::Explicit) => is_explicit,
            ConnectionInstance::Predefined(Predefined::Implicit(_, IdentifierLength::Extended)) => {
                request.group == GroupSelect::IMPLICIT_29
            }
            ConnectionInstance::Predefined(Predefined::Implicit(_, IdentifierLength::Standard)) => {
                request.group.standard().is_some()
            }
            ConnectionInstance::Dynamic(_) | ConnectionInstance::Reserved(_) => true,
        };
        if !fits || !self.allows(request.target, is_explicit) {
            return Err(INVALID);
        }
        Ok(Wish { requester, connection, at, target: request.target })
    }

    /// Whether a connection can have such a rate and such an action.
    fn allows(&self, target: Option<Target>, is_explicit: bool) -> bool {
        let Some(target) = target else { return true };
        let action = target.watchdog_action;
        let is_known = if is_explicit {
            matches!(action, WatchdogAction::AUTO_DELETE | WatchdogAction::DEFERRED_DELETE)
        } else {
            matches!(
                action,
                WatchdogAction::TRANSITION_TO_TIMED_OUT
                    | WatchdogAction::AUTO_DELETE
                    | WatchdogAction::AUTO_RESET
            )
        };
        is_known && self.settings.resolution.round_up(target.expected_packet_rate).is_some()
    }

    fn grant(&mut self, wish: Wish) -> Result<ConnectionResponse, GeneralStatus> {
        let is_explicit = wish.at.select() == GroupSelect::EXPLICIT_29;
        let own = self.own_message(&wish, is_explicit)?;
        if let Some(slot) = self.place_of(wish.connection).and_then(|place| self.slots.get(place))
            && slot.requester != wish.requester
            && slot.io_state() != Some(IoState::TimedOut)
        {
            return shared(slot).ok_or(GeneralStatus::OBJECT_STATE_CONFLICT);
        }
        let place = self.make_room(&wish, is_explicit).ok_or(GeneralStatus::RESOURCE_UNAVAILABLE)?;
        if is_explicit {
            self.open_explicit(place, &wish, own);
        } else {
            self.open_io(place, &wish, own);
        }
        let slot = self.slots.get(place).ok_or(GeneralStatus::RESOURCE_UNAVAILABLE)?;
        Ok(response(slot, own, if is_explicit { self.settings.body_format.into() } else { FormatByte(0) }))
    }

    /// Where the connection produces: as the requester, unless another connection does already with 11 bits.
    fn own_message(&self, wish: &Wish, is_explicit: bool) -> Result<GroupMessage, GeneralStatus> {
        if is_explicit || !can_produce(wish.connection) || wish.at.select().standard().is_none() {
            return Ok(wish.at);
        }
        let is_used = |at: &GroupMessage| {
            self.slots.iter().any(|slot| match &slot.body {
                Body::Io(io) => {
                    io.own == *at && slot.connection() != wish.connection && can_produce(slot.connection())
                }
                Body::Free | Body::Explicit(_) => false,
            })
        };
        wish.at.alternatives().find(|at| !is_used(at)).ok_or(GeneralStatus::RESOURCE_UNAVAILABLE)
    }

    fn open_explicit(&mut self, place: usize, wish: &Wish, own: GroupMessage) {
        self.tell_of_ended(place);
        let Some(slot) = self.slots.get_mut(place) else { return };
        let fresh = Explicit {
            connection: ExplicitConnection::NON_EXISTENT,
            request: wish.at.message(),
            response: own.message(),
            transaction: 0,
            transfer: Pipe::new(MESSAGE, Reply::NOBODY),
        };
        match &mut slot.body {
            Body::Explicit(explicit) => {
                let connection = explicit.connection.clone();
                *explicit = Explicit { connection, ..fresh };
                slot.line.abandon(false);
                slot.timers.clear_all();
            }
            Body::Free | Body::Io(_) => slot.body = Body::Explicit(fresh),
        }
        (slot.instance, slot.requester) = (number(wish.connection), wish.requester);
        if slot.is_open() {
            // It begins anew.
            let _ = self.explicit_step(place, ExplicitCause::Released);
        }
        let _ = self.explicit_step(place, ExplicitCause::Opened);
        if let Some(target) = wish.target {
            let _ = self.explicit_packet_rate(place, target.expected_packet_rate);
            if let Some(Body::Explicit(explicit)) = self.slots.get_mut(place).map(|slot| &mut slot.body) {
                let _ = explicit.connection.set_watchdog_action(target.watchdog_action);
            }
        }
    }

    fn open_io(&mut self, place: usize, wish: &Wish, own: GroupMessage) {
        let kind = self.trigger_of(wish.connection);
        self.tell_of_ended(place);
        let Some(slot) = self.slots.get_mut(place) else { return };
        (slot.instance, slot.requester) = (number(wish.connection), wish.requester);
        let connection = match &slot.body {
            Body::Io(io) => io.connection.clone(),
            Body::Free | Body::Explicit(_) => IoConnection::non_existent(kind),
        };
        slot.line.abandon(false);
        slot.body = Body::Io(Io {
            connection,
            peer: wish.at,
            own,
            told_to_consume: None,
            production: Production::IDLE,
            continued: false,
            mode: IoMode::Inactive,
            long: A::Long::default(),
        });
        self.allocate_io(place, kind);
        let Some(target) = wish.target else { return };
        if let Some(Body::Io(io)) = self.slots.get_mut(place).map(|slot| &mut slot.body) {
            let _ = io.connection.set_watchdog_action(target.watchdog_action);
        }
        // It was checked that the rate fits.
        let _ = self.io_packet_rate(place, target.expected_packet_rate);
    }

    /// Before a connection begins, what is still to be told of those that have ended: it may have the number of one, and the place
    /// of another.
    fn tell_of_ended(&mut self, place: usize) {
        for ended in 0..CONNECTIONS {
            let Some(slot) = self.slots.get_mut(ended) else { return };
            if slot.is_open() && ended != place {
                continue;
            }
            let mut news = core::mem::take(&mut slot.news);
            while let Some(event) = news.take() {
                self.raise(event);
            }
        }
    }

    fn trigger_of(&self, connection: ConnectionInstance) -> TransportClassTrigger {
        let ConnectionInstance::Predefined(predefined) = connection else { return DYNAMIC_TRIGGER };
        let trigger = predefined.transport_class_trigger();
        match connection.allowed_triggers() {
            [without, _] if !self.settings.acknowledged => *without,
            _ => trigger,
        }
    }

    /// The connection of that number, if it exists.
    pub(super) fn place_of(&self, connection: ConnectionInstance) -> Option<usize> {
        self.slots.iter().position(|slot| slot.is_open() && slot.connection() == connection)
    }

    /// Where the connection can be: where it is already, or at a free place. What it takes the place of ends: an explicit
    /// connection with the same identifiers, or one of the same number that was for other messages.
    fn make_room(&mut self, wish: &Wish, is_explicit: bool) -> Option<usize> {
        let (mut own, mut left) = (None, None);
        for place in 0..CONNECTIONS {
            let slot = self.slots.get(place).filter(|slot| slot.is_open());
            let Some(slot) = slot else { continue };
            let is_same = slot.connection() == wish.connection;
            let (is_alike, has_its_identifiers) = match &slot.body {
                Body::Explicit(explicit) => {
                    let is_theirs = slot.requester == wish.requester && explicit.request == wish.at.message();
                    (is_explicit, is_explicit && is_theirs)
                }
                Body::Io(_) | Body::Free => (!is_explicit, false),
            };
            if is_same && is_alike {
                own = Some(place);
            } else if is_same || has_its_identifiers {
                // One of them is it; the other changes nothing.
                let _ = self.io_step(place, IoCause::Released);
                let _ = self.explicit_step(place, ExplicitCause::Released);
                left = Some(place);
            }
        }
        own.or_else(|| self.slots.iter().position(Slot::is_free)).or(left)
    }

    fn next_dynamic(&self) -> Option<ConnectionInstance> {
        let numbers = (FIRST_DYNAMIC..=u8::MAX).map(ConnectionInstance::Dynamic);
        numbers.into_iter().find(|&connection| self.place_of(connection).is_none())
    }
}

/// Whether the connection may need a Message ID of its own: a dynamic one may, whatever it does at present.
const fn can_produce(connection: ConnectionInstance) -> bool {
    !matches!(connection, ConnectionInstance::Predefined(Predefined::Implicit(Kind::MulticastConsumer, _)))
}

/// The answer for a connection that produces to everybody already.
fn shared<L, const MESSAGE: usize>(slot: &Slot<L, MESSAGE>) -> Option<ConnectionResponse> {
    let ConnectionInstance::Predefined(Predefined::Implicit(Kind::Broadcast | Kind::MulticastProducer, _)) =
        slot.connection()
    else {
        return None;
    };
    let Body::Io(io) = &slot.body else { return None };
    (io.connection.state() == IoState::Established).then(|| response(slot, io.own, FormatByte(0)))
}

fn response<L, const MESSAGE: usize>(
    slot: &Slot<L, MESSAGE>,
    own: GroupMessage,
    body_format: FormatByte,
) -> ConnectionResponse {
    let granted = match slot.connection() {
        ConnectionInstance::Predefined(_) => Granted::Predefined {
            expected_packet_rate: slot.settings().map_or(0, |settings| settings.expected_packet_rate()),
        },
        ConnectionInstance::Dynamic(_) | ConnectionInstance::Reserved(_) => {
            Granted::Dynamic { instance: slot.id() }
        }
    };
    ConnectionResponse { group: own.select(), source_message: own.message(), body_format, granted }
}

fn number(connection: ConnectionInstance) -> u8 {
    let [low, _] = connection.number().0.to_le_bytes();
    low
}

const INVALID: GeneralStatus = GeneralStatus::INVALID_PARAMETER;
const FIRST_DYNAMIC: u8 = 128;
