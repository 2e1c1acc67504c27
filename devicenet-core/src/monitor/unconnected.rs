//! The Group 2 Only unconnected port, Message ID 6: Allocate and Release.

use cip_core::code::ServiceCode;
use cip_core::message::BodyFormat;
use cip_core::monitor::{Flaw, Seen};

use super::kind::Kind;
use super::nodes::Roles;
use super::problem::Problem;
use super::reading::Reading;
use super::requests;
use super::state::State;
use crate::id::MacId;
use crate::message::ExplicitHeader;

/// Reads a request on `0x406 + 8 slave`. Its response comes on the identifier of explicit responses.
pub(super) fn observe<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    header: ExplicitHeader,
    slave: MacId,
) {
    reading.kind = Kind::Group2UnconnectedRequest;
    reading.src = Some(header.mac);
    reading.dst = Some(slave);
    if header.mac == slave {
        reading.flag(Problem::HeaderRepeatsIdentifier { mac: slave });
    }
    if header.fragmented {
        reading.flag(Flaw::FragmentNotAllowed);
        return;
    }
    state.add_role(header.mac, Roles::MASTER);
    let frame = reading.frame;
    let body = frame.data().get(1..).unwrap_or_default();
    let seen = Seen { n: reading.n, at: reading.at };
    // Always addressed in the 8/8 format, whatever the explicit connection uses.
    let format = BodyFormat::Class8Instance8;
    let (parsed, transaction) = requests::request(reading.kind, format, seen, header.mac, header, body, 1);
    parsed.apply(reading);
    let Some(transaction) = transaction else { return };
    if !matches!(transaction.asked.service, ServiceCode::ALLOCATE | ServiceCode::RELEASE) {
        reading.flag(Flaw::UnexpectedService { service: transaction.asked.service });
    }
    if !state.node(slave).port.insert(transaction) {
        state.lost.requests = state.lost.requests.saturating_add(1);
    }
}
