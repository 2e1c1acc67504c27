//! The explicit client: one request to a server, and its response.
//!
//! A [`Conversation`] is the client's side of an explicit connection, of the unconnected port or of the UCMM, as its
//! [`Route`] says. It numbers transactions, cuts long requests into fragments and waits for their acknowledges, puts
//! long responses together and acknowledges them, repeats what was lost, and knows a response that is not its own.
//!
//! It is a part of larger machines (a master has one for each slave, a tool one or two), so it keeps no time: its owner
//! runs one timer for it ([`TimerChange`]), hands out its frames and tells it what became of them.
//!
//! ```text
//!          start             last fragment acknowledged,
//! +------+       +------------+   or only frame sent    +----------+  fragment  +-----------+
//! | Idle |------>| Requesting |------------------------>| Awaiting |----------->| Receiving |
//! +------+       +------------+                         +----------+            +-----------+
//!    ^            |     ^   repeat                        |     |                  |     |
//!    |  no ack,   |     +---------------------------------|-----+------------------+     |
//!    |  refused   |                     response, time-out|                              |
//!    +------------+---------------------------------------+------------------------------+
//! ```
//!
//! | Wait | Starts | Length | When it is over |
//! |---|---|---|---|
//! | acknowledge | a fragment of the request is on the bus | [`Waits::acknowledge`] | the fragment is repeated once, then [`Failure::NotAcknowledged`] |
//! | response | the request is on the bus, or its last fragment is acknowledged | [`Waits::response`] | the request is repeated, as often as [`start`](Conversation::start) allowed, then [`Failure::NoResponse`] |
//! | next fragment | a fragment of the response was received | [`Waits::next_fragment`] | as after the wait for the response |
//! | repetition | the response is complete | one second | its last fragment is no longer acknowledged again |
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
//! # Decisions where the literature is silent
//!
//! | Situation | What happens |
//! |---|---|
//! | the response comes before the acknowledge of the request's last fragment, or before its `TxDone` | it proves both |
//! | a frame is given back unsent | it counts as lost: it is repeated when the wait for its answer is over |
//! | a server repeats fragments that were there already | they are acknowledged, and do not prolong the wait |
//! | the last fragment of a complete response comes again | it is acknowledged for one second, until the next transaction |
//! | the next transaction begins before the last acknowledge is sent | the acknowledge goes first, with its own transaction ID and identifier |

mod conversation;
mod outcome;
mod receive;
mod route;
#[cfg(test)]
mod tests;

pub use conversation::Conversation;
pub use outcome::{Failure, Ignored, Progress, StartError, TimerChange, Waits};
pub use route::Route;
