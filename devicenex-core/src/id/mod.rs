//! CAN identifiers: 29 bits carry the protocol, 11 bits can carry I/O.
//!
//! The marks: **\[P\]** the paper says so (*The Feasibility Study of DeviceNet over Extended CAN*, Tang and McLaughlin),
//! **\[R\]** our reading of a passage that is ambiguous, **\[D\]** our decision where the paper is silent. The rules that a
//! decision must meet are the paper's: an identifier is its sender's own, and an address is at the top, where simple
//! controllers filter.
//!
//! # Classes of 29-bit identifiers
//!
//! | Bits 28-24 | Message | [`Layout`] |
//! |---|---|---|
//! | 11111 | Hello; Mini-who as a remote frame **\[P\]** | [`Hello`](Layout::Hello) |
//! | 11110 | ROAM **\[P\]** | [`Roam`](Layout::Roam) |
//! | 11101 | connection request and response **\[D\]** | [`Connection`](Layout::Connection) |
//! | 11100 | connectionless request and response **\[D\]** | [`Connectionless`](Layout::Connectionless) |
//! | 11000-11011 | reserved **\[D\]** | [`Reserved`](Layout::Reserved) |
//! | 10mmm | explicit message on a connection, Message ID mmm **\[D\]** | [`Explicit`](Layout::Explicit) |
//! | 0mmmm | implicit message, Message ID mmmm **\[D\]** | [`Implicit`](Layout::Implicit) |
//!
//! The lower identifier wins arbitration: I/O before explicit messages, Hello last.
//!
//! # Hello, Mini-who, ROAM **\[P\]**
//!
//! | Bits | 28-24 | 23-17 | 16 | 15-8 | 7-0 |
//! |---|---|---|---|---|---|
//! | Hello (figure 3) | 11111 | source OA | R: 0 request, 1 response **\[R\]** | serial number byte 0 | byte 1 |
//! | Mini-who (figure 4), remote | 11111 | 127 | 0 | sender's serial number byte 0 | byte 1 |
//! | ROAM (figure 6) | 11110 | destination OA, 127 | 0 | target's serial number byte 0 | byte 1 |
//!
//! Byte 0 of the serial number is the least significant one **\[R\]**: CIP is little-endian throughout.
//!
//! # From node to node **\[D\]**
//!
//! | Bits | 28-24 | 23-17 | 16 | 15-9 | 8 | 7-0 |
//! |---|---|---|---|---|---|---|
//! | classes 11101, 11100, 10mmm | class | destination OA | R | source OA | F | X |
//!
//! F = 0: the message is complete, and X is the transaction ID, chosen by the requester and echoed by the server. F = 1: it
//! is a fragment, and X is the fragmentation byte of DeviceNet: bits 7-6 type (first, middle, last, acknowledge), bits 5-0
//! count. So all eight data bytes carry the message. Class 11101 is never fragmented.
//!
//! # Implicit messages **\[D\]**
//!
//! | Identifier | Fields |
//! |---|---|
//! | 29 bits | `0`, Message ID (4), source OA (7), A (1), connection instance of the sender (16); A = 1: acknowledge of a change-of-state or cyclic message |
//! | Group 1, 11 bits | `0`, Message ID (3), source OA (7): 0x000-0x3FF |
//! | Group 2, 11 bits | `10`, Message ID (2), source OA (7): 0x400-0x5FF |
//! | Group 3, 11 bits | `11`, Message ID (2), source OA (7): 0x600-0x77F; Message ID 3 is reserved, because CAN 2.0 forbids seven leading recessive bits |
//!
//! ```
//! use devicenex_core::{Identifier, OperationalAddress, id::{Direction, Framing, Layout, Route}};
//!
//! let (manager, device) = (OperationalAddress::new(1).unwrap(), OperationalAddress::new(67).unwrap());
//! let route = Route { destination: device, direction: Direction::Request, source: manager };
//! let id = Identifier::connection(route, 9);
//! assert_eq!(id.to_string(), "1D860209");
//! assert_eq!(id.layout(), Layout::Connection { route, transaction: 9 });
//! assert_eq!(id.layout().to_string(), "connection request from OA 1 to OA 67, transaction 9");
//! ```

mod filters;
mod identifier;
mod layout;
mod operational_address;
#[cfg(test)]
mod tests;

pub use filters::{hello, implicit, network_manager, node, standby};
pub use identifier::{Direction, Identifier, MessageId, Sender};
pub use layout::{Framing, Group, Layout, Route};
pub use operational_address::{InvalidAddress, OperationalAddress};
