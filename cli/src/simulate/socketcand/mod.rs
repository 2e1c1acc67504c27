//! The socketcand protocol, by which programs such as python-can reach a CAN bus over TCP. Source: socketcand,
//! `doc/protocol.md`.
//!
//! | part | supported |
//! |---|---|
//! | `open`, `echo` | yes; the buses are the external nodes of the scenario, by their names |
//! | `rawmode`: `frame`, `rtr`, `error`, `send`, `sendrtr` | yes |
//! | `bcmmode`: `add`, `update`, `delete`, `send`, `subscribe`, `filter`, `unsubscribe` | yes, at most 256 cyclic frames and 256 subscriptions a client |
//! | `muxfilter` | refused |
//! | `controlmode`: `statistics` | yes |
//! | `isotpmode` | refused |
//! | discovery beacon | not sent |
//!
//! A frame of a client comes back to all other clients of its bus, as on a SocketCAN interface, when it was on the bus and
//! acknowledged. Times are those of the simulated bus. A client that says something wrong is told by `< error .. >`; one
//! that does not read what it is sent is dropped.

mod broadcast;
mod message;
mod server;
mod session;

pub(super) use server::{ClientId, Outgoing, Server};
