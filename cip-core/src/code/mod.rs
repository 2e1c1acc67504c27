//! Numbers with names: an open newtype for each code on the wire.
//!
//! A code is a transparent wrapper of its number, so that a value nobody has named yet survives a round trip. `Display`
//! and `Debug` print the name, or the kind and the number of a code without one.
//!
//! ```
//! use cip_core::code::GeneralStatus;
//!
//! assert_eq!(GeneralStatus(0x0E).to_string(), "Attribute not settable");
//! assert_eq!(GeneralStatus(0x7A).to_string(), "general status 0x7A");
//! ```

mod class;
mod data_type;
mod device_type;
mod service;
mod status;
mod vendor;

pub use class::{AttributeId, ClassId, IdRange, InstanceId};
pub use data_type::DataTypeCode;
pub use device_type::DeviceType;
pub use service::{ServiceCode, ServiceRange};
pub use status::{AdditionalCode, GeneralStatus};
pub use vendor::VendorId;

pub(crate) use link_core::codes;

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn named_codes_are_distinct() {
        let mut names: std::vec::Vec<_> = ServiceCode::NAMED.iter().map(ToString::to_string).collect();
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count);
    }

    #[test]
    fn unknown_codes_print_kind_and_number() {
        assert_eq!(ServiceCode(0x7A).to_string(), "service 0x7A");
        assert_eq!(ClassId(0x64).to_string(), "class 0x64");
        assert_eq!(ClassId(0x0300).to_string(), "class 0x0300");
        assert_eq!(InstanceId(101).to_string(), "instance 101");
        assert_eq!(VendorId(60000).to_string(), "vendor 60000");
        assert_eq!(DeviceType(0x64).to_string(), "device type 0x64");
        assert_eq!(std::format!("{:?}", GeneralStatus(0xD0)), "general status 0xD0");
    }
}
