//! `[[node]]` with `role = "slave"`.

use core::ops::Range;
use core::time::Duration;

use cip_core::message::AllocationChoice;
use toml::Spanned;

use super::device::is_set;
use super::{Checker, list};
use crate::scenario::diagnostic::ScenarioError;
use crate::scenario::model::{ConnectionName, Sizes, SlaveNode};
use crate::scenario::raw::{RawIo, RawNode, Table as _};
use crate::scenario::values::{RateSetting, Time};
use crate::text::hex_bytes;

impl Checker<'_> {
    pub(super) fn slave(&self, raw: &RawNode, table: &Range<usize>) -> Result<SlaveNode, ScenarioError> {
        let mut slave = SlaveNode {
            access: self.access(raw, table)?,
            offers: AllocationChoice::empty(),
            poll: Sizes::default(),
            bit_strobe: Sizes::default(),
            change_of_state: Sizes::default(),
            multicast_poll: Sizes::default(),
            input: Vec::new(),
            ucmm: is_set(raw.ucmm.as_ref()),
            unconnected_port: raw.unconnected_port.as_ref().is_none_or(|port| *port.get_ref()),
            heartbeat: raw.heartbeat.as_ref().map(|time| self.heartbeat(time)).transpose()?,
            shutdown_message: is_set(raw.shutdown_message.as_ref()),
            detects_bit_rate: raw.bit_rate.as_ref().is_some_and(|rate| *rate.get_ref() == RateSetting::Auto),
        };
        if let (Some(port), false) = (&raw.unconnected_port, slave.ucmm || slave.unconnected_port) {
            return self.fail(
                &port.span(),
                "without `unconnected_port` and without `ucmm` nobody can reach the slave; expected one of them",
            );
        }
        let mut longest = 0;
        for (name, io) in connections(raw) {
            let sizes = self.offered(name, io)?;
            longest = longest.max(sizes.produce);
            match name {
                ConnectionName::Explicit => {}
                ConnectionName::Poll => slave.poll = sizes,
                ConnectionName::BitStrobe => slave.bit_strobe = Sizes { consume: 1, ..sizes },
                ConnectionName::MulticastPoll => slave.multicast_poll = sizes,
                ConnectionName::ChangeOfState | ConnectionName::Cyclic => {
                    self.shared(&slave, name, io, sizes)?;
                    slave.change_of_state = sizes;
                }
            }
            slave.offers |= name.choice();
        }
        if slave.offers.intersects(CHANGE_OF_STATE) {
            slave.offers |= AllocationChoice::ACK_SUPPRESSION;
        }
        slave.input = match &raw.input {
            None => vec![0; longest.into()],
            Some(input) => self.data("input", input, longest.into(), "as the longest connection produces")?,
        };
        Ok(slave)
    }

    /// Instances 2 and 4 are each one connection, by whatever name it is allocated.
    fn shared(
        &self,
        slave: &SlaveNode,
        name: ConnectionName,
        io: &Spanned<RawIo>,
        sizes: Sizes,
    ) -> Result<(), ScenarioError> {
        if slave.offers.intersects(CHANGE_OF_STATE) && slave.change_of_state != sizes {
            return self.fail(
                &io.span(),
                "`cyclic` and `cos` are one connection, allocated in two ways; expected the same sizes of both",
            );
        }
        if slave.offers.contains(AllocationChoice::POLL) && sizes.consume != 0 {
            let place = io.get_ref().consume.as_ref().map_or_else(|| io.span(), Spanned::span);
            return self.fail(
                &place,
                format!(
                    "what `{name}` consumes comes with the poll command; expected `consume` of `poll` only"
                ),
            );
        }
        Ok(())
    }

    fn offered(&self, name: ConnectionName, io: &Spanned<RawIo>) -> Result<Sizes, ScenarioError> {
        let keys: &[&str] =
            if name == ConnectionName::BitStrobe { &["produce"] } else { &["produce", "consume"] };
        self.only(io.get_ref(), keys, &format!("`{name}` of a slave"))?;
        self.sizes(name, io)
    }

    /// The sizes of a connection, seen from the slave.
    pub(super) fn sizes(&self, name: ConnectionName, io: &Spanned<RawIo>) -> Result<Sizes, ScenarioError> {
        let (most, what) = match name {
            ConnectionName::BitStrobe => (8, "a number of bytes, 0 to 8"),
            _ => (448, "a number of bytes, 0 to 448"),
        };
        let size = |key, value: &Option<Spanned<i64>>| match value {
            Some(value) => self.number::<u16>(key, value, 0, most, what),
            None => Ok(0),
        };
        let raw = io.get_ref();
        if raw.keys().is_empty() {
            return self.fail(
                &io.span(),
                format!("`{name}` has no size; expected {} in bytes", list(&["produce", "consume"])),
            );
        }
        Ok(Sizes { produce: size("produce", &raw.produce)?, consume: size("consume", &raw.consume)? })
    }

    /// Bytes in hex, so many.
    pub(super) fn data(
        &self,
        key: &str,
        value: &Spanned<String>,
        length: usize,
        why: &str,
    ) -> Result<Vec<u8>, ScenarioError> {
        let data = self.bytes(key, value)?;
        if data.len() == length {
            return Ok(data);
        }
        let found = crate::text::count(data.len() as u64, "byte");
        self.fail(&value.span(), format!("`{key}` has {found}; expected {length}, {why}"))
    }

    /// Bytes in hex.
    pub(super) fn bytes(&self, key: &str, value: &Spanned<String>) -> Result<Vec<u8>, ScenarioError> {
        match hex_bytes(value.get_ref()) {
            Some(bytes) => Ok(bytes),
            None => self.fail(
                &value.span(),
                format!("`{key}` is `{}`; expected bytes in hex such as \"01FF\"", value.get_ref()),
            ),
        }
    }

    fn heartbeat(&self, value: &Spanned<Time>) -> Result<u8, ScenarioError> {
        let Time(time) = *value.get_ref();
        match u8::try_from(time.as_secs()) {
            Ok(seconds) if Duration::from_secs(seconds.into()) == time => Ok(seconds),
            _ => self.fail(
                &value.span(),
                format!("`heartbeat` is {}; expected whole seconds, 0s (none) to 255s", Time(time)),
            ),
        }
    }
}

/// The I/O connections of a slave, in the order in which they are looked at.
fn connections(raw: &RawNode) -> impl Iterator<Item = (ConnectionName, &Spanned<RawIo>)> {
    [
        (ConnectionName::Poll, &raw.poll),
        (ConnectionName::BitStrobe, &raw.bit_strobe),
        (ConnectionName::ChangeOfState, &raw.cos),
        (ConnectionName::Cyclic, &raw.cyclic),
        (ConnectionName::MulticastPoll, &raw.multicast_poll),
    ]
    .into_iter()
    .filter_map(|(name, io)| Some((name, io.as_ref()?)))
}

const CHANGE_OF_STATE: AllocationChoice = AllocationChoice::CHANGE_OF_STATE.union(AllocationChoice::CYCLIC);
