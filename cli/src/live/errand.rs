//! A node that goes on line, does something, and is gone again.

use core::fmt::Debug;
use core::ops::ControlFlow;
use core::time::Duration;
use std::fs;

use devicenet_core::MacId;
use devicenet_core::access::{Access, Fault, StateKind};
use devicenet_core::message::DeviceIdentity;
use link_core::{Action, Deadline, Input, Instant, LinkEvent, Machine, Port as _, drive};

use super::endpoint::Endpoint;
use super::permit;
use super::port::{LivePort, PortError};
use crate::exit::Failure;

/// The machine of a command.
pub(super) trait Errand: Machine {
    /// Its network access.
    fn access(&self) -> &Access;

    /// Why it is not on line yet.
    fn why_not_online(&self) -> String;

    /// Somebody wants it to end: it begins nothing new, and gives back what it holds of others. Its end is told as ever.
    fn leave(&mut self);

    /// What it has not come to an end with, in words.
    fn unfinished(&self) -> Option<String>;
}

/// How an errand ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum End {
    /// It is done.
    Done,
    /// The time is over.
    TooLate,
    /// Somebody has interrupted it, and everything is given back.
    Interrupted,
    /// The scenario has ended before, at this moment.
    ScenarioOver(Instant),
}

/// Runs an errand on a port whose link was up until now, until `follow` says that it is done, `longest` at most.
///
/// # Errors
/// What `follow` says, and when it does not get on line, its MAC ID is taken, the link is lost, or it is interrupted and something
/// is left behind.
pub(super) fn run<E: Errand>(
    errand: &mut E,
    endpoint: &Endpoint,
    port: &mut LivePort,
    longest: Duration,
    mut follow: impl FnMut(E::Event) -> ControlFlow<Result<(), Failure>>,
) -> Result<End, Failure> {
    let mut watched = Watched { errand, lost: None };
    let mut on_event = |_: &mut Watched<'_, E>, _, news| match news {
        News::Of(event) => follow(event),
        News::Taken(own) => ControlFlow::Break(Err(taken(endpoint, own))),
        News::Lost(event) => ControlFlow::Break(Err(lost(endpoint, event))),
    };
    let begin = port.now();
    watched.input(begin, Input::Link(LinkEvent::Up));
    port.set_end(begin + LONGEST_WAY);
    let mut ended = drive(&mut watched, port, &mut on_event);
    let is_over = |ended: &Result<_, PortError>| matches!(ended, Err(PortError::Over));
    if is_over(&ended) && watched.errand.access().is_online() && !port.is_interrupted() {
        port.set_end(begin + longest);
        ended = drive(&mut watched, port, &mut on_event);
    }
    let is_interrupted = is_over(&ended) && port.is_interrupted();
    if is_interrupted && watched.errand.access().is_online() {
        port.end_soon();
        watched.errand.leave();
        ended = drive(&mut watched, port, &mut on_event);
    }
    match ended {
        Ok(Ok(())) if is_interrupted => Ok(End::Interrupted),
        Ok(done) => done.map(|()| End::Done),
        Err(PortError::Failed(failure)) => Err(failure),
        Err(PortError::Over) if is_interrupted => match watched.errand.unfinished() {
            None => Ok(End::Interrupted),
            Some(words) => Err(Failure::Interrupted(format!("interrupted; {words}"))),
        },
        Err(PortError::Over) => match port.over() {
            Some(at) => Ok(End::ScenarioOver(at)),
            None if watched.errand.access().is_online() => Ok(End::TooLate),
            None => Err(no_way(endpoint, watched.errand)),
        },
    }
}

/// An errand that is over when its link or its MAC ID is.
struct Watched<'a, E> {
    errand: &'a mut E,
    /// What has taken the link, and is not told yet.
    lost: Option<LinkEvent>,
}

#[derive(Debug)]
enum News<T> {
    Of(T),
    /// Another node has this MAC ID.
    Taken(MacId),
    /// The link is down, or off the bus.
    Lost(LinkEvent),
}

impl<E: Errand> Machine for Watched<'_, E> {
    type Event = News<E::Event>;

    fn input(&mut self, now: Instant, input: Input) {
        if let Input::Link(event @ (LinkEvent::Down | LinkEvent::BusOff)) = input {
            self.lost = Some(event);
        }
        self.errand.input(now, input);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<Self::Event>> {
        if let Some(event) = self.lost.take() {
            return Some(Action::Event(News::Lost(event)));
        }
        if self.errand.access().fault() == Some(Fault::DuplicateMacId) {
            return Some(Action::Event(News::Taken(self.errand.access().mac_id())));
        }
        self.errand.poll(now).map(|action| action.map_event(News::Of))
    }

    fn deadline(&self) -> Option<Deadline> {
        self.errand.deadline()
    }

    fn max_in_flight(&self) -> usize {
        self.errand.max_in_flight()
    }
}

fn taken(endpoint: &Endpoint, own: MacId) -> Failure {
    Failure::Refused(format!(
        "MAC ID {own} is taken on {endpoint}: choose another one for this command with --own-mac"
    ))
}

fn lost(endpoint: &Endpoint, event: LinkEvent) -> Failure {
    match event {
        LinkEvent::BusOff => permit::bus_off(endpoint),
        _ => Failure::Transport(format!("{endpoint} went down before everything was asked")),
    }
}

fn no_way(endpoint: &Endpoint, errand: &impl Errand) -> Failure {
    Failure::Transport(match errand.access().state().kind() {
        // Its first frame is not sent. Few drivers say why.
        StateKind::SendingDupMac => format!(
            "nobody on {endpoint} acknowledges what is sent: no other node is on, the cable is open, the bit rate is wrong, \
             or the interface is listen-only"
        ),
        _ => format!("no way on line on {endpoint}: {}", errand.why_not_online()),
    })
}

/// Who the command is on the bus. No vendor has the number 0. On an interface it is the same from run to run, so that who watches the
/// bus does not take it for another device each time, and another one on another machine or interface.
pub(super) fn identity(endpoint: &Endpoint) -> DeviceIdentity {
    let serial = match endpoint {
        Endpoint::Scenario(_) | Endpoint::Recording(_) => 1,
        Endpoint::Interface(name) => {
            let known = MACHINE.iter().filter_map(|file| fs::read_to_string(file).ok());
            let machine = known.map(|id| id.trim().to_owned()).find(|id| !id.is_empty());
            serial(&machine.unwrap_or_default(), name)
        }
    };
    DeviceIdentity { vendor: 0.into(), serial }
}

/// FNV-1a of 32 bits (RFC 9923), which is the same in every version of the program.
fn serial(machine: &str, interface: &str) -> u32 {
    let bytes = machine.bytes().chain([0]).chain(interface.bytes());
    bytes.fold(0x811C_9DC5, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}

/// What tells a machine from others: systemd's machine ID, else its host name.
const MACHINE: [&str; 2] = ["/etc/machine-id", "/proc/sys/kernel/hostname"];
/// How long the way on line may take. Two duplicate MAC ID checks take two seconds, and more where others begin at the same time.
const LONGEST_WAY: Duration = Duration::from_secs(10);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_is_the_same_device_from_run_to_run() {
        let can0 = Endpoint::Interface("can0".into());
        assert_eq!(identity(&can0), identity(&can0));
        assert_ne!(identity(&can0).serial, identity(&Endpoint::Interface("can1".into())).serial);
        // The check values of the definition of FNV-1a for "a" and "foobar", the zero between them left out of the count.
        assert_eq!(serial("", ""), 0x050C_5D1F, "one zero byte");
    }
}
