//! The objects of readings, with the tools of [`link_core::recording::json`].

pub use link_core::recording::json::{Words, optional};
use serde::ser::{Serialize, SerializeMap, Serializer};

use super::{ConnectionState, Explicit, Frag, Vocabulary};
use crate::code::InstanceId;

impl Serialize for Frag {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("type", self.name())?;
        map.serialize_entry("count", &self.byte.count())?;
        optional(&mut map, "status", self.status)?;
        map.end()
    }
}

impl Serialize for ConnectionState {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl Explicit<'_> {
    /// Writes the entries `service`, `service_name`, `requested` (the service that was refused), `class`, `instance`,
    /// `attribute`, `attribute_name`, `status`, `additional`, `status_name`. The network says how the service is called, and
    /// whether the instance stands here.
    ///
    /// # Errors
    /// When the serializer fails.
    pub fn entries<M: SerializeMap>(
        &self,
        map: &mut M,
        vocabulary: &Vocabulary,
        service_name: Option<&'static str>,
        instance: Option<InstanceId>,
    ) -> Result<(), M::Error> {
        optional(map, "service", self.service)?;
        optional(map, "service_name", service_name)?;
        optional(map, "requested", self.requested.filter(|&requested| self.service != Some(requested)))?;
        optional(map, "class", self.class)?;
        optional(map, "instance", instance)?;
        optional(map, "attribute", self.attribute)?;
        optional(map, "attribute_name", self.attribute_name(vocabulary))?;
        optional(map, "status", self.status)?;
        optional(map, "additional", self.additional)?;
        optional(map, "status_name", self.status.and_then(|status| status.name()))
    }
}
