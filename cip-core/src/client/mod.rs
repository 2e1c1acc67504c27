//! The explicit client: one request to a server, and its response.
//!
//! A [`Conversation`] numbers transactions, cuts long requests into fragments and waits for their acknowledges, puts long
//! responses together and acknowledges them, repeats what was lost, and knows a response that is not its own. What differs
//! from network to network (identifiers, headers, lengths of fragments) is its [`Channel`].
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
//! # Decisions where the literature is silent
//!
//! | Situation | What happens |
//! |---|---|
//! | the response comes before the acknowledge of the request's last fragment, or before its `TxDone` | it proves both |
//! | a frame is given back unsent | it counts as lost: it is repeated when the wait for its answer is over |
//! | a server repeats fragments that were there already | they are acknowledged, and do not prolong the wait |
//! | the last fragment of a complete response comes again | it is acknowledged for one second, until the next transaction |
//! | the next transaction begins before the last acknowledge is sent | the acknowledge goes first, with its own transaction ID and identifier |

mod channel;
mod conversation;
mod outcome;
mod receive;

pub use channel::{Channel, Heard, Part};
pub use conversation::Conversation;
pub use outcome::{Failure, Ignored, Progress, StartError, TimerChange, Waits};
