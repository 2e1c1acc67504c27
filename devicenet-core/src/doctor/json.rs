//! Findings as one flat object.

use core::fmt::{self, Write as _};
use core::time::Duration;

use cip_core::message::AllocationChoice;
use link_core::Instant;
use serde::ser::{Serialize, SerializeMap, SerializeSeq, Serializer};

use super::finding::{Evidence, Facts, Finding};

/// Absent fields are left out; times are seconds from the zero of the doctor's clock:
///
/// `id`, `rule`, `severity`, `node`, `scanner_status`, `since`, `last`, `until`, `count`, `evidence` (numbers of frames),
/// `facts`, `first_cause`, `text`, `advice`. `facts` is an object with one entry, the name of the variant of [`Facts`] in lower
/// case with underscores: `{"silence":{"exchange":"poll","patience":0.32}}`, `{"status":1025}`.
impl Serialize for Finding {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("id", &self.id)?;
        map.serialize_entry("rule", &self.rule)?;
        map.serialize_entry("severity", &self.severity)?;
        optional(&mut map, "node", self.node)?;
        optional(&mut map, "scanner_status", self.scanner_status())?;
        map.serialize_entry("since", &seconds(self.since))?;
        map.serialize_entry("last", &seconds(self.last))?;
        optional(&mut map, "until", self.until.map(seconds))?;
        map.serialize_entry("count", &self.count)?;
        map.serialize_entry("evidence", &self.evidence)?;
        optional(&mut map, "facts", Some(self.facts).filter(|facts| *facts != Facts::None))?;
        optional(&mut map, "first_cause", self.first_cause)?;
        map.serialize_entry("text", &Words(self))?;
        map.serialize_entry("advice", &Words(self.advice()))?;
        map.end()
    }
}

impl Serialize for Evidence {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut sequence = serializer.serialize_seq(Some(self.frames().len()))?;
        self.frames().iter().try_for_each(|n| sequence.serialize_element(n))?;
        sequence.end()
    }
}

/// Seconds.
pub(super) fn span<S: Serializer>(span: &Duration, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(span.as_secs_f64())
}

/// The allocation choice byte.
pub(super) fn choice<S: Serializer>(
    choice: &Option<AllocationChoice>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    choice.map(|choice| choice.bits()).serialize(serializer)
}

/// The nearest number to what stands in a trace. Computed, it would be off by a digit now and then.
fn seconds(at: Instant) -> f64 {
    let mut text = heapless::String::<TIME>::new();
    match write!(text, "{at}") {
        Ok(()) => text.parse().unwrap_or_default(),
        Err(fmt::Error) => 0.0,
    }
}

fn optional<M: SerializeMap, T: Serialize>(
    map: &mut M,
    key: &'static str,
    value: Option<T>,
) -> Result<(), M::Error> {
    value.map_or(Ok(()), |value| map.serialize_entry(key, &value))
}

/// Serialises what `Display` prints.
struct Words<T>(T);

impl<T: fmt::Display> Serialize for Words<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&self.0)
    }
}

/// Characters of the latest moment that there is.
const TIME: usize = 24;
