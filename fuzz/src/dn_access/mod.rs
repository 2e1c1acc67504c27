//! Network access, against the table of CIP Vol. 3 as a second, small program.
//!
//! Operations that are legal at that moment are done to the machine and to the reference model; after each, both
//! must be in one state, and what the machine sent, withdrew and asked of its controller must be what the model allows
//! and demands. So nothing is sent before on line but check requests, and nothing in a fault but the answers of the
//! offline connection set.

mod model;
mod ops;

use core::time::Duration;

use arbitrary::Unstructured;
use devicenet_core::access::{Access, AccessEvent, Counters, NetworkStatus, StateKind};
use link_core::{
    Action, FilterSet, Frame, Input, Instant, LinkCommand, LinkEvent, Machine, TxOutcome, TxToken,
};

use model::{Fault, Model, State};
use ops::{Command, Op};

/// Does to a node what the bytes say.
pub fn run(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let Ok(config) = ops::config(&mut input) else { return };
    let mut node = Node::new(Access::new(config.clone()), Model::new(config));
    while !input.is_empty() {
        let Ok(op) = ops::op(&mut input) else { return };
        node.apply(op);
    }
}

/// The machine, the model, and what a port knows between them.
struct Node {
    access: Access,
    model: Model,
    /// The real time, of which the two know when they are called.
    clock: Instant,
    /// The frame in flight, whether its withdrawal was asked for.
    in_flight: Option<(TxToken, bool)>,
    link: Link,
    filter: Option<FilterSet>,
}

/// What the controller really does.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Link {
    Up,
    OffTheBus,
    Down,
}

impl Node {
    fn new(access: Access, model: Model) -> Self {
        Self { access, model, clock: Instant::ZERO, in_flight: None, link: Link::Down, filter: None }
    }

    /// Does one operation, if it is possible now, and checks everything.
    fn apply(&mut self, op: Op) {
        let now = self.clock;
        let before = *self.access.counters();
        match op {
            Op::Elapse(span) => {
                self.clock += span;
                return;
            }
            Op::Tick(span) => self.input(now + span, Input::Tick),
            Op::TickInThePast(span) => self.input(now.saturating_sub(span), Input::Tick),
            Op::TickAtDeadline => match self.access.deadline() {
                Some(deadline) => self.input(deadline.at, Input::Tick),
                None => return,
            },
            Op::TickBeforeDeadline => match self.access.deadline() {
                Some(deadline) => self.early_tick(deadline.at.saturating_sub(Duration::from_nanos(1))),
                None => return,
            },
            Op::Frame(frame) => self.frame(frame),
            Op::OwnCheck { len, head } => self.frame(ops::own_check(self.access.mac_id(), len, head)),
            Op::Faulted { message, head } => self.frame(ops::faulted(message, head)),
            Op::Sent => self.tx_done(TxOutcome::Sent),
            Op::GivenBack => {
                let asked = matches!(self.in_flight, Some((_, true)));
                self.tx_done(if asked { TxOutcome::Withdrawn } else { TxOutcome::Dropped });
            }
            Op::Link(event) => self.link(event),
            Op::Command(command) => self.command(command),
        }
        assert_never_fewer(&before, self.access.counters());
    }

    fn input(&mut self, now: Instant, input: Input) {
        self.clock = self.clock.max(now);
        self.model.advance(now);
        match input {
            Input::Frame(frame) => self.model.frame(&frame),
            Input::TxDone(_, TxOutcome::Sent) => self.model.sent(),
            Input::TxDone(..) => self.model.given_back(),
            Input::Link(event) => self.model.link(event),
            Input::Tick => {}
        }
        self.model.settle();
        let from = self.access.state().kind();
        self.access.input(now, input);
        self.drain(now, from);
        let mut ticked = self.access.clone();
        ticked.input(now, Input::Tick);
        assert_eq!(ticked, self.access, "a second tick changes nothing");
    }

    /// A tick before anything is due: only the clock of the machine moves on.
    fn early_tick(&mut self, now: Instant) {
        let (state, deadline) = (self.access.state(), self.access.deadline());
        if now > self.clock {
            self.input(now, Input::Tick);
            assert_eq!((self.access.state(), self.access.deadline()), (state, deadline), "an early tick");
        }
    }

    /// A frame can be heard only on a bus.
    fn frame(&mut self, frame: Frame) {
        if self.link == Link::Up {
            self.input(self.clock, Input::Frame(frame));
        }
    }

    /// A controller that left the bus sends nothing.
    fn tx_done(&mut self, outcome: TxOutcome) {
        let outcome = if self.link == Link::Up { outcome } else { TxOutcome::Dropped };
        if let Some((token, _)) = self.in_flight.take() {
            self.input(self.clock, Input::TxDone(token, outcome));
        }
    }

    fn link(&mut self, event: LinkEvent) {
        match event {
            LinkEvent::Up => self.link = Link::Up,
            LinkEvent::Down => self.link = Link::Down,
            LinkEvent::BusOff if self.link == Link::Down => return,
            LinkEvent::BusOff => self.link = Link::OffTheBus,
            _ => {}
        }
        self.input(self.clock, Input::Link(event));
    }

    fn command(&mut self, command: Command) {
        let now = self.clock;
        let from = self.access.state().kind();
        let obeyed = match command {
            Command::Reset => {
                self.access.reset(now);
                true
            }
            Command::ResetWithSwitches(mac) => {
                self.access.reset_with_switches(now, mac);
                true
            }
            Command::SetMacId(mac) => self.access.set_mac_id(now, mac).is_ok(),
            Command::SetBusOffInterrupt(on) => {
                self.access.set_bus_off_interrupt(on);
                true
            }
            Command::SetBusOffCounter(value) => self.access.set_bus_off_counter(value).is_ok(),
            Command::ClearBusOffCounter => {
                self.access.clear_bus_off_counter();
                true
            }
            Command::SetQuickConnect(on) => {
                self.access.set_quick_connect(on);
                true
            }
        };
        assert_eq!(obeyed, self.model.command(command), "{command:?}");
        self.drain(now, from);
        // Commands leave waits that are over to the tick that is due.
        self.input(now, Input::Tick);
    }

    /// Fetches and judges everything that the machine wants, then compares the two.
    fn drain(&mut self, now: Instant, mut from: StateKind) {
        for _ in 0..MOST_ACTIONS {
            let announced = self.access.deadline().is_some_and(|deadline| deadline.why == OUTPUT_PENDING);
            let action = self.access.poll(now);
            assert_eq!(announced, action.is_some(), "the deadline is now if and only if output is pending");
            match action {
                None => {
                    assert_eq!(from, self.access.state().kind(), "each change of state is told");
                    return self.compare();
                }
                Some(Action::Event(AccessEvent::StateChanged { from: told, to, .. })) => {
                    assert_eq!(told, from, "changes of state are told in their order");
                    from = to;
                }
                Some(Action::Event(event)) => assert!(!event.to_string().is_empty()),
                Some(Action::Transmit(token, frame)) => self.transmit(token, &frame),
                Some(Action::Withdraw(token)) => self.withdraw(token),
                Some(Action::Link(command)) => self.link_command(command),
            }
        }
        panic!("more than {MOST_ACTIONS} actions at once");
    }

    fn transmit(&mut self, token: TxToken, frame: &Frame) {
        assert!(self.in_flight.is_none(), "{frame}: only one frame in flight");
        assert_eq!(self.access.max_in_flight(), 1);
        self.model.transmit(frame);
        self.in_flight = Some((token, false));
    }

    fn withdraw(&mut self, token: TxToken) {
        let Some((in_flight, asked)) = &mut self.in_flight else { panic!("nothing to withdraw") };
        assert_eq!(*in_flight, token);
        assert!(!*asked, "withdrawn once only");
        assert!(self.model.withdraw_due, "the frame is wanted");
        *asked = true;
        self.model.withdraw_due = false;
    }

    fn link_command(&mut self, command: LinkCommand) {
        match command {
            LinkCommand::SetFilter(filter) => self.filter = Some(filter),
            LinkCommand::Reset => match self.model.restart_due() {
                Some(commanded) => *commanded = true,
                None => panic!("a restart of the controller in {:?}", self.model.state),
            },
            LinkCommand::SetMode(mode) => panic!("{mode:?}: network access leaves the mode alone"),
        }
    }

    fn compare(&mut self) {
        assert!(self.model.restart_due().is_none(), "the controller is never restarted");
        let Self { access, model, .. } = &*self;
        assert_eq!(access.state().kind(), model.kind(), "{:?} and {:?}", access.state(), model.state);
        assert_eq!(access.is_online(), model.kind() == StateKind::OnLine);
        assert_eq!(access.fault().is_some(), model.kind() == StateKind::CommFault);
        assert_eq!(access.mac_id().number(), model.mac);
        assert_eq!(access.bus_off_counter(), model.bus_off_counter);
        assert_eq!(access.bus_off_interrupt(), model.bus_off_interrupt);
        assert_eq!(access.quick_connect(), model.quick_connect);
        assert_eq!(access.network_status(), network_status(&model.state));
        assert_eq!(self.in_flight.is_some(), model.in_flight.is_some());
        assert_eq!(model.wants(), [], "not sent in {:?}", model.state);
        assert!(!model.withdraw_due, "not withdrawn in {:?}", model.state);
        if let Some(id) = model.must_hear() {
            let heard = Frame::new(link_core::frame::standard_id(id as u16), &[]).expect("no data");
            assert!(self.filter.as_ref().is_some_and(|filter| filter.accepts(&heard)), "deaf to {id:03X}");
        }
        assert_eq!(access.counters().stray_tx_done, 0);
        assert_eq!(access.counters().events_lost, 0);
    }
}

fn network_status(state: &State) -> NetworkStatus {
    match state {
        State::NonExistent | State::Sending { .. } | State::Waiting { .. } => NetworkStatus::Off,
        State::OnLine { .. } => NetworkStatus::FlashingGreen,
        State::Faulted(Fault::Duplicate { flashing: Some(_), .. }) => NetworkStatus::FlashingRedGreen,
        State::Faulted(_) => NetworkStatus::SolidRed,
    }
}

/// Counters only grow. A new counter does not compile before it is named here.
fn assert_never_fewer(before: &Counters, after: &Counters) {
    let numbers = |counters: &Counters| {
        let Counters {
            challenges,
            responses,
            requests_merged,
            duplicates,
            bad_frames,
            foreign_frames,
            discarded,
            unacknowledged,
            not_sent,
            frames_lost,
            refused,
            stray_tx_done,
            events_lost,
        } = *counters;
        let small = [
            challenges,
            responses,
            requests_merged,
            duplicates,
            bad_frames,
            not_sent,
            refused,
            stray_tx_done,
            events_lost,
        ];
        let large = [foreign_frames, discarded, unacknowledged, frames_lost];
        small.into_iter().map(u32::from).chain(large).collect::<Vec<_>>()
    };
    let (before, after) = (numbers(before), numbers(after));
    assert!(before.iter().zip(&after).all(|(before, after)| before <= after), "{before:?} then {after:?}");
}

const MOST_ACTIONS: usize = 32;
const OUTPUT_PENDING: &str = link_core::Deadline::now(Instant::ZERO).why;

#[cfg(test)]
mod tests {
    use super::*;

    const UP: [u8; 2] = [8, 0];
    const SENT: [u8; 1] = [6];
    const SECOND: [u8; 2] = [0, 0xC1];

    /// Runs the operations on MAC ID 5 without options, and returns the node.
    fn after(ops: &[&[u8]]) -> Node {
        let bytes = [&[5, 0][..], &ops.concat()].concat();
        run(&bytes);
        let mut input = Unstructured::new(&bytes);
        let config = ops::config(&mut input).unwrap();
        let mut node = Node::new(Access::new(config.clone()), Model::new(config));
        while !input.is_empty() {
            node.apply(ops::op(&mut input).unwrap());
        }
        node
    }

    fn on_line() -> Vec<u8> {
        [&UP[..], &SENT, &SECOND, &SENT, &SECOND].concat()
    }

    #[test]
    fn a_node_gets_on_line_after_two_requests_and_two_seconds() {
        assert_eq!(after(&[&on_line()]).model.kind(), StateKind::OnLine);
    }

    #[test]
    fn a_node_on_line_answers_a_request_and_obeys_a_response() {
        let defended = after(&[&on_line(), &[4, 7, 0x00]]);
        assert_eq!((defended.model.kind(), defended.in_flight.is_some()), (StateKind::OnLine, true));
        assert_eq!(after(&[&on_line(), &[4, 7, 0x80]]).model.kind(), StateKind::CommFault);
    }

    #[test]
    fn a_faulted_node_is_repaired() {
        let changed = after(&[&on_line(), &[4, 7, 0x80], &[5, 3, 0x11]]);
        assert_eq!((changed.model.kind(), changed.model.mac), (StateKind::SendingDupMac, 0x11));
    }

    #[test]
    fn a_withdrawn_request_may_have_been_sent() {
        let late = after(&[&UP, &[4, 7, 0x00], &SENT]);
        assert_eq!((late.model.kind(), late.in_flight), (StateKind::CommFault, None));
    }
}
