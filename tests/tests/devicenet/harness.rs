//! Frames into a monitor, words out of it.

use devicenet_cli::recording::{Content, Recording};
use devicenet_core::monitor::{Monitor, MonitorConfig, Problem, Reading};
use devicenet_tests::notation::frame;
use link_core::{Frame, Instant};

/// A monitor, and how much it has seen.
pub(crate) struct Observer {
    pub(crate) monitor: Box<Monitor>,
    pub(crate) n: u64,
}

/// What a test keeps of a reading.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Line {
    pub(crate) n: u64,
    pub(crate) at: Instant,
    pub(crate) frame: Frame,
    pub(crate) text: String,
    pub(crate) problem: Option<Problem>,
    pub(crate) json: serde_json::Value,
}

impl Line {
    pub(crate) fn of(reading: &Reading<'_>) -> Self {
        Self {
            n: reading.n,
            at: reading.at,
            frame: reading.frame,
            text: reading.to_string(),
            problem: reading.problem,
            json: serde_json::to_value(reading).expect("a reading serialises"),
        }
    }
}

impl Observer {
    pub(crate) fn new() -> Self {
        Self { monitor: Box::new(Monitor::new(MonitorConfig::default())), n: 0 }
    }

    pub(crate) fn observe(&mut self, at: Instant, frame: &Frame) -> Line {
        self.n += 1;
        Line::of(&self.monitor.observe(at, self.n, frame))
    }

    /// A frame as `5FF: 00 E7 03`, `millis` after zero.
    #[track_caller]
    pub(crate) fn line(&mut self, millis: u64, text: &str) -> Line {
        self.observe(Instant::from_millis(millis), &frame(text))
    }
}

/// Every classic frame of a recording in `tests/captures`.
#[track_caller]
pub(crate) fn capture(name: &str) -> Vec<(Instant, Frame)> {
    let path = devicenet_tests::workspace_root().join("tests/captures").join(name);
    let recording = Recording::open(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let frames = recording.map(|frame| frame.unwrap_or_else(|error| panic!("{name}: {error}")));
    frames
        .filter_map(|recorded| match recorded.content {
            Content::Classic(frame) => Some((recorded.at, frame)),
            Content::Error(_) | Content::Fd(_) => None,
        })
        .collect()
}

/// A recording, decoded: a line a frame, times from its start.
pub(crate) fn decode(name: &str) -> Vec<Line> {
    let mut observer = Observer::new();
    capture(name).iter().map(|(at, frame)| observer.observe(*at, frame)).collect()
}

/// Lines as a trace: seconds since the first frame, identifier, data, words.
pub(crate) fn trace(lines: &[Line]) -> String {
    let start = lines.first().map_or(Instant::ZERO, |line| line.at);
    let mut out = String::new();
    for line in lines {
        let at = Instant::ZERO + line.at.saturating_since(start);
        let frame = line.frame.to_string();
        out.push_str(format!("{at:.6}  {frame:<32}| {}", line.text).trim_end());
        out.push('\n');
    }
    out
}
