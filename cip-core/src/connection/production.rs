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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::connection::{IoConnection, TimerResolution};
    use core::time::Duration;
    use link_core::timers::TimerKey;
    use link_core::{Instant, Timers};

    #[derive(Clone, Copy, PartialEq, Debug)]
    struct Timer(ProductionTimer);

    impl From<ProductionTimer> for Timer {
        fn from(timer: ProductionTimer) -> Self {
            Self(timer)
        }
    }

    impl TimerKey<3> for Timer {
        const ALL: [Self; 3] = [
            Self(ProductionTimer::Trigger),
            Self(ProductionTimer::Inhibit),
            Self(ProductionTimer::Acknowledge),
        ];
        const WHY: [&'static str; 3] = ["trigger", "inhibit", "acknowledge"];
        fn index(self) -> usize {
            match self.0 {
                ProductionTimer::Trigger => 0,
                ProductionTimer::Inhibit => 1,
                ProductionTimer::Acknowledge => 2,
            }
        }
    }

    /// A producer with its timers, EPR 100 ms.
    #[derive(Clone)]
    struct Producer {
        kind: TransportClassTrigger,
        connection: IoConnection<TransportClassTrigger>,
        production: Production,
        timers: Timers<Timer, 3>,
        acknowledge: AcknowledgeSettings,
    }

    impl Producer {
        fn new(kind: u8, inhibit: u16) -> Self {
            let kind = TransportClassTrigger(kind);
            let mut connection = IoConnection::non_existent(kind);
            connection.allocate(kind).unwrap();
            let _ = connection.set_packet_rate(100, TimerResolution::DEFAULT).unwrap();
            connection.settings_mut().set_production_inhibit_time(inhibit).unwrap();
            let mut production = Production::IDLE;
            production.established(kind);
            let acknowledge = AcknowledgeSettings::default();
            Self { kind, connection, production, timers: Timers::new(), acknowledge }
        }

        /// What is due goes out.
        fn send(&mut self) {
            assert!(self.production.is_due());
            self.production.begin();
            self.sent();
        }

        fn sent(&mut self) {
            self.production.sent(self.kind, self.connection.settings(), &self.acknowledge, &mut self.timers);
        }

        fn changed(&mut self, is_in_flight: bool) -> bool {
            self.production.changed(self.kind, &mut self.timers, is_in_flight)
        }

        /// In how many ms each timer ends: trigger, inhibit, acknowledge.
        fn waits(&self) -> [Option<u128>; 3] {
            Timer::ALL.map(|timer| {
                self.timers.at(timer).map(|at| at.saturating_since(self.timers.now()).as_millis())
            })
        }
    }

    #[test]
    fn a_client_produces_at_once_and_a_server_when_it_is_asked() {
        for kind in [0x00, 0x02, 0x10, 0x12] {
            assert!(Producer::new(kind, 0).production.is_due());
        }
        let mut server = Producer::new(0x82, 0);
        assert!(!server.production.is_due());
        assert!(server.production.want());
        assert!(!server.production.want(), "together with the first");
        server.send();
        assert_eq!((server.waits(), server.production), ([None; 3], Production::IDLE));
    }

    #[test]
    fn the_timers_start_when_the_message_was_sent() {
        let mut producer = Producer::new(0x12, 30);
        assert_eq!(producer.waits(), [None; 3]);
        producer.send();
        assert_eq!(producer.waits(), [Some(100), Some(30), Some(16)]);
        // Cyclic without acknowledges, without inhibit time.
        let mut cyclic = Producer::new(0x00, 0);
        cyclic.send();
        assert_eq!(cyclic.waits(), [Some(100), None, None]);
    }

    #[test]
    fn changes() {
        let mut producer = Producer::new(0x10, 30);
        producer.send();
        // While the inhibit time runs it waits.
        assert!(producer.changed(false));
        assert!(!producer.production.is_due());
        producer.timers.clear(Timer(ProductionTimer::Inhibit));
        producer.production.inhibit_over(&mut producer.timers);
        assert!(producer.production.is_due());
        // What changes while a message is on its way goes out after it.
        let mut on_its_way = Producer::new(0x10, 0);
        on_its_way.production.begin();
        assert!(on_its_way.changed(true));
        assert!(!on_its_way.production.is_due());
        on_its_way.sent();
        assert!(on_its_way.production.is_due());
        // Nothing has changed.
        let mut quiet = Producer::new(0x10, 30);
        quiet.send();
        quiet.production.inhibit_over(&mut quiet.timers);
        assert!(!quiet.production.is_due());
        // At once, and not by others.
        let mut idle = Producer::new(0x10, 0);
        idle.send();
        assert!(idle.changed(false) && idle.production.is_due());
        for kind in [0x00, 0x02, 0x80, 0x82, 0x92] {
            assert!(!Producer::new(kind, 0).changed(false), "{kind:02X}");
        }
    }

    #[test]
    fn acknowledges() {
        let mut producer = Producer::new(0x12, 0);
        producer.acknowledge.retry_limit = 2;
        producer.send();
        producer.production.acknowledged(&mut producer.timers);
        assert_eq!(producer.waits(), [Some(100), None, None]);
        producer.timers.advance(Instant::ZERO + Duration::from_millis(100));
        producer.production.triggered(&mut producer.timers);
        producer.send();
        // Twice again; the trigger goes on from the first.
        for _ in 0..2 {
            producer.timers.advance(producer.timers.now() + Duration::from_millis(16));
            assert!(!producer.production.not_acknowledged(&producer.acknowledge));
            producer.send();
        }
        assert_eq!(producer.waits(), [Some(68), None, Some(16)]);
        assert!(producer.production.not_acknowledged(&producer.acknowledge), "told");
        assert!(!producer.production.is_due());
        // A new message has retries of its own, and no one waits for the acknowledge of the old one.
        producer.production.triggered(&mut producer.timers);
        assert_eq!(producer.waits()[2], None);
        producer.send();
        assert!(!producer.production.not_acknowledged(&producer.acknowledge));
    }

    #[test]
    fn a_rate_of_0_has_no_trigger() {
        let mut producer = Producer::new(0x10, 0);
        let _ = producer.connection.set_packet_rate(0, TimerResolution::DEFAULT).unwrap();
        producer.send();
        assert_eq!(producer.waits(), [None; 3]);
    }
}
