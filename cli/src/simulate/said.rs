//! What a frame says, in the protocol of the bus.

use core::fmt;

use devicenet_core::monitor::{Monitor, MonitorConfig, Reading};
use devicenex_core::monitor as nex;
use link_core::{Frame, Instant};
use serde::Serialize;

use crate::scenario::Protocol;

/// Reads the frames of one segment.
#[derive(Clone, Debug)]
pub(super) enum Reader {
    DeviceNet(Box<Monitor>),
    DeviceNex(Box<nex::Monitor>),
}

/// What one frame says.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub(super) enum Said<'a> {
    DeviceNet(Reading<'a>),
    DeviceNex(nex::Reading<'a>),
}

impl Reader {
    pub(super) fn new(protocol: Protocol) -> Self {
        match protocol {
            Protocol::DeviceNet => Self::DeviceNet(Box::new(Monitor::new(MonitorConfig::default()))),
            Protocol::DeviceNex => {
                Self::DeviceNex(Box::new(nex::Monitor::new(nex::MonitorConfig::default())))
            }
        }
    }

    /// Reads a frame that got through, which is the nth.
    pub(super) fn read<'a>(&'a mut self, at: Instant, n: u64, frame: &'a Frame) -> Said<'a> {
        match self {
            Self::DeviceNet(monitor) => Said::DeviceNet(monitor.observe(at, n, frame)),
            Self::DeviceNex(monitor) => Said::DeviceNex(monitor.observe(at, n, frame)),
        }
    }
}

impl Said<'_> {
    /// The number of the frame.
    pub(super) const fn n(&self) -> u64 {
        match self {
            Self::DeviceNet(reading) => reading.n,
            Self::DeviceNex(reading) => reading.n,
        }
    }
}

impl fmt::Display for Said<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DeviceNet(reading) => reading.fmt(f),
            Self::DeviceNex(reading) => reading.fmt(f),
        }
    }
}
