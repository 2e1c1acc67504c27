//! The run loop, written once: a [`Machine`] on one side, a [`Port`] on the other.

use core::ops::ControlFlow;

use crate::frame::Frame;
use crate::link::LinkCommand;
use crate::machine::{Action, Actions, Deadline, Input, Machine, TxToken};
use crate::time::Instant;

/// One controller on one bus, as a transport offers it.
///
/// What a port owes a machine:
///
/// - the first input is [`LinkEvent::Up`](crate::LinkEvent::Up) when the controller takes part in the bus;
/// - each [`transmit`](Self::transmit) is answered by one [`Input::TxDone`], and [`Sent`](crate::TxOutcome::Sent) means
///   *on the bus and acknowledged*, not *queued*;
/// - of the frames that are pending, the one with the smallest [`Frame::arbitration_key`] goes first;
/// - a machine's own frames are not delivered to it, and are told from a twin's identical frame by something other than
///   their content;
/// - inputs that arrive at the same moment as a deadline come before it.
pub trait Port {
    /// What can go wrong with the transport itself. An event of the bus is not an error but an [`Input`].
    type Error;

    /// The present moment, on the clock by which [`wait`](Self::wait) tells when an input happened.
    fn now(&mut self) -> Instant;

    /// Accepts a frame for transmission.
    ///
    /// # Errors
    /// When the transport has failed for good.
    fn transmit(&mut self, token: TxToken, frame: Frame) -> Result<(), Self::Error>;

    /// Takes a frame back if it is not on the bus yet.
    ///
    /// # Errors
    /// When the transport has failed for good.
    fn withdraw(&mut self, token: TxToken) -> Result<(), Self::Error>;

    /// Carries out a command, or answers it with [`LinkEvent::Refused`](crate::LinkEvent::Refused).
    ///
    /// # Errors
    /// When the transport has failed for good.
    fn command(&mut self, command: LinkCommand) -> Result<(), Self::Error>;

    /// Waits for the next input, at most until the deadline; [`Input::Tick`] when that came first. Without a deadline it
    /// waits for as long as it takes.
    ///
    /// # Errors
    /// When the transport has failed for good.
    fn wait(&mut self, deadline: Option<Deadline>) -> Result<(Instant, Input), Self::Error>;
}

/// Runs a machine on a port until `on_event` breaks or the port fails.
///
/// `on_event` is called with the machine between two actions, so it may give commands; what they cause leaves with the
/// next [`poll`](Machine::poll). Nothing else can reach the machine: a program that has something for it between two events,
/// such as inputs that it samples, makes the loop itself, around [`drain`].
///
/// # Errors
/// The first error of the port.
pub fn drive<M, P, B>(
    machine: &mut M,
    port: &mut P,
    mut on_event: impl FnMut(&mut M, Instant, M::Event) -> ControlFlow<B>,
) -> Result<B, P::Error>
where
    M: Machine,
    P: Port,
{
    // Only here is the present asked for. Later actions are of the moment of an input: by the present, a deadline would
    // overtake inputs that came before it and still wait in the port.
    let mut now = port.now();
    loop {
        if let ControlFlow::Break(value) = drain(machine, port, now, &mut on_event)? {
            return Ok(value);
        }
        let input;
        (now, input) = port.wait(machine.deadline())?;
        machine.input(now, input);
    }
}

/// Carries out everything that is pending in `machine`: what [`drive`](drive()) does between two waits, for a loop that
/// has other things to wait for or to do too.
///
/// `now` is the moment of the last input, and that of the port before the first.
///
/// # Errors
/// The first error of the port.
///
/// ```
/// use core::convert::Infallible;
/// use core::ops::ControlFlow;
/// use link_core::{Machine, Port, drain};
///
/// /// Returns when the port fails for good.
/// fn run<M: Machine, P: Port>(
///     machine: &mut M,
///     port: &mut P,
///     mut work: impl FnMut(&mut M),
/// ) -> Result<Infallible, P::Error> {
///     let mut now = port.now();
///     loop {
///         let mut on_event = |_: &mut M, _, _| ControlFlow::<Infallible>::Continue(());
///         let ControlFlow::Continue(()) = drain(machine, port, now, &mut on_event)?;
///         let input;
///         (now, input) = port.wait(machine.deadline())?;
///         machine.input(now, input);
///         work(machine);
///     }
/// }
/// ```
pub fn drain<M, P, B>(
    machine: &mut M,
    port: &mut P,
    now: Instant,
    on_event: &mut impl FnMut(&mut M, Instant, M::Event) -> ControlFlow<B>,
) -> Result<ControlFlow<B>, P::Error>
where
    M: Machine,
    P: Port,
{
    while let Some(action) = Actions::of(machine, now).next() {
        match action {
            Action::Transmit(token, frame) => port.transmit(token, frame)?,
            Action::Withdraw(token) => port.withdraw(token)?,
            Action::Link(command) => port.command(command)?,
            Action::Event(event) => {
                if let ControlFlow::Break(value) = on_event(machine, now, event) {
                    return Ok(ControlFlow::Break(value));
                }
            }
        }
    }
    Ok(ControlFlow::Continue(()))
}

#[cfg(test)]
mod tests {
    extern crate std;
    use core::convert::Infallible;
    use std::collections::VecDeque;
    use std::vec::Vec;

    use super::*;
    use crate::frame::standard_id;

    /// Tells the order in which it learns of frames and of its deadline.
    struct Waiting {
        until: Option<Instant>,
        heard: VecDeque<&'static str>,
    }

    impl Machine for Waiting {
        type Event = &'static str;
        fn input(&mut self, _: Instant, input: Input) {
            if let Input::Frame(_) = input {
                self.heard.push_back("frame");
            }
        }
        fn poll(&mut self, now: Instant) -> Option<Action<Self::Event>> {
            if let Some(heard) = self.heard.pop_front() {
                return Some(Action::Event(heard));
            }
            self.until.take_if(|until| *until <= now).map(|_| Action::Event("deadline"))
        }
        fn deadline(&self) -> Option<Deadline> {
            self.until.map(|at| Deadline { at, why: "test" })
        }
        fn max_in_flight(&self) -> usize {
            0
        }
    }

    /// A port that has been away: the present is later than the inputs that wait in it.
    struct Late {
        now: Instant,
        inputs: VecDeque<(Instant, Input)>,
    }

    impl Port for Late {
        type Error = Infallible;
        fn now(&mut self) -> Instant {
            self.now
        }
        fn transmit(&mut self, _: TxToken, _: Frame) -> Result<(), Infallible> {
            Ok(())
        }
        fn withdraw(&mut self, _: TxToken) -> Result<(), Infallible> {
            Ok(())
        }
        fn command(&mut self, _: LinkCommand) -> Result<(), Infallible> {
            Ok(())
        }
        fn wait(&mut self, deadline: Option<Deadline>) -> Result<(Instant, Input), Infallible> {
            let input = self.inputs.pop_front();
            // The clock goes on while an input is being worked on.
            self.now += core::time::Duration::from_millis(5);
            Ok(input
                .unwrap_or((deadline.map_or(self.now, |deadline| deadline.at.max(self.now)), Input::Tick)))
        }
    }

    /// A duplicate MAC ID check answered in time, but read late, is answered in time.
    #[test]
    fn a_frame_that_came_before_the_deadline_is_heard_before_it() {
        let ms = Instant::from_millis;
        let frame = Input::Frame(Frame::new(standard_id(0x52F), &[]).unwrap());
        let mut machine = Waiting { until: Some(ms(4)), heard: VecDeque::new() };
        let mut port = Late { now: ms(0), inputs: [(ms(1), frame), (ms(2), frame)].into() };
        let mut order = Vec::new();
        let Ok(()) = drive(&mut machine, &mut port, |_, _, event| {
            order.push(event);
            if order.len() == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!(order, ["frame", "frame", "deadline"]);
    }
}
