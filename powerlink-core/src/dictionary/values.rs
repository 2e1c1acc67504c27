//! The values that can be written.

use super::write::host_name;
use super::{Entry, ObjectAddress, STANDARD_ENTRIES};
use crate::wire::ConfigurationStamp;

/// The parameters of a node that a managing node writes, with their power-on values.
///
/// Those of the cycle count from the next `ResetConfiguration` on.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Values {
    /// 0x1006, µs, 27 or more; 0 while it is not known: then the loss of SoC is not noticed by time.
    pub cycle_length: u32,
    /// 0x1020/1 and /2.
    pub configuration: ConfigurationStamp,
    /// 0x1020/3.
    pub configuration_id: u32,
    /// 0x1300, ms; 0 for no time-out.
    pub sequence_timeout: u32,
    /// 0x1C13, ns.
    pub jitter_range: u32,
    /// 0x1C14, ns; 0 if the loss of SoC is not to be noticed by time.
    pub loss_of_soc_tolerance: u32,
    /// 0x1F98/4: the most process data of a PReq.
    pub preq_limit: u16,
    /// 0x1F98/5: the process data of every PRes, mapped or not.
    pub pres_limit: u16,
    /// 0x1F98/7: polled in every so many cycles; 0 for each.
    pub multiplexed_cycles: u8,
    /// 0x1F98/8
    pub async_mtu: u16,
    /// 0x1F98/9
    pub prescaler: u16,
    /// 0x1F99, µs; 0 for never.
    pub basic_ethernet_timeout: u32,
    /// 0x1F9A: digits, letters and hyphens, padded with zeros.
    pub host_name: [u8; 32],
}

impl Values {
    /// The first that is not in the range of its object. That of 0x1F98/5 depends on the node.
    pub(crate) fn out_of_range(&self) -> Option<ObjectAddress> {
        let numbers = [
            (ObjectAddress::new(0x1006, 0), self.cycle_length),
            (ObjectAddress::new(0x1F98, 4), self.preq_limit.into()),
            (ObjectAddress::new(0x1F98, 8), self.async_mtu.into()),
            (ObjectAddress::new(0x1F98, 9), self.prescaler.into()),
        ];
        let is_out = |&(at, value): &(ObjectAddress, u32)| {
            Entry::find(STANDARD_ENTRIES, at).is_ok_and(|entry| entry.check_range(value).is_err())
        };
        let number = numbers.iter().find(|number| is_out(number)).map(|&(at, _)| at);
        let name = host_name(&self.host_name).is_err().then_some(ObjectAddress::new(0x1F9A, 0));
        number.or(name)
    }
}

impl Default for Values {
    /// The defaults of EPSG DS 301, and 15 s for 0x1300, as openPOWERLINK has it.
    fn default() -> Self {
        Self {
            cycle_length: 0,
            configuration: ConfigurationStamp { date: 0, time: 0 },
            configuration_id: 0,
            sequence_timeout: 15_000,
            jitter_range: 2_000,
            loss_of_soc_tolerance: 100_000,
            preq_limit: 36,
            pres_limit: 36,
            multiplexed_cycles: 0,
            async_mtu: 300,
            prescaler: 2,
            basic_ethernet_timeout: 5_000_000,
            host_name: [0; 32],
        }
    }
}
