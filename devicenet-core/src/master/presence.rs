//! A slave as the master comes and goes, and as it comes and goes itself.

use core::time::Duration;

use super::config::Config;
use super::slot::{Slot, SlotTimer};
use super::state::{Cause, Stage};
use super::status::ScannerStatus;
use crate::counter::count;
use crate::id::MacId;

impl<const N: usize> Slot<N> {
    pub(super) fn master_on_line(&mut self, own: MacId) {
        // A tool gave the master the MAC ID of one of its slaves.
        if self.entry.mac_id == own {
            return self.set_status(ScannerStatus::ILLEGAL_SCAN_LIST);
        }
        self.enter(Stage::Waiting, Cause::MasterOnLine);
        self.set_status(ScannerStatus::INITIALISING);
        // Unless its own check was heard a moment ago.
        if self.timers.at(SlotTimer::Retry).is_none() {
            self.timers.set_after(SlotTimer::Retry, Duration::ZERO);
        }
    }

    pub(super) fn master_off_line(&mut self) {
        self.abandon_talk();
        self.conversation.cancel();
        self.timers.clear_all();
        self.failures = 0;
        self.absent = false;
        if self.stage != Stage::Offline {
            self.enter(Stage::Offline, Cause::MasterOffLine);
        }
    }

    pub(super) fn conversation_expired(&mut self, config: &Config, own: MacId) {
        let failure = self.conversation.timer_expired();
        self.keep_time();
        let Some(failure) = failure else { return };
        if self.is_running() {
            self.talk_failed(config, own, failure);
        } else {
            self.went_unanswered(config, own, failure);
        }
    }

    /// Nothing came over an instance of a slave that runs for too long, or it has started anew.
    pub(super) fn lost(&mut self, cause: Cause) {
        count(&mut self.counters.timeouts);
        self.abandon_talk();
        self.wait(cause, ScannerStatus::STOPPED_COMMUNICATING, Duration::ZERO);
    }

    /// It has started anew, and is on line again.
    pub(super) fn restarted(&mut self) {
        match self.stage {
            Stage::Offline | Stage::Waiting | Stage::Contacting(_) => {}
            Stage::Configuring(_) => {
                self.failures = 0;
                self.wait(Cause::CheckHeard, ScannerStatus::INITIALISING, Duration::ZERO);
            }
            Stage::Running => self.lost(Cause::CheckHeard),
        }
    }
}
