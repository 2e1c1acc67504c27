//! Implicit messages: what is consumed, and what is produced.
//!
//! | Attribute 3 | A message on the consumed connection ID | Produced |
//! |---|---|---|
//! | 0x00, 0x10 | there is none | every EPR; 0x10 when the data change too |
//! | 0x02, 0x12 | acknowledges the last message | the same, again if it is not acknowledged |
//! | 0x80 | is consumed | nothing |
//! | 0x82 | is consumed | the data, once for each message |
//! | 0x92 | is consumed | an acknowledge, once for each message |
//!
//! A message of the consumed size is run, an empty one idle; any other length is ignored, and the watchdog goes on. A message
//! of more than eight bytes comes and goes in fragments, none of which is acknowledged. What is produced are the data as they
//! are when the message is handed to the controller; messages that come while an answer still waits for its turn share it.

use cip_core::code::InstanceId;
use cip_core::connection::{IoMode, IoState, TransportClassTrigger, first_time_out};
use cip_core::fragment::{IO_UNFRAGMENTED_LEN, IoOutcome};
use link_core::{Frame, Instant};

use super::application::Application;
use super::doors::{io, set_mode};
use super::event::Ignored;
use super::long::LongMessages;
use super::machine::Device;
use super::slot::{Body, Slot};
use super::timer::{Timer, apply};
use crate::connection::ConnectionId;
use crate::counter::{count, count_wide};
use crate::id::{Identifier, Layout, OperationalAddress};
use crate::message::{ConnectionInstance, IdentifierLength, Predefined};

/// There is no established connection of that number that produces by change of state.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[error("connection {} is not established, or does not produce by change of state", .0.0)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NotProducing(pub InstanceId);

impl<A: Application, const MESSAGE: usize, const CONNECTIONS: usize> Device<A, MESSAGE, CONNECTIONS> {
    /// The data that a connection produces by change of state have changed. They are sent as soon as the production inhibit
    /// time allows it.
    ///
    /// # Errors
    /// If it does not do that.
    pub fn produce(&mut self, now: Instant, instance: InstanceId) -> Result<(), NotProducing> {
        self.advance(now);
        let place = self.place_of(ConnectionInstance::of(instance)).ok_or(NotProducing(instance))?;
        if self.data_changed(place) { Ok(()) } else { Err(NotProducing(instance)) }
    }

    /// The same for all connections that produce by change of state.
    pub fn inputs_changed(&mut self, now: Instant) {
        self.advance(now);
        for place in 0..CONNECTIONS {
            self.data_changed(place);
        }
    }

    fn data_changed(&mut self, place: usize) -> bool {
        let Some(slot) = self.slots.get_mut(place) else { return false };
        let Slot { body: Body::Io(io), timers, line, .. } = slot else { return false };
        let is_in_flight = !line.is_free() || io.continued;
        io.connection.state() == IoState::Established
            && io.production.changed(io.trigger(), timers, is_in_flight)
    }

    pub(super) fn implicit_frame(&mut self, id: Identifier, field: &[u8]) {
        let own = self.access.address();
        let mut is_ours = false;
        for place in 0..CONNECTIONS {
            if self
                .slots
                .get(place)
                .is_some_and(|slot| slot.io_state().is_some() && slot.consumed(own) == Some(id))
            {
                is_ours = true;
                if let Err(why) = self.consume(place, field) {
                    self.ignored(id, why);
                }
            }
        }
        if !is_ours {
            count_wide(&mut self.counters.foreign);
        }
    }

    fn consume(&mut self, place: usize, field: &[u8]) -> Result<(), Ignored> {
        let Some((slot, io)) = io(&mut self.slots, place) else { return Err(Ignored::NoConnection) };
        if io.connection.state() != IoState::Established {
            // The table has a row for it; nothing changes.
            #[cfg(test)]
            super::tests::edges::record_message(io.connection.state());
            let _ = io.connection.message();
            return Err(Ignored::NoConnection);
        }
        if !io.trigger().is_server() {
            // An acknowledge; what it carries nobody asked for.
            io.production.acknowledged(slot.timers);
            self.alive(place);
            return Ok(());
        }
        let (connection, size) = (slot.connection, self.application.consumed(slot.connection).len());
        let message = if size <= IO_UNFRAGMENTED_LEN {
            field
        } else {
            match io.long.receive(field) {
                Some(IoOutcome::Complete(message)) => message,
                Some(IoOutcome::Stored) => return Ok(()),
                Some(IoOutcome::TooLong) | None => return Err(Ignored::Length),
                Some(
                    IoOutcome::OutOfSequence { .. }
                    | IoOutcome::IgnoredNoFirst
                    | IoOutcome::InvalidFirst { .. }
                    | IoOutcome::UnexpectedAcknowledge,
                ) => return Err(Ignored::FragmentOrder),
            }
        };
        let mode = match message.len() {
            // Where no data are expected, none are no sign of idleness.
            len if len == size => IoMode::Run,
            0 => IoMode::Idle,
            _ => return Err(Ignored::Length),
        };
        if mode == IoMode::Run {
            self.application.consumed(connection).copy_from_slice(message);
            slot.news.received = Some(connection);
        }
        set_mode(slot.news, connection, io, mode);
        if io.produces() && !io.production.want() {
            count(&mut self.counters.merged);
        }
        self.alive(place);
        Ok(())
    }

    /// A message was consumed: the watchdog runs anew.
    fn alive(&mut self, place: usize) {
        count_wide(&mut self.counters.consumed);
        if let Some((slot, io)) = io(&mut self.slots, place) {
            #[cfg(test)]
            super::tests::edges::record_message(io.connection.state());
            let watchdog = io.connection.message();
            apply(slot.timers, io.connection.settings(), watchdog);
        }
    }

    /// The next frame of an I/O connection.
    pub(super) fn implicit_message(&mut self, place: usize, id: Identifier) -> Option<Frame> {
        let (slot, io) = io(&mut self.slots, place)?;
        if core::mem::take(&mut io.continued)
            && let Some(field) = io.long.field()
        {
            return id.frame(&field);
        }
        io.production.begin();
        if io.only_acknowledges() {
            return id.frame(&[]);
        }
        let data = self.application.produced(slot.connection);
        if usize::from(self.application.produced_size(slot.connection)) > IO_UNFRAGMENTED_LEN {
            io.long.load(data);
            return id.frame(&io.long.field().unwrap_or_default());
        }
        // Data that are longer than their size are none.
        id.frame(data).or_else(|| id.frame(&[]))
    }

    /// A frame of an I/O connection is with the controller no longer.
    pub(super) fn implicit_done(&mut self, place: usize, sent: bool) {
        let acknowledge = self.acknowledge;
        let Some((slot, io)) = io(&mut self.slots, place) else { return };
        // The rest of a message whose beginning is lost is of no use.
        if sent && io.long.advance() {
            io.continued = true;
            return;
        }
        io.long.unload();
        if sent {
            count_wide(&mut self.counters.produced);
        }
        if io.connection.state() == IoState::Established {
            let (trigger, settings) = (io.trigger(), io.connection.settings());
            io.production.sent(trigger, settings, &acknowledge, slot.timers);
        }
    }

    /// Attribute 3: what the connection does.
    pub(super) fn set_trigger(&mut self, place: usize, kind: TransportClassTrigger) {
        let Some((slot, io)) = io(&mut self.slots, place) else { return };
        io.connection.promote(kind);
        io.production.acknowledged(slot.timers);
        self.expect_first(place);
    }

    /// Attribute 5: whose data the connection consumes. By [`ConnectionId::NONE`] it is as by default; false for an identifier
    /// that it cannot consume.
    pub(super) fn set_consumed(&mut self, place: usize, id: ConnectionId) -> bool {
        let own = self.access.address();
        let Some((slot, io)) = io(&mut self.slots, place) else { return false };
        let identifier = match (id, id.identifier()) {
            (ConnectionId::NONE, _) => None,
            (_, Some(identifier)) if can_consume(slot.connection, io.trigger(), identifier, own) => {
                Some(identifier)
            }
            (_, Some(_) | None) => return false,
        };
        io.told_to_consume = identifier;
        io.long.discard();
        self.expect_first(place);
        true
    }

    /// An established connection consumes something else, or begins to: that has as long for its first message as it has when
    /// a connection is established.
    fn expect_first(&mut self, place: usize) {
        self.filter_changed = true;
        let Some((slot, io)) = io(&mut self.slots, place) else { return };
        if io.connection.state() != IoState::Established {
            return;
        }
        let settings = io.connection.settings();
        let wait = first_time_out(settings.expected_packet_rate(), settings.multiplier());
        match wait.filter(|_| io.consumes()) {
            Some(millis) => slot.timers.set_after_millis(Timer::Watchdog, millis),
            None => slot.timers.clear(Timer::Watchdog),
        }
    }
}

/// Whether what has the identifier is another node's, of the length that the connection has, and data or acknowledges as it
/// consumes them.
fn can_consume(
    connection: ConnectionInstance,
    trigger: TransportClassTrigger,
    identifier: Identifier,
    own: OperationalAddress,
) -> bool {
    let (source, length) = match identifier.layout() {
        Layout::Implicit { source, acknowledge, .. } if acknowledge != trigger.is_server() => {
            (source, IdentifierLength::Extended)
        }
        Layout::Standard { source, .. } => (source, IdentifierLength::Standard),
        _ => return false,
    };
    let fits = match connection {
        ConnectionInstance::Predefined(Predefined::Implicit(_, own)) => own == length,
        ConnectionInstance::Dynamic(_) => true,
        ConnectionInstance::Predefined(Predefined::Explicit) | ConnectionInstance::Reserved(_) => false,
    };
    fits && !source.is_none() && source != own
}
