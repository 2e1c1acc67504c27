//! `devicenet powerlink`: a station of Ethernet POWERLINK on an Ethernet interface.
//!
//! ```text
//! interface ── transport_ethernet::EthernetPort ── session: the end, an interruption, a recording
//!                                                     │
//!            cn: powerlink_core::ControlledNode ───────┼─────── mn: powerlink_core::managing::ManagingNode, of a network file
//!                                                     │
//!                                                log: lines, or JSON
//! ```

mod args;
#[cfg(target_os = "linux")]
mod cn;
#[cfg(target_os = "linux")]
mod folds;
#[cfg(target_os = "linux")]
mod limits;
#[cfg(target_os = "linux")]
mod log;
#[cfg(target_os = "linux")]
mod mn;
#[cfg(target_os = "linux")]
mod record;
#[cfg(target_os = "linux")]
mod session;

pub use args::{CnArgs, Hex, MnArgs, PowerlinkArgs, PowerlinkRole, StationArgs};

use crate::exit::{Exit, Failure};

/// Is a station of Ethernet POWERLINK.
///
/// # Errors
/// [`Failure`] when the command line, a file or the interface does not allow it.
#[cfg(target_os = "linux")]
pub fn run(args: &PowerlinkArgs, json: bool) -> Result<Exit, Failure> {
    match &args.role {
        PowerlinkRole::Cn(args) => cn::run(args, json),
        PowerlinkRole::Mn(args) => mn::run(args, json),
    }
}

/// Is a station of Ethernet POWERLINK.
///
/// # Errors
/// Always: raw Ethernet is for Linux.
#[cfg(not(target_os = "linux"))]
pub fn run(_: &PowerlinkArgs, _: bool) -> Result<Exit, Failure> {
    Err(Failure::Transport("raw Ethernet is supported on Linux only".into()))
}
