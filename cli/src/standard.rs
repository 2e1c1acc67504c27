//! `-` in the place of a file: standard input or output.

use std::io::{self, Read};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use crate::exit::Failure;

/// Whether a path means standard input or output.
pub(crate) fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// A path in messages; `standard` where it is none.
pub(crate) fn shown(path: &Path, standard: &str) -> String {
    match is_standard(path) {
        true => standard.to_owned(),
        false => path.display().to_string(),
    }
}

/// Refuses files of which several are standard input: the first would leave nothing for the others.
pub(crate) fn at_most_one<'a>(inputs: impl IntoIterator<Item = &'a Path>) -> Result<(), Failure> {
    match inputs.into_iter().filter(|path| is_standard(path)).count() {
        0 | 1 => Ok(()),
        times => Err(Failure::Usage(format!(
            "`-` is given {times} times: standard input can be read once, name files for the others"
        ))),
    }
}

/// Standard input that has an end when somebody interrupts the program: a pipe may stay open and silent for ever.
pub(crate) struct Interruptible {
    interrupted: &'static AtomicBool,
    pieces: Receiver<io::Result<Vec<u8>>>,
    /// What is left of the one that came last.
    piece: io::Cursor<Vec<u8>>,
}

impl Interruptible {
    /// Takes standard input for the rest of the program.
    pub(crate) fn new(interrupted: &'static AtomicBool) -> Self {
        let (send, pieces) = sync_channel(PIECES);
        // It ends with standard input, with whoever wants the pieces, or with the program.
        thread::spawn(move || {
            let mut stdin = io::stdin().lock();
            let mut buffer = vec![0; PIECE];
            loop {
                let piece = stdin.read(&mut buffer).map(|length| buffer[..length].to_vec());
                let is_last = !matches!(&piece, Ok(bytes) if !bytes.is_empty());
                if send.send(piece).is_err() || is_last {
                    return;
                }
            }
        });
        Self { interrupted, pieces, piece: io::Cursor::default() }
    }
}

impl Read for Interruptible {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            let length = self.piece.read(buffer)?;
            if length > 0 || self.interrupted.load(Ordering::Relaxed) {
                return Ok(length);
            }
            match self.pieces.recv_timeout(LOOK_AFTER) {
                Ok(piece) if matches!(&piece, Ok(bytes) if bytes.is_empty()) => return Ok(0),
                Ok(piece) => self.piece = io::Cursor::new(piece?),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(0),
            }
        }
    }
}

/// In bytes, and how many of them are read ahead.
const PIECE: usize = 64 * 1024;
const PIECES: usize = 4;
/// How often an interruption is looked for.
const LOOK_AFTER: Duration = Duration::from_millis(100);
