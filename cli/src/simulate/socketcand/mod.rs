//! The socketcand protocol, by which programs such as python-can reach a CAN bus over TCP. Source: socketcand,
//! `doc/protocol.md`.
//!
//! | part | supported |
//! |---|---|
//! | `open`, `echo` | yes; the buses are the external nodes of the scenario, by their names |
//! | `rawmode`: `frame`, `rtr`, `error`, `send`, `sendrtr` | yes; `send` with a length and without data is a remote frame, as python-can sends it |
//! | `bcmmode`: `add`, `update`, `delete`, `send`, `subscribe`, `filter`, `unsubscribe` | yes, at most 256 cyclic frames and 256 subscriptions a client |
//! | `muxfilter` | refused |
//! | `controlmode`: `statistics` | yes |
//! | `isotpmode` | refused |
//! | discovery beacon | not sent |
//!
//! A frame of a client comes back to all other clients of its bus, as on a SocketCAN interface, when it was on the bus and
//! acknowledged. Times are those of the simulated bus.
//!
//! A client that says something wrong is told by `< error .. >` in words, except in raw mode: there `error` has the class of
//! an error frame (`linux/can/error.h`) and a time, and clients such as python-can give up at words. Frames that are lost
//! are told by the error frames that an interface gives, and rubbish goes into the trace. A client that does not read what
//! it is sent is dropped, and so is one that has not opened a bus after 30 s.
//!
//! | error frame | when |
//! |---|---|
//! | `001` | a frame of the client was not sent: no power, no cable, bus-off |
//! | `004` | a frame of the client was not taken, too many wait; or the error state has changed |
//! | `040` | bus-off |
//! | `080` | an error on the bus |
//! | `100` | restarted after bus-off |
//!
//! Lines have no other end than `>`: an answer and the frames behind it may come in one TCP segment, and a client must look
//! for the brackets. Some compare what one read gives with the answer that they expect, python-can for one, after
//! `rawmode`. So the first frames of raw mode wait for 20 ms, or until the client says something.

mod broadcast;
mod connection;
mod framing;
mod message;
mod server;
mod session;
mod statistics;

pub(super) use connection::MOST_CLIENTS;
pub(super) use server::{ClientId, Complaint, Outgoing, Server};
