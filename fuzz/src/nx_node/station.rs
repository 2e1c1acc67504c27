//! A device as the bytes want it.

use arbitrary::{Result, Unstructured};
use cip_core::code::{DeviceType, VendorId};
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use cip_core::message::BodyFormat;
use cip_core::object::Identity;
use devicenex_core::access::Role;
use devicenex_core::device::{Application, Config, Fragmented};
use devicenex_core::message::{ConnectionInstance, PortByte};

/// One image in, one image out, for every connection.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Station {
    identity: DeviceIdentity,
    pub(super) inputs: Vec<u8>,
    pub(super) outputs: Vec<u8>,
}

impl Application for Station {
    type Long = Fragmented<{ LONGEST_IO }>;

    fn identity(&self) -> Identity<'_> {
        Identity::new(&self.identity)
    }

    fn produced(&self, _: ConnectionInstance) -> &[u8] {
        &self.inputs
    }

    fn consumed(&mut self, _: ConnectionInstance) -> &mut [u8] {
        &mut self.outputs
    }
}

/// Three bytes: lengths of the inputs and of the outputs, and choices.
///
/// | Bit of the third | Choice |
/// |---|---|
/// | 0 | change of state and cyclic begin without acknowledges |
/// | 1 | classes and instances of 16 bits |
/// | 2 | the address is told from time to time |
/// | 3 | whoever configures a connection has for ever |
/// | 4 | the last fragment of a request is forgotten at once |
/// | 5 | the node comes back after bus-off |
/// | 6 | it begins without power, and not on line |
/// | 7 | its bit rate cannot be set |
pub(super) fn config(input: &mut Unstructured<'_>) -> Result<(Config, Station, u8)> {
    let [inputs, outputs, choices]: [u8; 3] = input.arbitrary()?;
    let identity = DeviceIdentity {
        vendor: VendorId(0x03E7),
        device_type: DeviceType::GENERAL_PURPOSE_DISCRETE_IO,
        product_code: 0x2A,
        revision: Revision::new(1, 1).expect("it is valid"),
        serial: 0x1122_3344,
        name: ProductName::new("Example Block 2I1O").expect("it is short"),
    };
    let mut config = Config::new(&identity, PortByte::ZERO, Role::Device);
    let chosen = |bit: u8| choices & 1 << bit != 0;
    config.acknowledged = !chosen(0);
    if chosen(1) {
        config.body_format = BodyFormat::Class16Instance16;
    }
    config.access.announcement = if chosen(2) { 10_000 } else { 0 };
    if chosen(3) {
        config.configuring_time_out = 0;
    }
    config.reacknowledge_last = !chosen(4);
    config.access.bus_off_interrupt = chosen(5);
    let image = |len: u8| vec![0; usize::from(len) % (LONGEST_IO + 1)];
    let station = Station { identity, inputs: image(inputs), outputs: image(outputs) };
    Ok((config, station, choices))
}

/// The longest implicit message: three fragments.
const LONGEST_IO: usize = 16;
