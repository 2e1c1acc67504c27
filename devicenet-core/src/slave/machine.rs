//! The machine: what it is made of, and where each input goes.

use core::marker::PhantomData;

use cip_core::message::{AllocationChoice, BodyFormat};
use cip_core::transfer::Rules;
use link_core::timers::TimerSet;
use link_core::{Action, Deadline, Frame, Input, Instant, LinkEvent, Machine, Queue, TxOutcome, TxToken};

use super::application::{Application, IoKind, Parts};
use super::config::{Options, RECEIVE_TIME_OUT_MILLIS};
use super::detection::Detection;
use super::devicenet_object::Switches;
use super::event::{Counters, Event, SlaveEvent, count, count_wide};
use super::indicator::ModuleStatus;
use super::lines::{self, Line};
use super::node::Node;
use super::timer::Timer;
use super::transfer::{Piece, Transfer};
use super::unconnected::Answer;
use crate::access::{Access, Extent, NetworkStatus};
use crate::id::Identifier;

/// A slave; see the [module](super) text.
///
/// `MESSAGE` is the longest explicit message, from the service byte on. The product name takes two bytes more than it has
/// characters; an attribute that has no room is answered with error 0x11. `DYNAMIC` is how many explicit connections
/// clients can open through the UCMM; with 0 it is a [`Group2OnlyServer`].
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
// In this order the code is shortest, as in `Node`.
#[repr(C)]
pub struct Slave<A: Application, const MESSAGE: usize, const DYNAMIC: usize> {
    pub(super) errand: Errand,
    pub(super) online: bool,
    /// What may have followed from the last input has not been fetched to its end. Not kept with [`Parts::FAST_WAYS`].
    pub(super) pending: bool,
    pub(super) shown: NetworkStatus,
    pub(super) module: ModuleStatus,
    pub(super) detection: Detection,
    pub(super) receive_time_out: u16,
    pub(super) node: Node<A, DYNAMIC>,
    pub(super) explicit: Transfer<MESSAGE>,
    /// Responses of the unconnected ports that are still to be sent.
    pub(super) answers: Queue<Answer, 3>,
    pub(super) heartbeat_due: bool,
    pub(super) transfers: [DynamicTransfer<MESSAGE>; DYNAMIC],
    pub(super) long: A::Long,
}

/// A slave without the UCMM: it is reached through the Group 2 unconnected port only.
pub type Group2OnlyServer<A, const MESSAGE: usize = 32> = Slave<A, MESSAGE, 0>;

/// The buffers of a connection that was opened dynamically, and whether a frame of it is in flight.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct DynamicTransfer<const MESSAGE: usize> {
    pub(super) transfer: Transfer<MESSAGE>,
    pub(super) in_flight: bool,
    pub(super) piece: Option<Piece>,
    pub(super) unwanted: bool,
}

/// Whether there may be something to do before messages are sent: a withdrawal, a command to the controller, an event of
/// network access.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Errand {
    /// Nothing has happened since there was none.
    None,
    /// Something has happened from which one may follow.
    Perhaps,
    /// The bit rate is to be told to the controller; there may be others.
    Mode,
}

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Slave<A, MESSAGE, DYNAMIC> {
    /// What [`max_in_flight`](link_core::Machine::max_in_flight) returns, for the size of a port.
    // Network access, four I/O connections, the explicit line, that of the UCMM, and the dynamic ones.
    pub const MAX_IN_FLIGHT: usize = if DYNAMIC == 0 { 6 } else { DYNAMIC.saturating_add(7) };

    /// Its network access.
    #[must_use]
    pub const fn access(&self) -> &Access {
        &self.node.access
    }

    /// The device behind it.
    #[must_use]
    pub const fn application(&self) -> &A {
        &self.node.application
    }

    /// The same, to change its data. If what is produced by change of state has changed, call
    /// [`inputs_changed`](Self::inputs_changed) after that; sizes must stay as they are.
    pub const fn application_mut(&mut self) -> &mut A {
        self.expect_output();
        &mut self.node.application
    }

    /// What was counted since the slave was made, besides its [network access](Access::counters).
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.node.events.counters
    }

    /// What the switches show: attributes 6 to 9 of the DeviceNet object, which it has from then on if it has
    /// [`Parts::OPTIONAL_ATTRIBUTES`].
    pub const fn set_switches(&mut self, switches: Switches) {
        self.node.port.switches = Some(switches);
    }

    /// Moves every instant that it stores towards zero, so that a model checker can compare histories of different age.
    pub fn shift_time(&mut self, span: core::time::Duration) {
        self.node.access.shift_time(span);
        self.node.timers.shift(span);
        for timers in &mut self.node.dynamic_timers {
            timers.shift(span);
        }
    }

    pub(super) const fn rules(&self) -> Rules {
        Rules {
            receive_time_out: if A::PARTS.contains(Parts::CHOICES) {
                self.receive_time_out
            } else {
                RECEIVE_TIME_OUT_MILLIS
            },
            reacknowledge_last: self.node.options.contains(Options::REACKNOWLEDGE_LAST),
        }
    }

    /// A frame while the node is on line. Most of them are poll commands.
    #[inline]
    fn frame(&mut self, now: Instant, input: &Input, frame: &Frame) {
        match Identifier::of_frame(frame) {
            Some(id) if id == Identifier::poll_command(self.node.access.mac_id()) && !self.is_dynamic(id) => {
                self.command(id, IoKind::Poll, frame.data());
            }
            Some(id) => self.frame_besides_poll(now, id, input, frame.data()),
            None => self.tell_access(now, input),
        }
    }

    fn frame_besides_poll(&mut self, now: Instant, id: Identifier, input: &Input, field: &[u8]) {
        if self.is_dynamic(id) {
            return self.dynamic_frame(id, field);
        }
        // In group 2 the Message ID is below the MAC ID.
        let own = Identifier::bit_strobe_command(self.node.access.mac_id());
        match id.raw() ^ own.raw() {
            4 => self.explicit_frame(id, field),
            6 => self.unconnected_frame(id, field),
            7 => self.tell_access(now, input),
            2 if changes::<A>() => self.change_of_state_acknowledged(id),
            _ => self.frame_to_many(id, field),
        }
    }

    /// A frame whose identifier does not carry the own MAC ID: to all slaves of a master, to a group, to a connection that
    /// was opened dynamically, or to somebody else.
    #[inline(never)]
    fn frame_to_many(&mut self, id: Identifier, field: &[u8]) {
        if A::IO.contains(AllocationChoice::BIT_STROBE)
            && self.node.master.is_some_and(|master| id == Identifier::bit_strobe_command(master))
        {
            return self.strobe(id, field);
        }
        if A::IO.contains(AllocationChoice::MULTICAST_POLL)
            && id == Identifier::multicast_poll_command(self.node.group)
        {
            return self.command(id, IoKind::MulticastPoll, field);
        }
        if DYNAMIC > 0 { self.dynamic_frame(id, field) } else { self.foreign() }
    }

    pub(super) fn look_for_errands(&mut self) {
        if A::PARTS.contains(Parts::FAST_WAYS) && self.errand == Errand::None {
            self.errand = Errand::Perhaps;
        }
    }

    /// Something was told that may lead to output.
    pub(super) const fn expect_output(&mut self) {
        self.pending = !A::PARTS.contains(Parts::FAST_WAYS);
    }

    /// Whether there may be an errand. What does without [`Parts::FAST_WAYS`] looks every time.
    pub(super) fn may_have_errand(&self) -> bool {
        !A::PARTS.contains(Parts::FAST_WAYS) || self.errand != Errand::None
    }

    pub(super) fn foreign(&mut self) {
        count_wide::<A>(&mut self.node.events.counters.foreign);
    }

    #[inline(never)]
    pub(super) fn tell_access(&mut self, now: Instant, input: &Input) {
        self.look_for_errands();
        self.node.access.take_input::<Needed<A>>(now, input);
    }

    /// Counts what the controller tells.
    pub(super) fn note(&mut self, event: LinkEvent) {
        if A::PARTS.contains(Parts::OPTIONAL_ATTRIBUTES) {
            self.node.port.diagnostics.note(event);
        }
    }

    #[inline(never)]
    fn tx_done(&mut self, token: TxToken, outcome: TxOutcome) {
        let done = match lines::line_of(token) {
            Some(line) => self.line_done(line, outcome),
            None => self.dynamic_done(token, outcome),
        };
        if done.is_none() {
            count::<A>(&mut self.node.events.counters.stray_tx_done);
        }
    }

    fn line_done(&mut self, line: Line, outcome: TxOutcome) -> Option<()> {
        let wanted = self.node.lines.done(line)?;
        let sent = outcome == TxOutcome::Sent;
        if matches!(outcome, TxOutcome::Dropped | TxOutcome::Unknown) && self.online {
            self.not_sent(lines::identifier::<A>(line, self.node.access.mac_id()), outcome);
        }
        match lines::io_of::<A>(line) {
            Some(kind) if wanted => self.produced(kind, sent),
            // Of a connection that has ended since.
            Some(_) => {}
            None => self.explicit_done(line),
        }
        Some(())
    }

    pub(super) fn not_sent(&mut self, id: Identifier, outcome: TxOutcome) {
        count::<A>(&mut self.node.events.counters.not_sent);
        self.node.report(SlaveEvent::NotSent { id, outcome });
    }

    /// Serves every wait that is over at `until`.
    #[inline(never)]
    fn expire(&mut self, until: Instant) {
        if self.node.access.may_be_due(until) {
            self.look_for_errands();
            self.node.access.serve_waits::<Needed<A>>(until);
        }
        while let Some(timer) = self.node.timers.take_expired(until) {
            self.wait_over(timer);
        }
        self.expire_dynamic(until);
    }

    #[inline(never)]
    fn wait_over(&mut self, timer: Timer) {
        match timer {
            Timer::Explicit => self.node.explicit_timed_out(),
            Timer::Io(kind) => self.node.io_timed_out(kind.known::<A>()),
            Timer::Trigger if changes::<A>() => self.node.triggered(),
            Timer::Inhibit if changes::<A>() => self.node.inhibit_over(),
            Timer::Acknowledge if changes::<A>() => self.not_acknowledged(),
            Timer::Heartbeat if A::PARTS.contains(Parts::HEARTBEAT) => self.heartbeat_over(),
            Timer::FragmentAcknowledge => {
                if self.explicit.not_acknowledged() {
                    self.node.report(SlaveEvent::ResponseAbandoned { instance: 1 });
                }
            }
            Timer::Reassembly => self.explicit.reassembly_over(),
            Timer::Trigger | Timer::Inhibit | Timer::Acknowledge | Timer::Heartbeat => {}
        }
    }

    /// An input other than a frame on line.
    #[inline(never)]
    fn other_input(&mut self, now: Instant, input: &Input) {
        if A::PARTS.contains(Parts::BIT_RATE_DETECTION) && self.detection.is_running() {
            return self.detect(now, input);
        }
        match *input {
            Input::TxDone(token, outcome) if token != Access::TOKEN => self.tx_done(token, outcome),
            Input::Frame(_) | Input::TxDone(..) => self.tell_access(now, input),
            Input::Link(event) => {
                self.note(event);
                self.tell_access(now, input);
            }
            Input::Tick => {}
        }
    }

    /// What ended before this moment ended before its input.
    #[inline(never)]
    fn catch_up(&mut self, now: Instant) {
        self.expire(now.preceding());
        self.follow();
    }

    /// Whether a wait may be over. While the bit rate is being detected, nothing else is waited for.
    #[inline]
    fn may_be_due(&mut self, now: Instant) -> bool {
        let may_be_over = self.node.timers.may_be_due(now)
            || self.node.dynamic_timers.iter_mut().any(|timers| timers.is_due(now))
            || self.node.access.may_be_due(now);
        may_be_over && !(A::PARTS.contains(Parts::BIT_RATE_DETECTION) && self.detection.is_running())
    }

    /// The body format of a connection that was opened dynamically.
    pub(super) fn format_of(&self, index: u8) -> BodyFormat {
        self.node.dynamic.get(usize::from(index)).map_or_else(BodyFormat::default, |dynamic| dynamic.format)
    }
}

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Machine for Slave<A, MESSAGE, DYNAMIC> {
    type Event = Event;

    fn input(&mut self, now: Instant, input: Input) {
        self.expect_output();
        let now = self.node.advance_inline(now);
        let may_be_due = self.may_be_due(now);
        if may_be_due {
            self.catch_up(now);
        }
        match &input {
            Input::Frame(frame) if self.online => self.frame(now, &input, frame),
            _ => self.other_input(now, &input),
        }
        // A wait that ends at this moment ends after its input.
        if may_be_due {
            self.expire(now);
        }
        self.follow();
    }

    fn poll(&mut self, now: Instant) -> Option<Action<Event>> {
        self.output(now)
    }

    fn deadline(&self) -> Option<Deadline> {
        if self.has_output() {
            return Some(Deadline::now(self.node.timers.now()));
        }
        let mut next = Deadline::earlier(self.node.access.next_wait(), self.node.timers.next());
        for timers in &self.node.dynamic_timers {
            next = Deadline::earlier(next, timers.next());
        }
        next
    }

    fn max_in_flight(&self) -> usize {
        Self::MAX_IN_FLIGHT
    }
}

/// What of network access a slave needs.
pub(super) struct Needed<A>(PhantomData<A>);

impl<A: Application> Extent for Needed<A> {
    const OFFLINE_SET: bool = A::PARTS.contains(Parts::OFFLINE_SET);
    const QUICK_CONNECT: bool = A::PARTS.contains(Parts::OPTIONAL_ATTRIBUTES);
    const CHOICES: bool = A::PARTS.contains(Parts::CHOICES);
    const EVENTS: bool = A::PARTS.contains(Parts::REPORTS);
    const COUNTERS: bool = A::PARTS.contains(Parts::COUNTERS);
}

/// Whether the device offers change of state or cyclic.
pub(super) const fn changes<A: Application>() -> bool {
    A::IO.intersects(super::node::BOTH)
}
