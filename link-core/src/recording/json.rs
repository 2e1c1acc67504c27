//! The objects of readings: entries without a value are left out, and what people read is written as `Display` has it.

use core::fmt;

use serde::ser::{Serialize, SerializeMap, Serializer};

use super::Answered;

impl Serialize for Answered {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(2))?;
        map.serialize_entry("n", &self.n)?;
        map.serialize_entry("latency", &self.latency.as_secs_f64())?;
        map.end()
    }
}

/// Writes an entry if there is a value.
///
/// # Errors
/// When the serializer fails.
pub fn optional<M: SerializeMap, T: Serialize>(
    map: &mut M,
    key: &'static str,
    value: Option<T>,
) -> Result<(), M::Error> {
    match value {
        Some(value) => map.serialize_entry(key, &value),
        None => Ok(()),
    }
}

/// Serialises what `Display` prints.
#[derive(Debug, Clone, Copy)]
pub struct Words<T>(pub T);

impl<T: fmt::Display> Serialize for Words<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&self.0)
    }
}
