//! The network manager: it finds devices, gives them addresses, makes their connections, and replaces what is lost.

mod address;
mod command;
mod config;
mod connect;
mod database;
mod discover;
mod event;
mod lanes;
mod machine;
mod node;
mod output;
mod slot;
mod standing;
mod state;
mod talk;
#[cfg(test)]
mod tests;
mod watch;

pub use command::DeviceView;
pub use config::Config;
pub use database::{
    Attribute, DatabaseError, IdentityPattern, PlannedConnection, PlannedDevice, READS, SPARES, Source,
};
pub use event::{Counters, ManagerEvent, PlannedEvent, RequestFailure, Value};
pub use machine::Manager;
pub use state::{Cause, DeviceState, EDGES, Edge};
pub use talk::RequestError;
