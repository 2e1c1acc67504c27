//! The explicit client: one request to a node, and its response.
//!
//! A [`Conversation`] is the client's side of the connectionless port, of the connection port, or of an explicit
//! connection, as its [`Route`] says: [`cip_core::client`] with the identifiers of DeviceNeX. It numbers transactions, cuts
//! long requests into fragments, puts long responses together, repeats what was lost, and knows an answer that is not its
//! own. Its owner runs one timer for it, hands out its frames and tells it what became of them.
//!
//! | Port | Requests | Response |
//! |---|---|---|
//! | [`Route::connectionless`] | Get_Attribute_Single in the 8/8 format **\[P\]** | in fragments, if it is longer than eight bytes **\[D\]** |
//! | [`Route::connection`] | [`ConnectionRequest`](crate::message::ConnectionRequest) | [`ConnectionResponse`](crate::message::ConnectionResponse): the service code without bit 7 **\[R\]**, which reads as success; or an error |
//! | [`Route::opened`] | every service, in the format that the server told | every response |
//!
//! # A connection is asked for, and a long attribute read over it
//!
//! ```
//! use cip_core::code::{AttributeId, ClassId, InstanceId};
//! use cip_core::message::{AttributeRequest, Response};
//! use devicenex_core::OperationalAddress;
//! use devicenex_core::client::{Conversation, Progress, Route, Waits, connection_response, explicit_request};
//! use devicenex_core::id::MessageId;
//! use link_core::{ExtendedId, Frame, TxOutcome};
//!
//! let [manager, device] = [1, 67].map(|number| OperationalAddress::new(number).expect("up to 126"));
//! let mut client = Conversation::<32>::new(Route::connection(manager, device), Waits::UNCONNECTED);
//! /// What is heard on the bus.
//! fn heard(id: u32, data: &[u8]) -> Frame {
//!     Frame::new(ExtendedId::new(id).expect("29 bits"), data).expect("up to eight bytes")
//! }
//!
//! // Explicit connection, 2500 ms; the manager will send with Message ID 6.
//! let asked = explicit_request(MessageId::new(6).expect("up to 15"), 2500);
//! client.start_message(&asked, 2)?;
//! assert_eq!(client.poll().expect("a request").to_string(), "1D860200 [7] 4B D6 01 00 C4 09 01");
//! client.tx_done(TxOutcome::Sent);
//! // Its own Message ID is 6 too, the body format 8/8.
//! let granted = heard(0x1D03_8600, &[0x4B, 0xD6, 0x00, 0xC4, 0x09]);
//! let Progress::Response(response) = client.frame(&granted) else { panic!() };
//! let granted = connection_response(&asked, &response).expect("granted");
//!
//! client.reroute(Route::opened(manager, device, &asked, &granted).expect("Message IDs up to 7"), Waits::CONNECTED);
//! let name = AttributeRequest::get(ClassId::IDENTITY, InstanceId(1), AttributeId(7));
//! client.start_attribute(&name, 2)?;
//! assert_eq!(client.poll().expect("a request").to_string(), "16860201 [4] 0E 01 01 07");
//! client.tx_done(TxOutcome::Sent);
//!
//! // The first fragment tells the transaction, and is acknowledged.
//! client.frame(&heard(0x1603_8700, b"\x01\x8E\x08GRT1-"));
//! assert_eq!(client.poll().expect("an acknowledge").to_string(), "168603C0 [1] 00");
//! client.tx_done(TxOutcome::Sent);
//! let last = heard(0x1603_8781, b"DRT");
//! let Progress::Response(Response::Success { data, .. }) = client.frame(&last) else { panic!() };
//! assert_eq!(data, b"\x08GRT1-DRT");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod route;
#[cfg(test)]
mod tests;

pub use cip_core::client::{Failure, Ignored, Progress, StartError, TimerChange, Waits};
pub use route::{Route, connection_response, explicit_request};

/// The client's side of one port of another node; see the [module](self) text.
///
/// `N` is the longest body, from the service byte on, of a request and of a response.
pub type Conversation<const N: usize> = cip_core::client::Conversation<Route, N>;
