//! A faulted node in the offline connection set: who it is, where it is, and another MAC ID for it.
//!
//! | 0x7ED, while a duplicate keeps the node off line | Reaction |
//! |---|---|
//! | Who that means the node | Who response after the delay that the request asks for; a new Who restarts the delay |
//! | Identify, short, that means the node | Identify response |
//! | Identify, long, with the node's vendor and serial | the indicator flashes red and green; Identify response |
//! | Change_MAC_ID with the node's vendor and serial | a new start with the new MAC ID, or with the old one if switches set it; no response |
//! | malformed, or a reserved bit set | nothing but a counter and an event |
//!
//! The node does not ask who owns the set. Source: CIP Vol. 3, offline connection set; ICP DAS I-7242D manual p. 93.

use cip_core::codec::Writer;

use super::Access;
use super::config::{MacIdSource, MaskPredicate};
use super::extent::Extent;
use super::machine::Timer;
use super::pending::{Heard, Pending};
use super::state::{Cause, State, WhoAnswer};
use crate::id::{Identifier, MacId};
use crate::message::{
    ChangeMacIdRequest, CommunicationFaultedRequest, DelayOffset, NodeSelection, WhoRequest, WhoResponse,
    Wire,
};

impl Access {
    pub(super) fn communication_faulted<P: Extent>(&mut self, data: &[u8]) {
        let Ok(request) = CommunicationFaultedRequest::parse(data) else {
            let kept = self.hear::<P>(|| Heard::malformed(Identifier::COMMUNICATION_FAULTED_REQUEST, data));
            return self.bad_frame::<P>(kept);
        };
        match request {
            CommunicationFaultedRequest::Who(WhoRequest { nodes, delay_offset }) if self.is_meant(nodes) => {
                self.delay_who(delay_offset);
            }
            CommunicationFaultedRequest::Identify(request) if self.is_meant(request.nodes) => {
                self.answer_identify(request.nodes);
            }
            CommunicationFaultedRequest::IdentifyDevice(request) if request.device == self.config.device => {
                self.answer_identify(NodeSelection::ALL);
                self.begin_identify::<P>();
            }
            CommunicationFaultedRequest::ChangeMacId(request) if request.device == self.config.device => {
                self.change_mac_id::<P>(request);
            }
            // For another node.
            CommunicationFaultedRequest::Who(_)
            | CommunicationFaultedRequest::Identify(_)
            | CommunicationFaultedRequest::IdentifyDevice(_)
            | CommunicationFaultedRequest::ChangeMacId(_) => {}
        }
    }

    pub(super) fn who_delay_over(&mut self) {
        if let State::CommFault { offline, .. } = &mut self.state {
            offline.who = WhoAnswer::Due;
        }
    }

    /// The time is over, or the node leaves the fault.
    pub(super) fn end_identify<P: Extent>(&mut self) {
        if let State::CommFault { offline, .. } = &mut self.state
            && core::mem::take(&mut offline.indicating)
        {
            self.raise::<P>(Pending::Identify { on: false });
        }
    }

    fn is_meant(&self, nodes: NodeSelection) -> bool {
        is_selected(self.mac_id, nodes, self.config.mask_predicate)
    }

    /// The delay is what one byte of the response says, so that nodes answer at different times.
    fn delay_who(&mut self, offset: DelayOffset) {
        let response = WhoResponse { port: self.config.port, device: self.config.device };
        let units = byte_of(&response, offset);
        let State::CommFault { offline, .. } = &mut self.state else { return };
        offline.who = WhoAnswer::Delayed;
        let millis = u32::from(units).saturating_mul(self.config.who_delay_unit.into());
        self.timers.set_after_millis(Timer::DupMacOrWho, millis);
    }

    fn answer_identify(&mut self, nodes: NodeSelection) {
        if let State::CommFault { offline, .. } = &mut self.state {
            offline.identify = Some(nodes);
        }
    }

    fn begin_identify<P: Extent>(&mut self) {
        let State::CommFault { offline, .. } = &mut self.state else { return };
        let began = !core::mem::replace(&mut offline.indicating, true);
        self.timers.set_after_millis(Timer::BackOffOrIdentify, self.config.identify_timeout);
        if began {
            self.raise::<P>(Pending::Identify { on: true });
        }
    }

    fn change_mac_id<P: Extent>(&mut self, request: ChangeMacIdRequest) {
        match self.config.mac_id_source {
            MacIdSource::Software => {
                let from = core::mem::replace(&mut self.mac_id, request.mac);
                self.raise::<P>(Pending::MacIdAssigned { from, to: request.mac });
            }
            MacIdSource::Switches => self.raise::<P>(Pending::MacIdLocked { requested: request.mac }),
        }
        self.restart::<P>(Cause::MacIdAssigned);
    }
}

const fn is_selected(mac: MacId, nodes: NodeSelection, predicate: MaskPredicate) -> bool {
    match (nodes, predicate) {
        (NodeSelection::MacId(meant), _) => meant.number() == mac.number(),
        (NodeSelection::Mask(mask), MaskPredicate::Subset) => mac.number() & !mask.bits() == 0,
        (NodeSelection::Mask(mask), MaskPredicate::Intersects) => mac.number() & mask.bits() != 0,
    }
}

fn byte_of(response: &WhoResponse, offset: DelayOffset) -> u8 {
    let mut bytes = [0; 7];
    // The response has exactly that length.
    let written = response.emit(&mut Writer::new(&mut bytes));
    debug_assert!(written.is_ok(), "a Who response has seven bytes");
    bytes.get(usize::from(offset.number())).copied().unwrap_or_default()
}
