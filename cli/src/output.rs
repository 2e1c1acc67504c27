//! Standard output and standard error, as every subcommand uses them.

use std::cell::RefCell;
use std::io::{self, IsTerminal, Read, StdinLock, StdoutLock, Write};
use std::rc::Rc;
use std::sync::{Mutex, PoisonError};

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

/// Keeps notes, warnings and errors back, until what it returns is dropped: for as long as a screen has the terminal.
#[must_use]
pub fn hold() -> Held {
    *HELD.lock().unwrap_or_else(PoisonError::into_inner) = Some(Vec::new());
    Held(())
}

/// Messages are kept back. See [`hold`].
#[derive(Debug)]
pub struct Held(());

impl Drop for Held {
    fn drop(&mut self) {
        let held = HELD.lock().unwrap_or_else(PoisonError::into_inner).take().unwrap_or_default();
        let (first, rest) = held.split_at(held.len().min(MOST_HELD));
        for (colour, word, message) in first {
            say(*colour, word, message);
        }
        if !rest.is_empty() {
            say(AnsiColor::Cyan, "note", "further messages are left out");
        }
    }
}

/// Colour and text of its first word, and the rest.
type Message = (AnsiColor, &'static str, String);

fn say(colour: AnsiColor, word: &'static str, message: impl core::fmt::Display) {
    if let Some(held) = &mut *HELD.lock().unwrap_or_else(PoisonError::into_inner) {
        if held.len() <= MOST_HELD {
            held.push((colour, word, message.to_string()));
        }
        return;
    }
    let style: Style = colour.on_default().bold();
    // When even this fails there is nobody left to tell.
    let _ = writeln!(anstream::stderr().lock(), "{style}{word}{style:#}: {message}");
}

/// What is kept back.
static HELD: Mutex<Option<Vec<Message>>> = Mutex::new(None);
/// One more is kept, to know that there are more.
const MOST_HELD: usize = 100;
const BUFFER: usize = 64 * 1024;
