//! Lines: what happens when it happens, and a summary from time to time.

mod json;
mod text;

use core::time::Duration;

use link_core::machine::Deadline;
use link_core::{Input, Instant, Port as _};

use super::model::{Event, Model, Picture};
use crate::exit::Failure;
use crate::live::args::MonitorArgs;
use crate::live::port::{LivePort, PortError};
use crate::output::Output;

/// Watches until the end, and tells.
pub(super) fn run(
    args: &MonitorArgs,
    port: &mut LivePort,
    model: &mut Model,
    output: Output,
    json: bool,
) -> Result<(), Failure> {
    let begin = port.now();
    let mut lines = Lines { output, json, is_prompt: args.endpoint.is_standard_input() };
    let mut report_at = begin.saturating_add(args.interval.0);
    let mut now = begin;
    let ended = loop {
        let look_at = report_at.min(now.saturating_add(LOOK_EVERY));
        match port.wait(Some(Deadline { at: look_at, why: "a look" })) {
            Ok((at, input)) => {
                if at >= report_at {
                    // Of a silence that was passed over there is one summary, however many intervals it has.
                    report_at = last_report(report_at, at, args.interval.0);
                    lines.see(model, port, report_at, Input::Tick)?;
                    lines.report(&model.report(), false)?;
                    report_at = report_at.saturating_add(args.interval.0);
                }
                lines.see(model, port, at, input)?;
                now = now.max(at);
                lines.show(input)?;
            }
            Err(error) => break error,
        }
    };
    // The silence before the end counts.
    let end = args.span.map_or(Instant::MAX, |span| begin.saturating_add(span.0));
    let now = port.now().min(end);
    lines.see(model, port, now, Input::Tick)?;
    lines.report(&model.report(), true)?;
    match ended {
        PortError::Over => Ok(()),
        PortError::Failed(failure) => Err(failure),
    }
}

/// The last of the reports that are due at `first` and at every interval after it.
fn last_report(first: Instant, now: Instant, interval: Duration) -> Instant {
    let late = now.saturating_since(first).as_nanos();
    let within = late.checked_rem(interval.as_nanos()).unwrap_or_default();
    first.saturating_add(Duration::from_nanos(u64::try_from(late - within).unwrap_or(u64::MAX)))
}

/// Prints the last summary as text.
pub(super) fn last_words(picture: &Picture) -> Result<(), Failure> {
    Lines { output: Output::new(), json: false, is_prompt: false }.report(picture, true)
}

struct Lines {
    output: Output,
    json: bool,
    /// Nobody tells whether there is more to come.
    is_prompt: bool,
}

impl Lines {
    fn see(
        &mut self,
        model: &mut Model,
        port: &mut LivePort,
        at: Instant,
        input: Input,
    ) -> Result<(), Failure> {
        let begin = model.begin().unwrap_or(at);
        model.see_port(port, at, input, |event: Event| {
            let at = event.at.saturating_since(begin);
            let line = if self.json {
                json::event(at, &event.what, begin).to_string()
            } else {
                text::event(at, &event.what)
            };
            self.line(&line);
        })
    }

    fn report(&mut self, picture: &Picture, is_last: bool) -> Result<(), Failure> {
        let text = if self.json {
            json::summary(picture, is_last).to_string()
        } else {
            text::summary(picture, is_last)
        };
        self.line(text.trim_end());
        Ok(self.output.flush()?)
    }

    /// A person or a program that waits sees what happened, when the bus is silent or time has passed.
    fn show(&mut self, input: Input) -> Result<(), Failure> {
        match input {
            _ if self.output.buffer.is_empty() => {}
            Input::Tick => self.output.flush()?,
            _ if self.is_prompt => self.output.flush()?,
            _ => self.output.line_done()?,
        }
        Ok(())
    }

    fn line(&mut self, line: &str) {
        self.output.buffer.extend_from_slice(line.as_bytes());
        self.output.buffer.push(b'\n');
    }
}

/// How often time alone is given the word.
const LOOK_EVERY: Duration = Duration::from_millis(100);
#[cfg(target_os = "linux")]
const _: () = assert!(LOOK_EVERY.as_millis() > transport_socketcan::SocketCanPort::ONE_CALL.as_millis());
