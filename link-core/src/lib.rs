#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(test, allow(clippy::arithmetic_side_effects, clippy::as_conversions))]
//! What every sans-IO protocol core and every CAN transport share.
//!
//! A protocol core is a [`Machine`]: it takes frames, link events and ticks as [`Input`], and hands out
//! [`Action`]s. It owns no socket, no clock, no queue of frames and no memory but its own fields. A transport is
//! a [`Port`]: it sends what it is told to send, says when that was *on the bus*, and waits until the machine's
//! deadline. [`drive`](drive()) joins the two, and is the only run loop; [`drain`] is what it does between two waits, for a
//! program that has other things to do then.
//!
//! | module | what |
//! |---|---|
//! | [`time`] | [`Instant`], a count of nanoseconds; with feature `std` a [`Clock`](time::Clock) |
//! | [`timers`] | [`Timers`], the one place where a machine stores instants |
//! | [`frame`] | [`Frame`], classic CAN with 11 or 29 bit identifiers |
//! | [`wire`] | the same frame as bits: stuffing, CRC-15, exact length |
//! | [`filter`] | acceptance filters |
//! | [`link`] | what happens below the frame: bus-off, error-passive, bit rate, mode |
//! | [`machine`] | the contract |
//! | [`edge`] | the transitions of state machines |
//! | [`drive`](mod@drive) | the run loop and [`Port`] |
//! | [`ethernet`] | the same contract with raw Ethernet frames |
//! | [`codec`] | bounded reading and writing of bytes, and the laws of a type with a byte layout |
//! | [`codes`] | numbers with names |
//! | [`recording`] | which frame of a recording answers which |
//! | [`text`] | formatting without allocation |
//! | `embedded` | feature `embedded-can`: a [`Port`] on an `embedded_can` driver |
//!
//! # A machine, driven by hand
//! ```
//! use core::time::Duration;
//! use link_core::{Action, Deadline, Frame, Input, Instant, Machine, StandardId, Timers, TxToken, timers::TimerKey};
//!
//! /// Sends an empty frame every 100 ms.
//! struct Beacon {
//!     timers: Timers<Beat, 1>,
//!     on_the_bus: bool,
//! }
//!
//! #[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
//! struct Beat;
//! impl TimerKey<1> for Beat {
//!     const ALL: [Self; 1] = [Beat];
//!     const WHY: [&'static str; 1] = ["beacon interval"];
//!     fn index(self) -> usize { 0 }
//! }
//!
//! impl Machine for Beacon {
//!     type Event = ();
//!     fn input(&mut self, now: Instant, input: Input) {
//!         let now = self.timers.advance(now);
//!         if let Input::TxDone(..) = input {
//!             self.on_the_bus = false;
//!             self.timers.set(Beat, now + Duration::from_millis(100));
//!         }
//!     }
//!     fn poll(&mut self, now: Instant) -> Option<Action<()>> {
//!         self.timers.take_expired(now)?;
//!         self.on_the_bus = true;
//!         Some(Action::Transmit(TxToken(0), Frame::new(StandardId::ZERO, &[])?))
//!     }
//!     fn deadline(&self) -> Option<Deadline> { self.timers.next() }
//!     fn max_in_flight(&self) -> usize { 1 }
//! }
//!
//! let start = Instant::ZERO;
//! let mut beacon = Beacon { timers: Timers::new(), on_the_bus: false };
//! beacon.timers.set(Beat, start);
//! assert!(matches!(beacon.handle(start, Input::Tick).next(), Some(Action::Transmit(..))));
//! assert_eq!(beacon.deadline(), None, "it waits for the frame to be sent");
//! ```

#[cfg(any(test, feature = "std"))]
extern crate std;

mod code;
pub mod codec;
pub mod drive;
pub mod edge;
#[cfg(feature = "embedded-can")]
pub mod embedded;
pub mod ethernet;
pub mod filter;
pub mod frame;
pub mod link;
pub mod machine;
#[cfg(feature = "std")]
#[doc(hidden)]
pub mod machine_laws;
mod queue;
pub mod recording;
#[cfg(feature = "std")]
pub mod stamps;
pub mod text;
pub mod time;
pub mod timers;
pub mod wire;

pub use drive::{Port, drain, drive};
pub use edge::{Edge, NumberedEdge};
pub use embedded_can_types::{ExtendedId, Id, StandardId};
pub use filter::{Filter, FilterSet};
pub use frame::Frame;
pub use link::{BitRate, BusErrorKind, LinkCommand, LinkEvent, Mode};
pub use machine::{Action, Actions, Deadline, Input, Machine, TxOutcome, TxToken};
pub use queue::Queue;
pub use time::Instant;
pub use timers::Timers;
