//! Standard output and standard error, as every subcommand uses them.

use std::cell::RefCell;
use std::io::{self, IsTerminal, Read, StdinLock, StdoutLock, Write};
use std::rc::Rc;

use anstream::ColorChoice;
use anstyle::{AnsiColor, Style};

/// Standard output behind a buffer that lines are built in.
pub struct Output {
    stdout: StdoutLock<'static>,
    /// What is still to be written; append to it, then call [`line_done`](Self::line_done).
    pub buffer: Vec<u8>,
    /// What went wrong while nobody could be told.
    failure: Option<io::Error>,
}

impl Output {
    /// Takes standard output for the rest of the program.
    #[must_use]
    pub fn new() -> Self {
        Self { stdout: io::stdout().lock(), buffer: Vec::with_capacity(BUFFER + 4096), failure: None }
    }

    /// Whether to use colours: on a terminal, unless `NO_COLOR` and its kind say otherwise.
    #[must_use]
    pub fn is_coloured(&self) -> bool {
        !matches!(anstream::AutoStream::choice(&self.stdout), ColorChoice::Never)
    }

    /// Whether a person is looking on.
    #[must_use]
    pub fn is_terminal(&self) -> bool {
        self.stdout.is_terminal()
    }

    /// Writes the buffer out when it is full.
    ///
    /// # Errors
    /// When standard output fails.
    #[inline]
    pub fn line_done(&mut self) -> io::Result<()> {
        if self.buffer.len() < BUFFER && self.failure.is_none() { Ok(()) } else { self.flush() }
    }

    /// Writes everything out.
    ///
    /// # Errors
    /// When standard output fails.
    #[cold]
    pub fn flush(&mut self) -> io::Result<()> {
        if let Some(failure) = self.failure.take() {
            return Err(failure);
        }
        let written = self.stdout.write_all(&self.buffer);
        self.buffer.clear();
        written.and_then(|()| self.stdout.flush())
    }
}

impl Default for Output {
    fn default() -> Self {
        Self::new()
    }
}

/// Standard input that shows what there is to show before it waits for more: `candump -L can0 | devicenet decode -`
/// lags behind by nothing.
pub struct Attentive {
    stdin: StdinLock<'static>,
    output: Rc<RefCell<Output>>,
}

impl Attentive {
    /// Takes standard input for the rest of the program. `output` must not be borrowed while this is read.
    #[must_use]
    pub fn new(output: Rc<RefCell<Output>>) -> Self {
        Self { stdin: io::stdin().lock(), output }
    }
}

impl Read for Attentive {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if let Ok(mut output) = self.output.try_borrow_mut()
            && let Err(failure) = output.flush()
        {
            // It is no failure of the input: the next one who writes will see it.
            output.failure = Some(failure);
        }
        self.stdin.read(buffer)
    }
}

/// Prints `note: ...` on standard error.
pub fn note(message: impl core::fmt::Display) {
    say(AnsiColor::Cyan, "note", message);
}

/// Prints `warning: ...` on standard error.
pub fn warn(message: impl core::fmt::Display) {
    say(AnsiColor::Yellow, "warning", message);
}

/// Prints `error: ...` on standard error.
pub fn error(message: impl core::fmt::Display) {
    say(AnsiColor::Red, "error", message);
}

fn say(colour: AnsiColor, word: &str, message: impl core::fmt::Display) {
    let style: Style = colour.on_default().bold();
    // When even this fails there is nobody left to tell.
    let _ = writeln!(anstream::stderr().lock(), "{style}{word}{style:#}: {message}");
}

const BUFFER: usize = 64 * 1024;
