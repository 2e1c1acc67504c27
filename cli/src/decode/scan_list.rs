//! The scan lists that the masters of a recording must have had, as the traffic tells them.

use core::fmt::Write as _;
use std::collections::{HashMap, HashSet};

use cip_core::message::AllocationChoice;
use devicenet_core::id::Purpose;
use devicenet_core::monitor::{
    ConnectionName, ConnectionRecord, Detail, Kind, Monitor, NodeRecord, Predefined, Reading,
};
use devicenet_core::{Identifier, MacId};

use crate::scenario::Time;

/// Gathers what the monitors do not keep.
#[derive(Default)]
pub(super) struct ScanLists {
    /// Slaves whose messages by change of state or cyclic were acknowledged, by bus.
    acknowledged: HashSet<(usize, MacId)>,
    /// The longest data that came each way on an I/O connection of a slave, by bus.
    longest: HashMap<(usize, MacId, Predefined, Way), u16>,
    /// What was last allocated of a slave, by bus, and by whom: it may have been released since.
    allocated: HashMap<(usize, MacId), (MacId, AllocationChoice)>,
}

/// Which way data go, seen from the slave.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Way {
    Consumed,
    Produced,
}

/// The slave that has just been allocated.
pub(super) fn allocated(reading: &Reading<'_>) -> Option<MacId> {
    reading.src.filter(|_| matches!(reading.fields.detail, Detail::Allocated { .. }))
}

impl ScanLists {
    /// Sees a frame.
    pub(super) fn observe(&mut self, bus: usize, reading: &Reading<'_>) {
        if let (Kind::CosCyclicAck, Some(slave)) = (reading.kind, reading.dst) {
            self.acknowledged.insert((bus, slave));
        }
        if let Some((slave, connection, way)) = io_of(reading) {
            let length = reading.message.map_or(reading.frame.data().len(), |message| message.data.len());
            let longest = self.longest.entry((bus, slave, connection, way)).or_default();
            *longest = (*longest).max(u16::try_from(length).unwrap_or(u16::MAX));
        }
    }

    /// A slave as it is after an allocation.
    pub(super) fn allocated(&mut self, bus: usize, slave: &NodeRecord) {
        if let (Some(master), Some(choice)) = (slave.master, slave.choice) {
            self.allocated.insert((bus, slave.mac), (master, choice));
        }
    }

    /// The scan lists of a bus, in TOML: a `[[node.scan]]` for each slave, below the MAC ID of its master.
    pub(super) fn toml(&self, bus: usize, name: &str, monitor: &Monitor) -> String {
        let mut text = String::new();
        for master in MacId::all() {
            let slaves: Vec<NodeRecord> =
                (monitor.nodes()).filter(|node| self.master_of(bus, node) == Some(master)).collect();
            if slaves.is_empty() {
                continue;
            }
            let blank = if text.is_empty() { "" } else { "\n" };
            let _ = writeln!(text, "{blank}# The scan list of MAC ID {master}, seen on {name}");
            for slave in slaves {
                text.push('\n');
                self.push_entry(&mut text, bus, &slave, monitor);
            }
        }
        text
    }

    fn push_entry(&self, text: &mut String, bus: usize, slave: &NodeRecord, monitor: &Monitor) {
        let _ = writeln!(text, "[[node.scan]]\nmac = {}", slave.mac);
        let own = |connection: &ConnectionRecord| {
            connection.server == slave.mac && (connection.epr.is_some() || connection.frames > 0)
        };
        let connections: Vec<ConnectionRecord> = monitor.connections().filter(own).collect();
        let find = |name: Predefined| {
            let is_it = |connection: &&ConnectionRecord| connection.name == ConnectionName::Predefined(name);
            connections.iter().find(is_it)
        };
        let allocated = self.allocated.get(&(bus, slave.mac)).map(|(_, choice)| *choice).or(slave.choice);
        let choice = allocated.unwrap_or_default();
        let size = |told: Option<u16>, connection, way| {
            told.or_else(|| self.longest.get(&(bus, slave.mac, connection, way)).copied())
        };
        let produced =
            |connection: &ConnectionRecord, which| size(connection.produced_size, which, Way::Produced);
        let consumed =
            |connection: &ConnectionRecord, which| size(connection.consumed_size, which, Way::Consumed);
        let by_change = choice.intersects(AllocationChoice::CHANGE_OF_STATE | AllocationChoice::CYCLIC)
            || find(Predefined::CosCyclic).is_some();
        let polled = choice.contains(AllocationChoice::POLL) || (allocated.is_none() && !by_change);
        if polled && let Some(poll) = find(Predefined::Poll) {
            let sizes = [produced(poll, Predefined::Poll), consumed(poll, Predefined::Poll)];
            push_connection(text, "poll", poll, sizes, &[]);
        }
        if let Some(strobe) = find(Predefined::BitStrobe) {
            push_connection(text, "bit_strobe", strobe, [produced(strobe, Predefined::BitStrobe), None], &[]);
        }
        if let Some(change) = find(Predefined::CosCyclic) {
            let name = if choice.contains(AllocationChoice::CYCLIC) { "cyclic" } else { "cos" };
            // What the master sends comes over the instance of poll.
            let outputs = find(Predefined::Poll).filter(|_| !polled);
            let outputs = outputs.and_then(|poll| consumed(poll, Predefined::Poll));
            let mut more = Vec::new();
            more.extend(
                change.inhibit.filter(|inhibit| *inhibit > 0).map(|ms| format!("inhibit = \"{ms}ms\"")),
            );
            let is_suppressed = choice.contains(AllocationChoice::ACK_SUPPRESSION)
                || (allocated.is_none() && !self.acknowledged.contains(&(bus, slave.mac)));
            if is_suppressed {
                more.push("acknowledged = false".to_owned());
            }
            push_connection(text, name, change, [produced(change, Predefined::CosCyclic), outputs], &more);
        }
        if let Some(multicast) = find(Predefined::MulticastPoll) {
            let sizes = [produced(multicast, Predefined::MulticastPoll), multicast.consumed_size];
            push_connection(text, "multicast_poll", multicast, sizes, &[]);
        }
        push_key(text, slave);
    }

    /// The master of a slave; one that has released it since was its master too, unless it only had explicit messages for
    /// it: so has who looks for a replacement.
    fn master_of(&self, bus: usize, slave: &NodeRecord) -> Option<MacId> {
        let last = self.allocated.get(&(bus, slave.mac)).filter(|(_, choice)| has_io(*choice));
        slave.master.or(last.map(|(master, _)| *master))
    }
}

/// The I/O connection that a frame with data is on, unless it is a fragment that does not complete its message.
fn io_of(reading: &Reading<'_>) -> Option<(MacId, Predefined, Way)> {
    let identifier = Identifier::of_frame(&reading.frame)?;
    let (connection, way) = match (reading.kind, identifier.purpose()) {
        (Kind::PollCommand | Kind::CosCyclic, Purpose::PollCommand) => (Predefined::Poll, Way::Consumed),
        (Kind::PollResponse, Purpose::PollResponse) => (Predefined::Poll, Way::Produced),
        (Kind::BitStrobeResponse, Purpose::BitStrobeResponse) => (Predefined::BitStrobe, Way::Produced),
        (Kind::CosCyclic, Purpose::ChangeOfState) => (Predefined::CosCyclic, Way::Produced),
        (Kind::MulticastPollResponse, Purpose::MulticastPollResponse) => {
            (Predefined::MulticastPoll, Way::Produced)
        }
        _ => return None,
    };
    let is_whole = reading.frag.is_none() || reading.message.is_some();
    identifier.mac_id().filter(|_| is_whole).map(|slave| (slave, connection, way))
}

fn has_io(choice: AllocationChoice) -> bool {
    !choice.difference(AllocationChoice::EXPLICIT | AllocationChoice::ACK_SUPPRESSION).is_empty()
}

/// `poll = { produce = 3, consume = 1, epr = "80ms" }`; what was not seen is told in a comment.
fn push_connection(
    text: &mut String,
    name: &str,
    connection: &ConnectionRecord,
    [produced, consumed]: [Option<u16>; 2],
    more: &[String],
) {
    let mut fields = Vec::new();
    fields.push(format!("produce = {}", produced.unwrap_or(0)));
    fields.extend(consumed.filter(|size| *size > 0).map(|size| format!("consume = {size}")));
    let rate = connection.epr.unwrap_or(0);
    fields.push(format!("epr = \"{}\"", Time(core::time::Duration::from_millis(rate.into()))));
    fields.extend_from_slice(more);
    let mut unseen = Vec::new();
    if produced.is_none() {
        unseen.push("the produced size");
    }
    if connection.epr.is_none() {
        unseen.push("the expected packet rate");
    }
    let comment =
        if unseen.is_empty() { String::new() } else { format!("    # not seen: {}", unseen.join(", ")) };
    let _ = writeln!(text, "{name} = {{ {} }}{comment}", fields.join(", "));
}

/// What the slave was seen to be; nothing if nothing was.
fn push_key(text: &mut String, slave: &NodeRecord) {
    let mut fields = Vec::new();
    fields.extend(slave.vendor.map(|vendor| format!("vendor = 0x{:04X}", vendor.0)));
    fields.extend(slave.device_type.map(|device_type| format!("device_type = {}", device_type.0)));
    fields.extend(slave.product.map(|product| format!("product = {product}")));
    fields.extend(slave.revision.map(|(major, minor)| format!("revision = [{major}, {minor}]")));
    if !fields.is_empty() {
        let _ = writeln!(text, "key = {{ {} }}", fields.join(", "));
    }
}
