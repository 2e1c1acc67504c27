//! The bits: every layout of an identifier is in this file, and nowhere else.
//!
//! A 29-bit identifier is four bytes: `000 | class (5)`, `address (7) | flag (1)`, and two more. An 11-bit identifier is
//! `group and Message ID (4) | address (7)`.

use cip_core::code::InstanceId;
use cip_core::fragment::FragmentByte;
use link_core::Id;
use link_core::frame::{extended_id, standard_id};

use super::{Direction, Identifier, MessageId, OperationalAddress};

/// What an identifier says. The tables are in the [module](super) text.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Layout {
    /// Class 11111: a node tells its address and who it is. As a remote frame from address 127: Mini-who **\[P\]**.
    Hello {
        /// The sender's address; 127 in a Mini-who.
        source: OperationalAddress,
        /// The R bit **\[R\]**.
        direction: Direction,
        /// The low half of the sender's serial number, low byte first on the wire.
        serial_low: u16,
    },
    /// Class 11110: a device gets an address **\[P\]**.
    Roam {
        /// 127 in every valid message.
        destination: OperationalAddress,
        /// The low half of the *target's* serial number.
        serial_low: u16,
    },
    /// Class 11101: a connection is asked for **\[D\]**. Never a fragment.
    Connection {
        /// From whom to whom.
        route: Route,
        /// Chosen by the requester, echoed in the response.
        transaction: u8,
    },
    /// Class 11100: an explicit message without a connection **\[D\]**.
    Connectionless {
        /// From whom to whom.
        route: Route,
        /// Complete, or a part.
        framing: Framing,
    },
    /// Class 10mmm: an explicit message on a connection **\[D\]**.
    Explicit {
        /// 0 to 7.
        message: MessageId,
        /// From whom to whom.
        route: Route,
        /// Complete, or a part.
        framing: Framing,
    },
    /// Class 0mmmm: an implicit (I/O) message **\[D\]**.
    Implicit {
        /// 0 to 15.
        message: MessageId,
        /// The sender.
        source: OperationalAddress,
        /// It acknowledges a change-of-state or cyclic message.
        acknowledge: bool,
        /// The connection, of the sender, that it belongs to.
        instance: InstanceId,
    },
    /// An implicit message with an 11-bit identifier **\[D\]**.
    Standard {
        /// Which of the three groups.
        group: Group,
        /// 0 to 7 in Group 1, 0 to 3 in Group 2, 0 to 2 in Group 3.
        message: MessageId,
        /// The sender.
        source: OperationalAddress,
    },
    /// None of these: classes 11000 to 11011, a fragment of class 11101, a ROAM with bit 16 set, Group 3 Message ID 3.
    Reserved(Identifier),
}

/// From whom to whom a message between two nodes goes.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Route {
    /// To whom.
    pub destination: OperationalAddress,
    /// The R bit.
    pub direction: Direction,
    /// From whom.
    pub source: OperationalAddress,
}

/// The F bit and the X byte of a message between two nodes.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Framing {
    /// F = 0: the whole message.
    Complete {
        /// Chosen by the requester, echoed by the server.
        transaction: u8,
    },
    /// F = 1: a part of the message, or the acknowledge of one.
    Fragment(FragmentByte),
}

/// The groups of 11-bit identifiers.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Group {
    /// `0 mmm sssssss`, 0x000-0x3FF.
    Group1,
    /// `10 mm sssssss`, 0x400-0x5FF.
    Group2,
    /// `11 mm sssssss`, 0x600-0x77F.
    Group3,
}

impl Layout {
    /// Takes an identifier apart. Every identifier has a layout.
    #[must_use]
    pub fn of(identifier: Identifier) -> Self {
        match identifier.id() {
            Id::Standard(id) => Self::of_standard(id.as_raw()),
            Id::Extended(id) => Self::of_extended(id.as_raw()),
        }
        .unwrap_or(Self::Reserved(identifier))
    }

    /// The identifier; `None` if a Message ID has more bits than the layout has for it, or if what is called reserved is
    /// not.
    #[must_use]
    pub fn identifier(self) -> Option<Identifier> {
        match self {
            Self::Hello { source, direction, serial_low } => {
                Some(extended(HELLO, source, direction.bit(), serial_low.to_le_bytes()))
            }
            Self::Roam { destination, serial_low } => {
                Some(extended(ROAM, destination, false, serial_low.to_le_bytes()))
            }
            Self::Connection { route, transaction } => {
                Some(route.identifier(CONNECTION, Framing::Complete { transaction }))
            }
            Self::Connectionless { route, framing } => Some(route.identifier(CONNECTIONLESS, framing)),
            Self::Explicit { message, route, framing } => {
                message.at_most(7).map(|message| route.identifier(EXPLICIT | message, framing))
            }
            Self::Implicit { message, source, acknowledge, instance } => {
                Some(extended(message.number(), source, acknowledge, instance.0.to_be_bytes()))
            }
            Self::Standard { group, message, source } => {
                let message = message.at_most(group.last_message())?;
                Some(standard(group.base() | message, source))
            }
            Self::Reserved(identifier) => (Self::of(identifier) == self).then_some(identifier),
        }
    }

    fn of_extended(raw: u32) -> Option<Self> {
        let [class, second, third, fourth] = raw.to_be_bytes();
        let address = OperationalAddress::from_low_bits(second >> 1);
        let flag = second & 1 != 0;
        let route = Route {
            destination: address,
            direction: Direction::of(flag),
            source: OperationalAddress::from_low_bits(third >> 1),
        };
        let framing = match third & 1 {
            0 => Framing::Complete { transaction: fourth },
            _ => Framing::Fragment(fourth.into()),
        };
        let serial_low = u16::from_le_bytes([third, fourth]);
        let message = MessageId::from_low_bits(class);
        Some(match class {
            HELLO => Self::Hello { source: address, direction: Direction::of(flag), serial_low },
            ROAM if !flag => Self::Roam { destination: address, serial_low },
            CONNECTION => match framing {
                Framing::Complete { transaction } => Self::Connection { route, transaction },
                Framing::Fragment(_) => return None,
            },
            CONNECTIONLESS => Self::Connectionless { route, framing },
            EXPLICIT..=LAST_EXPLICIT => Self::Explicit { message: message.low_three_bits(), route, framing },
            0..EXPLICIT => Self::Implicit {
                message,
                source: address,
                acknowledge: flag,
                instance: InstanceId(u16::from_be_bytes([third, fourth])),
            },
            _ => return None,
        })
    }

    fn of_standard(raw: u16) -> Option<Self> {
        let [_, low] = raw.to_be_bytes();
        let [_, kind] = (raw >> 7).to_be_bytes();
        let group = match kind {
            GROUP_1..GROUP_2 => Group::Group1,
            GROUP_2..GROUP_3 => Group::Group2,
            _ => Group::Group3,
        };
        // The base of a group has no bit in common with its Message IDs.
        let message = MessageId::from_low_bits(kind & !group.base());
        message.at_most(group.last_message())?;
        Some(Self::Standard { group, message, source: OperationalAddress::from_low_bits(low) })
    }
}

impl Route {
    fn identifier(self, class: u8, framing: Framing) -> Identifier {
        let (fragment, last) = match framing {
            Framing::Complete { transaction } => (0, transaction),
            Framing::Fragment(byte) => (1, byte.into()),
        };
        extended(class, self.destination, self.direction.bit(), [self.source.number() << 1 | fragment, last])
    }
}

impl Group {
    /// 1 to 3.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::Group1 => 1,
            Self::Group2 => 2,
            Self::Group3 => 3,
        }
    }

    /// The highest Message ID.
    #[must_use]
    pub const fn last_message(self) -> u8 {
        match self {
            Self::Group1 => 7,
            Self::Group2 => 3,
            // With Message ID 3 an identifier would begin with up to eleven recessive bits; CAN 2.0 forbids seven.
            Self::Group3 => 2,
        }
    }

    const fn base(self) -> u8 {
        match self {
            Self::Group1 => GROUP_1,
            Self::Group2 => GROUP_2,
            Self::Group3 => GROUP_3,
        }
    }
}

fn extended(class: u8, address: OperationalAddress, flag: bool, [third, fourth]: [u8; 2]) -> Identifier {
    let second = address.number() << 1 | u8::from(flag);
    Identifier::from(Id::Extended(extended_id(u32::from_be_bytes([class, second, third, fourth]))))
}

fn standard(kind: u8, source: OperationalAddress) -> Identifier {
    Identifier::from(Id::Standard(standard_id(u16::from(kind) << 7 | u16::from(source.number()))))
}

/// Bits 28-24.
const HELLO: u8 = 0b1_1111;
const ROAM: u8 = 0b1_1110;
const CONNECTION: u8 = 0b1_1101;
const CONNECTIONLESS: u8 = 0b1_1100;
/// With the Message ID in bits 26-24.
const EXPLICIT: u8 = 0b1_0000;
const LAST_EXPLICIT: u8 = 0b1_0111;
/// Bits 10-7 of an 11-bit identifier, with the Message ID in the low ones.
const GROUP_1: u8 = 0b0000;
const GROUP_2: u8 = 0b1000;
const GROUP_3: u8 = 0b1100;
