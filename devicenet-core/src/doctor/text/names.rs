//! Nodes, times and kinds in words.

use core::fmt;
use core::time::Duration;

use crate::doctor::finding::{Exchange, Foreign, KeyField};
use crate::id::MacId;

/// `node 12`, `a node`.
pub(super) struct Node(pub(super) Option<MacId>);

impl fmt::Display for Node {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(mac) => write!(f, "node {mac}"),
            None => f.write_str("a node"),
        }
    }
}

/// `master 1`, `its master`.
pub(super) struct Master(pub(super) Option<MacId>);

impl fmt::Display for Master {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(mac) => write!(f, "master {mac}"),
            None => f.write_str("its master"),
        }
    }
}

/// `node 12`, `the interface`.
pub(super) struct Controller(pub(super) Option<MacId>);

impl fmt::Display for Controller {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(mac) => write!(f, "node {mac}"),
            None => f.write_str("the interface"),
        }
    }
}

/// ` of node 1`, or nothing.
pub(super) struct Asker(pub(super) Option<MacId>);

impl fmt::Display for Asker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |mac| write!(f, " of node {mac}"))
    }
}

/// `300 ms`, `0.8 ms`.
pub(super) struct Millis(pub(super) Duration);

impl fmt::Display for Millis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let micros = self.0.as_micros();
        match micros / 1_000 {
            0..10 => write!(f, "{}.{} ms", micros / 1_000, micros / 100 % 10),
            millis => write!(f, "{millis} ms"),
        }
    }
}

/// `10 s`, `0.500 s`.
pub(super) struct Seconds(pub(super) Duration);

impl fmt::Display for Seconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.subsec_millis() {
            0 => write!(f, "{} s", self.0.as_secs()),
            millis => write!(f, "{}.{:03} s", self.0.as_secs(), millis),
        }
    }
}

impl fmt::Display for Exchange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Poll => "polls",
            Self::BitStrobe => "bit-strobes",
            Self::ChangeOfState => "COS/cyclic messages",
            Self::MulticastPoll => "multicast polls",
            Self::Explicit => "explicit requests",
        })
    }
}

impl Exchange {
    /// The connection that it is on.
    pub(super) const fn connection(self) -> &'static str {
        match self {
            Self::Poll => "poll connection",
            Self::BitStrobe => "bit-strobe connection",
            Self::ChangeOfState => "COS/cyclic connection",
            Self::MulticastPoll => "multicast poll connection",
            Self::Explicit => "explicit connection",
        }
    }
}

impl fmt::Display for Foreign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ExtendedIdentifier => "a 29-bit identifier",
            Self::RemoteFrame => "a remote request",
            Self::InvalidIdentifier => "an identifier that must not be used",
            Self::ReservedIdentifier => "a reserved identifier",
            Self::CanFd => "the format of CAN FD",
        })
    }
}

impl fmt::Display for KeyField {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Vendor => "vendor",
            Self::DeviceType => "device type",
            Self::ProductCode => "product code",
            Self::Revision => "revision",
            Self::SerialNumber => "serial number",
        })
    }
}

impl KeyField {
    pub(super) fn value(self, number: u32) -> impl fmt::Display {
        KeyValue { field: self, number }
    }
}

struct KeyValue {
    field: KeyField,
    number: u32,
}

impl fmt::Display for KeyValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.field {
            KeyField::Vendor | KeyField::DeviceType | KeyField::ProductCode => write!(f, "{}", self.number),
            KeyField::SerialNumber => write!(f, "0x{:08X}", self.number),
            KeyField::Revision => {
                let [_, _, major, minor] = self.number.to_be_bytes();
                write!(f, "{major}.{minor}")
            }
        }
    }
}
