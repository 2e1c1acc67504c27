//! The progress bar of a long decode.

use std::io::IsTerminal as _;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::is_standard;
use crate::args::DecodeArgs;
use crate::output::Output;

/// Counts frames on standard error, if that is a terminal, no frames go to one, and it takes over a second.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    start: Instant,
    shown: bool,
}

impl Progress {
    pub(super) fn new(args: &DecodeArgs, output: &Output) -> Self {
        let is_quiet = args.summary || !output.is_terminal();
        let is_wanted = std::io::stderr().is_terminal() && is_quiet && !is_standard(&args.file);
        let bar = is_wanted.then(|| {
            let style = ProgressStyle::with_template("{spinner} {human_pos} frames, {per_sec}, {elapsed}");
            let bar = ProgressBar::hidden();
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
            bar
        });
        Self { bar, start: Instant::now(), shown: false }
    }

    #[inline]
    pub(super) fn advance(&mut self, frames: u64) {
        if frames.is_multiple_of(STEP) {
            self.update(frames);
        }
    }

    #[cold]
    fn update(&mut self, frames: u64) {
        let Some(bar) = &self.bar else { return };
        if !self.shown && self.start.elapsed() > PATIENCE {
            bar.set_draw_target(indicatif::ProgressDrawTarget::stderr());
            self.shown = true;
        }
        bar.set_position(frames);
    }

    /// Prints something without the bar in the way.
    pub(super) fn suspend(&self, print: impl FnOnce()) {
        match &self.bar {
            Some(bar) => bar.suspend(print),
            None => print(),
        }
    }

    pub(super) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Frames between two looks at the clock.
const STEP: u64 = 1 << 14;
/// Shorter work needs no bar.
const PATIENCE: Duration = Duration::from_secs(1);
