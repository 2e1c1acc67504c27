//! The duplicate MAC ID check.

use core::time::Duration;

use cip_core::codec::{Reader, Wire};

use super::bodies::problem_of;
use super::kind::Kind;
use super::nodes::{AccessState, Identity, Node};
use super::pairing::Seen;
use super::problem::Problem;
use super::reading::{Note, Reading};
use super::state::State;
use crate::id::MacId;
use crate::message::{Direction, DuplicateMacCheck};

/// Reads a frame on `0x407 + 8 mac`.
pub(super) fn observe<const N: usize>(state: &mut State<N>, reading: &mut Reading<'_>, mac: MacId) {
    let frame = reading.frame;
    let data = frame.data();
    reading.src = Some(mac);
    let direction = data.first().map_or(Direction::Request, |&byte| Direction::of(byte));
    reading.kind = match direction {
        Direction::Request => Kind::DupMacRequest,
        Direction::Response => Kind::DupMacResponse,
    };
    if data.len() != LEN {
        let found = u16::try_from(data.len()).unwrap_or_default();
        reading.flag(Problem::Length { expected: 7, found });
    }
    // A message of another length claims the MAC ID all the same.
    let check = match DuplicateMacCheck::read(&mut Reader::new(data)) {
        Ok(check) => check,
        Err(error) => {
            reading.flag(problem_of(error, data.len()));
            return;
        }
    };
    reading.fields.port = Some(check.port.number());
    reading.fields.vendor = Some(check.device.vendor);
    reading.fields.serial = Some(check.device.serial);
    match direction {
        Direction::Request => request(state, reading, mac, &check),
        Direction::Response => response(state, reading, mac, &check),
    }
}

fn request<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    mac: MacId,
    check: &DuplicateMacCheck,
) {
    let at = reading.at;
    let node = state.node(mac);
    let device = (Some(check.device.vendor), Some(check.device.serial));
    let known = (node.identity.vendor, node.identity.serial);
    let differs = match known {
        (Some(_), Some(_)) => known != device,
        (vendor, serial) => {
            (vendor.is_some() && vendor != device.0) || (serial.is_some() && serial != device.1)
        }
    };
    let before = node.check.replace(Seen { n: reading.n, at });
    let unanswered = before.is_some();
    let rival = node.rival.take();
    // A device that has said goodbye has left its MAC ID to whoever wants it.
    let is_free = node.access == AccessState::OffLine;
    if differs && !is_free && !(unanswered && rival == Some(check.device)) {
        reading.flag(Problem::TwoIdentities { mac });
        node.rival = Some(check.device);
        node.access = AccessState::SuspectedDuplicate;
        node.access_since = at;
        return;
    }
    if differs {
        // Nobody has objected to its first check, or nobody is there to do so: a device was replaced.
        node.identity = Identity::default();
        node.name.clear();
        node.access = AccessState::FirstCheck;
    }
    node.is_known_as(check);
    let since = at.saturating_since(node.access_since);
    let access = node.access_at(at);
    let follows = before.is_some_and(|before| at.saturating_since(before.at) <= SECOND_CHECK_WITHIN);
    if core::mem::take(&mut node.half_checked) && access == AccessState::OnLine && follows {
        // Quick Connect: on line since the first check.
        return;
    }
    node.access_since = at;
    node.access = match access {
        AccessState::FirstCheck if since <= SECOND_CHECK_WITHIN => AccessState::SecondCheck,
        AccessState::Unknown | AccessState::FirstCheck => AccessState::FirstCheck,
        AccessState::SecondCheck | AccessState::OnLine => AccessState::FirstCheck,
        AccessState::Faulted | AccessState::OffLine => AccessState::FirstCheck,
        // It starts anew: another objects, or it has the MAC ID after both checks.
        AccessState::SuspectedDuplicate => AccessState::FirstCheck,
    };
    let is_first = node.access == AccessState::FirstCheck;
    if access == AccessState::OnLine {
        reading.note = Some(Note::Restarted);
    }
    state.moved(mac, check, at);
    if is_first {
        // Whoever checks has no connections.
        state.drop_connections(mac, at);
    }
}

fn response<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    mac: MacId,
    check: &DuplicateMacCheck,
) {
    let node = state.node(mac);
    match node.check.take() {
        Some(request) => reading.request = Some(request.answered(reading.at)),
        None => reading.assumed = true,
    }
    reading.flag(Problem::DuplicateMacId { mac });
    // Only a node on line answers, and it stays there: the other one loses.
    node.is_known_as(check);
    node.access = AccessState::OnLine;
    node.half_checked = false;
    node.access_since = reading.at;
    state.moved(mac, check, reading.at);
}

impl Node {
    fn is_known_as(&mut self, check: &DuplicateMacCheck) {
        let held = &mut self.identity;
        held.port = Some(check.port);
        (held.vendor, held.serial) = (Some(check.device.vendor), Some(check.device.serial));
    }
}

const LEN: usize = 7;
/// The second request comes one second after the first was sent; a busy bus delays it.
pub(super) const SECOND_CHECK_WITHIN: Duration = Duration::from_secs(2);
