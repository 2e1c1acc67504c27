//! An identifier, how it is built, and how it reads.

use core::fmt;

use cip_core::code::InstanceId;
use link_core::{Frame, Id};

use super::{Framing, Group, Layout, OperationalAddress, Route};

/// An 11-bit or 29-bit identifier as DeviceNeX reads it. Every one is, so nothing is lost by the conversion.
///
/// ```
/// use devicenex_core::{Identifier, OperationalAddress, id::{Direction, Layout}};
///
/// let hello = Identifier::hello(OperationalAddress::NONE, Direction::Request, 0x3344);
/// assert_eq!(hello.to_string(), "1FFE4433");
/// assert_eq!(hello.layout().to_string(), "Hello request of OA 127, serial ending in 0x3344");
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Identifier(Id);

/// The R bit **\[R\]**: as in the duplicate MAC ID check of DeviceNet.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "lowercase"))]
pub enum Direction {
    /// 0
    Request,
    /// 1
    Response,
}

/// A Message ID, 0 to 15: which of a node's connections, and with what priority.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(transparent))]
pub struct MessageId(u8);

/// By what an identifier is its sender's own, so that no two nodes send it with different data.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Sender {
    /// By its address, which only one node has.
    Address(OperationalAddress),
    /// By its address and the low half of its serial number, as long as others may have that address too.
    Joining(OperationalAddress, u16),
}

impl Identifier {
    /// The identifier of a frame.
    #[must_use]
    pub fn of_frame(frame: &Frame) -> Self {
        Self(frame.id())
    }

    /// Hello; and Mini-who as a remote frame, with [`OperationalAddress::NONE`] and [`Direction::Request`].
    #[must_use]
    pub fn hello(source: OperationalAddress, direction: Direction, serial_low: u16) -> Self {
        Self::of(Layout::Hello { source, direction, serial_low })
    }

    /// ROAM, to a device without an address.
    #[must_use]
    pub fn roam(serial_low: u16) -> Self {
        Self::of(Layout::Roam { destination: OperationalAddress::NONE, serial_low })
    }

    /// Connection request or response.
    #[must_use]
    pub fn connection(route: Route, transaction: u8) -> Self {
        Self::of(Layout::Connection { route, transaction })
    }

    /// Explicit message without a connection.
    #[must_use]
    pub fn connectionless(route: Route, framing: Framing) -> Self {
        Self::of(Layout::Connectionless { route, framing })
    }

    /// Explicit message on a connection; `None` for a Message ID above 7.
    #[must_use]
    pub fn explicit(message: MessageId, route: Route, framing: Framing) -> Option<Self> {
        Layout::Explicit { message, route, framing }.identifier()
    }

    /// Implicit message with 29 bits.
    #[must_use]
    pub fn implicit(message: MessageId, source: OperationalAddress, instance: InstanceId) -> Self {
        Self::of(Layout::Implicit { message, source, acknowledge: false, instance })
    }

    /// Acknowledge of an implicit message with 29 bits.
    #[must_use]
    pub fn implicit_acknowledge(
        message: MessageId,
        source: OperationalAddress,
        instance: InstanceId,
    ) -> Self {
        Self::of(Layout::Implicit { message, source, acknowledge: true, instance })
    }

    /// Implicit message with 11 bits; `None` for a Message ID that the group does not have.
    #[must_use]
    pub fn standard(group: Group, message: MessageId, source: OperationalAddress) -> Option<Self> {
        Layout::Standard { group, message, source }.identifier()
    }

    /// What it says.
    #[must_use]
    pub fn layout(self) -> Layout {
        Layout::of(self)
    }

    /// By what it is its sender's own; `None` for a reserved one, and for ROAM. **The paper's ROAM carries the serial
    /// number of its target and nothing of its sender**, so two managers that give one device different addresses in the
    /// same bit time do collide; that there is one manager on a bus is up to those who build it.
    #[must_use]
    pub fn sender(self) -> Option<Sender> {
        match self.layout() {
            Layout::Hello { source, serial_low, .. } => Some(Sender::Joining(source, serial_low)),
            Layout::Connection { route, .. }
            | Layout::Connectionless { route, .. }
            | Layout::Explicit { route, .. } => Some(Sender::Address(route.source)),
            Layout::Implicit { source, .. } | Layout::Standard { source, .. } => {
                Some(Sender::Address(source))
            }
            Layout::Roam { .. } | Layout::Reserved(_) => None,
        }
    }

    /// The 11 or 29 bits.
    #[must_use]
    pub const fn id(self) -> Id {
        self.0
    }

    /// A data frame with this identifier; `None` for more than eight bytes.
    #[must_use]
    pub fn frame(self, data: &[u8]) -> Option<Frame> {
        Frame::new(self.0, data)
    }

    /// Of a layout that has no Message ID, or one of four bits.
    fn of(layout: Layout) -> Self {
        let identifier = layout.identifier();
        debug_assert!(identifier.is_some(), "{layout:?} has an identifier");
        identifier.unwrap_or(Self(Id::Extended(link_core::ExtendedId::MAX)))
    }
}

impl From<Id> for Identifier {
    fn from(id: Id) -> Self {
        Self(id)
    }
}

impl From<Identifier> for Id {
    fn from(identifier: Identifier) -> Self {
        identifier.0
    }
}

/// `1FFE4433`, `3A5`: as candump shows it.
impl fmt::Display for Identifier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Id::Standard(id) => write!(f, "{:03X}", id.as_raw()),
            Id::Extended(id) => write!(f, "{:08X}", id.as_raw()),
        }
    }
}

impl fmt::Debug for Identifier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Identifier({self})")
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Identifier {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Identifier {
    fn format(&self, f: defmt::Formatter<'_>) {
        match self.0 {
            Id::Standard(id) => defmt::write!(f, "{=u16:03X}", id.as_raw()),
            Id::Extended(id) => defmt::write!(f, "{=u32:08X}", id.as_raw()),
        }
    }
}

impl Direction {
    /// What the bit says.
    #[must_use]
    pub const fn of(bit: bool) -> Self {
        if bit { Self::Response } else { Self::Request }
    }

    /// The bit.
    #[must_use]
    pub const fn bit(self) -> bool {
        matches!(self, Self::Response)
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Request => "request",
            Self::Response => "response",
        })
    }
}

impl MessageId {
    /// The Message ID of that number; `None` above 15.
    #[must_use]
    pub const fn new(number: u8) -> Option<Self> {
        if number <= 0xF { Some(Self(number)) } else { None }
    }

    /// The Message ID in the low four bits; the others are not looked at.
    #[must_use]
    pub const fn from_low_bits(byte: u8) -> Self {
        Self(byte & 0xF)
    }

    /// 0 to 15.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.0
    }

    pub(super) const fn low_three_bits(self) -> Self {
        Self(self.0 & 7)
    }

    pub(super) const fn at_most(self, last: u8) -> Option<u8> {
        if self.0 <= last { Some(self.0) } else { None }
    }
}

impl fmt::Display for MessageId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, f)
    }
}

/// The words of a trace.
impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hello { source, direction, serial_low } => {
                write!(f, "Hello {direction} of OA {source}, serial ending in 0x{serial_low:04X}")
            }
            Self::Roam { destination, serial_low } => {
                write!(f, "ROAM to OA {destination}, serial ending in 0x{serial_low:04X}")
            }
            Self::Connection { route, transaction } => {
                write!(f, "connection {route}, transaction {transaction}")
            }
            Self::Connectionless { route, framing } => write!(f, "connectionless {route}, {framing}"),
            Self::Explicit { message, route, framing } => {
                write!(f, "explicit {route}, message {message}, {framing}")
            }
            Self::Implicit { message, source, acknowledge, instance } => {
                let what = if *acknowledge { "implicit acknowledge" } else { "implicit" };
                write!(f, "{what} of OA {source}, message {message}, {instance}")
            }
            Self::Standard { group, message, source } => {
                write!(f, "implicit of OA {source}, group {}, message {message}", group.number())
            }
            Self::Reserved(identifier) => write!(f, "reserved identifier {identifier}"),
        }
    }
}

/// `request from OA 1 to OA 67`
impl fmt::Display for Route {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} from OA {} to OA {}", self.direction, self.source, self.destination)
    }
}

impl fmt::Display for Framing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Complete { transaction } => write!(f, "transaction {transaction}"),
            Self::Fragment(fragment) => fmt::Display::fmt(fragment, f),
        }
    }
}
