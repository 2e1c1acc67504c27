//! How the command ends.

use std::io;
use std::process::ExitCode;

/// The exit codes, the same for every subcommand.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Exit {
    /// Done, and all is well.
    Done = 0,
    /// Done, and something was found: a problem in a recording, an expectation that failed.
    Findings = 1,
    /// The command line or a file is wrong.
    Usage = 2,
    /// The bus or the interface failed.
    Transport = 3,
    /// It would have transmitted without permission.
    Refused = 4,
    /// Somebody interrupted it before it was done: as a shell tells of a program that SIGINT has ended.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Why a command ends early.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The command line or a file is wrong; the message says what to do.
    #[error("{0}")]
    Usage(String),
    /// It would have let others transmit without permission; the message says how to give it.
    #[error("{0}")]
    Refused(String),
    /// The bus, an interface or an address cannot be used.
    #[error("{0}")]
    Transport(String),
    /// Somebody interrupted it; the message says what is left.
    #[error("{0}")]
    Interrupted(String),
    /// The output cannot be written.
    #[error("cannot write: {0}")]
    Output(#[from] io::Error),
}

impl Failure {
    /// The exit code for it. Whoever closes the pipe that we write to has seen enough: that is no failure.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::Output(error) if error.kind() == io::ErrorKind::BrokenPipe => Exit::Done,
            Self::Usage(_) | Self::Output(_) => Exit::Usage,
            Self::Refused(_) => Exit::Refused,
            Self::Transport(_) => Exit::Transport,
            Self::Interrupted(_) => Exit::Interrupted,
        }
    }
}
