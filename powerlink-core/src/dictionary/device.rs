//! What never changes: the device.

use crate::wire::{ConfigurationStamp, FeatureFlags, Identity};

/// What a device is: the constant objects, and what an IdentResponse tells of it.
///
/// There is no default: whose device it is has to be said.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Device {
    /// 0x1018
    pub identity: Identity,
    /// 0x1000: the low 16 bits are the number of the device profile.
    pub device_type: u32,
    /// 0x1008
    pub name: &'static str,
    /// 0x1009
    pub hardware_version: &'static str,
    /// 0x100A
    pub software_version: &'static str,
    /// Of the software, in the IdentResponse.
    pub software: ConfigurationStamp,
    /// 0x1F98/3, ns: from a PReq to the PRes, at most.
    pub pres_latency: u32,
    /// 0x1F98/6, ns: from a SoA to the answer, at most.
    pub asnd_latency: u32,
    /// In the IdentResponse.
    pub vendor_extension_1: u64,
    /// In the IdentResponse.
    pub vendor_extension_2: [u8; 48],
}

impl Device {
    /// A device of which only the identity is special.
    #[must_use]
    pub const fn new(identity: Identity) -> Self {
        Self {
            identity,
            device_type: 0,
            name: "",
            hardware_version: "",
            software_version: "",
            software: ConfigurationStamp { date: 0, time: 0 },
            pres_latency: 50_000,
            asnd_latency: 50_000,
            vendor_extension_1: 0,
            vendor_extension_2: [0; 48],
        }
    }
}

/// 0x1F82: what a node of this crate can do.
pub const FEATURES: FeatureFlags = FeatureFlags::ISOCHRONOUS
    .union(FeatureFlags::SDO_ASND)
    .union(FeatureFlags::EXTENDED_NMT)
    .union(FeatureFlags::DYNAMIC_MAPPING)
    .union(FeatureFlags::MULTIPLEXED);
