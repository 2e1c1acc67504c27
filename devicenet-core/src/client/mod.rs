//! The explicit client: one request to a server, and its response.
//!
//! A [`Conversation`] is the client's side of an explicit connection, of the unconnected port or of the UCMM, as its
//! [`Route`] says: [`cip_core::client`] with the identifiers and headers of DeviceNet.
//!
//! # An attribute is read
//!
//! ```
//! use cip_core::code::{AttributeId, ClassId, InstanceId};
//! use cip_core::message::{AttributeRequest, BodyFormat, Response};
//! use devicenet_core::client::{Conversation, Progress, Route, TimerChange, Waits};
//! use devicenet_core::{Identifier, MacId};
//! use link_core::TxOutcome;
//!
//! let (client, server) = (MacId::try_from(4)?, MacId::try_from(63)?);
//! let route = Route::predefined(client, server, BodyFormat::Class8Instance8);
//! let mut conversation = Conversation::<32>::new(route, Waits::CONNECTED);
//!
//! // The vendor, tried twice: reading may be repeated.
//! let vendor = AttributeRequest::get(ClassId::IDENTITY, InstanceId(1), AttributeId(1));
//! conversation.start_attribute(&vendor, 2)?;
//! let request = conversation.poll().expect("a request");
//! assert_eq!(request.to_string(), "5FC [5] 04 0E 01 01 01");
//!
//! // It is on the bus: now the owner's timer runs.
//! conversation.tx_done(TxOutcome::Sent);
//! assert_eq!(conversation.take_timer(), TimerChange::Set(Waits::CONNECTED.response));
//!
//! let heard = Identifier::explicit_response(server).frame(&[0x04, 0x8E, 0xE7, 0x03]).expect("four bytes");
//! let Progress::Response(Response::Success { data, .. }) = conversation.frame(&heard) else { panic!() };
//! assert_eq!(data, [0xE7, 0x03]);
//! assert_eq!(conversation.take_timer(), TimerChange::Clear);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
mod route;
#[cfg(test)]
mod tests;

pub use cip_core::client::{Failure, Ignored, Progress, StartError, TimerChange, Waits};
pub use route::Route;

/// The client's side of one explicit connection, of an unconnected port or of the UCMM; see the [module](self) text.
///
/// `N` is the longest body, from the service byte on, of a request and of a response.
pub type Conversation<const N: usize> = cip_core::client::Conversation<Route, N>;
