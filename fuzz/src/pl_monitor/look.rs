//! What the second program sees of a frame.

use powerlink_core::monitor::{Captured, Kind};

/// A frame by its offsets.
pub(super) struct Look<'a> {
    /// From the message type on.
    pub(super) powerlink: &'a [u8],
    pub(super) source: [u8; 6],
    pub(super) kind: Kind,
    /// All of its message is there.
    pub(super) is_whole: bool,
}

impl<'a> Look<'a> {
    pub(super) fn at(frame: Captured<'a>) -> Self {
        let bytes = frame.bytes;
        let invalid = Look { powerlink: &[], source: [0; 6], kind: Kind::Invalid, is_whole: false };
        let Some(&[high, low]) = bytes.get(12..14) else { return invalid };
        let header = if [high, low] == [0x81, 0x00] { 18 } else { 14 };
        let Some(powerlink) = bytes.get(header..) else { return invalid };
        let source = bytes[6..12].try_into().expect("six");
        if bytes[header - 2..header] != [0x88, 0xAB] {
            return Look { powerlink: &[], source, kind: Kind::Foreign, is_whole: false };
        }
        let Some(&[message_type, _, _]) = powerlink.get(..3) else {
            return Look { powerlink: &[], source, kind: Kind::Invalid, is_whole: false };
        };
        let size = powerlink.get(8..10).map_or(0, |size| usize::from(u16::from_le_bytes([size[0], size[1]])));
        let service = powerlink.get(3).copied();
        let (kind, need) = match (message_type & 0x7F, service) {
            (0x01, _) => (Kind::Soc, 22),
            (0x03, _) => (Kind::Preq, 10 + size),
            (0x04, _) => (Kind::Pres, 10 + size),
            (0x05, _) => (Kind::Soa, 9),
            (0x06, None) => (Kind::Invalid, 4),
            (0x06, Some(0x01)) => (Kind::AsndIdentResponse, 162),
            (0x06, Some(0x02)) => (Kind::AsndStatusResponse, 58),
            (0x06, Some(0x03)) => (Kind::AsndNmtRequest, 6),
            (0x06, Some(0x04)) => (Kind::AsndNmtCommand, 6),
            (0x06, Some(0x05)) => (Kind::AsndSdo, 8 + sdo_command(powerlink.get(8..).unwrap_or_default())),
            (0x06, Some(_)) => (Kind::AsndOther, 4),
            (0x07, _) => (Kind::Amni, 3),
            (0x0D, _) => (Kind::Ainv, 3),
            _ => (Kind::Reserved, 3),
        };
        let is_whole = powerlink.len() >= need;
        let is_cut = bytes.len() < frame.length && need != IMPOSSIBLE;
        let has_length = matches!(kind, Kind::AsndIdentResponse | Kind::AsndStatusResponse);
        let kind = if is_whole || is_cut || has_length { kind } else { Kind::Invalid };
        Look { powerlink, source, kind, is_whole }
    }

    fn byte(&self, at: usize) -> Option<u8> {
        self.powerlink.get(at).copied()
    }

    /// The state that it tells. That of a response that is too short, and not cut, does not count.
    pub(super) fn state(&self, is_cut: bool) -> Option<u8> {
        let at = match self.kind {
            Kind::Pres | Kind::Soa => 3,
            Kind::AsndIdentResponse | Kind::AsndStatusResponse => 6,
            _ => return None,
        };
        self.byte(at).filter(|_| self.is_whole || is_cut)
    }
}

/// How long a command is; 0 for none.
fn sdo_command(bytes: &[u8]) -> usize {
    let is_none = match bytes {
        [_, _, flags, command, low, high, ..] => [flags & 0xF0, *command, *low, *high] == [0; 4],
        _ => bytes.iter().all(|&byte| byte == 0),
    };
    let Some(&[_, _, flags, _, low, high, ..]) = bytes.get(..8).filter(|_| !is_none) else {
        return if is_none { 0 } else { 8 };
    };
    let size = usize::from(u16::from_le_bytes([low, high]));
    match flags & 0x30 {
        // The size of all data is counted.
        0x10 if bytes.len() < 12 => 12,
        0x10 if size < 4 => IMPOSSIBLE,
        _ => 8 + size,
    }
}

/// A length that no frame has: a field has a value that cannot be.
const IMPOSSIBLE: usize = 1 << 30;
