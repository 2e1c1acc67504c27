//! What requests say, from the service byte on.

use cip_core::code::{ClassId, ServiceCode};
use cip_core::codec::Wire;
use cip_core::message::{AllocateRequest, AllocationChoice, BodyFormat, ReleaseRequest};
use cip_core::monitor::packet::has_parts;
use cip_core::monitor::{Explicit, Flaw, Seen, Vocabulary, likely_format};

use super::bodies::Parsed;
use super::explicit::{Knowledge, Route};
use super::kind::Kind;
use super::pairing::Transaction;
use super::reading::{Detail, Fields};
use super::state::State;
use crate::id::MacId;
use crate::message::ExplicitHeader;

/// Reads a request on an explicit connection.
pub(super) fn connected<const N: usize>(
    state: &mut State<N>,
    route: &Route,
    seen: Seen,
    header: ExplicitHeader,
    body: &[u8],
    before: usize,
) -> Parsed {
    let channel = state.channel(route.link);
    if channel.knowledge == Knowledge::None
        && let Some(format) = likely_format(body)
    {
        channel.format = format;
    }
    let assumed = channel.knowledge != Knowledge::Told;
    let (mut parsed, transaction) =
        request(Kind::ExplicitRequest, channel.format, seen, route.client, header, body, before);
    parsed.assumed = assumed;
    channel.asked = true;
    let format = channel.format;
    // The server ignores a client that does not own the connection: the request of the one that does waits on.
    let waits = channel.pending.is_some_and(|held| held.requester != route.client);
    if route.intrudes && waits {
        return parsed;
    }
    let Some(transaction) = transaction else { return parsed };
    channel.pending = Some(Transaction { assumed, ..transaction });
    if has_parts(transaction.asked.service) {
        let kept = state.packets.keep(seen.n, &transaction.asked, format, body, &Vocabulary::DEVICENET);
        if kept.is_other_lost {
            state.lost.requests = state.lost.requests.saturating_add(1);
        }
        parsed.problem = parsed.problem.or(kept.flaw.map(Into::into).filter(|_| !assumed));
    }
    parsed
}

/// Reads a request in a body format.
pub(super) fn request(
    kind: Kind,
    format: BodyFormat,
    seen: Seen,
    requester: MacId,
    header: ExplicitHeader,
    body: &[u8],
    before: usize,
) -> (Parsed, Option<Transaction>) {
    let read = Explicit::request(format, body, before);
    let mut parsed = Parsed::new(kind);
    parsed.fields = Fields { explicit: read.explicit, ..Fields::default() };
    parsed.problem = read.flaw.map(Into::into);
    if read.explicit.class == Some(ClassId::DEVICENET) {
        match read.explicit.service {
            Some(ServiceCode::ALLOCATE) => allocate(read.data, &mut parsed),
            Some(ServiceCode::RELEASE) => release(read.data, &mut parsed),
            _ => {}
        }
    }
    let transaction =
        read.asked.map(|asked| Transaction { seen, requester, xid: header.xid, asked, assumed: false });
    (parsed, transaction)
}

fn allocate(data: &[u8], parsed: &mut Parsed) {
    parsed.fields.explicit.value = None;
    match AllocateRequest::parse(data) {
        Ok(AllocateRequest { choice, allocator }) => {
            parsed.fields.choice = Some(choice);
            parsed.fields.detail = Detail::Allocate { allocator };
            if !AllocationChoice::all().contains(choice) {
                parsed.flag(Flaw::ReservedBits { field: "allocation choice" });
            }
            if MacId::new(allocator).is_none() {
                parsed.flag(Flaw::ReservedBits { field: "allocator's MAC ID" });
            }
        }
        Err(error) => {
            if let Some(&choice) = data.first() {
                parsed.fields.choice = Some(AllocationChoice::from_bits_retain(choice));
            }
            parsed.flag(Flaw::of_parse(error, data.len()));
        }
    }
}

fn release(data: &[u8], parsed: &mut Parsed) {
    parsed.fields.explicit.value = None;
    match ReleaseRequest::parse(data) {
        Ok(ReleaseRequest { choice }) => {
            parsed.fields.choice = Some(choice);
            // Bit 6 is reserved as well, but products set it and receivers ignore it.
            if !AllocationChoice::all().contains(choice) {
                parsed.flag(Flaw::ReservedBits { field: "release choice" });
            }
        }
        Err(error) => {
            if let Some(&choice) = data.first() {
                parsed.fields.choice = Some(AllocationChoice::from_bits_retain(choice));
            }
            parsed.flag(Flaw::of_parse(error, data.len()));
        }
    }
}
