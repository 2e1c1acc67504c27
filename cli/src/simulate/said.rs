//! What a frame says, in the protocol of the bus.

use core::fmt;

use devicenet_core::monitor::{Monitor, MonitorConfig, Reading};
use devicenex_core::Identifier;
use devicenex_core::message::{Hello, Roam};
use link_core::{Frame, Instant};
use serde::Serialize;

use crate::scenario::Protocol;

/// Reads the frames of one segment.
#[derive(Clone, Debug)]
pub(super) enum Reader {
    DeviceNet(Box<Monitor>),
    DeviceNex,
}

/// What one frame says.
#[derive(Debug, Serialize)]
#[serde(untagged)]
#[expect(clippy::large_enum_variant, reason = "there is one at a time, on the stack")]
pub(super) enum Said<'a> {
    DeviceNet(Reading<'a>),
    DeviceNex {
        #[serde(skip)]
        n: u64,
        text: String,
    },
}

impl Reader {
    pub(super) fn new(protocol: Protocol) -> Self {
        match protocol {
            Protocol::DeviceNet => Self::DeviceNet(Box::new(Monitor::new(MonitorConfig::default()))),
            Protocol::DeviceNex => Self::DeviceNex,
        }
    }

    /// Reads a frame that got through, which is the nth.
    pub(super) fn read<'a>(&'a mut self, at: Instant, n: u64, frame: &'a Frame) -> Said<'a> {
        match self {
            Self::DeviceNet(monitor) => Said::DeviceNet(monitor.observe(at, n, frame)),
            Self::DeviceNex => Said::DeviceNex { n, text: words(frame) },
        }
    }
}

impl Said<'_> {
    /// The number of the frame.
    pub(super) const fn n(&self) -> u64 {
        match self {
            Self::DeviceNet(reading) => reading.n,
            Self::DeviceNex { n, .. } => *n,
        }
    }
}

impl fmt::Display for Said<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DeviceNet(reading) => reading.fmt(f),
            Self::DeviceNex { text, .. } => f.write_str(text),
        }
    }
}

fn words(frame: &Frame) -> String {
    match (Hello::of_frame(frame), Roam::of_frame(frame)) {
        (Some(Ok(hello)), _) => hello.to_string(),
        (_, Some(Ok(roam))) => roam.to_string(),
        _ => Identifier::of_frame(frame).layout().to_string(),
    }
}
