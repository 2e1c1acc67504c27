//! The device behind a simulated DeviceNeX device: input data that a scenario sets, and outputs that it keeps.

use std::collections::{BTreeMap, BTreeSet};

use cip_core::code::{AttributeId, ClassId, GeneralStatus, InstanceId};
use cip_core::codec::Writer;
use cip_core::connection::End;
use cip_core::identity::DeviceIdentity;
use cip_core::object::{AttributeRule, Effect, Effects, Failure, Identity, Object, ObjectSet, Resets, Size};
use devicenex_core::device::{Application, Fragmented, Offer};
use devicenex_core::message::{ConnectionInstance, Predefined, Production};

use crate::scenario::DeviceNode;

/// A device of the sizes that a scenario gives.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Block {
    identity: DeviceIdentity,
    /// What it sends on every connection that produces.
    pub(super) input: Vec<u8>,
    /// What it has received, by instance.
    outputs: BTreeMap<u16, Vec<u8>>,
    /// The connections that are established: they alone write their outputs.
    owners: BTreeSet<u16>,
    consume: usize,
}

impl Block {
    pub(super) fn new(node: &DeviceNode) -> Self {
        Self {
            identity: node.node.device.clone(),
            input: node.input.clone(),
            outputs: BTreeMap::new(),
            owners: BTreeSet::new(),
            consume: node.consume.into(),
        }
    }

    pub(super) fn output(&self, connection: ConnectionInstance) -> &[u8] {
        self.outputs.get(&connection.number().0).map(Vec::as_slice).unwrap_or_default()
    }

    /// While a connection owns its outputs, they cannot be set by explicit messages.
    pub(super) fn own(&mut self, connection: ConnectionInstance, is_owned: bool) {
        let number = connection.number().0;
        if is_owned {
            self.owners.insert(number);
        } else {
            self.owners.remove(&number);
        }
    }
}

impl Application for Block {
    type Long = Fragmented<448>;

    fn offered(&self) -> Offer {
        let mut offer = Offer::all();
        offer.set(Offer::MULTICAST_CONSUMER, self.consume > 0);
        for produced in [Offer::BROADCAST, Offer::MULTICAST_PRODUCER, Offer::CHANGE_OF_STATE, Offer::CYCLIC] {
            offer.set(produced, !self.input.is_empty());
        }
        offer
    }

    fn identity(&self) -> Identity<'_> {
        Identity { resets: Resets::OUT_OF_BOX | Resets::KEEP_COMMUNICATION, ..Identity::new(&self.identity) }
    }

    fn objects(&mut self) -> impl ObjectSet {
        (Assemblies(self),)
    }

    fn assembly(&self, connection: ConnectionInstance, end: End) -> Option<InstanceId> {
        match end {
            End::Produced => (!self.produced(connection).is_empty()).then_some(InstanceId(INPUT)),
            End::Consumed if consumes(connection) => output_assembly(connection.number()),
            End::Consumed => None,
        }
    }

    fn produced(&self, connection: ConnectionInstance) -> &[u8] {
        if produces(connection) { &self.input } else { &[] }
    }

    fn consumed(&mut self, connection: ConnectionInstance) -> &mut [u8] {
        let size = if consumes(connection) { self.consume } else { 0 };
        self.outputs.entry(connection.number().0).or_insert_with(|| vec![0; size])
    }
}

/// The Assembly object of a device. Outputs are set by explicit messages as long as their connection is not established.
///
/// | Instance | Data |
/// |---|---|
/// | 100 | the input data |
/// | 152, 153 | the outputs of the polled connections, with 11 and 29 bits |
/// | 162, 163 | those of the multicast connections that consume |
struct Assemblies<'a>(&'a mut Block);

/// The connection whose outputs an assembly has.
pub(super) fn connection_of_assembly(instance: InstanceId) -> Option<ConnectionInstance> {
    Some(ConnectionInstance::of(InstanceId(instance.0.checked_sub(OUTPUTS)?)))
}

impl Assemblies<'_> {
    fn data(&self, instance: InstanceId) -> Option<&[u8]> {
        if instance.0 == INPUT {
            return (!self.0.input.is_empty()).then_some(&self.0.input);
        }
        self.0
            .outputs
            .get(&instance.0.checked_sub(OUTPUTS)?)
            .map(Vec::as_slice)
            .filter(|data| !data.is_empty())
    }
}

impl Object for Assemblies<'_> {
    const CLASS: ClassId = ClassId::ASSEMBLY;
    const REVISION: u16 = 2;

    fn attributes(&self, instance: InstanceId) -> Option<&'static [AttributeRule]> {
        const READ: &[AttributeRule] = &[AttributeRule::get(3, 0).sized(Size::Any), AttributeRule::get(4, 2)];
        const WRITTEN: &[AttributeRule] =
            &[AttributeRule::get_set(3, 0).sized(Size::Any), AttributeRule::get(4, 2)];
        self.data(instance).map(|_| if instance.0 == INPUT { READ } else { WRITTEN })
    }

    /// The input data cannot be set; they are not without the service.
    fn has_set(&self, instance: InstanceId) -> bool {
        !instance.is_class()
    }

    fn next_instance(&self, instance: InstanceId) -> Option<InstanceId> {
        (instance.0 + 1..=OUTPUTS + LAST_PREDEFINED).map(InstanceId).find(|next| self.data(*next).is_some())
    }

    fn get(&self, instance: InstanceId, attribute: AttributeId, out: &mut Writer<'_>) -> Result<(), Failure> {
        let data = self.data(instance).unwrap_or_default();
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
        let number = instance.0.saturating_sub(OUTPUTS);
        let Some(outputs) = self.0.outputs.get_mut(&number) else {
            return Err(GeneralStatus::OBJECT_DOES_NOT_EXIST.into());
        };
        Size::Bytes(outputs.len() as u16).check(value)?;
        if self.0.owners.contains(&number) {
            return Err(GeneralStatus::OBJECT_STATE_CONFLICT.into());
        }
        outputs.copy_from_slice(value);
        Ok(Effect::ASSEMBLY_DATA.into())
    }
}

/// That of a connection of the predefined set; dynamic ones have none.
fn output_assembly(connection: InstanceId) -> Option<InstanceId> {
    (connection.0 <= LAST_PREDEFINED).then(|| InstanceId(OUTPUTS + connection.0))
}

const fn produces(connection: ConnectionInstance) -> bool {
    !matches!(
        connection,
        ConnectionInstance::Predefined(Predefined::Implicit(Production::MulticastConsumer, _))
    )
}

const fn consumes(connection: ConnectionInstance) -> bool {
    match connection {
        ConnectionInstance::Predefined(Predefined::Implicit(production, _)) => {
            matches!(production, Production::Polled | Production::MulticastConsumer)
        }
        ConnectionInstance::Dynamic(_) => true,
        ConnectionInstance::Predefined(Predefined::Explicit) | ConnectionInstance::Reserved(_) => false,
    }
}

const INPUT: u16 = 100;
/// The instance of the outputs of a connection is its number and this.
const OUTPUTS: u16 = 150;
const LAST_PREDEFINED: u16 = 13;
