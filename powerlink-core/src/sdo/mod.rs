//! SDO over ASnd: a server that reads and writes objects for its clients.
//!
//! The sequence layer opens a connection, numbers its frames, and sends again what was lost:
//!
//! ```text
//! client                  server
//! rcon 0, scon 1  ----->                      initialisation
//!                 <-----  rcon 1, scon 1
//! rcon 1, scon 2  ----->
//!                 <-----  rcon 2, scon 2      the connection is valid
//! 2/0, 2/1  command ---->
//!                 <-----  2/1, 2/1  response
//! 2/1, 2/1  ----------->                      acknowledge, or the next command
//! 0, 0      ----------->                      closed
//! ```
//!
//! The command layer reads and writes by index, expedited and in segments. Every frame of the server waits for the
//! asynchronous slot: [`Server::ready`] is what the node asks for, [`Server::emit`] what it sends when invited.

mod client;
mod connection;
mod outgoing;
mod server;
#[cfg(test)]
mod tests;

pub(crate) use client::{Client, Progress};
pub use server::{CONNECTIONS, Outcome, Received, Server};
