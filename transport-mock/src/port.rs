//! A node of a network as a [`Port`], so that a run loop drives a machine on the simulated bus as on a real one.

use std::collections::VecDeque;
use std::convert::Infallible;

use link_core::{Action, Deadline, Frame, Input, Instant, LinkCommand, Machine, Port, TxToken};

use crate::{Network, NodeConfig, NodeId, Sink};

/// A network with a node that is driven from outside, in virtual time: to wait is to let the network run.
///
/// A machine on it is told the same, in the same order and at the same moments, as one that was added to the network, but
/// takes no part in [`Reaction`](crate::Reaction)s and power: what it does follows at once, and it always runs.
///
/// ```
/// use link_core::{BitRate, Frame, Input, Instant, LinkEvent, Port, TxOutcome, TxToken, frame::standard_id};
/// use transport_mock::nodes::Listener;
/// use transport_mock::{BusConfig, Ignore, Network, NetworkPort, NodeConfig};
///
/// let mut network = Network::<()>::new(BusConfig::new(BitRate::K125, 1));
/// network.add_silent(NodeConfig::named("other"), Listener::new(1));
/// let mut port = NetworkPort::attach(network, NodeConfig::named("outside"), 3, Ignore);
///
/// assert_eq!(port.wait(None)?.1, Input::Link(LinkEvent::Up));
/// port.transmit(TxToken(3), Frame::new(standard_id(0x123), &[1, 2, 3]).unwrap())?;
/// let (at, done) = port.wait(None)?;
/// assert_eq!(done, Input::TxDone(TxToken(3), TxOutcome::Sent));
/// assert!(at > Instant::ZERO);
/// # Ok::<(), transport_mock::Ended>(())
/// ```
#[derive(Debug)]
pub struct NetworkPort<E, S> {
    network: Network<E>,
    node: NodeId,
    sink: S,
    end: Instant,
}

/// The simulation is over: its end has come, or nothing would ever happen in it any more.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("the simulation has come to its end at {at:.3} s")]
pub struct Ended {
    /// When.
    pub at: Instant,
}

/// The machine of that node: what it is told goes out, and what is said to it waits here.
#[derive(Clone, Debug)]
struct Outlet {
    max_in_flight: usize,
    actions: VecDeque<Action<Infallible>>,
    inputs: VecDeque<(Instant, Input)>,
}

impl Machine for Outlet {
    type Event = Infallible;

    fn input(&mut self, now: Instant, input: Input) {
        if input != Input::Tick {
            self.inputs.push_back((now, input));
        }
    }

    fn poll(&mut self, _: Instant) -> Option<Action<Infallible>> {
        self.actions.pop_front()
    }

    fn deadline(&self) -> Option<Deadline> {
        None
    }

    fn max_in_flight(&self) -> usize {
        self.max_in_flight
    }
}

impl<E: 'static, S: Sink<E>> NetworkPort<E, S> {
    /// Adds a node to a network, and is the port of that node: for a machine that has so many frames
    /// [in flight](Machine::max_in_flight) at most. Whatever happens in the network goes to the sink.
    pub fn attach(mut network: Network<E>, config: NodeConfig, max_in_flight: usize, sink: S) -> Self {
        let config = NodeConfig { own_power: true, clock_ppm: 0, ..config };
        let outlet = Outlet { max_in_flight, actions: VecDeque::new(), inputs: VecDeque::new() };
        let node = network.add_silent(config, outlet);
        Self { network, node, sink, end: Instant::MAX }
    }

    /// The same, with an end of time, at which [`wait`](Port::wait) fails.
    #[must_use]
    pub fn until(self, end: Instant) -> Self {
        Self { end, ..self }
    }

    /// The network.
    #[must_use]
    pub const fn network(&self) -> &Network<E> {
        &self.network
    }

    /// The sink.
    pub const fn sink(&mut self) -> &mut S {
        &mut self.sink
    }

    fn act(&mut self, action: Action<Infallible>) {
        self.network.command(self.node, |outlet: &mut Outlet, _| outlet.actions.push_back(action));
    }

    fn input(&mut self) -> Option<(Instant, Input)> {
        self.network.command(self.node, |outlet: &mut Outlet, _| outlet.inputs.pop_front()).flatten()
    }
}

impl<E: 'static, S: Sink<E>> Port for NetworkPort<E, S> {
    type Error = Ended;

    fn now(&mut self) -> Instant {
        self.network.now()
    }

    fn transmit(&mut self, token: TxToken, frame: Frame) -> Result<(), Ended> {
        self.act(Action::Transmit(token, frame));
        Ok(())
    }

    fn withdraw(&mut self, token: TxToken) -> Result<(), Ended> {
        self.act(Action::Withdraw(token));
        Ok(())
    }

    fn command(&mut self, command: LinkCommand) -> Result<(), Ended> {
        self.act(Action::Link(command));
        Ok(())
    }

    fn wait(&mut self, deadline: Option<Deadline>) -> Result<(Instant, Input), Ended> {
        let until = deadline.map_or(self.end, |deadline| deadline.at.min(self.end));
        loop {
            if let Some(input) = self.input() {
                return Ok(input);
            }
            let now = self.network.now();
            if now >= until {
                // What happens at this moment comes first.
                self.network.run_until(now, &mut self.sink);
                if let Some(input) = self.input() {
                    return Ok(input);
                }
                let over = deadline.is_some_and(|deadline| deadline.at <= now);
                return if over { Ok((now, Input::Tick)) } else { Err(Ended { at: now }) };
            }
            let next = self.network.next_event_time();
            if next == Instant::MAX && until == Instant::MAX {
                return Err(Ended { at: now });
            }
            // A nanosecond more: what begins at a moment is done when it has passed.
            let next = next.saturating_add(core::time::Duration::from_nanos(1));
            self.network.run_until(next.min(until).max(now), &mut self.sink);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::{Listener, Replay};
    use crate::{BusConfig, Ignore};
    use core::time::Duration;
    use link_core::frame::standard_id;
    use link_core::{BitRate, LinkEvent, TxOutcome};

    fn network() -> Network<()> {
        let mut network = Network::new(BusConfig::new(BitRate::K125, 1));
        network.add_silent(NodeConfig::named("other"), Listener::new(1));
        network
    }

    fn at(millis: u64) -> Option<Deadline> {
        Some(Deadline { at: Instant::from_millis(millis), why: "the test" })
    }

    fn frame(id: u16) -> Frame {
        Frame::new(standard_id(id), &[1, 2, 3]).unwrap()
    }

    #[test]
    fn what_comes_at_the_deadline_comes_before_it() {
        let mut network = network();
        let frames = vec![(Instant::from_millis(5), frame(0x100))];
        network.add_silent(NodeConfig::named("recorded"), Replay::since(Instant::ZERO, frames));
        let mut probe = NetworkPort::attach(network, NodeConfig::named("outside"), 3, Ignore);
        assert_eq!(probe.wait(None), Ok((Instant::ZERO, Input::Link(LinkEvent::Up))));
        assert_eq!(probe.wait(at(2)), Ok((Instant::from_millis(2), Input::Tick)));
        let (received, input) = probe.wait(None).unwrap();
        assert_eq!(input, Input::Frame(frame(0x100)));
        assert_eq!(received, Instant::from_millis(5) + Duration::from_micros(8) * frame(0x100).bit_len());
    }

    #[test]
    fn nor_does_a_deadline_of_the_same_moment_overtake_anything() {
        let mut network = network();
        let end = Instant::from_millis(5) + Duration::from_micros(8) * frame(0x100).bit_len();
        let frames = vec![(Instant::from_millis(5), frame(0x100))];
        network.add_silent(NodeConfig::named("recorded"), Replay::since(Instant::ZERO, frames));
        let mut port = NetworkPort::attach(network, NodeConfig::named("outside"), 3, Ignore);
        assert_eq!(port.wait(at(0)), Ok((Instant::ZERO, Input::Link(LinkEvent::Up))));
        let deadline = Some(Deadline { at: end, why: "the test" });
        assert_eq!(port.wait(deadline), Ok((end, Input::Frame(frame(0x100)))));
        assert_eq!(port.wait(deadline), Ok((end, Input::Tick)));
    }

    #[test]
    fn each_frame_is_answered_with_its_token() {
        let mut port = NetworkPort::attach(network(), NodeConfig::named("outside"), 3, Ignore);
        port.wait(None).unwrap();
        for (token, id) in [(1, 0x300), (2, 0x200), (3, 0x100)] {
            port.transmit(TxToken(token), frame(id)).unwrap();
        }
        port.withdraw(TxToken(2)).unwrap();
        let answers: Vec<Input> = (0..3).map(|_| port.wait(None).unwrap().1).collect();
        let done = |token, outcome| Input::TxDone(TxToken(token), outcome);
        assert_eq!(answers[0], done(2, TxOutcome::Withdrawn));
        assert_eq!(answers[1..], [done(3, TxOutcome::Sent), done(1, TxOutcome::Sent)], "by arbitration");
    }

    #[test]
    fn the_end_is_an_error_and_so_is_waiting_for_nothing() {
        let mut port = NetworkPort::attach(network(), NodeConfig::named("outside"), 3, Ignore);
        port.wait(None).unwrap();
        assert!(matches!(port.wait(None), Err(Ended { .. })));
        let mut port = port.until(Instant::from_millis(7));
        assert_eq!(port.wait(at(3)), Ok((Instant::from_millis(3), Input::Tick)));
        assert_eq!(port.wait(at(9)), Err(Ended { at: Instant::from_millis(7) }));
    }
}
