//! What has become of nodes and connections since the last look.

use devicenet_core::MacId;
use devicenet_core::monitor::{AccessState, ConnectionName, ConnectionRecord, ConnectionState, Monitor};

use link_core::Instant;

use super::event::Happening;

/// What was seen at the last look. Its size is that of the monitor's tables.
#[derive(Clone, Debug)]
pub(super) struct Changes {
    access: [AccessState; MacId::COUNT],
    connections: Vec<Known>,
    /// Of the look before, so that nothing is allocated.
    before: Vec<Known>,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Known {
    server: MacId,
    client: Option<MacId>,
    name: ConnectionName,
    state: ConnectionState,
}

impl Changes {
    pub(super) fn new() -> Self {
        let room = || Vec::with_capacity(MOST_CONNECTIONS);
        Self { access: [AccessState::Unknown; MacId::COUNT], connections: room(), before: room() }
    }

    /// Compares, and tells what is new.
    pub(super) fn look(&mut self, monitor: &Monitor, now: Instant, mut tell: impl FnMut(Happening)) {
        for record in monitor.nodes_at(now) {
            let known = &mut self.access[usize::from(record.mac.number())];
            if *known != record.access {
                tell(Happening::Access { mac: record.mac, from: *known, to: record.access });
                *known = record.access;
            }
        }
        core::mem::swap(&mut self.connections, &mut self.before);
        self.connections.clear();
        self.connections.extend(monitor.connections().map(|record| Known::of(&record)));
        // They come in the same order each time, but for those that come and go.
        let mut expected = 0;
        for now in &self.connections {
            let place = match self.before.get(expected) {
                Some(known) if known.is_same(now) => Some(expected),
                _ => self.before.iter().position(|known| known.is_same(now)),
            };
            expected = place.unwrap_or(expected) + 1;
            let before = place.map(|place| self.before[place]);
            let from = before.map_or(ConnectionState::Unknown, |known| known.state);
            let was_never = (from, now.state) == (ConnectionState::Unknown, ConnectionState::NonExistent);
            if from != now.state && !was_never {
                let Known { server, client, name, state } = *now;
                tell(Happening::Connection { server, client, name, from, to: state });
            }
        }
    }
}

impl Known {
    fn of(record: &ConnectionRecord) -> Self {
        Self { server: record.server, client: record.client, name: record.name, state: record.state }
    }

    fn is_same(&self, other: &Self) -> bool {
        let is_dynamic = matches!(self.name, ConnectionName::Dynamic { .. });
        self.server == other.server && self.name == other.name && (!is_dynamic || self.client == other.client)
    }
}

/// Five of the predefined set at every node, and the dynamic ones of [`Monitor`].
const MOST_CONNECTIONS: usize = 5 * MacId::COUNT + 32;
