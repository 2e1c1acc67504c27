//! Hello, Mini-who and ROAM: how nodes get their addresses.

use core::time::Duration;

use cip_core::monitor::{Flaw, Seen};
use link_core::Instant;

use super::kind::Kind;
use super::nodes::{AccessState, Node, Roles, SECOND_HELLO_WITHIN};
use super::problem::Problem;
use super::reading::{Detail, Note, Reading, Stage};
use super::state::State;
use crate::id::{Direction, OperationalAddress};
use crate::message::{DeviceIdentity, Hello, PortByte, Roam, RoamData, Wire};

/// Reads a frame of class 11111.
pub(super) fn observe<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    source: OperationalAddress,
    direction: Direction,
    serial_low: u16,
) {
    if reading.frame.is_remote() {
        if source.is_none() && direction == Direction::Request {
            mini_who(state, reading, serial_low);
        } else {
            reading.flag(Problem::RemoteFrame);
        }
        return;
    }
    reading.src = Some(source);
    reading.kind = match direction {
        Direction::Request => Kind::HelloRequest,
        Direction::Response => Kind::HelloResponse,
    };
    let data = reading.frame;
    let hello = match Hello::of_frame(&data) {
        Some(Ok(hello)) => hello,
        Some(Err(error)) => {
            reading.flag(Flaw::of_parse(error, data.data().len()));
            return;
        }
        None => return,
    };
    let Hello { device, port, .. } = hello;
    reading.fields.device = Some(device);
    reading.fields.port = Some(port.number());
    if port.is_reserved() {
        reading.flag(Flaw::ReservedBits { field: "port number" });
    }
    match direction {
        Direction::Response => response(state, reading, source, device, port),
        Direction::Request if source.is_none() => newcomer(state, reading, device, port),
        Direction::Request => request(state, reading, source, device, port),
    }
}

/// A device without an address says Hello.
fn newcomer<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    device: DeviceIdentity,
    port: PortByte,
) {
    let at = reading.at;
    let serial_low = device.serial_low();
    let shares =
        |node: &Node| node.device.is_some_and(|other| other != device && other.serial_low() == serial_low);
    if state.newcomers().any(shares) {
        reading.flag(Problem::SharedSerialHalf { serial_low });
    }
    if let Some(from) = leave_others(state, device, port, OperationalAddress::NONE, at) {
        reading.note = Some(Note::Moved { from });
    }
    let mini_who = state.mini_who;
    let Some(node) = state.newcomer(device) else { return };
    node.port = Some(port.number());
    let access = node.access_at(at);
    let since = at.saturating_since(node.access_since);
    // One that came after its last Hello.
    let asked = mini_who.filter(|asked| node.hello.is_none_or(|hello| asked.n > hello.n));
    node.hello = Some(Seen { n: reading.n, at });
    let waits = matches!(access, AccessState::Standby | AccessState::Unknown);
    let stage = match (access, asked) {
        (_, Some(asked)) if waits && at.saturating_since(asked.at) <= ANSWER_WITHIN => {
            reading.request = Some(asked.answered(at));
            reading.assumed = access == AccessState::Unknown;
            node.enter(AccessState::Standby, at);
            Stage::Asked
        }
        (AccessState::FirstHello, _) if since <= SECOND_HELLO_WITHIN => {
            node.enter(AccessState::SecondHello, at);
            Stage::Second
        }
        _ => {
            if matches!(access, AccessState::Standby) {
                reading.note = Some(Note::Restarted);
            }
            node.enter(AccessState::FirstHello, at);
            Stage::First
        }
    };
    reading.fields.detail = Detail::Hello(stage);
    if stage == Stage::Asked
        && let Some((roam, _)) = node.roam.take()
    {
        // It would have the address by now.
        reading.flag(Problem::RoamWithoutEffect { n: roam.n });
    }
}

/// A node that has an address, or wants it, says Hello.
fn request<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    address: OperationalAddress,
    device: DeviceIdentity,
    port: PortByte,
) {
    let at = reading.at;
    let roamed = state.newcomers().any(|node| node.device == Some(device));
    let before = if roamed { state.take_newcomer(device) } else { None };
    let roam = before.and_then(|node| node.roam).filter(|&(_, requested)| requested == address);
    if let Some((roam, _)) = roam {
        reading.request = Some(roam.answered(at));
    }
    let moved = leave_others(state, device, port, address, at);
    let Some(node) = state.node(address) else { return };
    let access = node.access_at(at);
    let since = at.saturating_since(node.access_since);
    let is_follow_up = node.hello.is_some() && since <= SECOND_HELLO_WITHIN;
    node.hello = Some(Seen { n: reading.n, at });
    let is_new = node.device.is_none_or(|held| held != device);
    let is_free = matches!(access, AccessState::Unknown | AccessState::OffLine) && node.device.is_none();
    // It has asked before, and nobody has objected.
    let is_unopposed = node.rival == Some(device) && access != AccessState::OnLine;
    let mut stage = Stage::First;
    match node.device {
        Some(_) if is_new && !is_free && roam.is_none() && !is_unopposed => {
            reading.flag(Problem::TwoIdentities { address });
            stage = if node.rival == Some(device) { Stage::Second } else { Stage::First };
            node.rival = Some(device);
            if access != AccessState::OnLine {
                node.enter(AccessState::Contested, at);
            }
        }
        held => {
            let is_second = is_unopposed
                || roam.is_none() && access == AccessState::FirstHello && is_follow_up && !is_new;
            if is_second {
                stage = Stage::Second;
            }
            reading.note = match held {
                Some(_) if is_new => Some(Note::Replaced),
                Some(_) if matches!(access, AccessState::OnLine) => Some(Note::Restarted),
                _ => moved.map(|from| Note::Moved { from }),
            };
            node.becomes(device);
            node.port = Some(port.number());
            node.enter(if is_second { AccessState::SecondHello } else { AccessState::FirstHello }, at);
            if !is_second {
                // Whoever says Hello has no connections.
                state.lapse(address);
            }
        }
    }
    reading.fields.detail = Detail::Hello(stage);
}

/// A node on line says that it has the address.
fn response<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    address: OperationalAddress,
    device: DeviceIdentity,
    port: PortByte,
) {
    reading.fields.detail = Detail::Hello(Stage::Response);
    let Some(node) = state.node(address) else {
        reading.flag(Problem::ResponseWithoutAddress);
        return;
    };
    // Whoever has just asked for the address, if it is another device.
    let asked = match node.device {
        Some(held) if held == device => node.hello.filter(|_| node.rival.is_some()),
        _ => node.hello.filter(|hello| reading.at.saturating_since(hello.at) <= SECOND_HELLO_WITHIN),
    };
    match asked {
        Some(hello) => {
            reading.request = Some(hello.answered(reading.at));
            reading.flag(Problem::AddressTaken { address });
        }
        // Nobody has: the node tells from time to time that it is there.
        None => {
            reading.fields.detail = Detail::Hello(Stage::Announcement);
            if node.device.is_some_and(|held| held != device) {
                reading.flag(Problem::TwoIdentities { address });
            }
        }
    }
    node.hello = None;
    node.becomes(device);
    node.port = Some(port.number());
    node.enter(AccessState::OnLine, reading.at);
}

fn mini_who<const N: usize>(state: &mut State<N>, reading: &mut Reading<'_>, serial_low: u16) {
    reading.kind = Kind::MiniWho;
    reading.dst = Some(OperationalAddress::NONE);
    reading.fields.detail = Detail::MiniWho { serial_low };
    let is_sender = |node: &&Node| {
        let is_its = node.device.is_some_and(|device| device.serial_low() == serial_low);
        is_its && !node.address.is_none()
    };
    let only = {
        let mut senders = state.nodes().filter(is_sender).map(|node| node.address);
        senders.next().filter(|_| senders.next().is_none())
    };
    reading.src = only;
    if let Some(sender) = only.and_then(|address| state.node(address)) {
        sender.roles |= Roles::MANAGER;
        sender.takes_part(reading.at);
    }
    match state.manager {
        Some(first) if first != serial_low => reading.flag(Problem::SecondManager { first }),
        _ => state.manager = Some(serial_low),
    }
    state.mini_who = Some(Seen { n: reading.n, at: reading.at });
}

/// Reads a frame of class 11110.
pub(super) fn roam<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    destination: OperationalAddress,
    serial_low: u16,
) {
    if reading.frame.is_remote() {
        reading.flag(Problem::RemoteFrame);
        return;
    }
    reading.kind = Kind::Roam;
    reading.dst = Some(destination);
    if !destination.is_none() {
        reading.flag(Problem::RoamToAddress { destination });
    }
    let frame = reading.frame;
    let roam = match RoamData::parse(frame.data()) {
        Ok(roam) => {
            Roam { target: DeviceIdentity::of_halves(serial_low, roam.target), requested: roam.requested }
        }
        Err(error) => {
            reading.flag(Flaw::of_parse(error, frame.data().len()));
            return;
        }
    };
    reading.fields.device = Some(roam.target);
    reading.fields.detail = Detail::Roam { requested: roam.requested };
    if roam.requested.is_none() {
        reading.flag(Flaw::ReservedValue { field: "requested OA", found: 127 });
        return;
    }
    if !destination.is_none() {
        return;
    }
    let Some(node) = state.newcomer(roam.target) else { return };
    let before = node.roam.replace((Seen { n: reading.n, at: reading.at }, roam.requested));
    if let Some((before, _)) = before {
        reading.flag(Problem::RoamWithoutEffect { n: before.n });
    }
}

/// The device has gone from every other address, which is returned, unless it is there with another of its ports.
fn leave_others<const N: usize>(
    state: &mut State<N>,
    device: DeviceIdentity,
    port: PortByte,
    to: OperationalAddress,
    at: Instant,
) -> Option<OperationalAddress> {
    let mut from = None;
    for node in state.nodes_mut().filter(|node| node.address != to) {
        node.rival = node.rival.filter(|&rival| rival != device);
        let is_port = node.port.is_none_or(|held| held == port.number());
        if is_port && node.device == Some(device) {
            from = Some(node.address);
            node.leaves(at);
        }
    }
    if let Some(address) = from {
        state.lapse(address);
    }
    from
}

/// A device in Standby answers a Mini-who at once; hundreds of them on a slow bus need their time.
const ANSWER_WITHIN: Duration = Duration::from_secs(1);
