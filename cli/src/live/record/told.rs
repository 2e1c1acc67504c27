//! What a recorder tells of its work: notes on standard error, or objects on standard output.

use core::time::Duration;
use std::path::Path;

use link_core::Instant;
use serde_json::{Value, json};

use crate::exit::Failure;
use crate::live::args::RecordArgs;
use crate::live::endpoint::Endpoint;
use crate::live::trigger::Trigger;
use crate::live::watch::Cause;
use crate::output::{self, Output};
use crate::scenario::Time;
use crate::standard::shown;
use crate::text::count;

/// A recording that is complete.
#[derive(Clone, Copy, Debug)]
pub(super) struct Written<'a> {
    /// Which, from 1.
    pub(super) n: u32,
    pub(super) path: &'a Path,
    pub(super) frames: u64,
    /// The times of its first and last frame, as they stand in it; `None` if it has none.
    pub(super) span: Option<(Instant, Instant)>,
    /// What there was no room for, of the time before the trigger.
    pub(super) dropped: u64,
    /// What was lost before it was read, at least.
    pub(super) lost: u64,
}

/// Why listening has ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum End {
    /// Everything that was wanted is recorded.
    Complete,
    /// `--for` is over.
    TimeOver,
    /// Somebody has interrupted it.
    Interrupted,
    /// The scenario or the recording has ended.
    EndpointOver,
    /// The interface has failed, or a file cannot be written.
    Failed,
}

impl End {
    /// For programs.
    const fn name(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::TimeOver => "time_over",
            Self::Interrupted => "interrupted",
            Self::EndpointOver => "endpoint_over",
            Self::Failed => "failed",
        }
    }
}

/// Tells.
pub(super) struct Teller {
    /// Of objects.
    output: Option<Output>,
}

impl Teller {
    pub(super) fn new(json: bool) -> Self {
        Self { output: json.then(Output::new) }
    }

    pub(super) fn start(&mut self, args: &RecordArgs, triggers: &[Trigger]) -> Result<(), Failure> {
        let triggers: Vec<String> = triggers.iter().map(Trigger::to_string).collect();
        self.object(|| {
            json!({
                "event": "start",
                "t": 0.0,
                "endpoint": args.endpoint.to_string(),
                "triggers": triggers,
                "before": seconds(args.before.0),
                "after": seconds(args.after.0),
                "count": args.count,
            })
        })
    }

    /// The interface went down, or is up again.
    pub(super) fn link(&mut self, t: Duration, endpoint: &Endpoint, is_down: bool) -> Result<(), Failure> {
        if self.output.is_none() {
            let at = Instant::ZERO + t;
            match is_down {
                true => output::note(format_args!(
                    "{at:.3} s: {endpoint} is down, and waited for; as root: ip link set {endpoint} up"
                )),
                false => output::note(format_args!("{at:.3} s: {endpoint} is up")),
            }
        }
        let state = if is_down { "down" } else { "up" };
        self.object(|| json!({ "event": "link", "t": seconds(t), "state": state }))
    }

    pub(super) fn trigger(&mut self, t: Duration, n: u32, path: &Path, cause: &Cause) -> Result<(), Failure> {
        if self.output.is_none() {
            let at = Instant::ZERO + t;
            output::note(format_args!("{at:.3} s: {cause}; recording to {}", shown(path, STDOUT)));
        }
        let file = path.display().to_string();
        self.object(|| json!({ "event": "trigger", "t": seconds(t), "n": n, "file": file, "text": cause.to_string() }))
    }

    pub(super) fn written(&mut self, t: Duration, written: Written<'_>, before: Time) -> Result<(), Failure> {
        let Written { n, path, frames, span, dropped, lost } = written;
        if self.output.is_none() {
            output::note(format_args!("{}: {}", shown(path, STDOUT), count(frames, "frame")));
        }
        if dropped > 0 {
            output::warn(format_args!(
                "{}: there is room for {MOST_FRAMES} frames before a trigger: {} of the {before} before it were dropped",
                shown(path, STDOUT),
                count(dropped, "frame"),
            ));
        }
        if lost > 0 {
            output::warn(format_args!(
                "{}: {} or more came faster than they were read, and are missing; each error frame of class 0x004 stands for some",
                shown(path, STDOUT),
                count(lost, "frame"),
            ));
        }
        self.object(|| {
            let mut object = json!({
                "event": "written",
                "t": seconds(t),
                "n": n,
                "file": path.display().to_string(),
                "frames": frames,
                "dropped": dropped,
                "lost": lost,
            });
            if let Some((first, last)) = span {
                object["first"] = stamp(first);
                object["last"] = stamp(last);
            }
            object
        })
    }

    pub(super) fn end(
        &mut self,
        t: Duration,
        args: &RecordArgs,
        captured: u32,
        end: End,
    ) -> Result<(), Failure> {
        if self.output.is_none() {
            match captured {
                0 if matches!(end, End::Failed) => {}
                0 => {
                    output::note(format_args!("{}: nothing happened that starts a recording", args.endpoint))
                }
                captured => output::note(format_args!("{}", count(captured.into(), "recording"))),
            }
        }
        self.object(
            || json!({ "event": "end", "t": seconds(t), "recordings": captured, "cause": end.name() }),
        )
    }

    fn object(&mut self, object: impl FnOnce() -> Value) -> Result<(), Failure> {
        if let Some(output) = &mut self.output {
            output.buffer.extend_from_slice(format!("{}\n", object()).as_bytes());
            output.flush()?;
        }
        Ok(())
    }
}

fn seconds(span: Duration) -> Value {
    (span.as_nanos() as f64 / 1e9).into()
}

fn stamp(at: Instant) -> Value {
    seconds(at.saturating_since(Instant::ZERO))
}

/// Two minutes of a full bus at 1 Mbit/s, in 50 megabytes.
pub(super) const MOST_FRAMES: usize = 1_000_000;
/// Standard output, in messages.
const STDOUT: &str = "<stdout>";
