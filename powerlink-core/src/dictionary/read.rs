//! Reading the standard objects.

use link_core::codec::{Full, Wire, Writer};

use super::{Dictionary, FEATURES, ObjectAddress};
use crate::error::Symptom;
use crate::ethernet::MAX_PROCESS_DATA;
use crate::pdo::{MAX_MAPPED, Mapping};
use crate::wire::{AbortCode, IpParameters, NmtCommandId, POWERLINK_V2};

impl Dictionary {
    /// Writes the value of an object, which the table has.
    pub(super) fn read(&self, at: ObjectAddress, out: &mut Writer<'_>) -> Result<(), AbortCode> {
        let identity = self.device.identity;
        let values = &self.values;
        match (at.index, at.sub) {
            (0x1000, _) => out.u32(self.device.device_type),
            (0x1001, _) => out.u8(self.error_register),
            (0x1003, 0) => out.u8(u8::try_from(self.history.len()).unwrap_or(u8::MAX)),
            (0x1003, sub) => {
                let index = usize::from(sub.saturating_sub(1));
                self.history().nth(index).ok_or(AbortCode::NO_SUB_INDEX)?.emit(out)
            }
            (0x1006, _) => out.u32(values.cycle_length),
            (0x1008, _) => out.bytes(self.device.name.as_bytes()),
            (0x1009, _) => out.bytes(self.device.hardware_version.as_bytes()),
            (0x100A, _) => out.bytes(self.device.software_version.as_bytes()),
            (0x1018 | 0x1020, 0) => out.u8(4),
            (0x1018, 1) => out.u32(identity.vendor_id),
            (0x1018, 2) => out.u32(identity.product_code),
            (0x1018, 3) => out.u32(identity.revision),
            (0x1018, _) => out.u32(identity.serial_number),
            (0x1020, 1) => out.u32(values.configuration.date),
            (0x1020, 2) => out.u32(values.configuration.time),
            (0x1020, 3) => out.u32(values.configuration_id),
            // Valid once somebody said which configuration it is.
            (0x1020, _) => out.u8(u8::from(values.configuration == Default::default())),
            (0x1030, sub) => self.read_interface(sub, out),
            (0x1300, _) => out.u32(values.sequence_timeout),
            (0x1400..=0x14FF, sub) => read_channel(self.receive(at, 0x1400)?, sub, out),
            (0x1600..=0x16FF, sub) => read_mapping(self.receive(at, 0x1600)?, sub, out)?,
            (0x1800, sub) => read_channel(&self.mappings.transmit, sub, out),
            (0x1A00, sub) => read_mapping(&self.mappings.transmit, sub, out)?,
            (0x1C0A..=0x1C10, sub) => self.read_counter(at.index, sub, out)?,
            (0x1C13, _) => out.u32(values.jitter_range),
            (0x1C14, _) => out.u32(values.loss_of_soc_tolerance),
            (0x1E40, sub) => self.read_ip(sub, out),
            (0x1F82, _) => out.u32(FEATURES.bits()),
            (0x1F83, _) => out.u8(POWERLINK_V2),
            (0x1F8C, _) => out.u8(self.state.code().0),
            (0x1F93, 0) => out.u8(2),
            (0x1F93, 1) => out.u8(self.node.0),
            (0x1F93, _) => out.u8(1),
            (0x1F98, sub) => self.read_timing(sub, out),
            (0x1F99, _) => out.u32(values.basic_ethernet_timeout),
            (0x1F9A, _) => out.bytes(values.host_name.split(|&byte| byte == 0).next().unwrap_or_default()),
            (0x1F9E, _) => out.u8(NmtCommandId::INVALID_SERVICE.0),
            _ => return Err(AbortCode::NO_OBJECT),
        }
        .map_err(|Full| AbortCode::OUT_OF_MEMORY)
    }

    fn read_interface(&self, sub: u8, out: &mut Writer<'_>) -> Result<(), Full> {
        match sub {
            0 => out.u8(9),
            1 => out.u16(1),
            2 | 6 => out.bytes(self.device.name.as_bytes()),
            // Ethernet, after RFC 1213.
            3 => out.u8(6),
            4 => out.u16(self.values.async_mtu),
            5 => out.bytes(&self.mac.0),
            7 | 8 => out.u8(1),
            _ => out.u8(1),
        }
    }

    fn read_counter(&self, index: u16, sub: u8, out: &mut Writer<'_>) -> Result<Result<(), Full>, AbortCode> {
        let symptom = Symptom::of_object(index).ok_or(AbortCode::NO_OBJECT)?;
        let counter = self.counters.of(symptom);
        Ok(match (symptom, sub) {
            (Symptom::LossOfLink, _) | (_, 1) => out.u32(counter.cumulative),
            (_, 0) => out.u8(3),
            (_, 2) => out.u32(counter.threshold_count),
            _ => out.u32(counter.threshold),
        })
    }

    fn read_ip(&self, sub: u8, out: &mut Writer<'_>) -> Result<(), Full> {
        let ip = IpParameters::of(self.node);
        match sub {
            0 => out.u8(5),
            1 => out.u16(1),
            2 => out.u32(ip.address.into()),
            3 => out.u32(ip.subnet_mask.into()),
            4 => out.u16(0),
            _ => out.u32(ip.gateway.into()),
        }
    }

    fn read_timing(&self, sub: u8, out: &mut Writer<'_>) -> Result<(), Full> {
        let values = &self.values;
        match sub {
            0 => out.u8(9),
            1 => out.u16(self.max_pres_payload),
            2 => out.u16(u16::try_from(MAX_PROCESS_DATA).unwrap_or(u16::MAX)),
            3 => out.u32(self.device.pres_latency),
            4 => out.u16(values.preq_limit),
            5 => out.u16(values.pres_limit),
            6 => out.u32(self.device.asnd_latency),
            7 => out.u8(values.multiplexed_cycles),
            8 => out.u16(values.async_mtu),
            _ => out.u16(values.prescaler),
        }
    }

    /// The receive mapping of an object in a row that begins at `first`.
    pub(super) fn receive(&self, at: ObjectAddress, first: u16) -> Result<&Mapping, AbortCode> {
        let channel = usize::from(at.index.saturating_sub(first));
        self.mappings.receive.get(channel).ok_or(AbortCode::NO_OBJECT)
    }
}

fn read_channel(mapping: &Mapping, sub: u8, out: &mut Writer<'_>) -> Result<(), Full> {
    match sub {
        0 => out.u8(2),
        1 => out.u8(mapping.node.0),
        _ => out.u8(mapping.version.0),
    }
}

fn read_mapping(mapping: &Mapping, sub: u8, out: &mut Writer<'_>) -> Result<Result<(), Full>, AbortCode> {
    debug_assert!(usize::from(sub) <= MAX_MAPPED);
    Ok(match sub {
        0 => out.u8(mapping.count()),
        sub => out.u64(mapping.entry(sub).ok_or(AbortCode::NO_SUB_INDEX)?.number()),
    })
}
