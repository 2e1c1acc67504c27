//! What the node must hand to the controller, and may.

use link_core::Frame;

use super::state::{Controller, Fault, Kind, Sending, State};
use super::{Model, own_bytes};

impl Model {
    /// What must be handed to the controller now.
    pub(in crate::dn_access) fn wants(&self) -> Vec<Kind> {
        if self.in_flight.is_some() {
            return Vec::new();
        }
        match self.state {
            State::Sending { controller: Controller::Ready, .. } => vec![Kind::CheckRequest],
            State::OnLine { pause: Some(_), .. } => Vec::new(),
            State::OnLine { answer_due: true, .. } => vec![Kind::CheckResponse],
            State::OnLine { second: Sending::Due, .. } => vec![Kind::CheckRequest],
            State::Faulted(Fault::Duplicate { who, identify, .. }) => {
                let who = (who == Sending::Due).then_some(Kind::WhoResponse);
                who.into_iter().chain(identify.map(Kind::IdentifyResponse)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Whether the machine must restart the controller now.
    pub(in crate::dn_access) fn restart_due(&mut self) -> Option<&mut bool> {
        match &mut self.state {
            State::Sending { controller: Controller::Restarting { commanded }, .. } if !*commanded => {
                Some(commanded)
            }
            _ => None,
        }
    }

    /// The machine hands this to the controller. Panics if it must not.
    pub(in crate::dn_access) fn transmit(&mut self, frame: &Frame) {
        let wants = self.wants();
        let kind = wants.iter().copied().find(|&kind| self.frame_of(kind) == *frame);
        let kind = kind.unwrap_or_else(|| panic!("{frame} in {:?}, which wants {wants:?}", self.state));
        self.in_flight = Some((kind, true));
        match (kind, &mut self.state) {
            (Kind::CheckResponse, State::OnLine { answer_due, .. }) => *answer_due = false,
            (Kind::WhoResponse, State::Faulted(Fault::Duplicate { who, .. })) => *who = Sending::Nothing,
            (Kind::IdentifyResponse(_), State::Faulted(Fault::Duplicate { identify, .. })) => {
                *identify = None
            }
            _ => {}
        }
    }

    /// 2.1 and 2.9.2: the bytes of what a node sends.
    fn frame_of(&self, kind: Kind) -> Frame {
        let mut check = own_bytes();
        let (id, data): (u32, &[u8]) = match kind {
            Kind::CheckRequest => (self.own_check(), &check),
            Kind::CheckResponse => {
                check[0] |= 0x80;
                (self.own_check(), &check)
            }
            Kind::WhoResponse => (0x7EC, &check),
            Kind::IdentifyResponse(head) => (0x7EC, &[head, 0xCC]),
        };
        Frame::new(link_core::frame::standard_id(id as u16), data).expect("at most eight bytes")
    }
}
