//! A capture of Ethernet, frame by frame, as Ethernet POWERLINK.

mod decoder;
mod summary;

pub use decoder::Decoder;

use std::cell::RefCell;
use std::rc::Rc;

use super::check::check_ethernet;
use super::decoder::Verdict;
use super::progress::Progress;
use super::{Tally, unreadable};
use crate::args::DecodeArgs;
use crate::exit::{Exit, Failure};
use crate::output::{self, Output};
use crate::recording::{Capture, Network};

/// Decodes a capture to its end, or to where it is damaged: what precedes is shown.
pub(super) fn run(
    args: &DecodeArgs,
    json: bool,
    mut capture: Capture,
    output: Rc<RefCell<Output>>,
    file: String,
) -> Result<Exit, Failure> {
    check_ethernet(args)?;
    let decoder = Decoder::new(args, json, output.borrow().is_coloured());
    let progress = Progress::new(args, &output.borrow());
    let mut session = Session { decoder, progress, output, file, tally: Tally::default() };
    let read = session.read(&mut capture, args.strict);
    let Session { mut decoder, progress, output, file, tally } = session;
    let mut output = output.borrow_mut();
    decoder.finish(&mut output.buffer, capture.channels(), &file, tally.bad_lines);
    let closed = output.flush().map_err(Failure::from);
    drop(output);
    progress.finish();
    let notes = (capture.notes(), Network::Ethernet);
    tally.conclude(&file, capture.format(), notes, (read, closed), decoder.is_bad())
}

/// A capture on its way to where it is wanted.
struct Session {
    decoder: Decoder,
    progress: Progress,
    output: Rc<RefCell<Output>>,
    file: String,
    tally: Tally,
}

impl Session {
    fn read(&mut self, capture: &mut Capture, strict: bool) -> Result<(), Failure> {
        while let Some(entry) = capture.next() {
            let frame = match entry {
                Ok(frame) => frame,
                Err(error) if error.is_fatal() || strict => return Err(unreadable(&self.file, error)),
                Err(error) => {
                    // The message comes after the frames before it.
                    self.output.borrow_mut().flush()?;
                    self.tally.bad_lines += 1;
                    self.progress.suspend(|| output::warn(format_args!("{}:{error}", self.file)));
                    continue;
                }
            };
            self.progress.advance(frame.n);
            self.tally.frames = frame.n;
            let mut output = self.output.borrow_mut();
            match self.decoder.frame(&mut output.buffer, &frame, capture.channels()) {
                Verdict::Hidden => continue,
                Verdict::Fine => {}
                Verdict::Problem => self.tally.problems += 1,
            }
            self.tally.shown += 1;
            output.line_done()?;
        }
        Ok(())
    }
}
