//! Whether the command may transmit.

use devicenet_core::MacId;
use link_core::Port as _;

use super::args::PermitArgs;
use super::endpoint::Endpoint;
use super::listen::{Heard, Link};
use super::port::LivePort;
use crate::exit::Failure;
use crate::output;
use crate::simulate;

/// Opens an endpoint for a machine that will send, says what, and listens first; refuses where the command line or what was heard does
/// not allow it.
pub(super) fn enter(
    endpoint: &Endpoint,
    args: &PermitArgs,
    own: MacId,
    what: &str,
    max_in_flight: usize,
) -> Result<(LivePort, Heard), Failure> {
    if let Endpoint::Recording(_) = endpoint {
        return Err(Failure::Usage(format!(
            "{endpoint} is a recording, which cannot be asked: name an interface such as can0, or sim:FILE"
        )));
    }
    let interrupted = simulate::interruption()?;
    let mut port = LivePort::open(endpoint, max_in_flight)?;
    port.set_interruption(interrupted);
    announce(endpoint, args, &port, own, what)?;
    let mut heard = Heard::new();
    let until = port.now() + args.listen.0;
    heard.listen(&mut port, until)?;
    if port.is_interrupted() {
        return Err(Failure::Interrupted("interrupted before anything was sent".into()));
    }
    if let Some(at) = port.over() {
        return Err(endpoint.ended_before(at, "anything was sent"));
    }
    bit_rate(endpoint, args, &port, &heard)?;
    Ok((port, heard))
}

/// Says what will be sent, and to whom; refuses where the command line or the interface does not allow it.
fn announce(
    endpoint: &Endpoint,
    args: &PermitArgs,
    port: &LivePort,
    own: MacId,
    what: &str,
) -> Result<(), Failure> {
    match endpoint {
        Endpoint::Interface(_) if !args.allow_tx => Err(Failure::Refused(format!(
            "would send on {endpoint} as MAC ID {own}: duplicate MAC ID checks, then {what}; say --allow-tx to do it"
        ))),
        Endpoint::Interface(_) if port.is_listen_only() => Err(Failure::Refused(format!(
            "{endpoint} is listen-only, so it sends nothing; as root: ip link set {endpoint} down && ip link set {endpoint} type \
             can listen-only off && ip link set {endpoint} up"
        ))),
        Endpoint::Interface(_) | Endpoint::Scenario(_) | Endpoint::Recording(_) => {
            output::note(format_args!(
                "sends on {endpoint} as MAC ID {own}: duplicate MAC ID checks, then {what}"
            ));
            Ok(())
        }
    }
}

/// Fails where nothing can be sent or heard.
pub(super) fn link(endpoint: &Endpoint, heard: &Heard) -> Result<(), Failure> {
    match heard.link() {
        Link::Up => Ok(()),
        Link::Down => Err(down(endpoint)),
        Link::BusOff => Err(bus_off(endpoint)),
    }
}

pub(super) fn down(endpoint: &Endpoint) -> Failure {
    Failure::Transport(format!("{endpoint} is down; as root: ip link set {endpoint} up"))
}

pub(super) fn bus_off(endpoint: &Endpoint) -> Failure {
    Failure::Transport(format!(
        "{endpoint} is off the bus (bus-off), after too many errors while it sent: check the bit rate, the cable and its \
         terminators; then, as root: ip link set {endpoint} type can restart"
    ))
}

/// Refuses to transmit where the bit rate may be wrong: one frame at a wrong rate disturbs everybody.
fn bit_rate(endpoint: &Endpoint, args: &PermitArgs, port: &LivePort, heard: &Heard) -> Result<(), Failure> {
    link(endpoint, heard)?;
    if heard.frames > 0 || args.assume_bit_rate || !port.has_bit_rate() {
        return Ok(());
    }
    Err(Failure::Refused(match heard.errors {
        0 => format!(
            "nothing was heard on {endpoint} in {}, so its bit rate is not confirmed: listen longer with --listen, or say \
             --assume-bit-rate if nobody sends there",
            args.listen
        ),
        errors => format!(
            "only errors ({errors}) and no frame were heard on {endpoint}: its bit rate is likely wrong; as root: ip link \
             set {endpoint} down && ip link set {endpoint} type can bitrate 125000 && ip link set {endpoint} up (or 250000, 500000)"
        ),
    }))
}

/// Refuses to talk to a node that another master has.
pub(super) fn ownership(mac: MacId, heard: &Heard) -> Result<(), Failure> {
    if is_owned(mac, heard) { Err(Failure::Refused(owned(mac))) } else { Ok(()) }
}

/// Whether it was heard that another master has a node. Which one is told, if that was heard too.
pub(super) fn is_owned(mac: MacId, heard: &Heard) -> bool {
    let master = heard.master_of(mac);
    if let Some(Some(master)) = master {
        output::note(format_args!("node {mac} has its master at MAC ID {master}"));
    }
    master.is_some()
}

/// The same words whether it was heard, or the node says so.
pub(super) fn owned(mac: MacId) -> String {
    format!(
        "node {mac} belongs to another master, and is left alone: ask it through that master, or take it off its scan list first"
    )
}
