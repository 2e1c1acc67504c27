//! CAN identifiers: the four message groups and the names of the predefined set.
//!
//! # Groups
//!
//! | Group | Bits 10..0 | Range | Fields |
//! |---|---|---|---|
//! | 1 | `0 mmmm ssssss` | 0x000-0x3FF | Message ID 0-15, source MAC ID |
//! | 2 | `10 aaaaaa mmm` | 0x400-0x5FF | MAC ID (source, destination or multicast), Message ID 0-7 |
//! | 3 | `11 mmm ssssss` | 0x600-0x7BF | Message ID 0-6, source MAC ID |
//! | 4 | `11111 mmmmmm` | 0x7C0-0x7EF | Message ID 0x00-0x2F, no MAC ID |
//! | invalid | `1111111 xxxx` | 0x7F0-0x7FF | never sent: old controllers cannot use seven leading recessive bits |
//!
//! The lower identifier wins arbitration: Group 1 beats 2 beats 3 beats 4. In Groups 1 and 3 the Message ID decides
//! first, in Group 2 the MAC ID.
//!
//! # Names
//!
//! s is a slave, m a master, n the node itself, g a multicast group.
//!
//! | Group | Message ID | Identifier | MAC ID in it | [`Purpose`] |
//! |---|---|---|---|---|
//! | 1 | 0x0-0xB | 0x000-0x2FF | source | [`Dynamic`](Purpose::Dynamic) |
//! | 1 | 0xC | 0x300 + s | source | [`MulticastPollResponse`](Purpose::MulticastPollResponse) |
//! | 1 | 0xD | 0x340 + s | source | [`ChangeOfState`](Purpose::ChangeOfState) or cyclic message of a slave |
//! | 1 | 0xE | 0x380 + s | source | [`BitStrobeResponse`](Purpose::BitStrobeResponse) |
//! | 1 | 0xF | 0x3C0 + s | source | [`PollResponse`](Purpose::PollResponse), or acknowledge of the master's COS/cyclic message |
//! | 2 | 0 | 0x400 + 8m | source | [`BitStrobeCommand`](Purpose::BitStrobeCommand) |
//! | 2 | 1 | 0x401 + 8g | multicast | [`MulticastPollCommand`](Purpose::MulticastPollCommand) |
//! | 2 | 2 | 0x402 + 8s | destination | [`ChangeOfStateAcknowledge`](Purpose::ChangeOfStateAcknowledge) |
//! | 2 | 3 | 0x403 + 8s | source | [`ExplicitResponse`](Purpose::ExplicitResponse), connected or unconnected; heartbeat and shutdown of a Group 2 Only server |
//! | 2 | 4 | 0x404 + 8s | destination | [`ExplicitRequest`](Purpose::ExplicitRequest) |
//! | 2 | 5 | 0x405 + 8s | destination | [`PollCommand`](Purpose::PollCommand), or the master's COS/cyclic message |
//! | 2 | 6 | 0x406 + 8s | destination | [`Group2UnconnectedRequest`](Purpose::Group2UnconnectedRequest) |
//! | 2 | 7 | 0x407 + 8n | checked | [`DuplicateMacCheck`](Purpose::DuplicateMacCheck) |
//! | 3 | 0-4 | 0x600-0x73F | source | [`Dynamic`](Purpose::Dynamic) |
//! | 3 | 5 | 0x740 + n | source | [`UnconnectedResponse`](Purpose::UnconnectedResponse); heartbeat and shutdown of a UCMM-capable node |
//! | 3 | 6 | 0x780 + n | source | [`UnconnectedRequest`](Purpose::UnconnectedRequest) |
//! | 4 | 0x00-0x2B | 0x7C0-0x7EB | - | [`Reserved`](Purpose::Reserved) |
//! | 4 | 0x2C | 0x7EC | - | [`CommunicationFaultedResponse`](Purpose::CommunicationFaultedResponse) |
//! | 4 | 0x2D | 0x7ED | - | [`CommunicationFaultedRequest`](Purpose::CommunicationFaultedRequest) |
//! | 4 | 0x2E | 0x7EE | - | [`OfflineOwnershipResponse`](Purpose::OfflineOwnershipResponse) |
//! | 4 | 0x2F | 0x7EF | - | [`OfflineOwnershipRequest`](Purpose::OfflineOwnershipRequest) |
//!
//! Sources: ODVA CIP Networks Library Vol. 3 (DeviceNet Adaptation of CIP); ICP DAS I-7242D and CAN-8124 manuals; MKS
//! Baratron DMA manual, appendix D; Rockwell 1760-UM003A. Some older manuals call Group 2 Message ID 1 "reserved for
//! master's use": multicast poll was defined later.
//!
//! ```
//! use devicenet_core::{MacId, id::{Identifier, MessageGroup, Purpose}};
//!
//! let check = Identifier::duplicate_mac_check(MacId::new(37).unwrap());
//! assert_eq!(check.raw(), 0x52F);
//! assert_eq!(check.to_string(), "group 2, message 7, MAC ID 37");
//! assert_eq!(check.group(), MessageGroup::Group2);
//! assert_eq!(check.purpose(), Purpose::DuplicateMacCheck);
//! ```

mod filters;
mod identifier;
mod mac_id;
mod purpose;

pub use filters::{
    communication_faulted, duplicate_mac_check, duplicate_mac_checks, group2_only_server, group2_server,
    master, offline_owner, ucmm_requests,
};
pub use identifier::{Identifier, MessageGroup};
pub use mac_id::{InvalidMacId, MacId};
pub use purpose::{MacIdRole, Purpose};
