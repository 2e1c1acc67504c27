//! Nodes without a protocol. They have nothing to tell: add them with
//! [`Network::add_silent`](crate::Network::add_silent).

mod babbler;
mod external;
mod listener;
mod replay;

pub use babbler::Babbler;
pub use external::{External, ExternalEvent, TooManyFrames};
pub use listener::Listener;
pub use replay::Replay;

use link_core::timers::TimerKey;

/// The one timer of these nodes.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
struct NextFrame;

impl TimerKey<1> for NextFrame {
    const ALL: [Self; 1] = [Self];
    const WHY: [&'static str; 1] = ["next frame"];

    fn index(self) -> usize {
        0
    }
}

/// The one conversation of these nodes.
const TOKEN: link_core::TxToken = link_core::TxToken(0);
