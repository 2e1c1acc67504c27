//! What the passive decoders of the networks share: everything that knows neither identifiers nor addresses.
//!
//! A decoder of a network finds out which identifier carries what, from whom and to whom. The rest is the same wherever CIP
//! runs on CAN, and is here:
//!
//! | Type | What |
//! |---|---|
//! | [`Explicit`], [`Asked`] | what an explicit message says, and what of a request its response does not repeat |
//! | [`packet`] | requests inside of a request, and their responses |
//! | [`Connection`], [`Side`], [`Flow`] | what is known of a connection, of one of its directions, and which that is |
//! | [`Flights`] | the fragments that wait for an acknowledge |
//! | [`Slots`], [`Piece`], [`Part`] | the messages that are being put together from fragments, and what becomes of a frame |
//! | [`Flaw`] | what can be wrong with a message |
//! | [`Remark`] | what a rule has found, for the [reading](Remarks) of the network |
//! | [`Frag`] | the fragmentation byte of a frame |
//! | [`Seen`], [`Answered`] | a frame of the recording, and what its answer says of it |
//! | [`Span`] | where in a message its value stands |
//! | [`Traffic`] | what a node has sent, in numbers |
//! | [`Vocabulary`], [`text`] | names and words; the network has some of its own |
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
