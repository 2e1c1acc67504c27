//! `decode --summary`: what each node and each connection did, what is wrong with the bus, and which problems there were, in
//! constant memory.

mod connection;
mod findings;
mod json;
pub(super) mod problems;
mod text;

use core::time::Duration;

use devicenet_core::doctor::Doctor;
use devicenet_core::monitor::{ConnectionState, Kind, Monitor, NodeRecord};
use devicenex_core::monitor as nex;
use link_core::{BitRate, Instant};

use super::meaning::Meaning;
use crate::bus_rate::{BusRate, Doubt, LeastRate};
use crate::bus_time;
use crate::histogram::Histogram;
use crate::recording::{Content, RecordedFrame};
use crate::text::product_name;
use crate::verdict::{Seen, Verdict};
use connection::ConnectionKey;
use findings::Findings;
use problems::Problems;

/// The counts of a recording.
#[derive(Debug)]
pub(super) struct Summary {
    /// As the user says it.
    bit_rate: Option<BitRate>,
    buses: Vec<Bus>,
}

#[derive(Debug)]
struct Bus {
    span: Option<(Instant, Instant)>,
    /// Where nobody says the bit rate, and whether the one that somebody says can be.
    least: LeastRate,
    /// Of the first frame, which end before the span begins.
    first_bits: u32,
    /// Decimals of a second that the recording gives.
    digits: u8,
    total: Count,
    /// Errors on the bus, of the frames in `total`.
    errors: Count,
    /// By MAC ID or operational address, and one more for frames whose sender is not known.
    nodes: Vec<Node>,
    /// Sorted by key.
    connections: Vec<(ConnectionKey, Connection)>,
    problems: Problems,
    findings: Findings,
    /// In the end.
    verdict: Option<Verdict>,
}

#[derive(Debug, Default)]
struct Node {
    count: Count,
    known: Option<Known>,
}

/// What a monitor knows of a node.
#[derive(Debug)]
struct Known {
    access: &'static str,
    vendor: Option<u16>,
    serial: Option<u32>,
    product: Option<u16>,
    product_name: Option<String>,
}

#[derive(Debug, Default)]
struct Count {
    frames: u64,
    bytes: u64,
    bits: u64,
    problems: u64,
    responses: Histogram,
}

/// What is counted of a frame.
struct Counted {
    /// Bits on the wire with stuff bits and intermission, 0 where they are not known.
    bits: u32,
    bytes: usize,
    has_problem: bool,
    /// On a response, the time since the request.
    latency: Option<Duration>,
}

#[derive(Debug, Default)]
struct Connection {
    count: Count,
    /// Sorted.
    states: Vec<ConnectionState>,
}

impl Summary {
    pub(super) fn new(bit_rate: Option<BitRate>) -> Self {
        // A recording without frames is still a bus.
        Self { bit_rate, buses: vec![Bus::new(bit_rate)] }
    }

    /// The bit rate, if somebody says it.
    pub(super) const fn known_rate(&self) -> Option<BitRate> {
        self.bit_rate
    }

    /// That of a bus: nobody says it for one of several.
    fn rate(&self, bus: &Bus) -> BusRate {
        match self.bit_rate {
            Some(said) if bus.least.doubt().is_none() => BusRate::Said(said),
            Some(_) | None => BusRate::AtLeast(bus.least.rate()),
        }
    }

    /// The buses whose frames are against the bit rate that somebody has said: which, that rate, and what there is against it.
    pub(super) fn doubts(&self) -> impl Iterator<Item = (usize, BitRate, Doubt)> {
        let doubts = self.buses.iter().enumerate();
        doubts.filter_map(|(index, bus)| bus.least.doubt().map(|(said, doubt)| (index, said, doubt)))
    }

    /// Takes note of when a frame was on a bus, whether it is counted or not: a load is a part of the whole recording.
    /// Returns whether the bit rate that somebody has said is in doubt since then.
    pub(super) fn see_time(&mut self, bus: usize, frame: &RecordedFrame) -> bool {
        let bus = self.bus(bus);
        let was_in_doubt = bus.least.doubt().is_some();
        if let Content::Classic(classic) = &frame.content {
            bus.least.see(frame.at, classic);
        }
        if let Some((first, last)) = bus.span {
            bus.span = Some((first.min(frame.at), last.max(frame.at)));
        } else {
            bus.first_bits = bits_of(&frame.content);
            bus.digits = frame.digits;
            bus.span = Some((frame.at, frame.at));
        }
        !was_in_doubt && bus.least.doubt().is_some()
    }

    /// Counts a frame of a bus.
    pub(super) fn observe(&mut self, bus: usize, frame: &RecordedFrame, meaning: &Meaning<'_>) {
        let bus = self.bus(bus);
        let seen = Counted::new(frame, meaning);
        bus.total.add(&seen);
        if matches!(&frame.content, Content::Error(error) if error.is_bus_error()) {
            bus.errors.add(&seen);
        }
        bus.problems.observe(frame, meaning);
        bus.nodes[meaning.source().map_or(NODES, usize::from)].count.add(&seen);
        // A monitor keeps a limited number of dynamic connections: what it has forgotten in the end was seen here.
        let (key, state) = match meaning {
            Meaning::Read(reading) => {
                (ConnectionKey::of(reading), reading.dynamic.map(|dynamic| dynamic.state))
            }
            Meaning::Nex(reading) => (ConnectionKey::of_nex(reading), reading.connection.map(|on| on.state)),
            Meaning::Outside(_) => (None, None),
        };
        if let Some(key) = key {
            let connection = bus.connection(key);
            connection.count.add(&seen);
            connection.saw(state);
        }
    }

    /// Takes over what the monitor of a bus has learned.
    pub(super) fn learn(&mut self, bus: usize, monitor: &Monitor) {
        let bus = self.bus(bus);
        for record in monitor.nodes() {
            let mac = usize::from(record.mac.number());
            bus.nodes[mac].known = Some(Known::of(&record));
        }
        for record in monitor.connections() {
            let Some(key) = ConnectionKey::of_record(&record) else { continue };
            // Only connections that had a frame among those shown.
            if let Ok(index) = bus.find(&key) {
                bus.connections[index].1.saw(record.states());
            }
        }
    }

    /// Takes over what the monitor of a bus of DeviceNeX has learned.
    pub(super) fn learn_nex(&mut self, bus: usize, monitor: &nex::Monitor) {
        let bus = self.bus(bus);
        // Devices without an address are one row, and if there is one only, it is known.
        let newcomers = monitor.nodes().filter(|record| record.address.is_none()).count();
        for record in monitor.nodes().filter(|record| !record.address.is_none() || newcomers == 1) {
            bus.nodes[usize::from(record.address.number())].known = Some(Known::of_nex(&record));
        }
        for record in monitor.connections() {
            if let Ok(index) = bus.find(&ConnectionKey::of_nex_record(&record)) {
                bus.connections[index].1.saw(record.states());
            }
        }
    }

    /// Takes over what the doctor of a bus has found, of one node or of all, at the time that is shown.
    pub(super) fn diagnose(&mut self, bus: usize, doctor: &Doctor, mac: Option<u8>) {
        let bus = self.bus(bus);
        if let Some(span) = bus.span {
            bus.findings = Findings::of(doctor, bus.digits, mac, span);
        }
    }

    /// Judges the buses by what is shown of them. So many lines or records could not be read.
    pub(super) fn conclude(&mut self, unread: u64) {
        for bus in &mut self.buses {
            let (frames, faulty_frames) = (bus.total.frames, bus.problems.faulty());
            bus.verdict = Some(bus.findings.verdict(Seen { frames, faulty_frames, unread }));
        }
    }

    /// Whether something is or was wrong; `None` before it was judged.
    pub(super) fn is_bad(&self) -> Option<bool> {
        let mut verdicts = self.buses.iter().map(|bus| bus.verdict);
        verdicts.try_fold(false, |is_bad, verdict| verdict.map(|verdict| is_bad || verdict.is_bad()))
    }

    fn bus(&mut self, index: usize) -> &mut Bus {
        if self.buses.len() <= index {
            self.buses.resize_with(index + 1, || Bus::new(self.bit_rate));
        }
        &mut self.buses[index]
    }
}

impl Bus {
    fn new(said: Option<BitRate>) -> Self {
        let nodes = core::iter::repeat_with(Node::default).take(NODES + 1).collect();
        Self {
            span: None,
            least: LeastRate::new(said),
            first_bits: 0,
            digits: 0,
            total: Count::default(),
            errors: Count::default(),
            nodes,
            connections: Vec::new(),
            problems: Problems::default(),
            findings: Findings::default(),
            verdict: None,
        }
    }

    /// The connection of a key, which is a new one if there is room.
    fn connection(&mut self, key: ConnectionKey) -> &mut Connection {
        let is_full = self.connections.len() >= MOST_CONNECTIONS;
        let found = self.find(&key).or_else(|index| match is_full && key.name.client().is_some() {
            true => self.find(&ConnectionKey::OTHERS).map_err(|index| (index, ConnectionKey::OTHERS)),
            false => Err((index, key)),
        });
        let index = found.unwrap_or_else(|(index, key)| {
            self.connections.insert(index, (key, Connection::default()));
            index
        });
        &mut self.connections[index].1
    }

    /// Where a connection is, or where it belongs.
    fn find(&self, key: &ConnectionKey) -> Result<usize, usize> {
        self.connections.binary_search_by_key(key, |(key, _)| *key)
    }

    /// The nodes that sent something; those not known last.
    fn senders(&self) -> impl Iterator<Item = (Option<u8>, &Node)> {
        let numbered =
            (0u8..).zip(&self.nodes).map(|(mac, node)| ((usize::from(mac) < NODES).then_some(mac), node));
        numbered.filter(|(_, node)| node.count.frames > 0)
    }

    /// The time between the first and the last frame.
    fn seconds(&self) -> f64 {
        self.span.map_or(0.0, |(first, last)| last.saturating_since(first).as_secs_f64())
    }

    /// The part of the time from the begin of the first frame to the end of the last that frames took, 0 to 1. The time
    /// of a frame is its end, so the first one's own length comes before the first time.
    fn load(&self, count: &Count, rate: BusRate) -> Option<f64> {
        let bits = self.seconds() * f64::from(rate.rate().0) + f64::from(self.first_bits);
        (bits > 0.0).then(|| count.bits as f64 / bits)
    }
}

/// The bits that an entry took on the bus, with the intermission: of an error the least that its frame can have, of a CAN FD frame none,
/// because they are not known.
fn bits_of(content: &Content) -> u32 {
    match content {
        Content::Classic(frame) => bus_time::bits(frame),
        Content::Error(error) if error.is_bus_error() => bus_time::ERROR_FRAME,
        Content::Error(_) | Content::Fd(_) => 0,
    }
}

impl Counted {
    fn new(frame: &RecordedFrame, meaning: &Meaning<'_>) -> Self {
        let bytes = match &frame.content {
            Content::Classic(frame) => frame.data().len(),
            Content::Error(_) => 0,
            Content::Fd(frame) => frame.data().len(),
        };
        let bits = bits_of(&frame.content);
        let latency = match meaning {
            // An acknowledge answers a fragment, but is no response.
            Meaning::Read(reading) if reading.kind == Kind::FragmentAck => None,
            Meaning::Read(reading) => reading.request.map(|request| request.latency),
            // Nor does a Hello answer by itself.
            Meaning::Nex(reading) => reading.response_time(),
            Meaning::Outside(_) => None,
        };
        Self { bits, bytes, has_problem: meaning.has_problem(), latency }
    }
}

impl Known {
    fn of(record: &NodeRecord) -> Self {
        Self {
            access: record.access.name(),
            vendor: record.vendor.map(|vendor| vendor.0),
            serial: record.serial,
            product: record.product,
            product_name: product_name(&record.product_name),
        }
    }

    fn of_nex(record: &nex::NodeRecord) -> Self {
        Self {
            access: record.access.name(),
            vendor: record.device.map(|device| device.vendor.0),
            serial: record.device.map(|device| device.serial),
            product: record.device.map(|device| device.product_code),
            product_name: product_name(&record.product_name),
        }
    }
}

impl Connection {
    fn saw(&mut self, states: impl IntoIterator<Item = ConnectionState>) {
        for state in states {
            if let Err(index) = self.states.binary_search(&state) {
                self.states.insert(index, state);
            }
        }
    }
}

impl Count {
    fn add(&mut self, seen: &Counted) {
        self.frames += 1;
        self.bytes += seen.bytes as u64;
        self.bits += u64::from(seen.bits);
        self.problems += u64::from(seen.has_problem);
        if let Some(latency) = seen.latency {
            self.responses.record(latency);
        }
    }
}

/// Rows in the table of connections before those opened by UCMM are no longer kept apart; the predefined set of a full
/// network needs fewer. A tool that connects anew for every request can open any number.
const MOST_CONNECTIONS: usize = 1024;
/// MAC IDs 0 to 63, or operational addresses 0 to 127.
const NODES: usize = 128;
