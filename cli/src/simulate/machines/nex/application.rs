//! The device behind a simulated DeviceNeX device: input data that a scenario sets, and outputs that it keeps.

use std::collections::BTreeMap;

use cip_core::identity::DeviceIdentity;
use cip_core::object::{Identity, Resets};
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
    consume: usize,
}

impl Block {
    pub(super) fn new(node: &DeviceNode) -> Self {
        Self {
            identity: node.node.device.clone(),
            input: node.input.clone(),
            outputs: BTreeMap::new(),
            consume: node.consume.into(),
        }
    }

    pub(super) fn output(&self, connection: ConnectionInstance) -> &[u8] {
        self.outputs.get(&connection.number().0).map(Vec::as_slice).unwrap_or_default()
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

    fn produced(&self, connection: ConnectionInstance) -> &[u8] {
        if produces(connection) { &self.input } else { &[] }
    }

    fn consumed(&mut self, connection: ConnectionInstance) -> &mut [u8] {
        let size = if consumes(connection) { self.consume } else { 0 };
        self.outputs.entry(connection.number().0).or_insert_with(|| vec![0; size])
    }
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
