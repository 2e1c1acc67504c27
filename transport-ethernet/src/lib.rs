#![cfg(target_os = "linux")]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]
//! Raw Ethernet on Linux: runs any [`Machine`](link_core::ethernet::Machine) on the frames of one EtherType of an interface.
//!
//! ```no_run
//! use core::ops::ControlFlow;
//! use link_core::ethernet::{Machine, MacAddress, drive};
//! use transport_ethernet::{EthernetPort, Options};
//! # fn run<M: Machine>(machine_at: impl FnOnce(MacAddress) -> M) -> Result<(), transport_ethernet::Error> {
//! // A protocol of one's own, and the group that it listens to.
//! let groups = &[MacAddress([0x03, 0, 0, 0, 0, 0x01])];
//! let mut port = EthernetPort::open("eth0", Options { groups, ..Options::new(0x88B5) })?;
//! let mut machine = machine_at(port.interface().mac());
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
//! | a frame, with the kernel's time | [`Input::Frame`](link_core::ethernet::Input::Frame) of that moment |
//! | a frame longer than [`MAX_FRAME`](link_core::ethernet::MAX_FRAME) | [`FramesLost`](link_core::ethernet::LinkEvent::FramesLost) `{ count: 1 }`, together with others right behind it |
//! | `SO_RXQ_OVFL`: the receive queue was full | `FramesLost`, before the next frame that was received |
//! | `ENETDOWN`, `ENODEV`, `ENXIO`; rtnetlink: the interface is down, gone, or without a cable | [`Down`](link_core::ethernet::LinkEvent::Down), behind the frames that came before; [`Up`](link_core::ethernet::LinkEvent::Up) when it is back, found by its name |
//! | `ENOBUFS`, `EAGAIN`, `EMSGSIZE`; a frame while the link is down | [`NotSent`](link_core::ethernet::LinkEvent::NotSent) |
//!
//! The kernel hands a socket of one EtherType what the interface received, never what it sent: own frames do not come back. The
//! socket joins the groups of [`Options`]; the kernel leaves them when it is closed.
//!
//! # No answer that comes too late
//!
//! A station that answers when it is asked must not answer when its turn is over: its frame would fall into the turn of another. A
//! program that the kernel lets wait finds what it missed in the receive queue. With
//! [`Options::answer_within`] all of that is heard, so that a machine knows where the network is, but what it would send because of
//! it is withheld, and told as `NotSent`: if the frame is older than that, or if another frame waits behind it. The station that
//! decides who sends goes on only when it has the answer, or has given it up. A tick is no frame, and what it leads to is sent.
//!
//! # Waiting
//!
//! [`EthernetPort`] waits for a frame, for news of the interface, and for the deadline to the nanosecond; the kernel may be later by
//! the timer slack of the thread, 50 us unless [`sharpen_timers`] was called, and by what else the machine does.
//!
//! # Unsafe code
//!
//! One block, in the private module `socket`: `bind` to an EtherType of an interface, and the memberships, for which `nix` has no safe
//! interface. The rest is `nix`.

mod error;
mod interface;
mod port;
mod socket;
mod watch;

pub use error::Error;
pub use interface::Interface;
pub use port::{EthernetPort, Options, sharpen_timers};
