//! The manager as a node: it answers others about itself.

use cip_core::identity::DeviceIdentity;
use cip_core::object::Identity;

use crate::device::{Application, Device, Offer};
use crate::message::ConnectionInstance;

/// The node that a manager is: network access, and the objects Identity, link object and Connection, for whoever asks without
/// a connection or over an explicit one. It has no I/O of its own.
pub(super) type OwnNode = Device<Principal, OWN_MESSAGE, OWN_CONNECTIONS>;

/// Who the manager is.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Principal {
    pub(super) device: DeviceIdentity,
}

impl Application for Principal {
    type Long = ();

    fn offered(&self) -> Offer {
        Offer::empty()
    }

    fn identity(&self) -> Identity<'_> {
        Identity::new(&self.device)
    }

    fn produced(&self, _: ConnectionInstance) -> &[u8] {
        &[]
    }

    fn consumed(&mut self, _: ConnectionInstance) -> &mut [u8] {
        &mut []
    }
}

/// The longest explicit message to and from the manager's own objects.
const OWN_MESSAGE: usize = 64;
/// How many clients can ask the manager at once.
const OWN_CONNECTIONS: usize = 2;
