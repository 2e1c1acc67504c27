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

mod conversation;
mod outcome;
mod route;
#[cfg(test)]
mod tests;

pub use conversation::Conversation;
pub use outcome::{Failure, Ignored, Progress, StartError, TimerChange, Waits};
pub use route::Route;
