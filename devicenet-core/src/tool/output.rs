//! What a tool wants next: its filter, events, frames.

use link_core::{Action, Frame, Instant, LinkCommand, Machine, TxToken};

use super::event::ToolEvent;
use super::machine::{OfflineTool, Outgoing};
use super::state::{Sending, State, Task};
use crate::id::Identifier;
use crate::message::{
    self, ChangeMacIdRequest, DeviceIdentity, Direction, IdentifyDeviceRequest, IdentifyRequest,
    NodeSelection, OfflineOwnership, WhoRequest,
};

impl OfflineTool {
    pub(super) fn poll_access(&mut self, now: Instant) -> Option<Action<ToolEvent>> {
        let action = self.access.poll(now)?;
        if let Action::Link(LinkCommand::SetFilter(_)) = action {
            return self.take_filter();
        }
        Some(action.map_event(ToolEvent::Access))
    }

    pub(super) fn set_filter(&mut self) -> Option<Action<ToolEvent>> {
        if self.filter_due { self.take_filter() } else { None }
    }

    fn take_filter(&mut self) -> Option<Action<ToolEvent>> {
        self.filter_due = false;
        Some(Action::Link(LinkCommand::SetFilter(self.filter())))
    }

    pub(super) fn event(&mut self) -> Option<Action<ToolEvent>> {
        if self.events_lost != 0 {
            let lost = core::mem::take(&mut self.events_lost);
            return Some(Action::Event(ToolEvent::EventsLost(lost)));
        }
        if self.events.is_empty() { None } else { Some(Action::Event(self.events.remove(0))) }
    }

    pub(super) fn wanted(&self) -> Option<Outgoing> {
        if self.in_flight.is_some() || !self.on_line {
            return None;
        }
        if self.response_due {
            return Some(Outgoing::OwnershipResponse);
        }
        (self.state.sending() == Some(Sending::Due)).then_some(Outgoing::Message)
    }

    pub(super) fn transmit(&mut self) -> Option<Action<ToolEvent>> {
        let what = self.wanted()?;
        let frame = match what {
            Outgoing::OwnershipResponse => {
                self.response_due = false;
                self.ownership(Direction::Response)?
            }
            Outgoing::Message => {
                if let Some(sending) = self.state.sending_mut() {
                    *sending = Sending::HandedOut;
                }
                self.message()?
            }
            Outgoing::BackedOff | Outgoing::Abandoned => return None,
        };
        self.in_flight = Some(what);
        Some(Action::Transmit(TOKEN, frame))
    }

    fn message(&self) -> Option<Frame> {
        let request = Identifier::COMMUNICATION_FAULTED_REQUEST;
        match self.state {
            State::Idle => None,
            State::Claiming { .. } => self.ownership(Direction::Request),
            State::Owner { task, .. } => match task {
                Task::None => None,
                Task::Who(delay_offset) => {
                    message::frame(request, &WhoRequest { nodes: NodeSelection::ALL, delay_offset })
                }
                Task::Identify(nodes) => message::frame(request, &IdentifyRequest { nodes }),
                Task::IdentifyDevice(device) => message::frame(request, &IdentifyDeviceRequest { device }),
                Task::ChangeMacId { device, mac, .. } => {
                    message::frame(request, &ChangeMacIdRequest { mac, device })
                }
            },
        }
    }

    fn ownership(&self, direction: Direction) -> Option<Frame> {
        let id = match direction {
            Direction::Request => Identifier::OFFLINE_OWNERSHIP_REQUEST,
            Direction::Response => Identifier::OFFLINE_OWNERSHIP_RESPONSE,
        };
        let device: DeviceIdentity = self.config.access.device;
        message::frame(id, &OfflineOwnership { direction, client: self.access.mac_id(), device })
    }
}

/// The token of every frame of the tool beyond its network access.
pub(super) const TOKEN: TxToken = TxToken(1);
