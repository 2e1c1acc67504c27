//! Device Heartbeat and Device Shutdown.

use core::time::Duration;

use cip_core::code::ServiceCode;
use cip_core::codec::{ParseError, Wire};
use cip_core::monitor::Flaw;

use super::kind::Kind;
use super::problem::Problem;
use super::reading::{Detail, Reading};
use super::state::State;
use crate::id::MacId;
use crate::message::{ExplicitHeader, Heartbeat, HeartbeatFlags, Shutdown};

/// The kind of broadcast that a frame on a response identifier is, if it is one.
///
/// On the UCMM identifier the service tells it. On the identifier of explicit responses the same service codes can
/// answer a request of a class, and only the header, which repeats the identifier's MAC ID, tells them apart.
pub(super) fn recognise(header: ExplicitHeader, data: &[u8], sender: MacId, is_ucmm: bool) -> Option<Kind> {
    if header.fragmented || !(is_ucmm || header.mac == sender) {
        return None;
    }
    match data.get(1).map(|&byte| ServiceCode::split(byte))? {
        (HEARTBEAT, true) => Some(Kind::Heartbeat),
        (SHUTDOWN, true) => Some(Kind::Shutdown),
        _ => None,
    }
}

/// Reads a frame that [`recognise`] has recognised.
pub(super) fn observe<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    header: ExplicitHeader,
    sender: MacId,
    kind: Kind,
) {
    reading.kind = kind;
    reading.src = Some(sender);
    if header.mac != sender {
        reading.flag(Problem::HeaderNotSender { found: header.mac });
    }
    if header.xid {
        reading.flag(Flaw::ReservedBits { field: "header" });
    }
    let frame = reading.frame;
    // The header is judged above.
    let mut data = [0; 8];
    let len = frame.data().len();
    if let Some(copy) = data.get_mut(..len) {
        copy.copy_from_slice(frame.data());
    }
    if let Some(first) = data.first_mut() {
        *first = sender.number();
    }
    let data = data.get(..len).unwrap_or_default();
    let result = match kind {
        Kind::Heartbeat => heartbeat(state, reading, sender, data),
        _ => shutdown(state, reading, sender, data),
    };
    if let Err(error) = result {
        reading.flag(Flaw::of_parse(error, len));
    }
}

fn heartbeat<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    sender: MacId,
    data: &[u8],
) -> Result<(), ParseError> {
    reading.fields.explicit.service = Some(HEARTBEAT);
    let heartbeat = Heartbeat::parse(data)?;
    reading.fields.explicit.instance = Some(heartbeat.instance);
    reading.fields.detail = Detail::Heartbeat {
        state: heartbeat.state.0,
        flags: heartbeat.flags.bits(),
        consistency: heartbeat.configuration_consistency,
    };
    if heartbeat.flags.reserved_bits() != 0 {
        reading.flag(Flaw::ReservedBits { field: "heartbeat flags" });
    }
    if heartbeat.flags.contains(HeartbeatFlags::EVENT) {
        reading.flag(Problem::HeartbeatEvent);
    }
    let node = state.node(sender);
    let before = node.heartbeat.replace(reading.at);
    if let (Some(before), Some(interval @ 1..)) = (before, node.heartbeat_interval) {
        let after = reading.at.saturating_since(before);
        if after > Duration::from_secs(interval.into()).saturating_mul(2) {
            let after = u16::try_from(after.as_secs()).unwrap_or(u16::MAX);
            reading.flag(Problem::HeartbeatMissing { after, interval: interval.into() });
        }
    }
    Ok(())
}

fn shutdown<const N: usize>(
    state: &mut State<N>,
    reading: &mut Reading<'_>,
    sender: MacId,
    data: &[u8],
) -> Result<(), ParseError> {
    reading.fields.explicit.service = Some(SHUTDOWN);
    state.drop_connections(sender, reading.at);
    let node = state.node(sender);
    node.heartbeat = None;
    node.goes_off_line(reading.at);
    let shutdown = Shutdown::parse(data)?;
    reading.fields.explicit.class = Some(shutdown.class);
    reading.fields.explicit.instance = Some(shutdown.instance);
    reading.fields.detail = Detail::Shutdown { code: shutdown.code.0 };
    Ok(())
}

pub(super) const HEARTBEAT: ServiceCode = ServiceCode(0x4D);
pub(super) const SHUTDOWN: ServiceCode = ServiceCode(0x4E);
