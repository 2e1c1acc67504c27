//! Connections: the instances, what each is by default, and the identifiers that it uses.
//!
//! A connection is set up by one request and one response **\[P\]**: a [`ConnectionRequest`](crate::message::ConnectionRequest)
//! names an instance of the target's Connection object, and *that instance* is what is spoken of here: its behaviour is
//! a set of attribute values, which the predefined connections have from the beginning.
//!
//! # Instances
//!
//! | Instance | Attribute 3 | The target | Consumes |
//! |---|---|---|---|
//! | 1 explicit | 0x83 | answers requests | the requester's requests |
//! | 2 / 3 polled | 0x82 | answers each command with its data | the requester's commands |
//! | 4 / 5 broadcast | 0x10 | produces to everybody, when its data change and every EPR | nothing |
//! | 6 / 7 multicast, producing | 0x10 | the same, to consumers that are told | nothing |
//! | 8 / 9 change of state | 0x12 | produces when its data change and every EPR | the requester's acknowledges |
//! | 10 / 11 cyclic | 0x02 | produces every EPR | the requester's acknowledges |
//! | 12 / 13 multicast, consuming | 0x80 | consumes | what the requester produces, or attribute 5 says |
//! | 128-255 dynamic | 0x83, or 0x82 until it is set | what attribute 3 says | the same |
//!
//! The numbers are the paper's **\[P\]**, what they do is ours **\[D\]**. Even numbers have 11-bit identifiers, odd ones 29.
//!
//! Attribute 3 of a dynamic I/O connection can be set while it is being configured:
//!
//! | Value | Meaning |
//! |---|---|
//! | 0x00 / 0x02 | produces every EPR, without / with acknowledge |
//! | 0x10 / 0x12 | produces when its data change and every EPR, without / with acknowledge |
//! | 0x80 | consumes |
//! | 0x82 | consumes, and answers with its data |
//! | 0x92 | consumes, and acknowledges |
//!
//! # Identifiers
//!
//! The Message ID of a request is that with which the requester produces **\[R\]**; the target takes the same for what it
//! produces itself, and with 11 bits another one of the group if it has that in use **\[D\]**: so the requester chooses the
//! priority.
//!
//! | | 29 bits | 11 bits |
//! |---|---|---|
//! | the target produces with | its Message ID, address, and the instance | group, its Message ID, its address |
//! | the requester produces with | its Message ID, address, and [`requester_instance`] | group, its Message ID, its address |
//! | an acknowledge | the same with A set | the same; a frame without data |
//!
//! A requester has no instance that the target would know of, and yet its commands to two targets need two identifiers:
//! what it produces carries the target's address and instance in the place of its own instance **\[D\]**.
//!
//! # Whose data a consumer consumes
//!
//! In section 5 of the paper a network manager tells A and C to consume what B2 produces. Attribute 5, the consumed
//! connection ID, is where it says so: it is the produced connection ID (attribute 4) of the other node. A dynamic
//! connection takes it while it is being configured. A predefined consumer (12, 13) is established by its request at once, and
//! takes it whenever it comes **\[D\]**; until then it consumes what the requester itself would produce on its instance 6 or 7,
//! so that a producer can set up its own consumers without another message. With an EPR of 0 the consumer waits for ever, and
//! goes on consuming when another node takes over the producer's address.

mod connection_id;
mod defaults;
mod identifiers;

pub use connection_id::ConnectionId;
pub(crate) use defaults::ACKNOWLEDGES;
pub use defaults::{ALLOWED_TRIGGERS, DYNAMIC_TRIGGER};
pub(crate) use identifiers::explicit;
pub use identifiers::{GroupMessage, InvalidGroup, requester_instance};
