//! What the passive decoders of the networks share: everything that knows neither identifiers nor addresses.
//!
//! A decoder of a network finds out which identifier carries what, from whom and to whom. The rest is the same wherever CIP
//! runs on CAN, and is here:
//!
//! | Type | What |
//! |---|---|
//! | [`Flaw`] | what can be wrong with a message |
//! | [`Frag`] | the fragmentation byte of a frame |
//! | [`Seen`], [`Answered`] | a frame of the recording, and what its answer says of it |
//! | [`Remark`] | what a rule has found, for the [reading](Remarks) of the network |
//! | [`Slots`] | the messages that are being put together from fragments |
//! | [`Span`] | where in a message its value stands |
//! | [`Traffic`] | what a node has sent, in numbers |
//!
//! Storage is fixed, and what a frame costs is bounded.

pub mod attribute;
mod connection;
mod data;
mod explicit;
mod flaw;
mod flight;
mod frag;
#[cfg(feature = "serde")]
pub mod json;
pub mod packet;
mod remarks;
mod slots;
mod span;
mod state;
pub mod text;
mod traffic;
mod vocabulary;

pub use link_core::recording::{Answered, Seen};

pub use connection::{Connection, Flow, Guess, Side};
pub use data::{FragmentationGuess, Part, Progress};
pub use explicit::{Asked, Explicit, PacketRate, ReadRequest, ReadResponse, likely_format};
pub use flaw::Flaw;
pub use flight::Flights;
pub use frag::Frag;
pub use remarks::{Remark, Remarks};
pub use slots::{Piece, Slots, Stream};
pub use span::Span;
pub use state::ConnectionState;
pub use traffic::{Sent, Traffic};
pub use vocabulary::Vocabulary;
