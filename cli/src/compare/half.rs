//! What is measured of each protocol.

use core::time::Duration;

use super::bench::Traffic;

/// The figures of one protocol.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Half {
    pub(super) fresh: Fresh,
    pub(super) full: Full,
    pub(super) establishment: Establishment,
    pub(super) transfer: Transfer,
    pub(super) replacement: Replacement,
    pub(super) standby: Standby,
}

/// Devices out of the box that are switched on in one bit time, beside a master or manager that is on line.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Fresh {
    /// How many there are.
    pub(super) devices: usize,
    pub(super) error_frames: usize,
    pub(super) bus_off: usize,
    /// On line with an address, five seconds after they were switched on.
    pub(super) usable: usize,
    /// The same once nothing more comes of it.
    pub(super) usable_at_last: usize,
    /// From power-up until the last of these is on line.
    pub(super) until_usable: Duration,
}

/// As many nodes as there are addresses.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Full {
    /// On line at the same time.
    pub(super) on_line: usize,
    /// From power-up until all of them are.
    pub(super) until_on_line: Duration,
}

/// From power-up to the first I/O data of every device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Establishment {
    pub(super) devices: usize,
    /// From on-line to the first I/O data: what a device needs that produces.
    pub(super) of_producer: Traffic,
    /// The same of one that consumes what another produces.
    pub(super) of_consumer: Traffic,
    /// What all of `devices` need that produce.
    pub(super) of_all: Traffic,
    /// What all needed to get on line.
    pub(super) access: Traffic,
    /// From power-up until every device has sent I/O data.
    pub(super) until_data: Duration,
}

/// One input of a device goes to two others.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Transfer {
    /// The frames without which it does not get there.
    pub(super) traffic: Traffic,
    /// From the change of the input until both have it: the shortest and the longest of many.
    pub(super) fastest: Duration,
    pub(super) slowest: Duration,
}

/// A device is cut off, and a spare is there.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Replacement {
    /// From the cut to the first I/O frame of the spare.
    pub(super) until_data: Duration,
    /// What becomes of the device when it is plugged in again.
    pub(super) returned: &'static str,
    /// Whether it can be the next spare as it is.
    pub(super) is_spare_again: bool,
}

/// A device without a task on a bus that is busy.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Standby {
    /// Frames on the bus.
    pub(super) frames: usize,
    /// Those that passed the filter that the device asked for.
    pub(super) passed: usize,
}
