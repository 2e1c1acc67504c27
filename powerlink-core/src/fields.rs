//! The fields that events and readings of frames share in JSON.

use link_core::recording::json::optional;
use serde::ser::SerializeMap;

use crate::dictionary::ObjectAddress;
use crate::wire::{AbortCode, ErrorCode};

/// `index` and `subindex`
pub(crate) fn object<M: SerializeMap>(map: &mut M, at: ObjectAddress) -> Result<(), M::Error> {
    map.serialize_entry("index", &at.index)?;
    map.serialize_entry("subindex", &at.sub)
}

/// `abort`, and `abort_name` of a known one
pub(crate) fn abort<M: SerializeMap>(map: &mut M, code: AbortCode) -> Result<(), M::Error> {
    map.serialize_entry("abort", &code)?;
    optional(map, "abort_name", code.name())
}

/// `error`, and `error_name` of a known one
pub(crate) fn error<M: SerializeMap>(map: &mut M, code: ErrorCode) -> Result<(), M::Error> {
    map.serialize_entry("error", &code)?;
    optional(map, "error_name", code.name())
}
