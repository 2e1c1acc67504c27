//! The run loop, written once: a [`Machine`] on one side, a [`Port`] on the other.

use core::ops::ControlFlow;

use super::{Action, Input, MAX_FRAME, Machine};
use crate::{Deadline, Instant};

/// One adapter on one network, as a transport offers it.
///
/// What a port owes a machine:
///
/// - the first input is [`LinkEvent::Up`](super::LinkEvent::Up) when there is a link;
/// - a machine's own frames are not delivered to it;
/// - a frame that was lost, and one that was not sent, is told;
/// - inputs that arrive at the same moment as a deadline come before it.
pub trait Port {
    /// What can go wrong with the transport itself. What happens on the network is not an error but an [`Input`].
    type Error;

    /// The present moment, on the clock by which [`wait`](Self::wait) tells when an input happened.
    fn now(&mut self) -> Instant;

    /// Sends a frame, or tells [`NotSent`](super::LinkEvent::NotSent) with the next [`wait`](Self::wait).
    ///
    /// # Errors
    /// When the transport has failed for good.
    fn transmit(&mut self, frame: &[u8]) -> Result<(), Self::Error>;

    /// Waits for the next input, at most until the deadline; [`Input::Tick`] when that came first. Without a deadline it
    /// waits for as long as it takes.
    ///
    /// # Errors
    /// When the transport has failed for good.
    fn wait(&mut self, deadline: Option<Deadline>) -> Result<(Instant, Input<'_>), Self::Error>;
}

/// Runs a machine on a port until `on_event` breaks or the port fails.
///
/// `on_event` is called with the machine between two actions, so it may give commands; what they cause leaves with the
/// next [`poll`](Machine::poll). An answer is sent before the next input is waited for.
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
    // Later actions are of the moment of an input: by the present, a deadline would overtake frames that came before it and
    // still wait in the port. Only the moment at which a frame was sent is the present one.
    let mut now = port.now();
    let mut buffer = [0; MAX_FRAME];
    loop {
        if let ControlFlow::Break(value) = drain(machine, port, now, &mut buffer, &mut on_event)? {
            return Ok(value);
        }
        let input;
        (now, input) = port.wait(machine.deadline())?;
        machine.input(now, input);
    }
}

/// Carries out everything that is pending in `machine`: what [`drive`](drive()) does between two waits, for a loop that
/// has other things to wait for too. Frames are written to the buffer, whatever stands there.
///
/// # Errors
/// The first error of the port.
pub fn drain<M, P, B>(
    machine: &mut M,
    port: &mut P,
    now: Instant,
    buffer: &mut [u8; MAX_FRAME],
    on_event: &mut impl FnMut(&mut M, Instant, M::Event) -> ControlFlow<B>,
) -> Result<ControlFlow<B>, P::Error>
where
    M: Machine,
    P: Port,
{
    while let Some(action) = machine.poll(now, buffer) {
        match action {
            Action::Transmit(frame) => {
                port.transmit(frame)?;
                machine.sent(port.now());
            }
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

    /// Answers each frame with its own bytes, and tells of its deadline.
    struct Echo {
        until: Option<Instant>,
        answer: Option<Vec<u8>>,
        /// When its answers were sent.
        sent: Vec<Instant>,
    }

    impl Machine for Echo {
        type Event = Instant;

        fn input(&mut self, _: Instant, input: Input<'_>) {
            if let Input::Frame(bytes) = input {
                self.answer = Some(bytes.to_vec());
            }
        }

        fn poll<'b>(&mut self, now: Instant, buffer: &'b mut [u8]) -> Option<Action<'b, Instant>> {
            if let Some(answer) = self.answer.take() {
                let frame = buffer.get_mut(..answer.len())?;
                frame.copy_from_slice(&answer);
                return Some(Action::Transmit(frame));
            }
            self.until.take_if(|until| *until <= now).map(|_| Action::Event(now))
        }

        fn sent(&mut self, at: Instant) {
            self.sent.push(at);
        }

        fn deadline(&self) -> Option<Deadline> {
            self.until.map(|at| Deadline { at, why: "test" })
        }
    }

    /// Frames that came while nobody looked: the present is later than they.
    struct Late {
        now: Instant,
        frames: VecDeque<(Instant, &'static [u8])>,
        sent: Vec<Vec<u8>>,
    }

    impl Port for Late {
        type Error = Infallible;

        fn now(&mut self) -> Instant {
            self.now
        }

        fn transmit(&mut self, frame: &[u8]) -> Result<(), Infallible> {
            self.sent.push(frame.to_vec());
            Ok(())
        }

        fn wait(&mut self, deadline: Option<Deadline>) -> Result<(Instant, Input<'_>), Infallible> {
            self.now += core::time::Duration::from_millis(5);
            Ok(match self.frames.pop_front() {
                Some((at, frame)) => (at, Input::Frame(frame)),
                None => (deadline.map_or(self.now, |deadline| deadline.at.max(self.now)), Input::Tick),
            })
        }
    }

    #[test]
    fn frames_are_answered_one_by_one_and_before_a_later_deadline() {
        let ms = Instant::from_millis;
        let mut machine = Echo { until: Some(ms(4)), answer: None, sent: Vec::new() };
        let frames: VecDeque<(Instant, &[u8])> = [(ms(1), &b"one"[..]), (ms(2), &b"two"[..])].into();
        let mut port = Late { now: ms(0), frames, sent: Vec::new() };
        let Ok(at) = drive(&mut machine, &mut port, |_, at, _| ControlFlow::Break(at));
        assert_eq!((at, &port.sent[..]), (ms(15), &[b"one".to_vec(), b"two".to_vec()][..]));
        assert_eq!(machine.sent, [ms(5), ms(10)], "by the clock, not by the stamp of what is answered");
    }
}
