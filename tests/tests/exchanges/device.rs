//! The devices under test, all with MAC ID 63, vendor 0x03E7 (fictitious) and serial number 0x11223344.

use cip_core::code::{AttributeId, ClassId, DeviceType, GeneralStatus, InstanceId, VendorId};
use cip_core::codec::Writer;
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use cip_core::message::AllocationChoice;
use cip_core::object::{AttributeRule, Effects, Failure, Identity, Object, ObjectSet};
use devicenet_core::slave::{Application, Fragmented, IoKind};
use devicenet_tests::block::Block;

/// As a block, by every connection of the predefined set, with longer data if they are to be so.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Full {
    device: DeviceIdentity,
    inputs: Vec<u8>,
    outputs: [Vec<u8>; 4],
}

/// A block with an object of its vendor, class 0x64: two attributes that cannot be set, for the reasons that only an object
/// knows, and three that are long.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Odd(pub(crate) Block<2, 1>);

struct Probe;

/// What an exchange can look at.
pub(crate) trait Data {
    fn set_inputs(&mut self, inputs: &[u8]);
    /// Of poll.
    fn outputs(&self) -> &[u8];
}

impl Full {
    pub(crate) fn new(inputs: &[u8], outputs: usize) -> Self {
        let outputs = [vec![0; outputs], vec![0], Vec::new(), vec![0; 1]];
        Self { device: device(), inputs: inputs.to_vec(), outputs }
    }
}

impl Application for Full {
    const IO: AllocationChoice = AllocationChoice::all();
    type Long = Fragmented<448>;

    fn identity(&self) -> Identity<'_> {
        Identity::new(&self.device)
    }

    fn produced(&self, connection: IoKind) -> &[u8] {
        let most = if connection == IoKind::BitStrobe { 8 } else { self.inputs.len() };
        &self.inputs[..most.min(self.inputs.len())]
    }

    fn consumed(&mut self, connection: IoKind) -> &mut [u8] {
        let at = IoKind::ALL.iter().position(|&kind| kind == connection).expect("one of them");
        &mut self.outputs[at]
    }
}

impl Application for Odd {
    const IO: AllocationChoice = AllocationChoice::POLL;
    type Long = ();

    fn identity(&self) -> Identity<'_> {
        self.0.identity()
    }

    fn objects(&mut self) -> impl ObjectSet {
        (Probe,)
    }

    fn produced(&self, connection: IoKind) -> &[u8] {
        self.0.produced(connection)
    }

    fn consumed(&mut self, connection: IoKind) -> &mut [u8] {
        self.0.consumed(connection)
    }
}

impl Object for Probe {
    const CLASS: ClassId = ClassId(0x64);

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        const RULES: &[AttributeRule] = &[
            AttributeRule::get(1, 64),
            AttributeRule::get_set(2, 1),
            AttributeRule::get_set(3, 1),
            AttributeRule::get(4, 11),
            AttributeRule::get(5, 63),
        ];
        (instance.0 == 1).then_some(RULES)
    }

    fn get(&self, _: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        let length = match attribute.0 {
            1 => 64,
            4 => 11,
            5 => 63,
            _ => 1,
        };
        Ok(out.bytes(&[0xEE; 64][..length])?)
    }

    fn set(
        &mut self,
        _: InstanceId,
        attribute: AttributeId,
        _: &[u8],
        _: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        Err(match attribute.0 {
            2 => GeneralStatus::DEVICE_STATE_CONFLICT.into(),
            _ => GeneralStatus::STORE_OPERATION_FAILURE.into(),
        })
    }
}

impl Data for Odd {
    fn set_inputs(&mut self, inputs: &[u8]) {
        self.0.set_inputs(inputs);
    }

    fn outputs(&self) -> &[u8] {
        self.0.outputs()
    }
}

impl<const IN: usize, const OUT: usize> Data for Block<IN, OUT> {
    fn set_inputs(&mut self, inputs: &[u8]) {
        self.inputs.copy_from_slice(inputs);
    }

    fn outputs(&self) -> &[u8] {
        &self.outputs
    }
}

impl Data for Full {
    fn set_inputs(&mut self, inputs: &[u8]) {
        self.inputs.copy_from_slice(inputs);
    }

    fn outputs(&self) -> &[u8] {
        &self.outputs[0]
    }
}

pub(crate) fn device() -> DeviceIdentity {
    DeviceIdentity {
        vendor: VendorId(0x03E7),
        device_type: DeviceType::GENERAL_PURPOSE_DISCRETE_IO,
        product_code: 0x2A,
        revision: Revision::new(1, 1).expect("not zero"),
        serial: 0x1122_3344,
        name: ProductName::new("Example Block 2I1O").expect("short"),
    }
}
