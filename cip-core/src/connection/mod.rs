//! The Connection object (class 5): its attributes, its state machines, its time-outs.
//!
//! An I/O connection is an [`IoConnection`], an explicit one an [`ExplicitConnection`]: a state, the few attributes that
//! a client can set ([`Settings`]), and nothing of the network. Whoever owns them tells what happens as an [`IoCause`] or
//! [`ExplicitCause`], and does with its timer what the answer says ([`Watchdog`]). What may lead from one state to the
//! next are the tables [`IO_EDGES`] and [`EXPLICIT_EDGES`]; debug builds check every step against them.
//!
//! What depends on the network and on the device (connection IDs, sizes, paths) is joined to it when it is read:
//! [`ConnectionView`].
//!
//! ```
//! use cip_core::connection::{IoCause, IoConnection, IoState, PredefinedConnection};
//! use cip_core::connection::{TimeoutMultiplier, TimerResolution, Watchdog};
//!
//! let mut poll = IoConnection::NON_EXISTENT;
//! poll.allocate(PredefinedConnection::Poll)?;
//! // The master sets the expected packet rate to 75 ms, and the connection is established.
//! let (used, watchdog) = poll.set_packet_rate(75, TimerResolution::DEFAULT)?;
//! assert_eq!((used, poll.state()), (80, IoState::Established));
//! let millis = |watchdog: Watchdog| watchdog.millis(used, TimeoutMultiplier::default());
//! assert_eq!(millis(watchdog), Some(10_000), "the first message may take that long");
//! assert_eq!(poll.handle(IoCause::Message), Ok(Watchdog::Start));
//! assert_eq!(millis(Watchdog::Start), Some(320));
//! assert_eq!(poll.handle(IoCause::WatchdogExpired), Ok(Watchdog::Stop));
//! assert_eq!(poll.state(), IoState::TimedOut);
//! # Ok::<(), cip_core::code::GeneralStatus>(())
//! ```

mod explicit_state;
mod io_state;
mod mode;
mod predefined;
mod production;
mod settings;
#[cfg(test)]
mod tests;
mod timing;
mod values;
mod view;

pub use explicit_state::{EXPLICIT_EDGES, ExplicitCause, ExplicitConnection, ExplicitEdge, ExplicitState};
pub use io_state::{IO_EDGES, IoCause, IoConnection, IoEdge, IoState};
pub use mode::{End, IoMode};
pub use predefined::{ConnectionDefaults, EXPLICIT_PACKET_RATE, PredefinedConnection};
pub use production::{Production, ProductionTimer};
pub use settings::Settings;
pub use timing::{FIRST_TIME_OUT_MILLIS, TimerResolution, Watchdog, first_time_out, time_out};
pub use values::{
    CommCharacteristics, CommDirection, ConnectionState, InstanceType, ProductionTrigger, TimeoutMultiplier,
    TransportClassTrigger, WatchdogAction,
};
pub use view::{ConnectionId, ConnectionPath, ConnectionView};
