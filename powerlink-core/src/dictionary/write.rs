//! Writing the standard objects.

use super::entry::unsigned;
use super::{Dictionary, ObjectAddress, ObjectSet};
use crate::NodeId;
use crate::error::Symptom;
use crate::nmt::Cause;
use crate::pdo::{Mapping, MappingEntry};
use crate::wire::{AbortCode, NmtCommandId, PdoVersion};

/// What has to follow from a write.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Effect {
    /// Nothing.
    None,
    /// The node is to be reset, once the answer is sent.
    Reset(Cause),
}

impl Dictionary {
    /// Takes a value that was checked against the table.
    pub(super) fn write<O: ObjectSet>(
        &mut self,
        at: ObjectAddress,
        data: &[u8],
    ) -> Result<Effect, AbortCode> {
        let value = unsigned(data).unwrap_or(0);
        let narrow = u16::try_from(value).unwrap_or(u16::MAX);
        let byte = u8::try_from(value).unwrap_or(u8::MAX);
        let values = &mut self.values;
        match (at.index, at.sub) {
            (0x1003, 0) => self.history.clear(),
            (0x1006, _) => values.cycle_length = value,
            (0x1020, 1) => values.configuration.date = value,
            (0x1020, 2) => values.configuration.time = value,
            (0x1020, 3) => values.configuration_id = value,
            (0x1300, _) => values.sequence_timeout = value,
            (0x1400..=0x14FF, sub) => write_channel(self.receive_mut(at, 0x1400)?, sub, byte)?,
            (0x1600..=0x16FF, 0) => {
                let (channel, limit) = (at.index.saturating_sub(0x1600), self.values.preq_limit);
                self.mappings.activate_receive::<O>(channel.into(), byte, limit.into())?;
            }
            (0x1600..=0x16FF, sub) => write_entry(self.receive_mut(at, 0x1600)?, sub, data)?,
            (0x1800, sub) => write_channel(&mut self.mappings.transmit, sub, byte)?,
            (0x1A00, 0) => {
                let limit = self.values.pres_limit.into();
                self.mappings.transmit.activate::<O>(byte, true, limit)?;
            }
            (0x1A00, sub) => write_entry(&mut self.mappings.transmit, sub, data)?,
            (0x1C0A..=0x1C10, sub) => self.write_counter(at.index, sub, value)?,
            (0x1C13, _) => values.jitter_range = value,
            (0x1C14, _) => values.loss_of_soc_tolerance = value,
            // What is mapped has to fit in the end, whichever of the two is written last.
            (0x1F98, 4) if narrow < self.mappings.poll_size() => return Err(AbortCode::PDO_LENGTH),
            (0x1F98, 4) => values.preq_limit = narrow,
            (0x1F98, 5) if narrow < self.mappings.transmit.size() => return Err(AbortCode::PDO_LENGTH),
            (0x1F98, 5) if narrow > self.max_pres_payload => return Err(AbortCode::VALUE_TOO_HIGH),
            (0x1F98, 5) => values.pres_limit = narrow,
            (0x1F98, 7) => values.multiplexed_cycles = byte,
            (0x1F98, 8) => values.async_mtu = narrow,
            (0x1F98, 9) => values.prescaler = narrow,
            (0x1F99, _) => values.basic_ethernet_timeout = value,
            (0x1F9A, _) => values.host_name = host_name(data)?,
            (0x1F9E, _) => {
                let command = NmtCommandId(byte);
                let cause =
                    Cause::of_command(command).filter(|_| command.is_reset()).ok_or(AbortCode::VALUE)?;
                return Ok(Effect::Reset(cause));
            }
            _ => return Err(AbortCode::READ_ONLY),
        }
        Ok(Effect::None)
    }

    fn write_counter(&mut self, index: u16, sub: u8, value: u32) -> Result<(), AbortCode> {
        let symptom = Symptom::of_object(index).ok_or(AbortCode::NO_OBJECT)?;
        let counter = self.counters.of_mut(symptom).ok_or(AbortCode::NO_OBJECT)?;
        match (symptom, sub) {
            (Symptom::LossOfLink, _) | (_, 1) => counter.cumulative = value,
            _ => counter.threshold = value,
        }
        Ok(())
    }

    fn receive_mut(&mut self, at: ObjectAddress, first: u16) -> Result<&mut Mapping, AbortCode> {
        let channel = usize::from(at.index.saturating_sub(first));
        self.mappings.receive.get_mut(channel).ok_or(AbortCode::NO_OBJECT)
    }
}

fn write_channel(mapping: &mut Mapping, sub: u8, value: u8) -> Result<(), AbortCode> {
    if !mapping.is_empty() {
        return Err(AbortCode::UNSUPPORTED_ACCESS);
    }
    match sub {
        1 => mapping.node = NodeId(value),
        _ => mapping.version = PdoVersion(value),
    }
    Ok(())
}

fn write_entry(mapping: &mut Mapping, sub: u8, data: &[u8]) -> Result<(), AbortCode> {
    let number = data.first_chunk().copied().map(u64::from_le_bytes).ok_or(AbortCode::LENGTH)?;
    mapping.set_entry(sub, MappingEntry::of(number))
}

/// A host name of at most 32 characters, padded with zeros.
pub(super) fn host_name(data: &[u8]) -> Result<[u8; 32], AbortCode> {
    let is_allowed = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'-';
    let name = data.split(|&byte| byte == 0).next().unwrap_or_default();
    if !name.iter().all(is_allowed) {
        return Err(AbortCode::VALUE);
    }
    let mut padded = [0; 32];
    let room = padded.get_mut(..name.len()).ok_or(AbortCode::TOO_LONG)?;
    room.iter_mut().zip(name).for_each(|(to, &from)| *to = from);
    Ok(padded)
}
