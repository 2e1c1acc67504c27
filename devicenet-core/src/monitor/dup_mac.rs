//! The duplicate MAC ID check.

use core::time::Duration;

use cip_core::codec::{Reader, Wire};
use cip_core::monitor::{Flaw, Seen};
use link_core::Instant;

use super::kind::Kind;
use super::nodes::{AccessState, Identity, Node};
use super::problem::Problem;
use super::reading::{Note, Reading};
use super::state::State;
use crate::id::MacId;
use crate::message::{DeviceIdentity, Direction, DuplicateMacCheck};

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
        reading.flag(Flaw::Length { expected: 7, found });
    }
    // A message of another length claims the MAC ID all the same.
    let check = match DuplicateMacCheck::read(&mut Reader::new(data)) {
        Ok(check) => check,
        Err(error) => {
            reading.flag(Flaw::of_parse(error, data.len()));
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
    if node.repeats(check.device, at) {
        node.check = Some(Seen { n: reading.n, at });
        node.access_since = at;
        return;
    }
    let differs = node.is_another(check.device);
    let is_unidentified = node.identity.vendor.is_none() || node.identity.serial.is_none();
    let before = node.check.replace(Seen { n: reading.n, at });
    let unanswered = before.is_some();
    let rival = node.rival.take();
    // A device that has said goodbye has left its MAC ID to whoever wants it.
    let is_free = node.access == AccessState::OffLine;
    // Unless the one that was there before has gone on since.
    let is_second = unanswered && rival == Some(check.device) && node.access != AccessState::OnLine;
    let is_contested = is_unidentified
        && node.access == AccessState::FirstCheck
        && rival.is_some_and(|rival| rival != check.device);
    if (differs || is_contested) && !is_free && !is_second {
        reading.flag(Problem::TwoIdentities { mac });
        node.rival = Some(check.device);
        node.access = AccessState::SuspectedDuplicate;
        node.access_since = at;
        return;
    }
    if is_unidentified && !is_second && node.access_at(at) == AccessState::OnLine {
        // Its answer tells that it is still there, or the second check that it is not.
        node.rival = Some(check.device);
        node.access = AccessState::FirstCheck;
        node.access_since = at;
        reading.note = Some(Note::RestartedOrAnother);
        reading.assumed = true;
        state.moved(mac, check, at);
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
    if is_first || is_second {
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
    /// Whether a check is the frame again that this device has sent last. It has not been acknowledged, so its wait has not begun.
    fn repeats(&self, device: DeviceIdentity, at: Instant) -> bool {
        let identity = &self.identity;
        let known =
            identity.vendor.zip(identity.serial).map(|(vendor, serial)| DeviceIdentity { vendor, serial });
        let is_last = |before: &Seen| {
            Some(before.at) == self.traffic.last_seen() && at.saturating_since(before.at) <= REPETITION_WITHIN
        };
        self.rival.or(known) == Some(device) && self.check.as_ref().is_some_and(is_last)
    }

    /// Whether what is known of the device is not true of this one.
    fn is_another(&self, device: DeviceIdentity) -> bool {
        let held = &self.identity;
        held.vendor.is_some_and(|vendor| vendor != device.vendor)
            || held.serial.is_some_and(|serial| serial != device.serial)
    }

    fn is_known_as(&mut self, check: &DuplicateMacCheck) {
        let held = &mut self.identity;
        held.port = Some(check.port);
        (held.vendor, held.serial) = (Some(check.device.vendor), Some(check.device.serial));
    }
}

const LEN: usize = 7;
/// The second request comes one second after the first was sent; a busy bus delays it.
pub(super) const SECOND_CHECK_WITHIN: Duration = Duration::from_secs(2);
/// A frame that nobody acknowledges is sent again at once, some milliseconds later at the lowest bit rate. A second check comes a
/// second after the first: half of that tells one from the other, however late the sender of either is.
const REPETITION_WITHIN: Duration = Duration::from_millis(500);
