//! What happens to a node, as expectations name it.

use crate::scenario::{EventName, What};

/// Something that happens to a node, and what it is about.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::simulate) struct Happening {
    pub(in crate::simulate) event: EventName,
    /// The slave of a master.
    pub(in crate::simulate) slave: Option<u8>,
    /// By instance.
    pub(in crate::simulate) connection: Option<u8>,
    /// The same of a DeviceNeX node.
    pub(in crate::simulate) nex_connection: Option<u16>,
    /// The planned device of a manager, by its operational address.
    pub(in crate::simulate) device: Option<u8>,
}

impl From<EventName> for Happening {
    fn from(event: EventName) -> Self {
        Self { event, slave: None, connection: None, nex_connection: None, device: None }
    }
}

impl Happening {
    pub(super) fn of_slave(event: EventName, slave: u8) -> Self {
        Self { slave: Some(slave), ..event.into() }
    }

    pub(super) fn on(event: EventName, connection: u8) -> Self {
        Self { connection: Some(connection), ..event.into() }
    }

    /// Whether it is the event that is expected.
    pub(in crate::simulate) fn is(self, what: &What) -> bool {
        what.event == Some(self.event)
            && (self.slave.is_none() || what.slave.is_none() || what.slave == self.slave)
            && (self.device.is_none() || what.device.is_none() || what.device == self.device)
            && match (self.connection, what.connection) {
                (Some(own), Some(wanted)) => own == wanted.instance(),
                _ => true,
            }
            && match (self.nex_connection, what.nex_connection) {
                (Some(own), Some(wanted)) => wanted.is(own),
                _ => true,
            }
    }
}
