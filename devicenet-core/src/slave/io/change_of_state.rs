//! Production by change of state and cyclic: instance 4.
//!
//! | Event | Condition | What happens |
//! |---|---|---|
//! | established | | produce |
//! | data changed | change of state, inhibit time over | produce |
//! | data changed | inhibit time runs | produce when it is over |
//! | transmission trigger (EPR) | | produce, changed or not |
//! | produce | | the present data; trigger and inhibit time anew; with acknowledges the acknowledge timer, no retries yet |
//! | acknowledge | | acknowledge timer stops, watchdog anew |
//! | acknowledge timer | retries left | the present data again |
//! | acknowledge timer | no retries left | told; the next production as usual |
//!
//! The timers start when the message has been sent.

use cip_core::connection::{IoState, PredefinedConnection};
use link_core::Instant;
use link_core::timers::TimerSet;

use crate::id::Identifier;
use crate::slave::application::{Application, IoKind};
use crate::slave::event::SlaveEvent;
use crate::slave::machine::Slave;
use crate::slave::node::Node;
use crate::slave::timer::Timer;

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Slave<A, MESSAGE, DYNAMIC> {
    /// The data that are produced by change of state have changed, for a reason other than a message. They are sent as
    /// soon as the production inhibit time allows it; on a cyclic connection, or without any, nothing happens.
    pub fn inputs_changed(&mut self, now: Instant) {
        self.node.advance(now);
        self.expect_output();
        self.node.inputs_changed();
    }

    /// The master's acknowledge of a change of state or cyclic message.
    #[inline(never)]
    pub(in crate::slave) fn change_of_state_acknowledged(&mut self, id: Identifier) {
        if self.node.io(IoKind::ChangeOfState).state() != IoState::Established || !self.node.is_acknowledged()
        {
            return self.not_established(id, IoKind::ChangeOfState);
        }
        self.node.timers.clear(Timer::Acknowledge);
        self.node.lines.retries = 0;
        self.alive(IoKind::ChangeOfState);
    }

    /// The acknowledge timer has run out.
    pub(in crate::slave) fn not_acknowledged(&mut self) {
        if self.node.lines.retries < self.node.acknowledge.retry_limit {
            self.node.lines.retries = self.node.lines.retries.saturating_add(1);
            self.node.lines.want(IoKind::ChangeOfState);
        } else {
            self.node.lines.retries = 0;
            self.node.report(SlaveEvent::NotAcknowledged);
        }
    }

    /// A message of instance 4 is with the controller no longer.
    pub(in crate::slave) fn change_of_state_sent(&mut self) {
        if self.node.io(IoKind::ChangeOfState).state() != IoState::Established {
            return;
        }
        if self.node.is_acknowledged() {
            self.node.timers.set_after_millis(Timer::Acknowledge, self.node.acknowledge.timer.into());
        }
        if self.node.lines.retries == 0 {
            self.node.start_trigger();
            self.node.start_inhibit();
        }
        // What changed while the message was on its way is not in it.
        if self.node.timers.at(Timer::Inhibit).is_none() {
            self.node.inhibit_over();
        }
    }
}

impl<A: Application, const DYNAMIC: usize> Node<A, DYNAMIC> {
    /// Instance 4 has become established.
    pub(in crate::slave) fn begin_production(&mut self) {
        self.lines.pending = false;
        self.lines.retries = 0;
        self.lines.want(IoKind::ChangeOfState);
    }

    /// The transmission trigger, from now on. An EPR of 0 has none.
    pub(in crate::slave) fn start_trigger(&mut self) {
        match self.io(IoKind::ChangeOfState).settings().expected_packet_rate() {
            0 => self.timers.clear(Timer::Trigger),
            millis => self.timers.set_after_millis(Timer::Trigger, millis.into()),
        }
    }

    /// The transmission trigger has run out.
    pub(in crate::slave) fn triggered(&mut self) {
        self.produce_change_of_state();
    }

    /// The production inhibit time is over.
    pub(in crate::slave) fn inhibit_over(&mut self) {
        if core::mem::take(&mut self.lines.pending) {
            self.produce_change_of_state();
        }
    }

    pub(in crate::slave) fn is_acknowledged(&self) -> bool {
        matches!(
            self.io(IoKind::ChangeOfState).kind(),
            PredefinedConnection::ChangeOfState { acknowledged: true }
                | PredefinedConnection::Cyclic { acknowledged: true }
        )
    }

    fn inputs_changed(&mut self) {
        let connection = self.io(IoKind::ChangeOfState);
        let by_change = matches!(connection.kind(), PredefinedConnection::ChangeOfState { .. });
        if !by_change || connection.state() != IoState::Established {
            return;
        }
        if self.timers.at(Timer::Inhibit).is_some() || !self.lines.is_change_of_state_free() {
            self.lines.pending = true;
        } else {
            self.produce_change_of_state();
        }
    }

    /// A new message replaces one that waits for its acknowledge.
    fn produce_change_of_state(&mut self) {
        self.lines.pending = false;
        self.lines.retries = 0;
        self.timers.clear(Timer::Acknowledge);
        self.lines.want(IoKind::ChangeOfState);
    }

    fn start_inhibit(&mut self) {
        match self.io(IoKind::ChangeOfState).settings().production_inhibit_time() {
            0 => self.timers.clear(Timer::Inhibit),
            millis => self.timers.set_after_millis(Timer::Inhibit, millis.into()),
        }
    }
}
