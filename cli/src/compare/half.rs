//! What is measured of each protocol.

use core::time::Duration;

use link_core::Instant;
use transport_mock::{Change, NodeId};

use super::Plan;
use super::bench::{Bench, Sent, Traffic};
use crate::simulate::NodeEvent;

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

/// How the nodes of a protocol are told to be on line.
#[derive(Clone, Copy)]
pub(super) struct Signs {
    /// A node is.
    pub(super) is_on_line: fn(&Bench, NodeId) -> bool,
    /// It says that it gets there.
    pub(super) gets_on_line: fn(&NodeEvent) -> bool,
}

/// The spare of a device that was cut off.
pub(super) struct Spare {
    /// When the device was cut off.
    pub(super) cut: Instant,
    /// When the first I/O frame of the spare was over.
    pub(super) first: Instant,
}

impl Signs {
    fn on_line(self, bench: &Bench, nodes: &[NodeId]) -> usize {
        nodes.iter().filter(|node| (self.is_on_line)(bench, **node)).count()
    }

    /// When the last of the nodes that got on line from a moment on did.
    fn last_on_line(self, bench: &Bench, from: Instant, nodes: &[NodeId]) -> Option<Instant> {
        nodes.iter().filter_map(|node| bench.first_told(from, *node, self.gets_on_line)).max()
    }
}

impl Fresh {
    /// All devices of the bench are switched on at [`START`].
    pub(super) fn of(mut bench: Bench, plan: &Plan, signs: Signs) -> Self {
        bench.run_to(START);
        let (devices, errors) = (bench.nodes("device"), bench.errors.len());
        bench.run_to(START + Duration::from_secs(5));
        let usable = signs.on_line(&bench, &devices);
        bench.run_to(START + plan.patience());
        let last = signs.last_on_line(&bench, START, &devices);
        Self {
            devices: devices.len(),
            error_frames: bench.errors.len() - errors,
            bus_off: bench.bus_off(&devices),
            usable,
            usable_at_last: signs.on_line(&bench, &devices),
            until_usable: last.unwrap_or(START).saturating_since(START),
        }
    }
}

impl Full {
    /// A bench on which all nodes have been switched on at zero.
    pub(super) fn of(bench: &Bench, all: &[NodeId], signs: Signs) -> Self {
        let last = signs.last_on_line(bench, Instant::ZERO, all);
        Self {
            on_line: signs.on_line(bench, all),
            until_on_line: last.unwrap_or_default().saturating_since(Instant::ZERO),
        }
    }
}

impl Transfer {
    /// The frames of the first of the transfers, and what each of them took.
    pub(super) fn of(traffic: Option<Traffic>, delays: &[Duration]) -> Self {
        Self {
            traffic: traffic.unwrap_or_default(),
            fastest: delays.iter().min().copied().unwrap_or_default(),
            slowest: delays.iter().max().copied().unwrap_or_default(),
        }
    }
}

impl Spare {
    /// Cuts `lost` off, waits for the data of the spare, and plugs `lost` in again a second later.
    pub(super) fn replaces(
        bench: &mut Bench,
        plan: &Plan,
        lost: NodeId,
        spare: NodeId,
        is_data: impl Fn(&Sent) -> bool,
    ) -> Self {
        let cut = bench.network.now();
        bench.network.apply(Change::Cut(lost));
        let is_first = |sent: &&Sent| sent.by == spare && sent.start >= cut && is_data(sent);
        let first = |bench: &Bench| bench.sent.iter().find(is_first).map(|sent| sent.end);
        bench.run_until(cut + plan.patience(), |bench| first(bench).is_some());
        let first = first(bench).unwrap_or(cut + plan.patience());
        bench.run_to(first + Duration::from_secs(1));
        bench.network.apply(Change::Plug(lost));
        Self { cut, first }
    }
}

impl Standby {
    /// A line that runs loses a device; `received` is what has passed the filter of the device without a task.
    pub(super) fn of(mut bench: Bench, received: impl Fn(&Bench) -> u64) -> Self {
        bench.run_to(bench.network.now() + Duration::from_secs(3));
        let missing = bench.nodes("device")[0];
        bench.network.apply(Change::Cut(missing));
        let (before, frames) = (received(&bench), bench.sent.len());
        bench.run_to(bench.network.now() + Duration::from_secs(10));
        let passed = usize::try_from(received(&bench) - before).unwrap_or(usize::MAX);
        Self { frames: bench.sent.len() - frames, passed }
    }
}

/// The master or manager is on line by then.
pub(super) const START: Instant = Instant::from_millis(3_000);
/// Changes of an input that are transferred.
pub(super) const ROUNDS: u8 = 20;
