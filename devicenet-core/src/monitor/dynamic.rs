//! Identifiers that UCMM assigns: Group 1 Message IDs 0-11, Group 3 Message IDs 0-4, and Group 2 Message IDs 0-5 while
//! a connection uses them.

use cip_core::fragment::{FragmentByte, FragmentKind};
use cip_core::monitor::{Flaw, Flow, Frag, Slots, Span, Stream};

use super::FragmentationGuess;
use super::created;
use super::explicit::{self, Route};
use super::kind::Kind;
use super::reading::{Message, Reading};
use super::state::{Link, State};
use super::ucmm;
use crate::id::{Identifier, MacId, MessageGroup};
use crate::message::{Direction, ExplicitHeader};

/// Reads a frame on a dynamic identifier of Group 1 or 3.
pub(super) fn observe<'s, const N: usize, const B: usize>(
    state: &mut State<N>,
    slots: &'s mut Slots<N, B>,
    reading: &mut Reading<'_>,
    identifier: Identifier,
    guess: FragmentationGuess,
) -> Option<Message<'s>> {
    if let Some(ends) = created::find(state, identifier) {
        return created::observe(state, slots, reading, ends, guess);
    }
    let frame = reading.frame;
    let header = frame.data().first().copied().map(ExplicitHeader::from);
    if let Some(header) = header
        && let Some(route) = route(state, reading, identifier, header)
    {
        return explicit::observe(state, slots, reading, header, &route);
    }
    reading.src = identifier.mac_id();
    reading.assumed = true;
    if identifier.group() == MessageGroup::Group1 {
        // Group 1 is for I/O; without the configuration the data stay as they are.
        reading.kind = Kind::Io;
        reading.fields.explicit.value = Span::tail(frame.data().len(), frame.data().len());
        return None;
    }
    unassigned(reading, header);
    None
}

/// Reads a frame of Group 2 if it belongs to a connection that UCMM has opened there.
pub(super) fn group2<const N: usize>(
    state: &State<N>,
    reading: &Reading<'_>,
    identifier: Identifier,
) -> Option<(ExplicitHeader, Route)> {
    let header = ExplicitHeader::from(*reading.frame.data().first()?);
    let (index, flow) = state.find_dynamic(identifier, header.mac)?;
    Some((header, route_of(state, index, flow, identifier, header)?))
}

fn route<const N: usize>(
    state: &mut State<N>,
    reading: &Reading<'_>,
    identifier: Identifier,
    header: ExplicitHeader,
) -> Option<Route> {
    if let Some((index, flow)) = state.find_dynamic(identifier, header.mac) {
        return route_of(state, index, flow, identifier, header);
    }
    let adopted = ucmm::adopt(state, reading.at, identifier, header.mac);
    let index = match (adopted, identifier.group()) {
        (Some(index), _) => index,
        (None, MessageGroup::Group3) => {
            let from_client = direction(header, reading.frame.data())? == Direction::Request;
            ucmm::unknown(state, reading.at, identifier, header.mac, from_client)?
        }
        (None, _) => return None,
    };
    let flow = state.dynamics.get(index)?.as_ref()?.flow(identifier, header.mac)?;
    route_of(state, index, flow, identifier, header)
}

fn route_of<const N: usize>(
    state: &State<N>,
    index: usize,
    flow: Flow,
    identifier: Identifier,
    header: ExplicitHeader,
) -> Option<Route> {
    let dynamic = state.dynamics.get(index)?.as_ref()?;
    let opposite = match flow {
        Flow::Consumed => dynamic.responses.map(|id| (id, dynamic.client)),
        Flow::Produced if dynamic.group == 2 => dynamic.requests.map(|id| (id, dynamic.client)),
        Flow::Produced => dynamic.requests.map(|id| (id, dynamic.server)),
    };
    Some(Route {
        link: Link { server: dynamic.server, dynamic: Some(index) },
        flow,
        client: dynamic.client,
        stream: Stream::explicit(identifier.raw(), header.mac.number()),
        opposite: opposite.map(|(id, mac)| Stream::explicit(id.raw(), mac.number())),
        intrudes: false,
    })
}

/// Whether the first bytes of a message are those of a request: only then can the connection's ends be told apart.
fn direction(header: ExplicitHeader, data: &[u8]) -> Option<Direction> {
    if !header.fragmented {
        return data.get(1).map(|&service| Direction::of(service));
    }
    let byte = FragmentByte::from(*data.get(1)?);
    (byte == FragmentByte::FIRST).then(|| data.get(2).map(|&service| Direction::of(service)))?
}

/// A fragment or stump on an identifier of Group 3 about which nothing is known.
fn unassigned(reading: &mut Reading<'_>, header: Option<ExplicitHeader>) {
    let frame = reading.frame;
    let Some(header) = header else {
        reading.kind = Kind::ExplicitRequest;
        reading.flag(Flaw::TooShort { at_least: 2, found: 0 });
        return;
    };
    reading.dst = Some(header.mac).filter(|&mac: &MacId| Some(mac) != reading.src);
    reading.kind = if header.fragmented { Kind::Fragment } else { Kind::ExplicitRequest };
    let Some(&byte) = frame.data().get(1) else {
        reading.flag(Flaw::TooShort { at_least: 2, found: 1 });
        return;
    };
    if !header.fragmented {
        return;
    }
    let byte = FragmentByte::from(byte);
    let mut frag = Frag::new(byte);
    if byte.kind == FragmentKind::Acknowledge {
        reading.kind = Kind::FragmentAck;
        frag.status = frame.data().get(2).copied();
    }
    reading.frag = Some(frag);
}
