#![no_std]
#![no_main]
//! A controlled node of POWERLINK: 8 bytes of process data in each direction, values of up to 256 bytes over SDO. As with the
//! others, `scripts/bare-metal` prints its size, and demands that no panicking code was linked into it.

use core::hint::black_box;
use core::sync::atomic::AtomicU8;

use cortex_m_rt::entry;
use devicenet_firmware::drive_ethernet;
use link_core::codec::Writer;
use link_core::ethernet::MacAddress;
use panic_halt as _;
use powerlink_core::dictionary::{Access, Device, Entry, Mappable, ObjectAddress, ObjectSet, ObjectType};
use powerlink_core::node::{Config, DefaultMapping};
use powerlink_core::pdo::MappingEntry;
use powerlink_core::wire::{AbortCode, Identity};
use powerlink_core::{ControlledNode, NodeId};

/// 64 bits in, 64 bits out.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct Block {
    inputs: u64,
    outputs: u64,
}

impl ObjectSet for Block {
    const ENTRIES: &'static [Entry] = &[
        Entry::new(0x6020, 1, "inputs", ObjectType::Unsigned(8), Access::ReadOnly).mapped(Mappable::Transmit),
        Entry::new(0x6220, 1, "outputs", ObjectType::Unsigned(8), Access::ReadWrite)
            .mapped(Mappable::Receive),
    ];

    fn read(&self, at: ObjectAddress, out: &mut Writer<'_>) -> Result<(), AbortCode> {
        let value = if at.index == 0x6020 { self.inputs } else { self.outputs };
        out.u64(value).map_err(|_| AbortCode::OUT_OF_MEMORY)
    }

    fn write(&mut self, _: ObjectAddress, data: &[u8]) -> Result<(), AbortCode> {
        self.outputs = u64::from_le_bytes(*data.first_chunk().ok_or(AbortCode::LENGTH)?);
        Ok(())
    }

    fn restore(&mut self) {
        self.outputs = 0;
    }
}

const fn whole(index: u16) -> MappingEntry {
    MappingEntry { object: ObjectAddress::new(index, 1), offset: 0, length: 64 }
}

#[entry]
fn main() -> ! {
    // A fictitious device.
    let identity = Identity {
        vendor_id: black_box(0x0123),
        product_code: 7,
        revision: 0x0001_0000,
        serial_number: black_box(42),
    };
    let mac = MacAddress(black_box([2, 0, 0, 0, 0, 1]));
    let Ok(mut config) = Config::new(NodeId(black_box(1)), mac, Device::new(identity)) else { loop {} };
    config.mapping =
        DefaultMapping { receive: const { &[whole(0x6220)] }, transmit: const { &[whole(0x6020)] } };
    let Ok(mut node) = Node::new(config, Block { inputs: black_box(0), outputs: 0 }) else { loop {} };
    drive_ethernet(&mut node)
}

type Node = ControlledNode<Block>;

/// The RAM of the machine without its application, as the size of a symbol.
#[used]
static MACHINE_RAM: [AtomicU8; RAM] = [const { AtomicU8::new(0) }; RAM];
const RAM: usize = size_of::<Node>() - size_of::<Block>();
