//! When a connection produces.
//!
//! | Event | Condition | What happens |
//! |---|---|---|
//! | established | client | produce |
//! | message consumed | server that answers | produce, together with what waits for its turn already |
//! | data changed | change of state, inhibit time over | produce |
//! | data changed | inhibit time runs, or a message is on its way | produce when that is over |
//! | transmission trigger (EPR) | | produce, changed or not |
//! | produced | | trigger and inhibit time anew; with acknowledges the acknowledge timer |
//! | acknowledge | | acknowledge timer stops, no retries yet |
//! | acknowledge timer | retries left | the present data again |
//! | acknowledge timer | no retries left | told; the next production as usual |
//!
//! The timers start when the message has been sent.

use link_core::timers::TimerSet;

use super::{ProductionTrigger, Settings, TransportClassTrigger};
use crate::object::AcknowledgeSettings;

/// What of the production of one connection is not in its timers.
///
/// Its owner has the timers, says what has happened, and produces when that is [due](Self::is_due).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Production {
    due: bool,
    /// The data have changed since they were last sent.
    pending: bool,
    /// How often the present message was sent again.
    retries: u8,
}

/// What a production waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ProductionTimer {
    /// The expected packet rate: [`Production::triggered`].
    Trigger,
    /// The production inhibit time: [`Production::inhibit_over`].
    Inhibit,
    /// The acknowledge of the consumer: [`Production::not_acknowledged`].
    Acknowledge,
}

impl Production {
    /// Nothing is to be produced.
    pub const IDLE: Self = Self { due: false, pending: false, retries: 0 };

    /// Whether a message is to be produced.
    pub const fn is_due(&self) -> bool {
        self.due
    }

    /// The message is handed to the controller.
    pub const fn begin(&mut self) {
        self.due = false;
    }

    /// A message is to be produced; false if one waits already, with which it goes together.
    pub const fn want(&mut self) -> bool {
        !core::mem::replace(&mut self.due, true)
    }

    /// The connection is established: a client produces at once.
    pub const fn established(&mut self, kind: TransportClassTrigger) {
        *self = Self { due: !kind.is_server(), ..Self::IDLE };
    }

    /// The data have changed, for a reason other than a message; false for a connection that does not mind.
    pub fn changed<K: From<ProductionTimer>>(
        &mut self,
        kind: TransportClassTrigger,
        timers: &mut impl TimerSet<K>,
        is_in_flight: bool,
    ) -> bool {
        if kind.is_server() || kind.trigger() != ProductionTrigger::CHANGE_OF_STATE {
            return false;
        }
        if is_in_flight || timers.at(ProductionTimer::Inhibit.into()).is_some() {
            self.pending = true;
        } else {
            self.anew(timers);
        }
        true
    }

    /// The transmission trigger has run out.
    pub fn triggered<K: From<ProductionTimer>>(&mut self, timers: &mut impl TimerSet<K>) {
        self.anew(timers);
    }

    /// The production inhibit time is over.
    pub fn inhibit_over<K: From<ProductionTimer>>(&mut self, timers: &mut impl TimerSet<K>) {
        if self.pending {
            self.anew(timers);
        }
    }

    /// The acknowledge has come.
    pub fn acknowledged<K: From<ProductionTimer>>(&mut self, timers: &mut impl TimerSet<K>) {
        self.retries = 0;
        timers.clear(ProductionTimer::Acknowledge.into());
    }

    /// The acknowledge timer has run out; true if the message is not sent again.
    pub const fn not_acknowledged(&mut self, settings: &AcknowledgeSettings) -> bool {
        if self.retries < settings.retry_limit {
            self.retries = self.retries.saturating_add(1);
            self.due = true;
            return false;
        }
        self.retries = 0;
        true
    }

    /// A message of a client is with the controller no longer.
    pub fn sent<K: From<ProductionTimer>>(
        &mut self,
        kind: TransportClassTrigger,
        settings: &Settings,
        acknowledge: &AcknowledgeSettings,
        timers: &mut impl TimerSet<K>,
    ) {
        if kind.is_server() {
            return;
        }
        if kind.class() != 0 {
            timers.set_after_millis(ProductionTimer::Acknowledge.into(), acknowledge.timer.into());
        }
        if self.retries == 0 {
            self.start_trigger(settings, timers);
            set_or_clear(timers, ProductionTimer::Inhibit, settings.production_inhibit_time());
        }
        // What changed while the message was on its way is not in it.
        if timers.at(ProductionTimer::Inhibit.into()).is_none() {
            self.inhibit_over(timers);
        }
    }

    /// The transmission trigger, from now on. An EPR of 0 has none.
    pub fn start_trigger<K: From<ProductionTimer>>(
        &self,
        settings: &Settings,
        timers: &mut impl TimerSet<K>,
    ) {
        set_or_clear(timers, ProductionTimer::Trigger, settings.expected_packet_rate());
    }

    /// A new message replaces one that waits for its acknowledge.
    fn anew<K: From<ProductionTimer>>(&mut self, timers: &mut impl TimerSet<K>) {
        *self = Self { due: true, ..Self::IDLE };
        timers.clear(ProductionTimer::Acknowledge.into());
    }
}

fn set_or_clear<K: From<ProductionTimer>>(
    timers: &mut impl TimerSet<K>,
    timer: ProductionTimer,
    millis: u16,
) {
    match millis {
        0 => timers.clear(timer.into()),
        millis => timers.set_after_millis(timer.into(), millis.into()),
    }
}
