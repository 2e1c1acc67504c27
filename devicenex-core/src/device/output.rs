//! What a device sends and tells. It follows from its state; nothing but short answers is queued.

use cip_core::codec::Writer;
use cip_core::transfer::Part;
use link_core::{Action, Filter, FilterSet, Frame, LinkCommand, TxToken};

use super::application::Application;
use super::connectionless::Port;
use super::event::DeviceEvent;
use super::explicit::{framing, write_part};
use super::line::{self, Sent};
use super::machine::Device;
use super::slot::{Body, Slot};
use crate::access::Role;
use crate::id::{self, Direction, Identifier, OperationalAddress, Route};

/// A conversation that has a frame to send.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Speaker {
    Connection(usize),
    Port,
    Answers,
}

impl<A: Application, const MESSAGE: usize, const CONNECTIONS: usize> Device<A, MESSAGE, CONNECTIONS> {
    /// The next thing to do: what the controller must be told, frames in the order of their identifiers, then events.
    pub(super) fn output(&mut self) -> Option<Action<DeviceEvent>> {
        if let Some(token) = self.withdraw() {
            return Some(Action::Withdraw(token));
        }
        // On line the filter is the device's; what network access alone would hear is not enough.
        if self.access.is_online() && (self.access.take_filter_change() || self.filter_changed) {
            self.filter_changed = false;
            return Some(Action::Link(LinkCommand::SetFilter(self.filter())));
        }
        if let Some(action) = self.access.poll_except_transmit() {
            return Some(action.map_event(DeviceEvent::Access));
        }
        if let Some(action) = self.transmit() {
            return Some(action);
        }
        // Hello has the lowest priority.
        if let Some(action) = self.access.transmit() {
            return Some(action.map_event(DeviceEvent::Access));
        }
        self.tell().map(Action::Event)
    }

    pub(super) fn has_output(&self) -> bool {
        (self.filter_changed && self.access.is_online())
            || self.access.has_output()
            || !self.events.is_empty()
            || self.slots.iter().any(|slot| slot.line.must_withdraw() || !slot.news.is_empty())
            || self.port.line.must_withdraw()
            || self.answering.0.must_withdraw()
            || self.speaker().is_some()
    }

    fn withdraw(&mut self) -> Option<TxToken> {
        let place = self.slots.iter_mut().position(|slot| slot.line.take_withdrawal());
        if let Some(place) = place.and_then(|place| u8::try_from(place).ok()) {
            return Some(line::token(place));
        }
        if self.port.line.take_withdrawal() {
            return Some(line::CONNECTIONLESS);
        }
        self.answering.0.take_withdrawal().then_some(line::ANSWERS)
    }

    /// What the node needs to hear on line.
    pub(super) fn filter(&self) -> FilterSet {
        let own = self.access.address();
        let mut filters = match self.access.config().role {
            Role::Device => id::node(own),
            Role::NetworkManager { .. } => id::network_manager(own),
        };
        for slot in self.slots.iter().filter(|slot| slot.io_state().is_some()) {
            if let Some(id) = slot.consumed(own) {
                filters.add(Filter::exact(id.id()));
            }
        }
        filters
    }

    /// The conversation that has the frame of the highest priority.
    fn speaker(&self) -> Option<Speaker> {
        let own = self.access.address();
        let connections = self.slots.iter().enumerate();
        let connections =
            connections.filter_map(|(place, slot)| Some((next_of(slot, own)?, Speaker::Connection(place))));
        let Port { pipe, line, .. } = &self.port;
        let port = pipe.peek().filter(|_| line.is_free()).map(|(reply, part)| {
            (Identifier::connectionless(back(reply.client, own), framing(reply, &part)), Speaker::Port)
        });
        let answer = self.answers.iter().next().filter(|_| self.answering.0.is_free());
        let answer = answer.map(|frame| (Identifier::of_frame(frame), Speaker::Answers));
        let first = connections.chain(port).chain(answer).min_by_key(|(id, speaker)| (id.id(), *speaker));
        first.map(|(_, speaker)| speaker)
    }

    fn transmit(&mut self) -> Option<Action<DeviceEvent>> {
        let own = self.access.address();
        match self.speaker()? {
            Speaker::Connection(place) => self.transmit_of_connection(place),
            Speaker::Port => {
                let (reply, part) = self.port.pipe.take()?;
                let id = Identifier::connectionless(back(reply.client, own), framing(reply, &part));
                self.port.line.begin(sent(&part));
                let frame = frame_of(id, |out| write_part(reply, &part, out))?;
                Some(Action::Transmit(line::CONNECTIONLESS, frame))
            }
            Speaker::Answers => {
                let frame = self.answers.pop()?;
                self.answering.0.begin(Sent::Response);
                self.answering.1 = Some(Identifier::of_frame(&frame));
                Some(Action::Transmit(line::ANSWERS, frame))
            }
        }
    }

    fn transmit_of_connection(&mut self, place: usize) -> Option<Action<DeviceEvent>> {
        let own = self.access.address();
        let token = line::token(u8::try_from(place).ok()?);
        let slot = self.slots.get_mut(place)?;
        let id = next_of(slot, own)?;
        let frame = match &mut slot.body {
            Body::Explicit(explicit) => {
                let (reply, part) = explicit.transfer.take()?;
                slot.line.begin(sent(&part));
                frame_of(id, |out| write_part(reply, &part, out))?
            }
            Body::Io(_) => {
                slot.line.begin(Sent::Implicit);
                self.implicit_message(place, id)?
            }
            Body::Free => return None,
        };
        Some(Action::Transmit(token, frame))
    }

    /// The next event: what was raised, then what connections keep.
    fn tell(&mut self) -> Option<DeviceEvent> {
        self.events.pop().or_else(|| self.slots.iter_mut().find_map(|slot| slot.news.take()))
    }
}

/// The identifier of the next frame of a connection, if it has one to send.
fn next_of<L, const MESSAGE: usize>(slot: &Slot<L, MESSAGE>, own: OperationalAddress) -> Option<Identifier> {
    if !slot.line.is_free() {
        return None;
    }
    match &slot.body {
        Body::Free => None,
        Body::Explicit(explicit) => {
            let (reply, part) = explicit.transfer.peek()?;
            Identifier::explicit(explicit.response, back(reply.client, own), framing(reply, &part))
        }
        Body::Io(io) if io.continued || io.production.is_due() => io.produced(own, slot.id()),
        Body::Io(_) => None,
    }
}

/// To a client.
const fn back(client: OperationalAddress, own: OperationalAddress) -> Route {
    Route { destination: client, direction: Direction::Response, source: own }
}

const fn sent(part: &Part<'_>) -> Sent {
    match part {
        Part::Acknowledge(..) => Sent::Acknowledge,
        Part::Whole(_) | Part::Fragment(_) => Sent::Response,
    }
}

fn frame_of(
    id: Identifier,
    write: impl FnOnce(&mut Writer<'_>) -> Result<(), cip_core::codec::Full>,
) -> Option<Frame> {
    let mut field = [0; Frame::MAX_DATA];
    let mut out = Writer::new(&mut field);
    write(&mut out).ok()?;
    id.frame(out.written())
}
