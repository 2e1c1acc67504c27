//! What the master does with the frames of its slaves.

use core::time::Duration;

use cip_core::code::ServiceCode;
use cip_core::fragment::{IO_UNFRAGMENTED_LEN, IoOutcome};
use cip_core::message::Response;
use link_core::Frame;

use super::config::Config;
use super::event::SlaveEvent;
use super::machine::Master;
use super::scan_list::IoInstance;
use super::slot::{Slot, SlotTimer};
use super::state::{Cause, Stage};
use super::status::ScannerStatus;
use crate::client::Progress;
use crate::counter::{count, count_wide};
use crate::id::{Identifier, MacId, Purpose};
use crate::message::{Direction, ExplicitMessage, Heartbeat, Shutdown, Wire};

impl<const SLAVES: usize, const MESSAGE: usize> Master<SLAVES, MESSAGE> {
    pub(super) fn frame(&mut self, frame: &Frame) {
        let Some(id) = Identifier::of_frame(frame) else { return count_wide(&mut self.counters.unrelated) };
        let Some(slave) = id.mac_id() else { return count_wide(&mut self.counters.unrelated) };
        if !self.board.listed().contains(slave) {
            return self.frame_of_stranger(id, slave, frame);
        }
        match id.purpose() {
            Purpose::DuplicateMacCheck => self.check_heard(slave, frame.data()),
            _ if !self.on_line => {}
            Purpose::PollResponse => self.io(slave, IoInstance::Poll, frame.data()),
            Purpose::BitStrobeResponse => self.io(slave, IoInstance::BitStrobe, frame.data()),
            Purpose::ChangeOfState => self.io(slave, IoInstance::ChangeOfState, frame.data()),
            Purpose::MulticastPollResponse => self.io(slave, IoInstance::MulticastPoll, frame.data()),
            Purpose::ExplicitResponse | Purpose::UnconnectedResponse if self.broadcast(slave, frame) => {}
            Purpose::ExplicitResponse if self.is_others_allocation(frame) => {
                count_wide(&mut self.counters.unrelated);
                self.with_slot(slave, Slot::taken_over);
            }
            Purpose::PollCommand => {
                count_wide(&mut self.counters.unrelated);
                self.with_slot(slave, Slot::verify_owner);
            }
            _ => self.explicit_frame(slave, frame),
        }
    }

    /// A node outside of the scan list: of interest only as a replacement.
    fn frame_of_stranger(&mut self, id: Identifier, node: MacId, frame: &Frame) {
        let replaces = node == MacId::MAX && node != self.access().mac_id();
        if replaces && id.purpose() == Purpose::DuplicateMacCheck {
            self.candidate_heard(frame);
        } else if !(replaces && self.on_line && self.candidate_frame(frame)) {
            count_wide(&mut self.counters.unrelated);
        }
    }

    /// A slave that checks its MAC ID is on line one second after its second request.
    fn check_heard(&mut self, slave: MacId, data: &[u8]) {
        let Some(slot) = self.board.get_mut(&mut self.slots, slave) else { return };
        let direction = data.first().map_or(Direction::Request, |&byte| Direction::of(byte));
        match slot.stage {
            Stage::Offline => slot.timers.set_after(SlotTimer::Retry, AFTER_CHECK),
            Stage::Waiting => {
                slot.failures = 0;
                slot.enter(Stage::Waiting, Cause::CheckHeard);
                slot.timers.set_after(SlotTimer::Retry, AFTER_CHECK);
            }
            // Who checks does not answer: the attempt would fail.
            Stage::Contacting(_) => {
                slot.failures = 0;
                if direction == Direction::Request {
                    slot.wait(Cause::CheckHeard, slot.status, AFTER_CHECK);
                }
            }
            // The slave itself would not answer its own request, and it would object to that of a newcomer.
            Stage::Configuring(_) | Stage::Running => match direction {
                Direction::Request => slot.timers.set_after(SlotTimer::Restart, AFTER_CHECK),
                Direction::Response => slot.timers.clear(SlotTimer::Restart),
            },
        }
    }

    /// Heartbeat and shutdown: the header has the sender's own MAC ID.
    fn broadcast(&mut self, slave: MacId, frame: &Frame) -> bool {
        let data = frame.data();
        if data.first() != Some(&slave.number()) {
            return false;
        }
        let Some(slot) = self.board.get_mut(&mut self.slots, slave) else { return false };
        if let Ok(heartbeat) = Heartbeat::parse(data) {
            count_wide(&mut slot.counters.heartbeats);
            slot.raise(SlaveEvent::Heartbeat(heartbeat));
        } else if let Ok(shutdown) = Shutdown::parse(data) {
            slot.raise(SlaveEvent::Shutdown(shutdown));
        } else {
            return false;
        }
        true
    }

    /// A slave answers the Allocate of another master with success. A poll command names no master: two that take the slave
    /// for theirs would both poll it, and believe its responses, for ever.
    fn is_others_allocation(&self, frame: &Frame) -> bool {
        let Ok(message) = ExplicitMessage::parse(frame.data()) else { return false };
        let allocated = matches!(
            Response::parse(message.body),
            Ok(Response::Success { service: ServiceCode::ALLOCATE, .. })
        );
        allocated && message.mac != self.access().mac_id()
    }

    fn with_slot(&mut self, slave: MacId, act: impl FnOnce(&mut Slot<MESSAGE>, &Config, MacId)) {
        let own = self.access().mac_id();
        let Some(slot) = self.board.get_mut(&mut self.slots, slave) else { return };
        act(slot, &self.config, own);
    }

    fn explicit_frame(&mut self, slave: MacId, frame: &Frame) {
        let own = self.access().mac_id();
        let Some(slot) = self.board.get_mut(&mut self.slots, slave) else { return };
        let failure = match slot.conversation.frame(frame) {
            Progress::NotMine => return count_wide(&mut self.counters.unrelated),
            Progress::Ignored(_) => return count(&mut slot.counters.explicit_ignored),
            Progress::Pending => {
                slot.timers.clear(SlotTimer::Restart);
                None
            }
            Progress::Failed(failure) => Some(failure),
            Progress::Response(response) => {
                slot.timers.clear(SlotTimer::Restart);
                // The response may lie in the conversation that its consequences change.
                let mut buffer = [0; MESSAGE];
                let mut out = cip_core::codec::Writer::new(&mut buffer);
                let copied = response.emit(&mut out);
                debug_assert!(copied.is_ok(), "a response fits where it came from");
                slot.keep_time();
                if let Ok(response) = cip_core::message::Response::parse(out.written()) {
                    if slot.is_running() {
                        slot.talked(&self.config, own, &response);
                    } else {
                        slot.brought_further(&self.config, own, &response);
                    }
                }
                None
            }
        };
        slot.keep_time();
        let Some(failure) = failure else { return };
        if slot.is_running() {
            slot.talk_failed(&self.config, own, failure);
        } else {
            slot.went_unanswered(&self.config, own, failure);
        }
    }

    fn io(&mut self, slave: MacId, instance: IoInstance, data: &[u8]) {
        let run = self.run;
        let Some(slot) = self.board.get_mut(&mut self.slots, slave) else { return };
        let agreed = slot.entry.agreed(instance);
        let Some(agreed) = agreed.filter(|_| slot.is_running()) else {
            return count_wide(&mut self.counters.unexpected);
        };
        // The acknowledge of output data that are sent without poll.
        let Some(size) = agreed.produce else { return };
        if slot.io_message(instance, usize::from(size), data, run) {
            self.cycle.satisfy(instance, slave);
        }
    }
}

impl<const N: usize> Slot<N> {
    /// Takes a frame of an I/O message; true if the message is complete, and whatever became of it.
    fn io_message(&mut self, instance: IoInstance, size: usize, data: &[u8], run: bool) -> bool {
        let acknowledged = instance == IoInstance::ChangeOfState
            && self.entry.change_of_state.is_some_and(|change| change.acknowledged);
        let Some(input) = self.inputs.get_mut(instance.index()) else { return false };
        let message = if size > IO_UNFRAGMENTED_LEN {
            match input.reassembly.frame(data) {
                IoOutcome::Stored => return false,
                IoOutcome::Complete(message) => message,
                IoOutcome::TooLong => return self.wrong_length(instance),
                IoOutcome::OutOfSequence { .. }
                | IoOutcome::IgnoredNoFirst
                | IoOutcome::InvalidFirst { .. }
                | IoOutcome::UnexpectedAcknowledge => {
                    count(&mut self.counters.fragment_errors);
                    self.set_io_status(instance, ScannerStatus::FRAGMENT_SEQUENCE);
                    return true;
                }
            }
        } else {
            data
        };
        let idle = message.is_empty() && size != 0;
        if !idle && message.len() != size {
            return self.wrong_length(instance);
        }
        let changed = !idle && (!input.received || input.data != message);
        if changed {
            input.data.clear();
            // The scan list was checked: it fits.
            let kept = input.data.extend_from_slice(message);
            debug_assert!(kept.is_ok());
            input.received = true;
        }
        count_wide(&mut self.counters.received);
        self.feed_watchdog(instance);
        self.timers.clear(SlotTimer::Restart);
        self.acknowledge_due |= acknowledged;
        let status = if idle && run { ScannerStatus::SLAVE_IDLE } else { ScannerStatus::NORMAL };
        self.set_io_status(instance, status);
        if changed {
            self.raise(SlaveEvent::Input(instance));
        }
        true
    }

    fn wrong_length(&mut self, instance: IoInstance) -> bool {
        count(&mut self.counters.length_errors);
        self.set_io_status(instance, ScannerStatus::WRONG_LENGTH);
        true
    }
}

/// Whether a frame is what a scan waits for: all others it gives way to.
pub(super) fn is_response_of_scan(frame: &Frame) -> bool {
    Identifier::of_frame(frame).is_some_and(|id| {
        matches!(
            id.purpose(),
            Purpose::PollResponse | Purpose::BitStrobeResponse | Purpose::MulticastPollResponse
        )
    })
}

/// From a duplicate MAC ID check request to the moment at which its sender is on line, if it was its second, and a
/// little for its reaction.
pub(super) const AFTER_CHECK: Duration = Duration::from_millis(1005);
