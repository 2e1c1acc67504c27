//! The device behind a simulated slave: input data that a scenario sets, outputs that it keeps, and its assemblies.

use cip_core::code::{AttributeId, ClassId, GeneralStatus, InstanceId};
use cip_core::codec::Writer;
use cip_core::identity::DeviceIdentity;
use cip_core::message::AllocationChoice;
use cip_core::object::{AttributeRule, Effect, Effects, Failure, Identity, Object, ObjectSet, Resets, Size};
use devicenet_core::slave::{Application, End, Fragmented, IoKind};

use crate::scenario::{Sizes, SlaveNode};

/// A device of the sizes that a scenario gives.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(in crate::simulate) struct Device {
    identity: DeviceIdentity,
    offers: AllocationChoice,
    /// Of which each connection sends the first bytes.
    pub(super) input: Vec<u8>,
    /// How many each sends, in the order of the instances.
    produced: [usize; 4],
    outputs: [Vec<u8>; 4],
    /// Whose outputs a master has.
    owned: [bool; 4],
    configuration: [u8; CONFIGURATION],
}

impl Device {
    pub(super) fn new(node: &SlaveNode) -> Self {
        // What a master sends by change of state comes over instance 2.
        let consume = node.poll.consume.max(node.change_of_state.consume);
        let sizes = [
            Sizes { consume, ..node.poll },
            node.bit_strobe,
            Sizes { consume: 0, ..node.change_of_state },
            node.multicast_poll,
        ];
        Self {
            identity: node.access.device.clone(),
            offers: node.offers,
            input: node.input.clone(),
            produced: sizes.map(|size| size.produce.into()),
            outputs: sizes.map(|size| vec![0; size.consume.into()]),
            owned: [false; 4],
            configuration: [0; CONFIGURATION],
        }
    }

    pub(super) fn output(&self, connection: IoKind) -> &[u8] {
        &self.outputs[place(connection)]
    }

    /// While a master owns them, outputs cannot be set by explicit messages.
    pub(super) const fn own(&mut self, connection: IoKind, is_owned: bool) {
        self.owned[place(connection)] = is_owned;
    }

    /// The outputs in an assembly.
    fn outputs_of(&self, instance: InstanceId) -> Option<usize> {
        let index = usize::from(instance.0.checked_sub(FIRST_OUTPUT)?);
        self.outputs.get(index).filter(|output| !output.is_empty()).map(|_| index)
    }
}

impl Application for Device {
    const IO: AllocationChoice = AllocationChoice::all();
    type Long = Fragmented<448>;

    fn offered(&self) -> AllocationChoice {
        self.offers
    }

    fn identity(&self) -> Identity<'_> {
        Identity { resets: Resets::OUT_OF_BOX | Resets::KEEP_COMMUNICATION, ..Identity::new(&self.identity) }
    }

    fn objects(&mut self) -> impl ObjectSet {
        (Assemblies(self),)
    }

    fn produced(&self, connection: IoKind) -> &[u8] {
        self.input.get(..self.produced[place(connection)]).unwrap_or_default()
    }

    fn consumed(&mut self, connection: IoKind) -> &mut [u8] {
        &mut self.outputs[place(connection)]
    }

    fn assembly(&self, connection: IoKind, end: End) -> Option<InstanceId> {
        let place = place(connection);
        match end {
            End::Produced => (self.produced[place] == self.input.len()).then_some(InstanceId(INPUT)),
            End::Consumed => {
                let instance = InstanceId(FIRST_OUTPUT + place as u16);
                self.outputs_of(instance).map(|_| instance)
            }
        }
    }
}

/// The Assembly object of a device.
///
/// | Instance | Data |
/// |---|---|
/// | 100 | the input data |
/// | 150, 151, 153 | the outputs of poll, bit-strobe, multicast poll |
/// | 199 | 16 bytes of configuration, which are kept and mean nothing |
struct Assemblies<'a>(&'a mut Device);

impl Object for Assemblies<'_> {
    const CLASS: ClassId = ClassId::ASSEMBLY;
    const REVISION: u16 = 2;

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        const READ: &[AttributeRule] = &[AttributeRule::get(3, 0).sized(Size::Any), AttributeRule::get(4, 2)];
        const WRITTEN: &[AttributeRule] =
            &[AttributeRule::get_set(3, 0).sized(Size::Any), AttributeRule::get(4, 2)];
        match instance.0 {
            INPUT => Some(READ),
            SETTINGS => Some(WRITTEN),
            _ => self.0.outputs_of(instance).map(|_| WRITTEN),
        }
    }

    fn has_set(&self, instance: InstanceId) -> bool {
        !instance.is_class()
    }

    fn next_instance(&self, instance: InstanceId) -> Option<InstanceId> {
        (instance.0 + 1..=SETTINGS).map(InstanceId).find(|next| self.attributes(*next).is_some())
    }

    fn get(&self, instance: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        let data: &[u8] = match instance.0 {
            INPUT => &self.0.input,
            SETTINGS => &self.0.configuration,
            _ => self.0.outputs_of(instance).map_or(&[], |index| &self.0.outputs[index]),
        };
        match attribute.0 {
            3 => out.bytes(data)?,
            _ => out.u16(data.len() as u16)?,
        }
        Ok(())
    }

    fn set(
        &mut self,
        instance: InstanceId,
        _: AttributeId,
        value: &[u8],
        _: &mut Writer<'_>,
    ) -> Result<Effects, Failure> {
        let output = self.0.outputs_of(instance);
        let data = match output {
            Some(index) => self.0.outputs[index].as_mut_slice(),
            None => &mut self.0.configuration,
        };
        Size::Bytes(data.len() as u16).check(value)?;
        if output.is_some_and(|index| self.0.owned[index]) {
            return Err(GeneralStatus::OBJECT_STATE_CONFLICT.into());
        }
        data.copy_from_slice(value);
        Ok(Effect::ASSEMBLY_DATA.into())
    }
}

const fn place(connection: IoKind) -> usize {
    match connection {
        IoKind::Poll => 0,
        IoKind::BitStrobe => 1,
        IoKind::ChangeOfState => 2,
        IoKind::MulticastPoll => 3,
    }
}

const INPUT: u16 = 100;
const FIRST_OUTPUT: u16 = 150;
const SETTINGS: u16 = 199;
const CONFIGURATION: usize = 16;
