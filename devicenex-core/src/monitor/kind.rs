//! What a frame is.

use core::fmt;

/// What a frame is, by its identifier and what was learned before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Kind {
    /// Hello of a node that joins, or that answers a Mini-who.
    HelloRequest,
    /// Hello of the node that has the address: it is taken.
    HelloResponse,
    /// Mini-who: whoever has no address shall say Hello.
    MiniWho,
    /// ROAM: a device gets an address.
    Roam,
    /// A connection is asked for.
    ConnectionRequest,
    /// A connection is granted or refused.
    ConnectionResponse,
    /// Explicit request without a connection.
    ConnectionlessRequest,
    /// Its response.
    ConnectionlessResponse,
    /// Request on an explicit connection.
    ExplicitRequest,
    /// Response on an explicit connection.
    ExplicitResponse,
    /// Fragment of an explicit message, on a connection or without one.
    Fragment,
    /// Acknowledge of such a fragment.
    FragmentAck,
    /// Implicit (I/O) message, with 11 or 29 bits.
    Implicit,
    /// Acknowledge of a change-of-state or cyclic message.
    ImplicitAck,
    /// An identifier without a use.
    Reserved,
    /// Not a frame of DeviceNeX.
    Foreign,
}

impl Kind {
    /// All kinds, in the order of the table of names.
    pub const ALL: [Self; 16] = [
        Self::HelloRequest,
        Self::HelloResponse,
        Self::MiniWho,
        Self::Roam,
        Self::ConnectionRequest,
        Self::ConnectionResponse,
        Self::ConnectionlessRequest,
        Self::ConnectionlessResponse,
        Self::ExplicitRequest,
        Self::ExplicitResponse,
        Self::Fragment,
        Self::FragmentAck,
        Self::Implicit,
        Self::ImplicitAck,
        Self::Reserved,
        Self::Foreign,
    ];

    /// The machine-readable name: lower case with underscores.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::HelloRequest => "hello_request",
            Self::HelloResponse => "hello_response",
            Self::MiniWho => "mini_who",
            Self::Roam => "roam",
            Self::ConnectionRequest => "connection_request",
            Self::ConnectionResponse => "connection_response",
            Self::ConnectionlessRequest => "connectionless_request",
            Self::ConnectionlessResponse => "connectionless_response",
            Self::ExplicitRequest => "explicit_request",
            Self::ExplicitResponse => "explicit_response",
            Self::Fragment => "fragment",
            Self::FragmentAck => "fragment_ack",
            Self::Implicit => "implicit",
            Self::ImplicitAck => "implicit_ack",
            Self::Reserved => "reserved",
            Self::Foreign => "foreign",
        }
    }

    /// True for the kinds that carry I/O data or acknowledge it.
    #[must_use]
    pub const fn is_io(self) -> bool {
        matches!(self, Self::Implicit | Self::ImplicitAck)
    }

    /// True for what a server sends: responses. A fragment can go either way.
    #[must_use]
    pub const fn is_answer(self) -> bool {
        matches!(self, Self::ConnectionResponse) || self.is_response()
    }

    /// True for the explicit messages that answer others.
    pub(super) const fn is_response(self) -> bool {
        matches!(self, Self::ConnectionlessResponse | Self::ExplicitResponse)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Kind {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}
