//! A DeviceNeX device, against a referee.
//!
//! Operations that are legal at that moment are done to the machine; after each, every frame, withdrawal, command and event
//! must be what is allowed. So:
//!
//! - nothing is sent before the bit rate is confirmed, nothing off the bus, nothing but Hello off line or without an address;
//! - every identifier is the device's own, and no two of its connections produce with the same one;
//! - nobody is answered who has not asked, with a transaction that was not asked with;
//! - data go out only on established connections, and connections exist only on line;
//! - the events tell one history, and it is that of the connections;
//! - a connectionless request changes nothing; a frame that the filter does not let through neither;
//! - the work of one input is bounded, one frame at most of each conversation is in flight, a second tick changes nothing, an early
//!   one causes nothing, and nothing is overdue after all is fetched.

mod ops;
mod referee;
mod station;
#[cfg(test)]
mod tests;

use core::time::Duration;

use arbitrary::Unstructured;
use devicenex_core::device::{Config, Device};
use link_core::frame::extended_id;
use link_core::link::LinkCommandKind;
use link_core::{
    Action, FilterSet, Frame, Input, Instant, LinkCommand, LinkEvent, Machine as _, TxOutcome, TxToken,
};

use ops::Op;
use referee::Referee;
use station::Station;

/// Does to a device what the bytes say.
pub fn run(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let Ok((config, station, choices)) = station::config(&mut input) else { return };
    let mut node = Node::new(config, station, choices & 0x80 != 0);
    if choices & 0x40 == 0 {
        node.bring_up();
    }
    while !input.is_empty() {
        let Ok(op) = ops::op(&mut input) else { return };
        node.apply(op);
    }
}

type Machine = Device<Station, 24, 4>;

/// The machine, the referee, and what a port knows.
#[derive(Clone)]
struct Node {
    device: Machine,
    referee: Referee,
    clock: Instant,
    link: Link,
    /// The bit rate cannot be set.
    is_fixed: bool,
    filter: FilterSet,
    in_flight: Vec<InFlight>,
    /// What the controller answers next.
    answers: Vec<LinkEvent>,
    transaction: u8,
}

#[derive(Clone)]
struct InFlight {
    token: TxToken,
    asked_back: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Link {
    Up,
    OffTheBus,
    Down,
}

impl Node {
    fn new(config: Config, station: Station, is_fixed: bool) -> Self {
        Self {
            device: Device::new(config, station).expect("the sizes are valid"),
            referee: Referee::default(),
            clock: Instant::ZERO,
            link: Link::Down,
            is_fixed,
            filter: FilterSet::none(),
            in_flight: Vec::new(),
            answers: Vec::new(),
            transaction: 0,
        }
    }

    /// On line with OA 67, if the bit rate can be set.
    fn bring_up(&mut self) {
        self.link(LinkEvent::Up);
        for _ in 0..2 {
            self.apply(Op::MiniWho(1));
        }
        self.say_hello_twice();
        self.apply(Op::Roam(67));
        self.say_hello_twice();
        assert_eq!(self.is_fixed, !self.device.access().is_online());
    }

    fn say_hello_twice(&mut self) {
        for _ in 0..2 {
            self.done(0, TxOutcome::Sent);
            self.input(self.clock + Duration::from_secs(1), Input::Tick);
        }
    }

    /// Does one operation, if it is possible now, and checks everything.
    fn apply(&mut self, op: Op) {
        let now = self.clock;
        let own = u32::from(self.device.access().address().number());
        let to_device =
            |class: u32, node: u8, low: u32| class << 24 | own << 17 | low | source(node, own) << 9;
        self.transaction = self.transaction.wrapping_add(1);
        let transaction = u32::from(self.transaction);
        match op {
            Op::Elapse(span) => self.clock += span,
            Op::Tick(span) => self.input(now + span, Input::Tick),
            Op::TickInThePast(span) => self.input(now.saturating_sub(span), Input::Tick),
            Op::TickAtDeadline | Op::TickBeforeDeadline => {
                let Some(deadline) = self.device.deadline() else { return };
                let early = if op == Op::TickAtDeadline { 0 } else { 1 };
                let at = deadline.at.saturating_sub(Duration::from_nanos(early));
                if at < now + LONGEST_WAIT {
                    self.input(at, Input::Tick);
                }
            }
            Op::Frame(frame) => self.frame(&frame),
            Op::Connect { node, body } => self.send(to_device(0x1D, node, transaction), &body),
            Op::Request { node, message, body } => {
                self.send(to_device(0x10 | u32::from(message), node, transaction), &body);
            }
            Op::Fragment { node, byte, data } => {
                self.send(to_device(0x10, node, 0x100 | u32::from(byte)), &data);
            }
            Op::Acknowledge { node, connectionless, count, status } => {
                let class = if connectionless { 0x1C } else { 0x10 };
                self.send(to_device(class, node, 0x1C0 | u32::from(count)), &[status]);
            }
            Op::Implicit { which, data } => {
                let consumed: Vec<_> =
                    self.device.connections().filter_map(|one| one.consumed.identifier()).collect();
                if let Some(id) = consumed.get(which % consumed.len().max(1)) {
                    let frame = id.frame(&data).expect("at most eight bytes");
                    self.frame(&frame);
                }
            }
            Op::Done { which, sent } => {
                self.done(which, if sent { TxOutcome::Sent } else { TxOutcome::Dropped })
            }
            Op::Link(event) => self.link(event),
            Op::Inputs(value) => {
                self.catch_up(now);
                self.device.application_mut().inputs.fill(value);
                self.device.inputs_changed(now);
                self.drain(now);
            }
            Op::Connectionless { node, body } => {
                self.connectionless(to_device(0x1C, node, transaction), &body)
            }
            Op::Hello { response, serial } => {
                let id = 0x1F00_0000 | own << 17 | u32::from(response) << 16 | u32::from(serial);
                self.send(id, &[0, 0, serial, 0, 1, 0, 1, 0]);
            }
            Op::MiniWho(serial) => {
                let id = extended_id(0x1FFE_0000 | u32::from(serial));
                self.frame(&Frame::remote(id, 8).expect("it is short"));
            }
            Op::Roam(address) => {
                self.send(0x1EFE_4433, &[0x22, 0x11, 0xE7, 0x03, 0x2A, 0x00, 0x01, address]);
            }
            Op::InFragments { node, body } => self.in_fragments(to_device(0x10, node, 0x100), &body),
        }
    }

    /// Up to eight bytes of data.
    fn send(&mut self, id: u32, data: &[u8]) {
        let data = &data[..data.len().min(8)];
        self.frame(&Frame::new(extended_id(id), data).expect("at most eight bytes"));
    }

    /// A frame can be heard only on a bus.
    fn frame(&mut self, frame: &Frame) {
        if self.link != Link::Up {
            return;
        }
        self.catch_up(self.clock);
        self.check_filter(frame);
        self.referee.hears(&self.device, frame);
        self.input(self.clock, Input::Frame(*frame));
    }

    /// What the filter does not let through would have changed nothing.
    fn check_filter(&self, frame: &Frame) {
        if !self.device.access().is_online() || self.filter.accepts(frame) {
            return;
        }
        let mut device = self.device.clone();
        device.input(self.clock, Input::Frame(*frame));
        let output = device.poll(self.clock);
        assert!(
            matches!(output, None | Some(Action::Event(_))),
            "a frame that the filter does not let through, {frame}, causes {output:?}"
        );
        assert!(device.connections().eq(self.device.connections()), "{frame}");
        assert_eq!(device.application(), self.device.application(), "{frame}");
    }

    /// Whatever is asked without a connection, nothing changes.
    fn connectionless(&mut self, id: u32, body: &[u8]) {
        self.catch_up(self.clock);
        let before = self.device.clone();
        self.send(id, body);
        assert!(self.device.connections().eq(before.connections()));
        assert_eq!(self.device.application(), before.application());
        assert_eq!(self.device.access().address(), before.access().address());
    }

    /// The fragments of a request of two pieces or more, with every frame of the device sent in between.
    fn in_fragments(&mut self, id: u32, body: &[u8]) {
        let stream = [&[self.transaction], body].concat();
        let pieces: Vec<&[u8]> = stream.chunks(8).collect();
        for (at, piece) in pieces.iter().enumerate() {
            let kind = if at == 0 {
                0
            } else if at + 1 == pieces.len() {
                0x80
            } else {
                0x40
            };
            self.send(id | kind | at as u32, piece);
            while !self.in_flight.is_empty() && self.link == Link::Up {
                self.done(0, TxOutcome::Sent);
            }
        }
    }

    /// A controller that left the bus sends nothing.
    fn done(&mut self, which: usize, outcome: TxOutcome) {
        if self.in_flight.is_empty() {
            return;
        }
        let frame = self.in_flight.remove(which % self.in_flight.len());
        let outcome = match outcome {
            TxOutcome::Sent if self.link == Link::Up => TxOutcome::Sent,
            _ if frame.asked_back => TxOutcome::Withdrawn,
            _ => TxOutcome::Dropped,
        };
        self.input(self.clock, Input::TxDone(frame.token, outcome));
    }

    fn link(&mut self, event: LinkEvent) {
        match event {
            LinkEvent::Up => self.link = Link::Up,
            LinkEvent::Down => self.link = Link::Down,
            LinkEvent::BusOff if self.link == Link::Down => return,
            LinkEvent::BusOff => self.link = Link::OffTheBus,
            // Of a command that was not given.
            LinkEvent::Refused(_) => return,
            _ => {}
        }
        if self.link != Link::Up {
            self.referee.mode = None;
        }
        self.input(self.clock, Input::Link(event));
    }

    /// What is over by now is over before what comes next.
    fn catch_up(&mut self, now: Instant) {
        self.clock = self.clock.max(now);
        self.device.input(self.clock, Input::Tick);
        self.drain(self.clock);
    }

    fn input(&mut self, now: Instant, input: Input) {
        self.clock = self.clock.max(now);
        self.device.input(now, input);
        self.drain(now);
        while let Some(event) = self.answers.pop() {
            self.device.input(now, Input::Link(event));
            self.drain(now);
        }
    }

    /// Carries out everything, and judges it.
    fn drain(&mut self, now: Instant) {
        let mut actions = 0;
        while let Some(action) = self.device.poll(now) {
            actions += 1;
            assert!(actions < MOST_ACTIONS, "the work of one input is bounded");
            match action {
                Action::Transmit(token, frame) => {
                    assert!(
                        self.in_flight.iter().all(|other| other.token != token),
                        "{token:?} is in flight"
                    );
                    self.referee.sends(&self.device, &frame);
                    self.in_flight.push(InFlight { token, asked_back: false });
                    assert!(self.in_flight.len() <= self.device.max_in_flight());
                }
                Action::Withdraw(token) => {
                    let frame = self.in_flight.iter_mut().find(|frame| frame.token == token);
                    let frame = frame.expect("what is withdrawn is in flight");
                    assert!(!core::mem::replace(&mut frame.asked_back, true), "withdrawn twice");
                }
                Action::Link(command) => self.command(command),
                Action::Event(event) => {
                    // In words, too.
                    assert!(!event.to_string().is_empty());
                    self.referee.tells(&event);
                }
            }
        }
        assert_eq!(self.device.counters().events_lost, 0, "there is room for what one input can raise");
        assert_eq!(self.device.counters().stray_tx_done, 0);
        self.referee.forget(&self.device);
        self.referee.holds(&self.device);
        self.check_time(now);
    }

    fn command(&mut self, command: LinkCommand) {
        match command {
            LinkCommand::SetMode(mode) if self.is_fixed => {
                let _ = mode;
                self.answers.push(LinkEvent::Refused(LinkCommandKind::SetMode));
            }
            LinkCommand::SetMode(mode) => {
                self.referee.mode = Some(mode);
                self.answers.push(LinkEvent::ModeSet(mode));
            }
            LinkCommand::SetFilter(filter) => self.filter = filter,
            LinkCommand::Reset => {
                self.link = Link::Up;
                self.answers.push(LinkEvent::Up);
            }
        }
    }

    /// Nothing is overdue, nothing happens twice, nothing happens early.
    fn check_time(&self, now: Instant) {
        let mut ticked = self.device.clone();
        ticked.input(now, Input::Tick);
        assert!(ticked == self.device, "a second tick changes something");
        let Some(deadline) = ticked.deadline() else { return };
        let mut early = ticked;
        early.input(deadline.at.saturating_sub(Duration::from_nanos(1)), Input::Tick);
        let output = early.poll(now);
        assert!(output.is_none(), "{output:?} before {deadline:?}");
    }
}

/// The address of a node, as the operations name it.
fn source(node: u8, own: u32) -> u32 {
    match node % 8 {
        0..=4 => 1,
        5 => 2,
        6 => 127,
        _ => own,
    }
}

/// Nobody waits longer for a deadline: the clock has an end.
const LONGEST_WAIT: Duration = Duration::from_secs(100_000);
/// Four connections with a frame, a withdrawal and three events each, and what else there is.
const MOST_ACTIONS: usize = 64;
