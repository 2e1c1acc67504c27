//! What the application asks of the node, and what it can ask about it.

use core::time::Duration;

use link_core::Instant;

use super::config::Config;
use super::event::NodeCounters;
use super::machine::{ControlledNode, Request};
use crate::NodeId;
use crate::cycle::CycleState;
use crate::dictionary::{Dictionary, ObjectSet};
use crate::nmt::{Cause, NmtState};
use crate::wire::{EntryType, ErrorEntry, NetTime, NmtCommandId};

/// Why a command of the application was not followed.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NodeError {
    /// The state does not allow it.
    #[error("not possible in {0}")]
    State(NmtState),
    /// The command needs a list of nodes, which a request does not carry.
    #[error("{0} needs a list of nodes: ask for {plain} of each node", plain = .0.plain())]
    Extended(NmtCommandId),
    /// Too many requests wait already.
    #[error("too many NMT requests wait for an invitation: try again after the next SoA")]
    Full,
    /// An entry of mode 0 ends a list of errors: what is behind it would not be read, and it is none itself.
    #[error("an error entry of type 0x{:04X} ends a list: its mode (bits 13-12) is 1 for an active error, 2 for one that is over, 3 for an event", .0.0)]
    EndOfList(EntryType),
}

impl<O: ObjectSet, const PRES: usize, const SDO: usize> ControlledNode<O, PRES, SDO> {
    /// Power is on.
    pub fn power_on(&mut self, now: Instant) {
        self.timers.advance(now);
        self.cause(Cause::PowerOn);
    }

    /// Starts anew, as after a power cycle.
    pub fn reset(&mut self, now: Instant) {
        self.timers.advance(now);
        self.cause(Cause::LocalReset);
    }

    /// Stops for good: nothing is sent until [`power_on`](Self::power_on).
    pub fn switch_off(&mut self, now: Instant) {
        self.timers.advance(now);
        self.cause(Cause::SwitchOff);
    }

    /// The application is ready to operate. It is asked for in `PreOperational2`, each time that state is entered, where
    /// [`Readiness`](super::Readiness) says so.
    ///
    /// # Errors
    /// In any other state.
    pub fn ready(&mut self, now: Instant) -> Result<(), NodeError> {
        self.timers.advance(now);
        let state = self.nmt.state();
        if self.cause(Cause::ApplicationReady) { Ok(()) } else { Err(NodeError::State(state)) }
    }

    /// Asks the managing node for a plain NMT command; it is sent when the managing node invites it. A reset of the node drops
    /// what waits.
    ///
    /// # Errors
    /// Outside of POWERLINK mode, for commands with a list of nodes, and while too many wait.
    pub fn request_command(&mut self, command: NmtCommandId, target: NodeId) -> Result<(), NodeError> {
        let state = self.nmt.state();
        if !state.is_powerlink_mode() {
            return Err(NodeError::State(state));
        }
        if command.is_extended() {
            return Err(NodeError::Extended(command));
        }
        self.requests.push(Request { command, target }).map_err(|_| NodeError::Full)
    }

    /// An error of the application: into the history, and to the managing node.
    ///
    /// # Errors
    /// For an entry that [ends a list](EntryType::is_terminator).
    pub fn report_error(&mut self, now: Instant, entry: ErrorEntry) -> Result<(), NodeError> {
        self.timers.advance(now);
        if entry.kind.is_terminator() {
            return Err(NodeError::EndOfList(entry.kind));
        }
        self.log(entry);
        Ok(())
    }

    /// Whether the inputs may be used: else the PRes says so (RD), in `Operational` too. They may, until this is said.
    pub const fn set_inputs_valid(&mut self, are_valid: bool) {
        self.are_inputs_valid = are_valid;
    }

    /// Sets the error register (0x1001). NMTResetCommunication and deeper resets set it to 0.
    pub const fn set_error_register(&mut self, register: u8) {
        self.dictionary.error_register = register;
    }

    /// Sets the six bytes of the device in the static error bit field. GT1, GT2 and GT8 (power, a local reset, NMTSwReset) set them
    /// to 0; NMTResetNode, NMTResetCommunication and NMTResetConfiguration leave them as they are.
    pub fn set_static_errors(&mut self, errors: [u8; 6]) {
        if let Some(own) = self.static_errors.last_chunk_mut() {
            *own = errors;
        }
    }

    /// The NMT state.
    #[must_use]
    pub const fn state(&self) -> NmtState {
        self.nmt.state()
    }

    /// Where it is in the cycle.
    #[must_use]
    pub const fn cycle_state(&self) -> CycleState {
        self.cycle.state()
    }

    /// What it was told at the start.
    #[must_use]
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// The standard objects.
    #[must_use]
    pub const fn dictionary(&self) -> &Dictionary {
        &self.dictionary
    }

    /// The objects of the application.
    #[must_use]
    pub const fn objects(&self) -> &O {
        &self.objects
    }

    /// The objects of the application, to be changed: inputs are taken from them at each SoC.
    pub const fn objects_mut(&mut self) -> &mut O {
        &mut self.objects
    }

    /// The time of day in the last SoC of the cycle.
    #[must_use]
    pub const fn net_time(&self) -> NetTime {
        self.net_time
    }

    /// RelativeTime of the last SoC of the cycle: µs since the managing node started.
    #[must_use]
    pub const fn relative_time(&self) -> u64 {
        self.relative_time
    }

    /// Whether the error indicator is lit.
    #[must_use]
    pub const fn error_led(&self) -> bool {
        self.error_led
    }

    /// What it counted.
    #[must_use]
    pub const fn counters(&self) -> &NodeCounters {
        &self.counters
    }

    /// Sets all that it [counted](Self::counters) to 0; the error counters of the dictionary stay.
    pub fn clear_counters(&mut self) {
        self.counters = NodeCounters::default();
    }

    /// Moves every instant that the machine stores towards zero, so that a model checker can compare histories of different
    /// age.
    pub fn shift_time(&mut self, span: Duration) {
        self.timers.shift(span);
    }
}
