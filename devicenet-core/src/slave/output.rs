//! What a slave sends and tells. It follows from its state; nothing but the answers of the unconnected ports is queued.

use cip_core::message::AllocationChoice;
use link_core::{Action, Frame, Instant, LinkCommand, Mode, TxToken};

use super::application::{Application, IoKind, Parts};
use super::departure::has_rates;
use super::dynamic;
use super::event::{Event, SlaveEvent};
use super::indicator::ModuleStatus;
use super::lines::{self, Line, Sent};
use super::machine::{Errand, Needed, Slave};
use super::node::Changed;
use super::transfer::Piece;
use super::unconnected::UnconnectedPort;
use crate::access::NetworkStatus;
use crate::id::{Identifier, MessageGroup};

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Slave<A, MESSAGE, DYNAMIC> {
    /// The next thing to do: I/O, then what the controller must be told, then other frames in the order of their
    /// identifiers, then events.
    pub(super) fn output(&mut self, now: Instant) -> Option<Action<Event>> {
        if DYNAMIC > 0
            && let Some(action) = self.send_dynamic(MessageGroup::Group1)
        {
            return Some(action);
        }
        match self.node.lines.ready::<A>() {
            Some(kind) => self.send_io(kind),
            None if A::PARTS.contains(Parts::FAST_WAYS) => self.output_besides_io(now),
            None => self.output_by_turns(now),
        }
    }

    /// A response in one frame if nothing goes before it, else what comes next.
    #[inline(never)]
    fn output_besides_io(&mut self, now: Instant) -> Option<Action<Event>> {
        debug_assert!(self.may_have_errand() || !self.has_errand(), "what an errand follows from is marked");
        if self.errand == Errand::None
            && self.answers.is_empty()
            && self.node.lines.is_free(Line::EXPLICIT)
            && let Some(frame) =
                self.explicit.take_whole(Identifier::explicit_response(self.node.access.mac_id()))
        {
            return Some(self.explicit_action(Sent::Piece(Piece::Response), frame));
        }
        self.output_by_turns(now)
    }

    #[inline(never)]
    fn output_by_turns(&mut self, now: Instant) -> Option<Action<Event>> {
        self.node.advance_inline(now);
        if self.may_have_errand() {
            if let Some(action) = self.manage() {
                return Some(action);
            }
            self.errand = Errand::None;
        }
        // Without fast ways it is not asked beforehand whether there is something to send: less code.
        let may_send = if A::PARTS.contains(Parts::FAST_WAYS) {
            self.is_explicit_ready()
        } else {
            self.node.lines.is_free(Line::EXPLICIT)
        };
        if may_send && let Some(action) = self.send_explicit() {
            return Some(action);
        }
        self.other_output()
    }

    /// What is less urgent than a response.
    #[inline(never)]
    fn other_output(&mut self) -> Option<Action<Event>> {
        if DYNAMIC > 0
            && let Some(action) = self.send_dynamic(MessageGroup::Group2)
        {
            return Some(action);
        }
        if let Some(action) = self.node.access.transmit::<Needed<A>, _>() {
            return Some(action);
        }
        if DYNAMIC > 0
            && let Some(action) = self.send_dynamic(MessageGroup::Group3).or_else(|| self.send_on_ucmm())
        {
            return Some(action);
        }
        let told = self.tell();
        if told.is_none() {
            self.pending = false;
        }
        told.map(|event| Action::Event(Event::Slave(event)))
    }

    /// Whether [`manage`](Self::manage) has something to do.
    fn has_errand(&self) -> bool {
        self.node.lines.must_withdraw()
            || self.must_set_mode()
            || self.must_set_filter()
            || self.node.access.has_output_except_transmit::<Needed<A>>()
    }

    /// What the controller must be told, and what network access tells.
    fn manage(&mut self) -> Option<Action<Event>> {
        if let Some(token) = self.withdraw() {
            return Some(Action::Withdraw(token));
        }
        if self.must_set_mode() {
            self.errand = Errand::Perhaps;
            let listen_only = self.detection.listens();
            return Some(Action::Link(LinkCommand::SetMode(Mode {
                bit_rate: self.node.port.active,
                listen_only,
            })));
        }
        if let Some(action) = self.node.access.command() {
            return Some(action);
        }
        if self.node.access.take_filter_change::<Needed<A>>() || self.must_set_filter() {
            self.node.changed.remove(Changed::FILTER);
            // On line the filter is the slave's; what network access alone would hear is not enough.
            let filter = if self.node.access.is_online() {
                self.filter()
            } else {
                self.node.access.filter_within::<Needed<A>>()
            };
            return Some(Action::Link(LinkCommand::SetFilter(filter)));
        }
        self.node.access.news::<Needed<A>>().map(|told| Action::Event(Event::Access(told)))
    }

    /// Whether there is something to fetch. What does without [`Parts::FAST_WAYS`] does not ask each that could have
    /// something: there may be, until it was looked for to the end after an input or a command.
    pub(crate) fn has_output(&self) -> bool {
        if !A::PARTS.contains(Parts::FAST_WAYS) {
            return self.pending;
        }
        let lines = &self.node.lines;
        lines.ready::<A>().is_some()
            || (self.errand != Errand::None && self.has_errand())
            || self.node.access.wants_to_transmit::<Needed<A>>()
            || !self.node.events.is_empty::<A>(self.node.received)
            || (A::PARTS.contains(Parts::INDICATOR_EVENTS)
                && (self.shown != self.network_status() || self.module != self.module_status()))
            || self.is_explicit_ready()
            || (DYNAMIC > 0 && (self.is_dynamic_due() || (lines.is_free(Line::UCMM) && self.is_ucmm_due())))
    }

    fn send_io(&mut self, kind: IoKind) -> Option<Action<Event>> {
        self.node.lines.begin::<A>(kind);
        let line = lines::of(kind);
        let id = lines::identifier::<A>(line, self.node.access.mac_id());
        Some(Action::Transmit(lines::token(line), self.produce(kind, id)?))
    }

    fn withdraw(&mut self) -> Option<TxToken> {
        if let Some(token) = self.node.lines.withdraw() {
            return Some(token);
        }
        for (index, dynamic) in dynamic::indices::<DYNAMIC>().zip(&mut self.transfers) {
            if core::mem::take(&mut dynamic.unwanted) {
                return Some(lines::dynamic_token(index));
            }
        }
        None
    }

    fn must_set_mode(&self) -> bool {
        has_rates::<A>() && self.errand == Errand::Mode
    }

    fn must_set_filter(&self) -> bool {
        self.node.changed.contains(Changed::FILTER)
    }

    /// What the slave needs to hear on line.
    pub(crate) fn filter(&self) -> link_core::FilterSet {
        let mac = self.node.access.mac_id();
        let held = self.node.held.intersection(A::IO);
        let strobe = self.node.master.filter(|_| held.contains(AllocationChoice::BIT_STROBE));
        let group = held.contains(AllocationChoice::MULTICAST_POLL).then_some(self.node.group);
        if DYNAMIC == 0 {
            return crate::id::group2_only_server(mac, strobe, group);
        }
        let mut filters = crate::id::group2_server(mac, strobe, group);
        for dynamic in self.node.dynamic.iter().filter(|dynamic| dynamic.is_open()) {
            if let Some(id) = dynamic.consumed(mac) {
                filters.add(link_core::Filter::exact(link_core::StandardId::from(id)));
            }
        }
        filters
    }

    /// The next event: what was raised, then indicators that show something else.
    fn tell(&mut self) -> Option<SlaveEvent> {
        if let Some(event) = self.node.events.pop::<A>(&mut self.node.received) {
            return Some(event);
        }
        if !A::PARTS.contains(Parts::INDICATOR_EVENTS) {
            return None;
        }
        let network = self.network_status();
        if core::mem::replace(&mut self.shown, network) != network {
            return Some(SlaveEvent::NetworkStatus(network));
        }
        let module = self.module_status();
        (core::mem::replace(&mut self.module, module) != module).then_some(SlaveEvent::ModuleStatus(module))
    }

    /// What the network status indicator shows.
    #[must_use]
    pub fn network_status(&self) -> NetworkStatus {
        if !self.node.access.is_online() {
            return self.node.access.network_status();
        }
        if self.node.is_io_timed_out() {
            return NetworkStatus::FlashingRed;
        }
        if self.node.master.is_some() || (DYNAMIC > 0 && self.node.is_any_open()) {
            return NetworkStatus::SolidGreen;
        }
        NetworkStatus::FlashingGreen
    }

    /// What the module status indicator shows. A device without the state attribute is operational.
    #[must_use]
    pub fn module_status(&self) -> ModuleStatus {
        let identity = self.node.application.identity();
        let state = identity.state.unwrap_or(cip_core::identity::DeviceState::OPERATIONAL);
        ModuleStatus::of(state, identity.status)
    }

    /// Whether the line of the explicit connection is free, and something is to be sent on it.
    fn is_explicit_ready(&self) -> bool {
        self.node.lines.is_free(Line::EXPLICIT)
            && (self.explicit.is_due()
                || self.is_answer_due(UnconnectedPort::Group2)
                || (DYNAMIC == 0 && self.is_broadcast_due()))
    }

    /// The line that carries the explicit connection, the unconnected port, and without the UCMM the broadcasts.
    fn send_explicit(&mut self) -> Option<Action<Event>> {
        let mut frame = Identifier::explicit_response(self.node.access.mac_id()).empty_frame();
        let sent = self.write_explicit(&mut frame)?;
        Some(self.explicit_action(sent, frame))
    }

    #[inline]
    fn explicit_action(&mut self, sent: Sent, frame: Frame) -> Action<Event> {
        self.node.lines.in_flight.insert(Line::EXPLICIT);
        self.node.lines.explicit = Some(sent);
        Action::Transmit(lines::token(Line::EXPLICIT), frame)
    }

    /// Acknowledges of fragments first, so that they precede the response.
    fn write_explicit(&mut self, frame: &mut Frame) -> Option<Sent> {
        if !self.explicit.must_acknowledge() {
            if DYNAMIC == 0 {
                // All answers wait for this line.
                if let Some(answer) = self.answers.first() {
                    frame.append(answer.field())?;
                    self.answers.drop_first();
                    return Some(Sent::Unconnected);
                }
            } else if let Some(answer) = self.take_answer(UnconnectedPort::Group2) {
                frame.append(answer.field())?;
                return Some(Sent::Unconnected);
            }
        }
        if self.explicit.is_due() {
            return Some(Sent::Piece(self.explicit.write(frame)?));
        }
        let (sent, field) = if DYNAMIC == 0 { self.take_broadcast()? } else { return None };
        frame.append(&field)?;
        Some(sent)
    }

    /// A frame of the explicit line, or of that of the UCMM, is with the controller no longer.
    pub(super) fn explicit_done(&mut self, line: Line) {
        let sent = if DYNAMIC > 0 && line == Line::UCMM {
            self.node.lines.ucmm.take()
        } else {
            self.node.lines.explicit.take()
        };
        match sent {
            Some(Sent::Piece(piece)) => self.explicit.handed(&mut self.node.timers, piece),
            Some(Sent::Shutdown) if A::PARTS.contains(Parts::SHUTDOWN_MESSAGE) => self.leave(),
            Some(Sent::Shutdown | Sent::Unconnected | Sent::Heartbeat) | None => {}
        }
    }
}
