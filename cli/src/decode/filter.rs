//! Which frames of a CAN bus are shown.

use devicenet_core::MacId;
use devicenet_core::monitor::{Detail, Kind, Reading};
use devicenex_core::OperationalAddress;
use devicenex_core::monitor as nex;
use link_core::Instant;

use super::meaning::Meaning;
use super::span::Span;
use crate::args::DecodeArgs;

/// Which frames are shown.
pub(super) struct Filter {
    span: Span,
    pub(super) mac: Option<u8>,
    kinds: Vec<&'static str>,
}

impl Filter {
    pub(super) fn new(args: &DecodeArgs) -> Self {
        Self { span: Span::new(args), mac: args.mac, kinds: args.kind.clone() }
    }

    /// Whether the time is right.
    #[inline]
    pub(super) fn is_within(&mut self, at: Instant) -> bool {
        self.span.contains(at)
    }

    #[inline]
    pub(super) fn accepts(&self, meaning: &Meaning<'_>) -> bool {
        let is_of_node = self.mac.is_none_or(|mac| match meaning {
            Meaning::Read(reading) => concerns(reading, mac),
            Meaning::Nex(reading) => concerns_address(reading, mac),
            Meaning::Outside(_) => false,
        });
        is_of_node && (self.kinds.is_empty() || self.kinds.contains(&meaning.kind()))
    }
}

/// Whether a frame of DeviceNeX is from a node, to it, or to all; or gives it its address.
fn concerns_address(reading: &nex::Reading<'_>, address: u8) -> bool {
    let is_node = |end: Option<OperationalAddress>| end.map(u8::from) == Some(address);
    let is_to_all = reading.kind == nex::Kind::MiniWho;
    let is_new =
        matches!(reading.fields.detail, nex::Detail::Roam { requested } if u8::from(requested) == address);
    is_to_all || is_new || is_node(reading.src) || is_node(reading.dst)
}

/// Whether a frame is from a node, to it, or to all.
fn concerns(reading: &Reading<'_>, mac: u8) -> bool {
    let is_node = |end: Option<MacId>| end.map(u8::from) == Some(mac);
    let is_to_all = match reading.kind {
        Kind::BitStrobeCommand | Kind::MulticastPollCommand => true,
        // Unless it names the one node that it is for, or from.
        Kind::OfflineFaultRequest | Kind::OfflineOwnershipRequest => reading.dst.is_none(),
        Kind::OfflineFaultResponse | Kind::OfflineOwnershipResponse => reading.src.is_none(),
        _ => false,
    };
    let is_new_mac = matches!(reading.fields.detail, Detail::ChangeMacId { mac: new } if new.number() == mac);
    is_to_all || is_new_mac || is_node(reading.src) || is_node(reading.dst)
}
