//! The device behind the slaves of the suites.

use cip_core::identity::DeviceIdentity;
use cip_core::message::AllocationChoice;
use cip_core::object::{Identity, Resets};
use devicenet_core::slave::{Application, IoKind};

/// `IN` bytes in and `OUT` bytes out, by poll; it can be reset to what it was out of the box.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Block<const IN: usize, const OUT: usize> {
    /// Who it is.
    pub identity: DeviceIdentity,
    /// What it sends.
    pub inputs: [u8; IN],
    /// What it received.
    pub outputs: [u8; OUT],
}

impl<const IN: usize, const OUT: usize> Block<IN, OUT> {
    /// A device that sends this, and has received nothing.
    #[must_use]
    pub const fn new(identity: DeviceIdentity, inputs: [u8; IN]) -> Self {
        Self { identity, inputs, outputs: [0; OUT] }
    }
}

impl<const IN: usize, const OUT: usize> Application for Block<IN, OUT> {
    const IO: AllocationChoice = AllocationChoice::POLL;
    type Long = ();

    fn identity(&self) -> Identity<'_> {
        let mut identity = Identity::new(&self.identity);
        identity.resets = Resets::OUT_OF_BOX;
        identity
    }

    fn produced(&self, _: IoKind) -> &[u8] {
        &self.inputs
    }

    fn consumed(&mut self, _: IoKind) -> &mut [u8] {
        &mut self.outputs
    }
}
