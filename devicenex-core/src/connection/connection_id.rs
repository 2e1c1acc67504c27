//! An identifier as an attribute.

use core::fmt;

use cip_core::codec::{Full, Writer};
use link_core::Id;
use link_core::frame::{extended_id, standard_id};

use crate::id::Identifier;

/// A connection ID: attributes 4 and 5 of the Connection object, a UDINT **\[D\]**.
///
/// | Bits | Content |
/// |---|---|
/// | 31 | 1: 29-bit identifier, in bits 28-0; 0: 11-bit identifier, in bits 10-0 |
/// | others | 0 |
///
/// 0xFFFF_FFFF stands for none. The identifier of an explicit message has F and X 0.
///
/// ```
/// use devicenex_core::connection::ConnectionId;
/// use devicenex_core::id::{Identifier, MessageId, OperationalAddress};
/// use cip_core::code::InstanceId;
///
/// // What OA 67 produces on its connection 7, with Message ID 2.
/// let source = OperationalAddress::new(67).unwrap();
/// let produced = Identifier::implicit(MessageId::new(2).unwrap(), source, InstanceId(7));
/// assert_eq!(u32::from(ConnectionId::from(produced)), 0x8286_0007);
/// assert_eq!(ConnectionId::from(0x8286_0007).identifier(), Some(produced));
/// assert_eq!(ConnectionId::NONE.identifier(), None);
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(transparent))]
pub struct ConnectionId(u32);

impl ConnectionId {
    /// The connection does not produce, or does not consume.
    pub const NONE: Self = Self(u32::MAX);

    /// The identifier; `None` for [`NONE`](Self::NONE), and if bits are set that must not be.
    #[must_use]
    pub fn identifier(self) -> Option<Identifier> {
        let raw = self.0 & !EXTENDED;
        let id = if self.0 & EXTENDED != 0 {
            (raw <= link_core::ExtendedId::MAX.as_raw()).then(|| Id::Extended(extended_id(raw)))?
        } else {
            let raw = u16::try_from(raw).ok().filter(|&raw| raw <= link_core::StandardId::MAX.as_raw())?;
            Id::Standard(standard_id(raw))
        };
        Some(Identifier::from(id))
    }
}

impl From<Identifier> for ConnectionId {
    fn from(identifier: Identifier) -> Self {
        Self(match identifier.id() {
            Id::Standard(id) => id.as_raw().into(),
            Id::Extended(id) => id.as_raw() | EXTENDED,
        })
    }
}

impl From<Option<Identifier>> for ConnectionId {
    fn from(identifier: Option<Identifier>) -> Self {
        identifier.map_or(Self::NONE, Self::from)
    }
}

impl From<u32> for ConnectionId {
    fn from(raw: u32) -> Self {
        Self(raw)
    }
}

impl From<ConnectionId> for u32 {
    fn from(id: ConnectionId) -> Self {
        id.0
    }
}

impl cip_core::connection::ConnectionId for ConnectionId {
    fn emit(self, out: &mut Writer<'_>) -> Result<(), Full> {
        out.u32(self.0)
    }
}

/// The identifier, `none`, or the number if it is no identifier.
impl fmt::Display for ConnectionId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (*self, self.identifier()) {
            (Self::NONE, _) => f.write_str("none"),
            (_, Some(identifier)) => fmt::Display::fmt(&identifier, f),
            (Self(raw), None) => write!(f, "0x{raw:08X}, which is none"),
        }
    }
}

const EXTENDED: u32 = 1 << 31;

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::string::ToString;

    #[test]
    fn bits_that_must_not_be_set_are_no_identifier() {
        for raw in [0x800, 0x4000_0000, 0xA000_0000, 0xC000_0000, 0x7FFF_FFFF] {
            assert_eq!(ConnectionId(raw).identifier(), None, "{raw:08X}");
        }
        assert_eq!(ConnectionId(0x7FF).to_string(), "7FF");
        assert_eq!(ConnectionId(0x9FFF_FFFF).to_string(), "1FFFFFFF");
        assert_eq!(ConnectionId(0x800).to_string(), "0x00000800, which is none");
        assert_eq!(ConnectionId::from(None).to_string(), "none");
    }

    proptest! {
        #[test]
        fn identifiers_survive(raw in 0_u32..0x2000_0000, short in 0_u16..0x800) {
            for id in [Id::Extended(extended_id(raw)), Id::Standard(standard_id(short))] {
                let identifier = Identifier::from(id);
                let connection = ConnectionId::from(identifier);
                prop_assert_eq!(connection.identifier(), Some(identifier));
                prop_assert_eq!(ConnectionId::from(u32::from(connection)), connection);
            }
        }
    }
}
