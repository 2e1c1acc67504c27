//! The device under test, and everything about it that is configured.
//!
//! Two bytes of configuration, then one of sizes:
//!
//! | Byte | Content |
//! |---|---|
//! | 0 | bits 5-0 MAC ID, bit 6 `ACCEPT_SHORTER_IO`, bit 7 `ANSWER_SHORT_BODY` |
//! | 1 | each bit turns one option over, see [`OPTIONS`] |
//! | 2 | bit 0 long poll response, 1 long poll command, 2 long change of state, 3 long multicast, 4 no poll outputs, 5 resolution 1 ms, 6 `EMPTY_AS_3F`, 7 `ANSWER_INHIBIT_TIME` |

use arbitrary::{Result, Unstructured};
use cip_core::code::{DeviceType, VendorId};
use cip_core::connection::TimerResolution;
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use cip_core::message::AllocationChoice;
use cip_core::object::Identity;
use devicenet_core::MacId;
use devicenet_core::slave::{Application, Config, Fragmented, IoKind, Options};

/// A fictitious device with every connection of the predefined set.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Device {
    identity: DeviceIdentity,
    /// What poll, bit-strobe, change of state and multicast poll produce.
    pub(super) inputs: [Vec<u8>; 4],
    /// What they consume; for bit-strobe the own bit.
    pub(super) outputs: [Vec<u8>; 4],
}

impl Application for Device {
    const IO: AllocationChoice = AllocationChoice::all();
    type Long = Fragmented<16>;

    fn identity(&self) -> Identity<'_> {
        Identity::new(&self.identity)
    }

    fn produced(&self, connection: IoKind) -> &[u8] {
        &self.inputs[index(connection)]
    }

    fn consumed(&mut self, connection: IoKind) -> &mut [u8] {
        &mut self.outputs[index(connection)]
    }
}

pub(super) fn index(connection: IoKind) -> usize {
    IoKind::ALL.iter().position(|&kind| kind == connection).expect("one of them")
}

/// Reads the configuration, and makes the device that belongs to it.
pub(super) fn config(input: &mut Unstructured<'_>) -> Result<(Config, Device)> {
    let [first, options, sizes]: [u8; 3] = input.arbitrary()?;
    let long = |bit: u8, short: usize, long: usize| vec![0; if sizes >> bit & 1 == 1 { long } else { short }];
    let device = Device {
        identity: identity(),
        inputs: [long(0, 2, 15), vec![0; 1], long(2, 3, 14), long(3, 2, 9)],
        outputs: [long(1, if sizes & 0x10 == 0 { 1 } else { 0 }, 10), vec![0], vec![], long(3, 1, 16)],
    };
    let mut config = Config::new(&device.identity, MacId::new(first & 0x3F).expect("six bits"));
    config.access.bus_off_interrupt = true;
    for (bit, option) in OPTIONS.into_iter().enumerate().filter(|(bit, _)| options >> bit & 1 == 1) {
        let _ = bit;
        config.options.toggle(option);
    }
    config.options.set(Options::ACCEPT_SHORTER_IO, first & 0x40 != 0);
    config.options.set(Options::ANSWER_SHORT_BODY, first & 0x80 != 0);
    config.options.set(Options::EMPTY_AS_3F, sizes & 0x40 != 0);
    config.options.set(Options::ANSWER_INHIBIT_TIME, sizes & 0x80 != 0);
    if sizes & 0x20 != 0 {
        config.resolution = TimerResolution::new(1).expect("not zero");
    }
    Ok((config, device))
}

fn identity() -> DeviceIdentity {
    DeviceIdentity {
        vendor: VendorId(0x03E7),
        device_type: DeviceType::GENERAL_PURPOSE_DISCRETE_IO,
        product_code: 0x2A,
        revision: Revision::new(1, 1).expect("not zero"),
        serial: 0x1122_3344,
        name: ProductName::new(NAME).expect("short"),
    }
}

/// 17 characters: the response has 19 bytes, in four fragments.
pub(super) const NAME: &str = "Example Block 2I1";

/// What byte 1 of the configuration turns over.
const OPTIONS: [Options; 8] = [
    Options::RELEASE_IGNORES_BIT_6,
    Options::RELEASE_BY_OWNER_ONLY,
    Options::ALLOCATE_FOR_ONESELF_ONLY,
    Options::KEEP_TIMED_OUT,
    Options::DROP_CONFIGURING_WITH_EXPLICIT,
    Options::IO_TIME_OUT_DELETES_ACTION_3,
    Options::IDLE_ON_RELEASE,
    Options::REACKNOWLEDGE_LAST,
];
