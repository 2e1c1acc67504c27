//! An interface until the command is over.

use core::ops::ControlFlow;
use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use std::io;
use std::time::SystemTime;

use link_core::ethernet::drive::drain;
use link_core::ethernet::{Input, LinkEvent, MAX_FRAME, Machine, Port};
use link_core::{Deadline, Instant};
use powerlink_core::ethernet::{ETHERTYPE, group};
use transport_ethernet::{EthernetPort, Options, sharpen_timers};

use super::args::StationArgs;
use super::record::Recorder;
use crate::exit::Failure;
use crate::{output, simulate};

/// A port with an end, and with a recording if one is wanted.
pub(super) struct Session {
    port: EthernetPort,
    /// The zero of its clock, since 1970.
    zero: Duration,
    end: Instant,
    interrupted: &'static AtomicBool,
    recorder: Option<Recorder>,
}

/// Why a session ends.
pub(super) enum Ended {
    /// Its time is over, or somebody has interrupted it.
    Over,
    /// The interface or a file has failed.
    Failed(Failure),
}

impl Session {
    /// Opens the interface for a station that answers within a time, or for one that decides itself. Says what it will send, and
    /// refuses where the command line does not allow it.
    pub(super) fn open(
        args: &StationArgs,
        answer_within: Option<Duration>,
        what: &str,
    ) -> Result<Self, Failure> {
        let name = &args.interface;
        let groups = &[group::SOC, group::PRES, group::SOA, group::ASND];
        let mut port = EthernetPort::open(name, Options { ethertype: ETHERTYPE, groups, answer_within })
            .map_err(failed)?;
        if !args.allow_tx {
            return Err(Failure::Refused(format!(
                "would send on {name} {what}; say --allow-tx to do it, where the network is for POWERLINK alone"
            )));
        }
        let interrupted = simulate::interruption()?;
        let wall = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let zero = wall.saturating_sub(port.now().saturating_since(Instant::ZERO));
        let recorder = args.record.as_deref().map(|path| Recorder::create(path, zero)).transpose()?;
        output::note(format_args!("sends on {name} {what}"));
        if !port.interface().has_link() {
            output::note(format_args!(
                "{name} has no link, and is waited for; if it is down, as root: ip link set {name} up"
            ));
        }
        // Without it waits end up to 50 us later.
        let _ = sharpen_timers();
        let mut session = Self { port, zero, end: Instant::MAX, interrupted, recorder };
        if let Some(span) = args.span {
            session.end = session.now() + span.0;
        }
        Ok(session)
    }

    /// The interface.
    pub(super) const fn interface(&self) -> &transport_ethernet::Interface {
        self.port.interface()
    }

    /// When it was 0 o'clock, since 1970: what the times of its recording begin with.
    pub(super) const fn zero(&self) -> Duration {
        self.zero
    }

    /// Records no more, after what cannot be written.
    pub(super) fn stop_recording(&mut self) {
        self.recorder = None;
    }

    /// Interrupted or not, there is a little time to come to an end.
    pub(super) fn end_soon(&mut self) {
        static NEVER: AtomicBool = AtomicBool::new(false);
        self.interrupted = &NEVER;
        self.end = self.now() + LONGEST_GOODBYE;
    }

    /// Runs a machine until the session ends, or the machine is done.
    pub(super) fn run<M: Machine>(
        &mut self,
        machine: &mut M,
        mut tell: impl FnMut(&mut M, Instant, News<M::Event>) -> io::Result<()>,
        is_done: impl Fn(&M) -> bool,
    ) -> Result<(), Failure> {
        let mut now = self.now();
        let mut buffer = [0; MAX_FRAME];
        loop {
            let mut on_event = |machine: &mut M, now, event| match tell(machine, now, News::Event(event)) {
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => ControlFlow::Break(error),
            };
            match drain(machine, self, now, &mut buffer, &mut on_event) {
                Ok(ControlFlow::Continue(())) => {}
                Ok(ControlFlow::Break(error)) => return Err(error.into()),
                Err(Ended::Over) => return Ok(()),
                Err(Ended::Failed(failure)) => return Err(failure),
            }
            if is_done(machine) {
                return Ok(());
            }
            let link;
            match self.wait(machine.deadline()) {
                Ok((at, input)) => {
                    now = now.max(at);
                    link = match input {
                        Input::Link(event) => Some(event),
                        Input::Frame(_) | Input::Tick => None,
                    };
                    machine.input(now, input);
                }
                Err(Ended::Over) => return Ok(()),
                Err(Ended::Failed(failure)) => return Err(failure),
            }
            if let Some(event) = link {
                tell(machine, now, News::Link(event))?;
            }
            tell(machine, now, News::Time)?;
        }
    }

    /// Completes the recording.
    pub(super) fn finish(self) -> Result<(), Failure> {
        self.recorder.map_or(Ok(()), Recorder::finish)
    }
}

/// What there is to tell.
pub(super) enum News<E> {
    /// By the machine.
    Event(E),
    /// By the interface.
    Link(LinkEvent),
    /// Time has passed.
    Time,
}

impl Port for Session {
    type Error = Ended;

    fn now(&mut self) -> Instant {
        self.port.now()
    }

    fn transmit(&mut self, frame: &[u8]) -> Result<(), Ended> {
        let not_sent = self.port.not_sent();
        self.port.transmit(frame).map_err(|error| Ended::Failed(failed(error)))?;
        match &mut self.recorder {
            Some(recorder) if self.port.not_sent() == not_sent => {
                recorder.write(self.port.now(), frame).map_err(Ended::Failed)
            }
            _ => Ok(()),
        }
    }

    /// Ticks may come early, which changes nothing.
    fn wait(&mut self, deadline: Option<Deadline>) -> Result<(Instant, Input<'_>), Ended> {
        let now = self.port.now();
        if self.interrupted.load(Ordering::Relaxed) || now >= self.end {
            return Err(Ended::Over);
        }
        let look = Deadline { at: self.end.min(now + LOOK_AFTER), why: "the end, or an interruption" };
        let (at, input) = self
            .port
            .wait(Deadline::earlier(deadline, Some(look)))
            .map_err(|error| Ended::Failed(failed(error)))?;
        if let (Input::Frame(frame), Some(recorder)) = (&input, &mut self.recorder) {
            recorder.write(at, frame).map_err(Ended::Failed)?;
        }
        Ok((at, input))
    }
}

fn failed(error: transport_ethernet::Error) -> Failure {
    Failure::Transport(error.to_string())
}

/// How often an interruption is looked for.
const LOOK_AFTER: Duration = Duration::from_millis(200);
/// Some cycles.
const LONGEST_GOODBYE: Duration = Duration::from_secs(1);
