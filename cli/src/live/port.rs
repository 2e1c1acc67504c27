//! A port for each endpoint, so that one run loop does for all.

mod open;

use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;

#[cfg(target_os = "linux")]
use link_core::TxOutcome;
use link_core::machine::Deadline;
use link_core::{BitRate, Frame, Input, Instant, LinkCommand, Port, TxToken};
use transport_mock::{Ended, Ignore, NetworkPort};

use super::endpoint::Endpoint;
use super::recorded::Recorded;
use crate::bus_rate::Doubt;
use crate::exit::Failure;
use crate::scenario::Time;
use crate::simulate::NodeEvent;

/// The bus of an endpoint.
pub(super) struct LivePort {
    bus: Bus,
    /// Of a scenario.
    bit_rate: Option<BitRate>,
    end: End,
    /// When the scenario or the recording has ended.
    over: Option<Instant>,
    /// Waiting ends when this is set.
    interrupted: Option<&'static AtomicBool>,
    /// The latest that was told.
    #[cfg(target_os = "linux")]
    refusal: Option<transport_socketcan::Refusal>,
    /// The same.
    #[cfg(target_os = "linux")]
    unconfirmed: Option<transport_socketcan::Unconfirmed>,
}

enum Bus {
    #[cfg(target_os = "linux")]
    Interface(Box<transport_socketcan::SocketCanPort>),
    Simulated(Box<NetworkPort<NodeEvent, Ignore>>),
    Recorded(Box<Recorded>),
}

/// When waiting ends.
struct End {
    at: Instant,
    /// What came later. It is told when there is time again: with a [`Input::TxDone`] a machine can go on.
    late: Option<(Instant, Input)>,
}

impl End {
    /// Lets an input pass, unless it came too late: on a bus that is faster than this program there is always one more.
    fn admit(&mut self, input: (Instant, Input)) -> Result<(Instant, Input), PortError> {
        if input.0 <= self.at {
            return Ok(input);
        }
        self.late = Some(input);
        Err(PortError::Over)
    }
}

/// Why waiting ends.
#[derive(Debug)]
pub(super) enum PortError {
    /// The time that was set is over, or the recording or the scenario is.
    Over,
    /// The interface has failed.
    Failed(Failure),
}

impl LivePort {
    /// Sets the moment at which waiting ends.
    pub(super) const fn set_end(&mut self, at: Instant) {
        self.end.at = at;
    }

    /// Ends waiting when somebody interrupts the command.
    pub(super) const fn set_interruption(&mut self, interrupted: &'static AtomicBool) {
        self.interrupted = Some(interrupted);
    }

    /// Plays a silence of a recording for so long at least, before the rest of it is passed over.
    pub(super) fn set_patience(&mut self, span: Duration) {
        if let Bus::Recorded(recorded) = &mut self.bus {
            recorded.set_patience(span);
        }
    }

    /// The number of the entry of a recording that was told last, as `decode` counts them; `None` on any other bus.
    pub(super) fn entry(&self) -> Option<u64> {
        match &self.bus {
            Bus::Recorded(recorded) => Some(recorded.entry()).filter(|entry| *entry > 0),
            #[cfg(target_os = "linux")]
            Bus::Interface(_) => None,
            Bus::Simulated(_) => None,
        }
    }

    /// The frame of CAN FD of a recording that the last tick stands for, and its number.
    pub(super) fn can_fd(&mut self) -> Option<(Instant, u64)> {
        match &mut self.bus {
            Bus::Recorded(recorded) => recorded.can_fd(),
            #[cfg(target_os = "linux")]
            Bus::Interface(_) => None,
            Bus::Simulated(_) => None,
        }
    }

    fn has_can_fd(&self) -> bool {
        match &self.bus {
            Bus::Recorded(recorded) => recorded.has_can_fd(),
            #[cfg(target_os = "linux")]
            Bus::Interface(_) => false,
            Bus::Simulated(_) => false,
        }
    }

    /// How many lines or records of a recording could not be read so far.
    pub(super) fn bad_entries(&self) -> u64 {
        match &self.bus {
            Bus::Recorded(recorded) => recorded.bad_entries(),
            #[cfg(target_os = "linux")]
            Bus::Interface(_) => 0,
            Bus::Simulated(_) => 0,
        }
    }

    /// Says what there was in a recording besides its frames.
    pub(super) fn tell_the_rest(&self) {
        if let Bus::Recorded(recorded) = &self.bus {
            recorded.tell_the_rest();
        }
    }

    /// When the scenario or the recording has ended, if it has.
    pub(super) const fn over(&self) -> Option<Instant> {
        self.over
    }

    /// Says that the scenario or the recording has ended, where somebody wanted more of it.
    pub(super) fn note_early_end(&self, endpoint: &Endpoint, wanted: Option<Time>) {
        if let (Some(at), Some(wanted)) = (self.over, wanted)
            && !self.is_interrupted()
        {
            let ended = endpoint.ended(at);
            crate::output::note(format_args!("{ended}, before --for {wanted} was over"));
        }
    }

    /// Somebody has interrupted the command.
    pub(super) fn is_interrupted(&self) -> bool {
        self.interrupted.is_some_and(|interrupted| interrupted.load(Ordering::Relaxed))
    }

    /// Interrupted or not, there is a little time to come to an end, and to give back what is held of others.
    pub(super) fn end_soon(&mut self) {
        self.interrupted = None;
        self.end.at = self.now() + LONGEST_GOODBYE;
    }

    fn wait_for_the_bus(&mut self, deadline: Option<Deadline>) -> Result<(Instant, Input), PortError> {
        match &mut self.bus {
            #[cfg(target_os = "linux")]
            Bus::Interface(port) => {
                let input = port.wait(deadline).map_err(failed)?;
                // The machine sends the frame again, and does not hear why.
                if let (_, Input::TxDone(_, TxOutcome::Unknown)) = input
                    && let Some(why) = port.unconfirmed().filter(|why| self.unconfirmed != Some(*why))
                {
                    crate::output::warn(format_args!("{}: {why}", port.interface().name()));
                    self.unconfirmed = Some(why);
                }
                Ok(input)
            }
            Bus::Simulated(port) => port.wait(deadline).map_err(|Ended { at }| {
                self.over = Some(at);
                PortError::Over
            }),
            Bus::Recorded(recorded) => recorded.next(deadline, self.end.at).inspect_err(|error| {
                self.over = matches!(error, PortError::Over).then(|| recorded.now());
            }),
        }
    }

    /// The bit rate, if it is known: that of a scenario, or of a controller.
    pub(super) fn bit_rate(&self) -> Option<BitRate> {
        match &self.bus {
            #[cfg(target_os = "linux")]
            Bus::Interface(port) => match port.interface().kind() {
                Ok(transport_socketcan::Kind::Controller { bit_rate, .. }) => bit_rate,
                Ok(transport_socketcan::Kind::HiddenBitRate | transport_socketcan::Kind::WithoutBitRate)
                | Err(_) => None,
            },
            Bus::Simulated(_) | Bus::Recorded(_) => self.bit_rate,
        }
    }

    /// Tells what there is against the bit rate that the user has said. An interface may have been late more than once, and is listened
    /// to on.
    ///
    /// # Errors
    /// A recording cannot have come so.
    pub(super) fn doubt_bit_rate(&self, said: BitRate, doubt: Doubt) -> Result<(), Failure> {
        match &self.bus {
            Bus::Recorded(recorded) => recorded.doubt_bit_rate(said, doubt),
            #[cfg(target_os = "linux")]
            Bus::Interface(port) => {
                let why = doubt.why(said, port.interface().name());
                match doubt {
                    Doubt::Once => crate::output::warn(why),
                    Doubt::TooLow(_) => crate::output::warn(format_args!("{why}; it counts as not known")),
                }
                Ok(())
            }
            Bus::Simulated(_) => Ok(()),
        }
    }

    /// Whether a wrong bit rate could do harm: on an interface with a controller.
    pub(super) fn has_bit_rate(&self) -> bool {
        match &self.bus {
            #[cfg(target_os = "linux")]
            Bus::Interface(port) => {
                !matches!(port.interface().kind(), Ok(transport_socketcan::Kind::WithoutBitRate))
            }
            Bus::Simulated(_) | Bus::Recorded(_) => false,
        }
    }

    /// Whether it is an interface that is down, or gone.
    pub(super) fn is_down(&self) -> bool {
        match &self.bus {
            #[cfg(target_os = "linux")]
            Bus::Interface(port) => !port.interface().is_up(),
            Bus::Simulated(_) | Bus::Recorded(_) => false,
        }
    }

    /// Whether its controller was told to neither send nor acknowledge.
    pub(super) fn is_listen_only(&self) -> bool {
        match &self.bus {
            #[cfg(target_os = "linux")]
            Bus::Interface(port) => {
                use transport_socketcan::Kind;
                matches!(port.interface().kind(), Ok(Kind::Controller { listen_only: true, .. }))
            }
            Bus::Simulated(_) | Bus::Recorded(_) => false,
        }
    }
}

impl Port for LivePort {
    type Error = PortError;

    fn now(&mut self) -> Instant {
        match &mut self.bus {
            #[cfg(target_os = "linux")]
            Bus::Interface(port) => port.now(),
            Bus::Simulated(port) => port.now(),
            Bus::Recorded(recorded) => recorded.now(),
        }
    }

    fn transmit(&mut self, token: TxToken, frame: Frame) -> Result<(), PortError> {
        match &mut self.bus {
            #[cfg(target_os = "linux")]
            Bus::Interface(port) => port.transmit(token, frame).map_err(failed),
            Bus::Simulated(port) => port.transmit(token, frame).map_err(|_| PortError::Over),
            Bus::Recorded(_) => Ok(()),
        }
    }

    fn withdraw(&mut self, token: TxToken) -> Result<(), PortError> {
        match &mut self.bus {
            #[cfg(target_os = "linux")]
            Bus::Interface(port) => port.withdraw(token).map_err(failed),
            Bus::Simulated(port) => port.withdraw(token).map_err(|_| PortError::Over),
            Bus::Recorded(_) => Ok(()),
        }
    }

    fn command(&mut self, command: LinkCommand) -> Result<(), PortError> {
        match &mut self.bus {
            #[cfg(target_os = "linux")]
            Bus::Interface(port) => {
                port.command(command).map_err(failed)?;
                // The machine hears that it was refused, but not why.
                if let Some(refusal) = port.refusal().filter(|refusal| self.refusal.as_ref() != Some(refusal))
                {
                    crate::output::warn(refusal);
                    self.refusal = Some(refusal.clone());
                }
                Ok(())
            }
            Bus::Simulated(port) => port.command(command).map_err(|_| PortError::Over),
            Bus::Recorded(_) => Ok(()),
        }
    }

    fn wait(&mut self, deadline: Option<Deadline>) -> Result<(Instant, Input), PortError> {
        if let Some(late) = self.end.late.take() {
            return self.end.admit(late);
        }
        let end = Deadline { at: self.end.at, why: "the end" };
        let is_last = deadline.is_none_or(|deadline| end.at < deadline.at);
        let deadline = Deadline::earlier(deadline, Some(end)).filter(|deadline| deadline.at < Instant::MAX);
        loop {
            if self.is_interrupted() {
                return Err(PortError::Over);
            }
            let look = self.interrupted.map(|_| self.now() + LOOK_AFTER);
            let look = look.map(|at| Deadline { at, why: "an interruption" });
            match self.wait_for_the_bus(Deadline::earlier(deadline, look))? {
                input @ (now, Input::Tick) if deadline.is_none_or(|deadline| now < deadline.at) => {
                    if self.has_can_fd() {
                        return Ok(input);
                    }
                }
                (_, Input::Tick) if is_last => return Err(PortError::Over),
                input => return self.end.admit(input),
            }
        }
    }
}

#[cfg(target_os = "linux")]
fn failed(error: transport_socketcan::Error) -> PortError {
    PortError::Failed(Failure::Transport(error.to_string()))
}

/// How often an interruption is looked for.
const LOOK_AFTER: Duration = Duration::from_millis(200);
#[cfg(target_os = "linux")]
const _: () = assert!(LOOK_AFTER.as_millis() > transport_socketcan::SocketCanPort::ONE_CALL.as_millis());
/// An answer that is on its way, and that to the release.
const LONGEST_GOODBYE: Duration = Duration::from_secs(3);

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// A command that runs late reads what came after its end, and has something to do still.
    #[test]
    fn what_came_after_the_end_is_told_when_there_is_time_again() {
        let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/live/two.toml");
        let mut port = LivePort::open(&Endpoint::Scenario(scenario), 1).ok().unwrap();
        let frame = loop {
            if let input @ (_, Input::Frame(_)) = port.wait(None).unwrap() {
                break input;
            }
        };
        port.set_end(Instant::ZERO);
        assert!(matches!(port.end.admit(frame), Err(PortError::Over)));
        assert!(matches!(port.wait(None), Err(PortError::Over)), "there is no more time yet");
        port.set_end(Instant::MAX);
        assert_eq!(port.wait(None).unwrap(), frame);
    }
}
