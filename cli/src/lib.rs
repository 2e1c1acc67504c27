#![allow(
    clippy::arithmetic_side_effects,
    clippy::as_conversions,
    clippy::indexing_slicing,
    reason = "runs on a host, over files: counters of 64 bits, and indices that the line before has checked"
)]
//! What the `devicenet` command is made of.
//!
//! | module | what |
//! |---|---|
//! | [`args`] | the command line |
//! | [`compare`] | `devicenet compare` |
//! | [`decode`] | `devicenet decode` |
//! | [`eds`] | `devicenet eds` |
//! | [`health`] | what a doctor is told of a network beforehand |
//! | [`live`] | `devicenet monitor`, `scan`, `get`, `set`, `slave`, `master`, `record`, `recover`: on an interface, on the simulated bus, over a recording |
//! | [`powerlink`] | `devicenet powerlink` |
//! | [`recording`] | readers and writers of recordings of a CAN bus, streaming, the format found in the content |
//! | [`scenario`] | scenario files: model, parser, diagnostics |
//! | [`simulate`] | `devicenet simulate` |
//! | [`trace`] | the one text form of bus traffic |
//! | [`output`], [`exit`] | standard output, messages, exit codes |

pub mod args;
mod bus_rate;
mod bus_time;
pub mod compare;
pub mod decode;
pub mod eds;
mod excerpt;
pub mod exit;
pub mod health;
mod histogram;
pub mod live;
mod losses;
pub mod output;
pub mod powerlink;
pub mod recording;
pub mod scenario;
pub mod simulate;
mod standard;
mod table;
mod text;
pub mod trace;
mod verdict;

use args::{Cli, Command};
use exit::{Exit, Failure};

/// Runs the command.
///
/// # Errors
/// [`Failure`], whose message is for the user and whose [exit code](Failure::exit) is for the shell.
pub fn run(cli: &Cli) -> Result<Exit, Failure> {
    match &cli.command {
        Command::Compare(args) => compare::run(args, cli.json),
        Command::Decode(args) => decode::run(args, cli.json),
        Command::Eds(args) => eds::run(args, cli.json),
        Command::Get(args) => live::get(args, cli.json),
        Command::Master(args) => live::master(args, cli.json),
        Command::Monitor(args) => live::monitor(args, cli.json),
        Command::Powerlink(args) => powerlink::run(args, cli.json),
        Command::Record(args) => live::record(args, cli.json),
        Command::Recover(args) => live::recover(args, cli.json),
        Command::Scan(args) => live::scan(args, cli.json),
        Command::Set(args) => live::set(args, cli.json),
        Command::Slave(args) => live::slave(args, cli.json),
        Command::Simulate(args) => simulate::run(args, cli.json),
    }
}
