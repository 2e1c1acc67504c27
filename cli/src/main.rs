//! The `devicenet` command.

use std::process::ExitCode;

use clap::Parser as _;
use devicenet_cli::args::Cli;
use devicenet_cli::exit::Exit;
use devicenet_cli::output;

fn main() -> ExitCode {
    let exit = devicenet_cli::run(&Cli::parse()).unwrap_or_else(|failure| {
        if failure.exit() != Exit::Done {
            output::error(&failure);
        }
        failure.exit()
    });
    exit.into()
}
