#![cfg(target_os = "linux")]
#![cfg_attr(test, allow(clippy::arithmetic_side_effects, clippy::as_conversions, clippy::indexing_slicing))]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]
//! Linux SocketCAN: runs any [`Machine`](link_core::Machine) on a CAN interface of the kernel.
//!
//! ```no_run
//! use core::ops::ControlFlow;
//! use link_core::drive;
//! use transport_socketcan::SocketCanPort;
//! # fn run<M: link_core::Machine>(mut machine: M) -> Result<(), transport_socketcan::Error> {
//! let mut port = SocketCanPort::open("can0")?;
//! drive(&mut machine, &mut port, |_, now, event| -> ControlFlow<()> {
//!     println!("{now:.6} {event:?}");
//!     ControlFlow::Continue(())
//! })
//! # }
//! ```
//!
//! # What the kernel tells, and what a machine hears
//!
//! | kernel | machine |
//! |---|---|
//! | a frame, with the kernel's time | [`Input::Frame`](link_core::Input::Frame) of that moment |
//! | the echo of an own frame, marked `MSG_CONFIRM` | [`TxDone(_, Sent)`](link_core::TxOutcome::Sent): it was on the bus and acknowledged |
//! | a frame taken by an interface without an echo (`vcan`, `slcan`) | `TxDone(_, Sent)`, of the last known moment |
//! | the same frame from a twin, unmarked | `Input::Frame`: an echo is never recognised by its content |
//! | no echo for 3 s (up to 60 s, as long as nothing at all is heard), though the controller tells of no trouble, or for 1 s after frames were lost | [`TxDone(_, Unknown)`](link_core::TxOutcome::Unknown); [`SocketCanPort::unconfirmed`] tells which of these |
//! | error frame, class bus-off | [`LinkEvent::BusOff`](link_core::LinkEvent::BusOff); frames in flight are `Dropped` |
//! | error frame, restarted | `Up`; before it `BusOff`, if the news of that was lost |
//! | error frame, controller | `ErrorWarning`, `ErrorPassive`, `ErrorActive`, `Overrun` |
//! | error frame, protocol violation, no acknowledge | `BusError` with its kind |
//! | error frame with counters | `Counters`, before the change of state |
//! | `SO_RXQ_OVFL` | `Overrun { lost }` |
//! | `ENETDOWN`, `ENODEV`, `ENXIO` | `Down`; frames in flight are `Dropped`; `Up` when the interface is back, found by its name |
//! | `ENOBUFS`, `EAGAIN` | nothing: the transmit queue, or the part of it that a socket may fill, is full; the frame is offered again |
//!
//! The kernel's transmit queue is first in, first out. So that the most urgent frame goes first, the kernel has one frame of
//! a port at a time; the others wait in the order of their arbitration keys.
//!
//! # Bit rate, listen-only, restart
//!
//! [`LinkCommand::SetMode`](link_core::LinkCommand::SetMode) and [`Reset`](link_core::LinkCommand::Reset) are carried out
//! through netlink, which takes the right to administer the network. Without it the machine hears
//! [`Refused`](link_core::LinkEvent::Refused), and [`SocketCanPort::refusal`] names the `ip link` command that does it.
//! A kernel that restarts the controller by itself (`restart-ms`) refuses to be told to: there, `Reset` is answered by
//! [`Up`](link_core::LinkEvent::Up) when it has done so, and needs no right. A mode that is in force already needs none either. A virtual interface has no bit rate, so it has every one. An `slcan`
//! adapter may have one that the kernel does not know ([`Kind`]): it is set anew, or refused, but never taken for the right one.
//!
//! # Unsafe code
//!
//! One block, in the private module `receive`: `recvmmsg`, for neither the flag `MSG_CONFIRM` nor the count of lost frames
//! is handed out by a safe interface.

mod echo;
mod error;
mod error_frame;
mod frame;
mod interface;
mod link;
mod outbox;
mod port;
mod receive;
mod socket;
#[cfg(feature = "tokio")]
mod tokio;

pub use error::{Error, Refusal, Unconfirmed};
pub use interface::{Interface, Kind};
pub use port::SocketCanPort;
#[cfg(feature = "tokio")]
pub use tokio::{TokioPort, drive};
