//! What the application can ask of the tool.

use core::time::Duration;

use link_core::Instant;

use super::event::Counters;
use super::machine::OfflineTool;
use super::state::{Cause, Request, Sending, State, Task, ToolState};
use crate::access::{self, Access};
use crate::id::MacId;
use crate::message::{DelayOffset, DeviceIdentity, NodeSelection};

/// Why a command was not carried out.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CommandError {
    /// Only a node that is on line may ask for the set.
    #[error("the tool is not on line: wait for its network access")]
    NotOnLine,
    /// Only the owner may talk to faulted nodes.
    #[error("the offline connection set is not this tool's: claim it first")]
    NotOwner,
    /// One thing at a time.
    #[error("the tool waits for answers to its last message: wait for its event")]
    Busy,
    /// The device would be faulted again at once.
    #[error("MAC ID {0} is the tool's own: give the device another")]
    OwnMacId(MacId),
    /// Network access refuses it.
    #[error(transparent)]
    Access(#[from] access::CommandError),
}

impl OfflineTool {
    /// Asks for the offline connection set: two requests, two waits. Nothing happens if it is owned or asked for already.
    pub fn claim(&mut self, now: Instant) -> Result<(), CommandError> {
        self.timers.advance(now);
        if !self.access.is_online() {
            return Err(CommandError::NotOnLine);
        }
        if self.state == State::Idle {
            self.enter(State::Claiming { request: Request::First, sending: Sending::Due }, Cause::Claimed);
        }
        Ok(())
    }

    /// Gives the set up. There is no message for that: the tool ceases to answer other tools.
    pub fn release(&mut self, now: Instant) {
        self.timers.advance(now);
        if self.state != State::Idle {
            self.enter(State::Idle, Cause::Released);
        }
    }

    /// Asks every faulted node who it is. `delay_offset` says by which byte of their answers they spread them in time;
    /// with another one a second attempt finds those whose answers met.
    pub fn who(&mut self, now: Instant, delay_offset: DelayOffset) -> Result<(), CommandError> {
        self.begin(now, Task::Who(delay_offset))
    }

    /// Asks whether any of these nodes is there.
    pub fn identify(&mut self, now: Instant, nodes: NodeSelection) -> Result<(), CommandError> {
        self.begin(now, Task::Identify(nodes))
    }

    /// Makes one device flash its network status indicator.
    pub fn identify_device(&mut self, now: Instant, device: DeviceIdentity) -> Result<(), CommandError> {
        self.begin(now, Task::IdentifyDevice(device))
    }

    /// Gives a faulted device another MAC ID, and waits until it is on line with it.
    pub fn change_mac_id(
        &mut self,
        now: Instant,
        device: DeviceIdentity,
        mac: MacId,
    ) -> Result<(), CommandError> {
        if mac == self.access.mac_id() {
            return Err(CommandError::OwnMacId(mac));
        }
        self.begin(now, Task::ChangeMacId { device, mac, checks: 0 })
    }

    /// Starts anew, as after a power cycle: the way out of a fault of its own network access. The set is lost.
    pub fn reset(&mut self, now: Instant) {
        self.timers.advance(now);
        self.access.reset(now);
        self.follow_access();
    }

    /// Starts anew with another MAC ID. The set is lost.
    pub fn set_mac_id(&mut self, now: Instant, mac: MacId) -> Result<(), CommandError> {
        self.timers.advance(now);
        self.access.set_mac_id(now, mac)?;
        self.follow_access();
        Ok(())
    }

    fn begin(&mut self, now: Instant, task: Task) -> Result<(), CommandError> {
        self.timers.advance(now);
        match self.state {
            State::Idle | State::Claiming { .. } => Err(CommandError::NotOwner),
            State::Owner { task: Task::None, .. } => {
                self.turn_to(task);
                Ok(())
            }
            State::Owner { .. } => Err(CommandError::Busy),
        }
    }

    /// Whether the set is this tool's.
    #[must_use]
    pub const fn state(&self) -> ToolState {
        self.state.kind()
    }

    /// Its own network access.
    #[must_use]
    pub const fn access(&self) -> &Access {
        &self.access
    }

    /// What is counted.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Moves every stored moment `span` towards zero, so that states that differ in the time of day only are equal.
    pub fn shift_time(&mut self, span: Duration) {
        self.access.shift_time(span);
        self.timers.shift(span);
    }
}
