//! What is read from the instances of the Connection object.

use cip_core::connection::{
    CommCharacteristics, ConnectionPath, ConnectionState, ConnectionView, ExplicitConnection, InstanceType,
    PredefinedConnection, Settings, TransportClassTrigger,
};
use cip_core::message::AllocationChoice;

use super::application::{Application, End, IoKind};
use super::connection_object::{ConnectionObject, Which};
use super::dynamic::Dynamic;
use super::lines;
use super::machine::changes;
use super::node::Node;
use crate::id::{Identifier, MacId};

/// An instance that is read.
pub(super) struct Instance<'o, 's, 'a, A: Application, const MESSAGE: usize, const DYNAMIC: usize> {
    pub(super) object: &'o ConnectionObject<'s, 'a, A, MESSAGE, DYNAMIC>,
    pub(super) which: Which,
    /// Attribute 8, if it is for I/O.
    pub(super) consumed_size: usize,
}

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Instance<'_, '_, '_, A, MESSAGE, DYNAMIC> {
    fn node(&self) -> &Node<A, DYNAMIC> {
        self.object.server.node
    }

    fn mac(&self) -> MacId {
        self.object.server.node.access.mac_id()
    }

    fn explicit(&self) -> &ExplicitConnection {
        match self.which {
            Which::Dynamic(index) => self.dynamic(index).map_or(&self.node().explicit, |one| &one.connection),
            Which::Explicit | Which::Io(_) => &self.node().explicit,
        }
    }

    fn dynamic(&self, index: u8) -> Option<&Dynamic> {
        self.node().dynamic.get(usize::from(index))
    }

    fn path(&self, kind: IoKind, end: End) -> ConnectionPath {
        let assembly = self.object.server.node.application.assembly(kind, end);
        assembly.map_or(ConnectionPath::Empty, ConnectionPath::Assembly)
    }

    /// One that a client opened is as the explicit one of the predefined set.
    fn kind(&self) -> PredefinedConnection {
        match self.which {
            Which::Explicit | Which::Dynamic(_) => PredefinedConnection::Explicit,
            Which::Io(kind) => match kind.known::<A>() {
                IoKind::Poll if !changes::<A>() => PredefinedConnection::Poll,
                IoKind::BitStrobe => PredefinedConnection::BitStrobe,
                IoKind::MulticastPoll => PredefinedConnection::MulticastPoll,
                kind @ (IoKind::Poll | IoKind::ChangeOfState) => self.node().io(kind).kind(),
            },
        }
    }

    fn produces(&self) -> bool {
        self.kind() != PredefinedConnection::ConsumeOnly
    }

    fn consumes(&self) -> bool {
        !matches!(
            self.kind(),
            PredefinedConnection::ChangeOfState { acknowledged: false }
                | PredefinedConnection::Cyclic { acknowledged: false }
        )
    }
}

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> ConnectionView
    for Instance<'_, '_, '_, A, MESSAGE, DYNAMIC>
{
    type Id = u16;

    fn instance_type(&self) -> InstanceType {
        self.kind().instance_type()
    }

    fn transport_class_trigger(&self) -> TransportClassTrigger {
        self.kind().transport_class_trigger()
    }

    fn state(&self) -> ConnectionState {
        match self.which {
            Which::Explicit | Which::Dynamic(_) => self.explicit().state().into(),
            Which::Io(kind) => self.node().io(kind).state().into(),
        }
    }

    fn produced_id(&self) -> u16 {
        let own = self.mac();
        let id = match self.which {
            Which::Explicit => Some(Identifier::explicit_response(own)),
            Which::Io(kind) => {
                self.produces().then(|| lines::identifier::<A>(lines::of(kind.known::<A>()), own))
            }
            Which::Dynamic(index) => self.dynamic(index).and_then(|one| one.produced(own)),
        };
        id.map_or(NO_ID, Identifier::raw)
    }

    fn consumed_id(&self) -> u16 {
        let own = self.mac();
        let id = match self.which {
            Which::Explicit => Some(Identifier::explicit_request(own)),
            Which::Io(kind) => self.consumes().then(|| match kind.known::<A>() {
                IoKind::Poll => Identifier::poll_command(own),
                IoKind::BitStrobe => Identifier::bit_strobe_command(self.node().master.unwrap_or(MacId::MIN)),
                IoKind::ChangeOfState => Identifier::change_of_state_acknowledge(own),
                IoKind::MulticastPoll => Identifier::multicast_poll_command(self.node().group),
            }),
            Which::Dynamic(index) => self.dynamic(index).and_then(|one| one.consumed(own)),
        };
        id.map_or(NO_ID, Identifier::raw)
    }

    fn comm_characteristics(&self) -> CommCharacteristics {
        match self.which {
            Which::Dynamic(index) => {
                CommCharacteristics(self.dynamic(index).map_or(0, Dynamic::characteristics))
            }
            Which::Explicit | Which::Io(_) => self.kind().comm_characteristics(),
        }
    }

    fn produced_size(&self) -> u16 {
        match self.which {
            Which::Explicit | Which::Dynamic(_) => short(MESSAGE),
            // Instance 2 acknowledges without data where poll is not allocated.
            Which::Io(IoKind::Poll) if !self.node().held.contains(AllocationChoice::POLL) => 0,
            Which::Io(kind) if self.produces() => self.object.server.node.application.produced_size(kind),
            Which::Io(_) => 0,
        }
    }

    fn consumed_size(&self) -> u16 {
        short(match self.which {
            Which::Explicit | Which::Dynamic(_) => MESSAGE,
            Which::Io(_) => self.consumed_size,
        })
    }

    fn settings(&self) -> &Settings {
        match self.which {
            Which::Explicit | Which::Dynamic(_) => self.explicit().settings(),
            Which::Io(kind) => self.node().io(kind).settings(),
        }
    }

    fn produced_path(&self) -> ConnectionPath {
        match self.which {
            Which::Io(kind) if self.produces() => self.path(kind, End::Produced),
            Which::Io(_) | Which::Explicit | Which::Dynamic(_) => ConnectionPath::Empty,
        }
    }

    fn consumed_path(&self) -> ConnectionPath {
        match self.which {
            Which::Explicit | Which::Dynamic(_) => ConnectionPath::Empty,
            Which::Io(kind) => match kind.known::<A>() {
                IoKind::ChangeOfState if self.consumes() => ConnectionPath::AcknowledgeHandler,
                IoKind::ChangeOfState => ConnectionPath::Empty,
                kind @ (IoKind::Poll | IoKind::BitStrobe | IoKind::MulticastPoll) => {
                    self.path(kind, End::Consumed)
                }
            },
        }
    }
}

/// A size in an attribute.
fn short(size: usize) -> u16 {
    u16::try_from(size).unwrap_or(u16::MAX)
}

const NO_ID: u16 = 0xFFFF;
