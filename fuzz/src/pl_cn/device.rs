//! The node under test, and everything about it that is configured.
//!
//! Three bytes:
//!
//! | Byte | Content |
//! |---|---|
//! | 0 | each bit turns a choice of [`Options`] over, in their order from `poll_restarts_basic_ethernet` to `clears_before_answer` |
//! | 1 | bit 0 the application says when it is ready, bit 1 polled in one cycle of four, bit 2 `InitiateSize::NotCounted`, bits 4-3 the version check, bits 7-5 errors in a StatusResponse, less 2 |
//! | 2 | bit 0 nothing is mapped, bit 1 no cycle length, bit 2 no basic Ethernet, bit 3 0x1F98/5 is 64, bit 4 0x1300 is 1 s, bits 6-5 0x1F98/8 |

use arbitrary::{Result, Unstructured};
use link_core::codec::Writer;
use link_core::ethernet::MacAddress;
use powerlink_core::cycle::PollWithoutSoc;
use powerlink_core::dictionary::{
    Access, Device as Constants, Entry, Mappable, ObjectAddress, ObjectSet, ObjectType,
};
use powerlink_core::node::{Config, DefaultMapping, Options, Readiness, VersionCheck};
use powerlink_core::pdo::MappingEntry;
use powerlink_core::wire::{AbortCode, Identity, InitiateSize};
use powerlink_core::{ControlledNode, NodeId};

pub(super) const NODE: NodeId = NodeId(1);
pub(super) const MAC: MacAddress = MacAddress([2, 0, 0, 0, 0, 1]);
pub(super) const VENDOR: u32 = 0x0123;
/// The greatest value of 0x6201/1.
pub(super) const MOST_OUTPUTS: u32 = 0x7FFF_FFFF;
/// While 0x6000/1 has this value, it cannot be read.
pub(super) const UNREADABLE: u8 = 15;

pub(super) type Node = ControlledNode<Device, 64, 128>;

/// A fictitious device: two inputs of which one cannot always be read, two outputs of which one takes some values only, a text that
/// needs segments, and an object that takes nothing.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Device {
    pub(super) inputs: (u8, u64),
    pub(super) outputs: (u8, u32),
    pub(super) text: Vec<u8>,
}

impl ObjectSet for Device {
    const ENTRIES: &'static [Entry] = &[
        Entry::new(0x2000, 0, "text", ObjectType::Bytes(128), Access::ReadWrite),
        Entry::new(0x2100, 0, "stubborn", ObjectType::Unsigned(1), Access::WriteOnly),
        Entry::new(0x6000, 1, "input", ObjectType::Unsigned(1), Access::ReadOnly).mapped(Mappable::Transmit),
        Entry::new(0x6001, 1, "inputs", ObjectType::Unsigned(8), Access::ReadOnly).mapped(Mappable::Transmit),
        Entry::new(0x6200, 1, "output", ObjectType::Unsigned(1), Access::ReadWrite).mapped(Mappable::Receive),
        Entry::new(0x6201, 1, "outputs", ObjectType::Unsigned(4), Access::ReadWrite)
            .mapped(Mappable::Receive)
            .within(0, MOST_OUTPUTS),
    ];

    fn read(&self, at: ObjectAddress, out: &mut Writer<'_>) -> core::result::Result<(), AbortCode> {
        match at.index {
            0x2000 => out.bytes(&self.text),
            0x6000 if self.inputs.0 == UNREADABLE => return Err(AbortCode::STATE),
            0x6000 => out.u8(self.inputs.0),
            0x6001 => out.u64(self.inputs.1),
            0x6200 => out.u8(self.outputs.0),
            _ => out.u32(self.outputs.1),
        }
        .map_err(|_| AbortCode::OUT_OF_MEMORY)
    }

    fn write(&mut self, at: ObjectAddress, data: &[u8]) -> core::result::Result<(), AbortCode> {
        match at.index {
            0x2000 => self.text = data.to_vec(),
            0x6200 => self.outputs.0 = data[0],
            0x6201 => self.outputs.1 = u32::from_le_bytes(data.try_into().expect("checked by its line")),
            _ => return Err(AbortCode::GENERAL),
        }
        Ok(())
    }

    fn restore(&mut self) {
        *self = Self::default();
    }
}

pub(super) fn config(input: &mut Unstructured<'_>) -> Result<Config> {
    let [turned, kinds, sizes]: [u8; 3] = input.arbitrary()?;
    let identity =
        Identity { vendor_id: VENDOR, product_code: 7, revision: 0x0001_0000, serial_number: 0x1122_3344 };
    let mut config = Config::new(NODE, MAC, Constants::new(identity)).expect("a controlled node");
    options(&mut config.options, turned, kinds);
    let values = &mut config.values;
    values.cycle_length = if sizes & 0x02 == 0 { 20_000 } else { 0 };
    values.multiplexed_cycles = if kinds & 0x02 == 0 { 0 } else { 4 };
    if sizes & 0x04 != 0 {
        values.basic_ethernet_timeout = 0;
    }
    values.pres_limit = if sizes & 0x08 == 0 { 36 } else { 64 };
    if sizes & 0x10 != 0 {
        values.sequence_timeout = 1000;
    }
    values.async_mtu = [300, 301, 1499, 1500][usize::from(sizes >> 5 & 3)];
    if sizes & 0x01 == 0 {
        config.mapping = DefaultMapping {
            receive: const { &[entry(0x6200, 0, 8), entry(0x6201, 8, 32)] },
            transmit: const { &[entry(0x6000, 0, 8), entry(0x6001, 8, 64)] },
        };
    }
    Ok(config)
}

fn options(options: &mut Options, turned: u8, kinds: u8) {
    for (bit, choice) in [
        &mut options.poll_restarts_basic_ethernet,
        &mut options.poll_ends_not_active,
        &mut options.pres_ends_basic_ethernet,
        &mut options.reacts_to_loss_of_soa,
        &mut options.reacts_to_jitter,
        &mut options.reacts_to_collisions,
        &mut options.clears_before_answer,
    ]
    .into_iter()
    .enumerate()
    {
        *choice ^= turned >> bit & 1 == 1;
    }
    if turned & 0x80 != 0 {
        options.poll_without_soc = PollWithoutSoc::WaitSoa;
    }
    if kinds & 0x01 != 0 {
        options.readiness = Readiness::ByApplication;
    }
    if kinds & 0x04 != 0 {
        options.initiate_size = InitiateSize::NotCounted;
    }
    let checks = [VersionCheck::Main, VersionCheck::Exact, VersionCheck::None];
    options.version_check = checks[usize::from(kinds >> 3 & 3) % 3];
    options.status_entries = 2 + usize::from(kinds >> 5);
}

const fn entry(index: u16, offset: u16, length: u16) -> MappingEntry {
    MappingEntry { object: ObjectAddress::new(index, 1), offset, length }
}
