//! The scan lists that the masters of a recording must have had, as the traffic tells them.

use core::fmt::Write as _;
use std::collections::HashSet;

use cip_core::message::AllocationChoice;
use devicenet_core::MacId;
use devicenet_core::monitor::{
    ConnectionName, ConnectionRecord, Kind, Monitor, NodeRecord, Predefined, Reading,
};

use crate::scenario::Time;

/// Gathers what the monitors do not keep.
#[derive(Default)]
pub(super) struct ScanLists {
    /// Slaves whose messages by change of state or cyclic were acknowledged, by bus.
    acknowledged: HashSet<(usize, MacId)>,
}

impl ScanLists {
    /// Sees a frame.
    pub(super) fn observe(&mut self, bus: usize, reading: &Reading<'_>) {
        if let (Kind::CosCyclicAck, Some(slave)) = (reading.kind, reading.dst) {
            self.acknowledged.insert((bus, slave));
        }
    }

    /// The scan lists of a bus, in TOML: a `[[node.scan]]` for each slave, below the MAC ID of its master.
    pub(super) fn toml(&self, bus: usize, name: &str, monitor: &Monitor) -> String {
        let mut text = String::new();
        for master in MacId::all() {
            let slaves: Vec<NodeRecord> =
                (monitor.nodes()).filter(|node| master_of(node, monitor) == Some(master)).collect();
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
        let choice = slave.choice.unwrap_or_default();
        let by_change = choice.intersects(AllocationChoice::CHANGE_OF_STATE | AllocationChoice::CYCLIC)
            || find(Predefined::CosCyclic).is_some();
        let polled = choice.contains(AllocationChoice::POLL) || (slave.choice.is_none() && !by_change);
        if polled && let Some(poll) = find(Predefined::Poll) {
            push_connection(text, "poll", poll, poll.consumed_size, &[]);
        }
        if let Some(strobe) = find(Predefined::BitStrobe) {
            push_connection(text, "bit_strobe", strobe, None, &[]);
        }
        if let Some(change) = find(Predefined::CosCyclic) {
            let name = if choice.contains(AllocationChoice::CYCLIC) { "cyclic" } else { "cos" };
            // What the master sends comes over the instance of poll.
            let consumed = find(Predefined::Poll).filter(|_| !polled).and_then(|poll| poll.consumed_size);
            let mut more = Vec::new();
            more.extend(
                change.inhibit.filter(|inhibit| *inhibit > 0).map(|ms| format!("inhibit = \"{ms}ms\"")),
            );
            let is_suppressed = choice.contains(AllocationChoice::ACK_SUPPRESSION)
                || (slave.choice.is_none() && !self.acknowledged.contains(&(bus, slave.mac)));
            if is_suppressed {
                more.push("acknowledged = false".to_owned());
            }
            push_connection(text, name, change, consumed, &more);
        }
        if let Some(multicast) = find(Predefined::MulticastPoll) {
            push_connection(text, "multicast_poll", multicast, multicast.consumed_size, &[]);
        }
        push_key(text, slave);
    }
}

/// The master of a slave; one that has released it since was its master too.
fn master_of(slave: &NodeRecord, monitor: &Monitor) -> Option<MacId> {
    let is_own = |connection: &ConnectionRecord| {
        connection.server == slave.mac && matches!(connection.name, ConnectionName::Predefined(_))
    };
    slave.master.or_else(|| monitor.connections().filter(is_own).find_map(|connection| connection.client))
}

/// `poll = { produce = 3, consume = 1, epr = "80ms" }`; what was not seen is told in a comment.
fn push_connection(
    text: &mut String,
    name: &str,
    connection: &ConnectionRecord,
    consumed: Option<u16>,
    more: &[String],
) {
    let mut fields = Vec::new();
    fields.push(format!("produce = {}", connection.produced_size.unwrap_or(0)));
    fields.extend(consumed.filter(|size| *size > 0).map(|size| format!("consume = {size}")));
    let rate = connection.epr.unwrap_or(0);
    fields.push(format!("epr = \"{}\"", Time(core::time::Duration::from_millis(rate.into()))));
    fields.extend_from_slice(more);
    let mut unseen = Vec::new();
    if connection.produced_size.is_none() {
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
