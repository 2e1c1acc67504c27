//! The wire types: the data field of every DeviceNeX message, with its layout.
//!
//! Each type reads and writes the *whole* data field of one frame ([`Wire::parse`], [`Wire::emit`]); what it means
//! depends on the identifier. [`frame`] joins the two. [`Hello`], [`MiniWho`] and [`Roam`] are told in both parts, and read
//! and written as frames. [`for_each_wire_type`](crate::for_each_wire_type) lists all data fields.
//!
//! | Identifier | Messages |
//! |---|---|
//! | 11111 | [`Hello`]: [`HelloData`]; [`MiniWho`] |
//! | 11110 | [`Roam`]: [`RoamData`] |
//! | 11101 | [`ConnectionRequest`], [`ConnectionResponse`], [`ErrorResponse`] |
//! | 11100 | [`ConnectionlessRequest`], [`ConnectionlessResponse`], [`ErrorResponse`]; fragments of a response |
//! | 10mmm | [`ExplicitMessage`], [`FirstFragment`], [`NextFragment`], [`FragmentAcknowledge`] |
//! | 0mmmm, 11 bits | raw data, [`ImplicitFragment`] |
//!
//! The marks **\[P\]**, **\[R\]** and **\[D\]** are explained in the [crate] text.

mod connect;
mod explicit;
mod fields;
mod hello;
mod implicit;
mod instance;
#[cfg(test)]
mod laws;
mod list;
mod roam;

pub use cip_core::codec::{ParseError, ParseErrorKind, Wire};

pub use connect::{ConnectionRequest, ConnectionResponse, FormatByte, Granted, GroupSelect, Target};
pub use explicit::{
    ConnectionlessRequest, ConnectionlessResponse, ErrorResponse, ExplicitMessage, FirstFragment,
    FragmentAcknowledge, NextFragment,
};
pub use fields::{DeviceIdentity, PortByte, RestOfIdentity};
pub use hello::{Hello, HelloData, MiniWho};
pub use implicit::ImplicitFragment;
pub use instance::{ConnectionInstance, IdentifierLength, Predefined, Production};
pub use roam::{Roam, RoamData};

use cip_core::codec::Writer;
use link_core::Frame;

use crate::id::Identifier;

/// The frame that carries a message; `None` only for a message whose free data are too long for a frame.
///
/// ```
/// use cip_core::code::InstanceId;
/// use cip_core::connection::WatchdogAction;
/// use devicenex_core::{Identifier, OperationalAddress, id::{Direction, MessageId, Route}};
/// use devicenex_core::message::{self, ConnectionRequest, GroupSelect, Target};
///
/// let (manager, device) = (OperationalAddress::new(1).unwrap(), OperationalAddress::new(67).unwrap());
/// let route = Route { destination: device, direction: Direction::Request, source: manager };
/// // The multicast connection of the device, with 29 bits, twice a second.
/// let request = ConnectionRequest {
///     predefined: true,
///     group: GroupSelect::IMPLICIT_29,
///     source_message: MessageId::default(),
///     target: Some(Target {
///         instance: InstanceId(7),
///         expected_packet_rate: 500,
///         watchdog_action: WatchdogAction::AUTO_RESET,
///     }),
/// };
/// let frame = message::frame(Identifier::connection(route, 9), &request).unwrap();
/// assert_eq!(frame.to_string(), "1D860209 [7] 4B C0 07 00 F4 01 02");
/// ```
#[must_use]
pub fn frame<'a>(id: Identifier, message: &impl Wire<'a>) -> Option<Frame> {
    let mut data = [0; Frame::MAX_DATA];
    let mut writer = Writer::new(&mut data);
    message.emit(&mut writer).ok()?;
    id.frame(writer.written())
}
