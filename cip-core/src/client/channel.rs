//! What a network adds to a conversation.

use core::fmt::Debug;
use core::hash::Hash;

use link_core::Frame;

use crate::codec::{ParseError, Wire};
use crate::fragment::{AckStatus, Fragment};
use crate::message::{BodyFormat, Response};

/// How a network carries the messages between one client and one server: the identifiers, and what of a message stands
/// in them or before the body.
pub trait Channel: Clone + PartialEq + Eq + Hash + Debug {
    /// Tells the messages of one transaction from those of the one before.
    type Transaction: Copy + PartialEq + Eq + Hash + Debug;

    /// That before the first.
    const BEFORE_FIRST: Self::Transaction;

    /// The transaction that follows.
    fn after(transaction: Self::Transaction) -> Self::Transaction;

    /// The transaction of a fragment as one bit, by which the repetition of the last fragment of the response before is
    /// known; always the same where fragments do not carry it.
    fn xid(transaction: Option<Self::Transaction>) -> bool;

    /// Whether a body is too long for one frame.
    fn is_fragmented(body: &[u8]) -> bool;

    /// Fragment number `index` of a body, counted from 0; `None` after the last.
    fn cut(body: &[u8], index: usize) -> Option<Fragment<'_>>;

    /// How requests are addressed.
    fn format(&self) -> BodyFormat;

    /// The frame that carries a part to the server; `None` if it does not fit.
    fn frame(&self, transaction: Self::Transaction, part: Part<'_>) -> Option<Frame>;

    /// What a frame of the bus says to the client; `None` if it is not from this server to this client.
    fn hear<'a>(&self, frame: &'a Frame) -> Option<Result<Heard<'a, Self::Transaction>, ParseError>>;

    /// Reads the body of a response.
    fn response<'a>(&self, body: &'a [u8]) -> Result<Response<'a>, ParseError> {
        Response::parse(body)
    }
}

/// What a client sends in one frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part<'a> {
    /// A whole request, from the service byte on.
    Complete(&'a [u8]),
    /// A part of one.
    Fragment(Fragment<'a>),
    /// The acknowledge of a fragment of the response.
    Acknowledge {
        /// That of the fragment.
        count: u8,
        /// Whether the client goes on.
        status: AckStatus,
    },
}

/// What a server says in one frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Heard<'a, T> {
    /// A whole response.
    Complete {
        /// That of the request.
        transaction: T,
        /// From the service byte on.
        body: &'a [u8],
    },
    /// A part of one.
    Fragment {
        /// That of the request, if the fragment carries it.
        transaction: Option<T>,
        /// Its byte and data.
        fragment: Fragment<'a>,
    },
    /// The acknowledge of a fragment of the request.
    Acknowledge {
        /// That of the request, if the acknowledge carries it.
        transaction: Option<T>,
        /// That of the fragment.
        count: u8,
        /// Whether the server goes on.
        status: AckStatus,
    },
}
