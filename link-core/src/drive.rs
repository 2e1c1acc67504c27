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
/// next [`poll`](Machine::poll).
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
    loop {
        let now = port.now();
        if let ControlFlow::Break(value) = drain(machine, port, now, &mut on_event)? {
            return Ok(value);
        }
        let (now, input) = port.wait(machine.deadline())?;
        machine.input(now, input);
        if let ControlFlow::Break(value) = drain(machine, port, now, &mut on_event)? {
            return Ok(value);
        }
    }
}

/// Carries out everything that is pending in `machine`: what [`drive`](drive()) does between two waits, for a loop that
/// has other things to wait for too.
///
/// # Errors
/// The first error of the port.
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
