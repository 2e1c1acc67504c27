//! The master as a node: it answers others about itself.

use cip_core::identity::DeviceIdentity;
use cip_core::message::AllocationChoice;
use cip_core::object::Identity;

use crate::slave::{Application, IoKind, Slave};

/// The node that a master is: network access, and the objects Identity, DeviceNet and Connection for clients that open a
/// connection through the UCMM. It has no I/O of its own.
pub(super) type OwnNode = Slave<Scanner, OWN_MESSAGE, OWN_CONNECTIONS>;

/// Who the master is.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Scanner {
    pub(super) device: DeviceIdentity,
}

impl Application for Scanner {
    const IO: AllocationChoice = AllocationChoice::empty();
    type Long = ();

    fn identity(&self) -> Identity<'_> {
        Identity::new(&self.device)
    }

    fn produced(&self, _: IoKind) -> &[u8] {
        &[]
    }

    fn consumed(&mut self, _: IoKind) -> &mut [u8] {
        &mut []
    }
}

/// The longest explicit message to and from the master's own objects.
const OWN_MESSAGE: usize = 64;
/// How many clients can ask the master at once.
const OWN_CONNECTIONS: usize = 2;
