//! A short way for what a slave is asked most: Get_Attribute_Single of an attribute that fits into one frame.
//!
//! | Object | Instance | Attributes |
//! |---|---|---|
//! | Identity | 1 | 1 to 6 |
//! | DeviceNet | 1 | 1 to 5 |
//! | Connection | 1 to 5, where it exists | 1 (state), 9 (expected packet rate) |
//!
//! Everything else, every refusal among it, goes the way of all requests, and so does a request while something is in
//! progress. The answer is the same on both ways.

use cip_core::code::{AttributeId, ClassId, InstanceId, ServiceCode};
use cip_core::connection::{ConnectionState, ExplicitState, IoState, Settings};

use super::application::{Application, IoKind};
use super::event::count;
use super::machine::Slave;
use super::node::Node;
use crate::message::ExplicitHeader;

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Slave<A, MESSAGE, DYNAMIC> {
    /// True if the data field was such a request, and is answered; otherwise nothing has happened.
    #[inline]
    pub(super) fn fast_get(&mut self, field: &[u8]) -> bool {
        let &[byte, GET, class, instance, attribute] = field else { return false };
        if !self.is_free_for(ExplicitHeader::from(byte)) {
            return false;
        }
        let class = ClassId(class.into());
        let Some(len) = self.fast_value(class, instance, AttributeId(attribute.into())) else { return false };
        self.explicit.respond_whole(byte, len);
        count::<A>(&mut self.node.events.counters.requests);
        self.node.explicit_message();
        true
    }

    /// The header is that of a whole message of the master, whose connection is established and has nothing in progress.
    #[inline]
    fn is_free_for(&self, header: ExplicitHeader) -> bool {
        !header.fragmented
            && Some(header.mac) == self.node.master
            && self.node.explicit.state() == ExplicitState::Established
            && self.node.departure.is_none()
            && self.explicit.is_idle()
    }

    /// Writes the response, and says how long it is.
    #[inline]
    fn fast_value(&mut self, class: ClassId, instance: u8, attribute: AttributeId) -> Option<usize> {
        let mut out = self.explicit.writer();
        out.u8(ServiceCode(GET).response_byte()).ok()?;
        match (class, instance, attribute.0) {
            (ClassId::IDENTITY, 1, 1..=6) => {
                self.node.identity().emit_attribute(attribute, &mut out).ok()?;
            }
            (ClassId::DEVICENET, 1, 1..=5) => {
                self.node.emit_mandatory(attribute, &mut out).ok()?;
            }
            (ClassId::CONNECTION, _, 1 | 9) => {
                let (state, settings) = connection(&self.node, instance)?;
                if attribute.0 == 1 { out.u8(state.0) } else { out.u16(settings.expected_packet_rate()) }
                    .ok()?;
            }
            _ => return None,
        }
        Some(out.len())
    }
}

/// State and settings of an instance of the predefined set, if it exists.
#[inline]
fn connection<A: Application, const DYNAMIC: usize>(
    node: &Node<A, DYNAMIC>,
    instance: u8,
) -> Option<(ConnectionState, &Settings)> {
    if instance == 1 {
        return Some((node.explicit.state().into(), node.explicit.settings()));
    }
    let kind = IoKind::of_instance(InstanceId(instance.into()))?.offered::<A>()?;
    let connection = node.io(kind);
    (connection.state() != IoState::NonExistent).then(|| (connection.state().into(), connection.settings()))
}

const GET: u8 = ServiceCode::GET_ATTRIBUTE_SINGLE.0;
