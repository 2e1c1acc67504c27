//! What starts a recording.

use core::fmt;
use core::str::FromStr;
use core::time::Duration;

use devicenet_core::MacId;
use devicenet_core::monitor::{Kind, Reading};

use crate::scenario::Time;
use crate::text::unsigned;

/// A condition, as it is written on the command line.
///
/// | Text | When |
/// |---|---|
/// | `timeout`, `timeout=10` | a node (that node) leaves polls unanswered for four times its expected packet rate, or as attribute 18 says, or a connection of it times out |
/// | `duplicate` | a second device wants a MAC ID, or answers for it |
/// | `error` | an error on the bus |
/// | `bus-off` | the interface is bus-off |
/// | `problem` | a frame is wrong or suspicious |
/// | `silence=2s` | nothing was heard for so long |
/// | `kind=..`, `mac=..`, `id=..`, `data=..`, joined with commas | a frame to which all of them apply; `data` is hexadecimal, `??` is any byte, and what follows is not looked at |
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Trigger {
    /// `timeout`
    TimeOut(Option<MacId>),
    /// `duplicate`
    Duplicate,
    /// `error`
    BusError,
    /// `bus-off`
    BusOff,
    /// `problem`
    Problem,
    /// `silence`
    Silence(Duration),
    /// A filter expression.
    Frame(FrameFilter),
}

/// What a frame must be; parts that are `None` are not looked at.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct FrameFilter {
    kind: Option<Kind>,
    mac: Option<u8>,
    id: Option<u32>,
    data: Option<Vec<Option<u8>>>,
}

impl FrameFilter {
    pub(super) fn accepts(&self, reading: &Reading<'_>) -> bool {
        let is_node = |mac: MacId, wanted: u8| mac.number() == wanted;
        let begins = |data: &Vec<Option<u8>>| {
            let found = reading.frame.data();
            data.len() <= found.len()
                && data.iter().zip(found).all(|(wanted, byte)| wanted.is_none_or(|wanted| wanted == *byte))
        };
        self.kind.is_none_or(|kind| kind == reading.kind)
            && self.mac.is_none_or(|mac| {
                [reading.src, reading.dst].into_iter().flatten().any(|node| is_node(node, mac))
            })
            && self.id.is_none_or(|id| id == reading.frame.raw_id())
            && self.data.as_ref().is_none_or(begins)
    }
}

impl FromStr for Trigger {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Ok(match text.split_once('=') {
            None => match text {
                "timeout" => Self::TimeOut(None),
                "duplicate" => Self::Duplicate,
                "error" => Self::BusError,
                "bus-off" => Self::BusOff,
                "problem" => Self::Problem,
                _ => return Err(format!("expected {EXPECTED}")),
            },
            Some(("timeout", mac)) => {
                let mac = crate::args::parse_mac_id(mac)?;
                Self::TimeOut(MacId::new(mac))
            }
            Some(("silence", span)) => {
                let Time(span) = span.parse::<Time>().map_err(|error| error.to_string())?;
                if span.is_zero() {
                    return Err("a silence lasts longer than 0 s".into());
                }
                Self::Silence(span)
            }
            Some(_) => Self::Frame(filter(text)?),
        })
    }
}

/// As it is written on the command line.
impl fmt::Display for Trigger {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TimeOut(None) => f.write_str("timeout"),
            Self::TimeOut(Some(mac)) => write!(f, "timeout={mac}"),
            Self::Duplicate => f.write_str("duplicate"),
            Self::BusError => f.write_str("error"),
            Self::BusOff => f.write_str("bus-off"),
            Self::Problem => f.write_str("problem"),
            Self::Silence(span) => write!(f, "silence={}", Time(*span)),
            Self::Frame(filter) => filter.fmt(f),
        }
    }
}

impl fmt::Display for FrameFilter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, mac, id, data } = self;
        let byte = |byte: &Option<u8>| byte.map_or_else(|| "??".to_owned(), |byte| format!("{byte:02x}"));
        let parts = [
            kind.map(|kind| format!("kind={}", kind.name())),
            mac.map(|mac| format!("mac={mac}")),
            id.map(|id| format!("id=0x{id:x}")),
            data.as_ref().map(|data| format!("data={}", data.iter().map(byte).collect::<String>())),
        ];
        f.write_str(&parts.into_iter().flatten().collect::<Vec<_>>().join(","))
    }
}

fn filter(text: &str) -> Result<FrameFilter, String> {
    let mut filter = FrameFilter::default();
    for part in text.split(',') {
        match part.split_once('=') {
            Some(("kind", name)) => {
                let kind = Kind::ALL.into_iter().find(|kind| kind.name() == name);
                let kind = kind.ok_or_else(|| {
                    format!("`{name}` is no kind of frame; `devicenet decode --help` lists them")
                })?;
                once("kind", &mut filter.kind, kind)?;
            }
            Some(("mac", mac)) => once("mac", &mut filter.mac, crate::args::parse_mac_id(mac)?)?,
            Some(("id", id)) => {
                let id =
                    unsigned(id).and_then(|id| u32::try_from(id).ok()).filter(|id| *id <= MAX_IDENTIFIER);
                once(
                    "id",
                    &mut filter.id,
                    id.ok_or("an identifier of 11 or 29 bits such as 0x3FF expected")?,
                )?;
            }
            Some(("data", bytes)) => {
                once(
                    "data",
                    &mut filter.data,
                    pattern(bytes).ok_or("up to 8 bytes such as 01??FF expected")?,
                )?;
            }
            _ => return Err(format!("expected {EXPECTED}")),
        }
    }
    Ok(filter)
}

/// A frame has one of each.
fn once<T>(name: &str, place: &mut Option<T>, value: T) -> Result<(), String> {
    match place.replace(value) {
        None => Ok(()),
        Some(_) => Err(format!("{name} is given twice; for one or the other give --trigger twice")),
    }
}

fn pattern(text: &str) -> Option<Vec<Option<u8>>> {
    let is_pattern = |byte: u8| byte.is_ascii_hexdigit() || byte == b'?';
    let is_length = (2..=2 * MAX_DATA).contains(&text.len()) && text.len().is_multiple_of(2);
    if !is_length || !text.bytes().all(is_pattern) {
        return None;
    }
    let pairs = text.as_bytes().chunks_exact(2);
    pairs
        .map(|pair| match pair {
            b"??" => Some(None),
            pair => u8::from_str_radix(core::str::from_utf8(pair).ok()?, 16).ok().map(Some),
        })
        .collect()
}

/// Of 29 bits.
const MAX_IDENTIFIER: u32 = 0x1FFF_FFFF;
/// In a classic frame.
const MAX_DATA: usize = 8;
const EXPECTED: &str = "timeout, timeout=MAC, duplicate, error, bus-off, problem, silence=TIME, or kind=KIND, mac=N, id=N, \
                        data=HEX joined with commas";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triggers_as_they_are_written() {
        assert_eq!("timeout".parse(), Ok(Trigger::TimeOut(None)));
        assert_eq!("timeout=0x0A".parse(), Ok(Trigger::TimeOut(MacId::new(10))));
        assert_eq!("silence=2s".parse(), Ok(Trigger::Silence(Duration::from_secs(2))));
        let filter = FrameFilter {
            kind: Some(Kind::PollResponse),
            mac: Some(10),
            id: Some(0x3CA),
            data: Some(vec![Some(1), None, Some(0xFF)]),
        };
        assert_eq!("kind=poll_response,mac=10,id=0x3ca,data=01??fF".parse(), Ok(Trigger::Frame(filter)));
        for text in [
            "timeout",
            "timeout=10",
            "duplicate",
            "error",
            "bus-off",
            "problem",
            "silence=1.5s",
            "kind=poll_response,mac=10,id=0x3ca,data=01??ff",
            "id=0x3ca",
        ] {
            assert_eq!(text.parse::<Trigger>().unwrap().to_string(), text);
        }
        for text in [
            "",
            "time",
            "timeout=64",
            "silence=2",
            "silence=0s",
            "kind=poll",
            "data=0",
            "data=0?",
            "data=",
            "id=x",
            "id=0x20000000",
            "data=010203040506070809",
            "mac=1,mac=2",
            "mac=10,error",
        ] {
            assert!(text.parse::<Trigger>().is_err(), "{text}");
        }
    }
}
