//! What a controller has besides its bits: mailboxes, mode, and what it remembers while the bus is cheap.

use link_core::{FilterSet, Frame, Instant, Mode, TxToken};

use super::counters::Counters;
use super::engine::{Engine, JOINING_RUN};
use super::phase::Phase;

/// A frame that waits to be sent.
#[derive(Clone, Debug)]
pub(crate) struct Mail {
    pub(crate) key: u32,
    pub(crate) token: TxToken,
    pub(crate) frame: Frame,
    /// Not sent before, because the node takes its time.
    pub(crate) ready: Instant,
    /// In the attempt that is under way.
    pub(crate) sending: bool,
    /// Not to be tried again.
    pub(crate) withdrawn: bool,
}

/// The mailboxes of a controller, the one that goes first in front.
#[derive(Clone, Debug, Default)]
pub(crate) struct Queue {
    mails: Vec<Mail>,
}

impl Queue {
    pub(crate) fn with_capacity(capacity: usize) -> Self {
        Self { mails: Vec::with_capacity(capacity) }
    }

    pub(crate) fn push(&mut self, token: TxToken, frame: Frame, ready: Instant) {
        let key = frame.arbitration_key();
        let place = self.mails.partition_point(|mail| mail.key <= key);
        self.mails.insert(place, Mail { key, token, frame, ready, sending: false, withdrawn: false });
    }

    pub(crate) const fn is_empty(&self) -> bool {
        self.mails.is_empty()
    }

    pub(crate) const fn len(&self) -> usize {
        self.mails.len()
    }

    /// When the first of them may be sent.
    pub(crate) fn earliest(&self) -> Option<Instant> {
        self.mails.iter().map(|mail| mail.ready).min()
    }

    /// The one that goes first at `at`.
    pub(crate) fn head(&self, at: Instant) -> Option<&Mail> {
        self.mails.iter().find(|mail| mail.ready <= at)
    }

    /// Marks the one that goes first at `at` as being sent.
    pub(crate) fn send(&mut self, at: Instant) -> Option<Frame> {
        let mail = self.mails.iter_mut().find(|mail| mail.ready <= at)?;
        mail.sending = true;
        Some(mail.frame)
    }

    pub(crate) fn find(&mut self, token: TxToken) -> Option<&mut Mail> {
        self.mails.iter_mut().find(|mail| mail.token == token)
    }

    /// Takes out the one that is being sent.
    pub(crate) fn take_sent(&mut self) -> Option<Mail> {
        let place = self.mails.iter().position(|mail| mail.sending)?;
        Some(self.mails.remove(place))
    }

    /// The attempt came to nothing: the mail waits again, or is returned if it was withdrawn.
    pub(crate) fn give_up(&mut self) -> Option<Mail> {
        let place = self.mails.iter().position(|mail| mail.sending)?;
        self.mails[place].sending = false;
        self.mails[place].withdrawn.then(|| self.mails.remove(place))
    }

    pub(crate) fn remove(&mut self, token: TxToken) -> Option<Mail> {
        let place = self.mails.iter().position(|mail| mail.token == token)?;
        Some(self.mails.remove(place))
    }

    pub(crate) fn pop(&mut self) -> Option<Mail> {
        (!self.mails.is_empty()).then(|| self.mails.remove(0))
    }
}

/// A controller on the bus.
#[derive(Clone, Debug)]
pub(crate) struct Station {
    pub(crate) engine: Engine,
    pub(crate) queue: Queue,
    pub(crate) mode: Mode,
    pub(crate) mode_at_power_up: Mode,
    pub(crate) filter_at_power_up: FilterSet,
    pub(crate) clock_ppm: i32,
    pub(crate) segment: usize,
    /// It has power, and its cable is plugged.
    pub(crate) attached: bool,
    /// It left the bus because of its errors.
    pub(crate) bus_off: bool,
    /// [`LinkEvent::Up`](link_core::LinkEvent::Up) is due when it has joined.
    pub(crate) announce: bool,
    /// Counters of which the node and the trace know.
    pub(crate) known: Counters,
    /// While the bus is not simulated bit by bit: suspend transmission ends.
    pub(crate) suspend_until: Instant,
    /// While the bus is not simulated bit by bit: the recessive bits that count for [`Phase::Joining`] began.
    pub(crate) heard_from: Instant,
    /// Bit timing, where controllers differ in it.
    pub(crate) bit_clock: BitClock,
}

/// Where a controller is in its bit.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BitClock {
    pub(crate) sample_at: Instant,
    pub(crate) ends_at: Instant,
    /// The end of the bit is next; otherwise its sample.
    pub(crate) sampled: bool,
    /// It has synchronised in this bit.
    pub(crate) synchronised: bool,
    /// The level at its last sample.
    pub(crate) level: bool,
}

impl Station {
    pub(crate) fn new(mode: Mode, clock_ppm: i32, filter: FilterSet, mailboxes: usize) -> Self {
        Self {
            engine: Engine::new(),
            queue: Queue::with_capacity(mailboxes),
            mode,
            mode_at_power_up: mode,
            filter_at_power_up: filter,
            clock_ppm,
            segment: 0,
            attached: false,
            bus_off: false,
            announce: false,
            known: Counters::default(),
            suspend_until: Instant::ZERO,
            heard_from: Instant::ZERO,
            bit_clock: BitClock::default(),
        }
    }

    /// The length of its bit in nanoseconds, by its own clock.
    pub(crate) fn bit(&self) -> u64 {
        self.bit_with(self.clock_ppm)
    }

    /// The length of its bit if its clock were fast by `ppm`.
    pub(crate) fn bit_with(&self, ppm: i32) -> u64 {
        let nominal = self.mode.bit_rate.bit_time_nanos().unwrap_or(1).max(1);
        if ppm.unsigned_abs() <= TOLERATED_PPM {
            return nominal;
        }
        // A fast clock makes short bits.
        (nominal * 1_000_000 / (1_000_000 + i64::from(ppm)).max(1).unsigned_abs()).max(1)
    }

    /// It may send.
    pub(crate) fn can_send(&self) -> bool {
        self.attached && !self.bus_off && !self.mode.listen_only
    }

    /// It takes part: hears, and unless it only listens acknowledges and sends.
    pub(crate) fn has_joined(&self) -> bool {
        !matches!(self.engine.phase, Phase::Off | Phase::Joining { .. })
    }

    /// It is idle and in the same state as `other`.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.engine.phase == Phase::Idle
            && other.engine.phase == Phase::Idle
            && self.queue.is_empty()
            && other.queue.is_empty()
            && self.engine.counters == other.engine.counters
            && self.engine.listen_only == other.engine.listen_only
            && !self.engine.spoil_end
            && !other.engine.spoil_end
    }

    /// When it will have joined if the bus stays recessive.
    pub(crate) fn joins_at(&self) -> Option<Instant> {
        let Phase::Joining { left, .. } = self.engine.phase else { return None };
        let bits = u64::from(left) * u64::from(JOINING_RUN);
        Some(after(self.heard_from, bits * self.bit()))
    }
}

/// `nanos` after `at`.
pub(crate) fn after(at: Instant, nanos: u64) -> Instant {
    Instant::from_nanos(at.as_nanos().saturating_add(nanos))
}

/// Nanoseconds from `earlier` to `later`; zero if they are the other way round.
pub(crate) fn span(earlier: Instant, later: Instant) -> u64 {
    later.as_nanos().saturating_sub(earlier.as_nanos())
}

/// Two clocks that are each off by less than 0.485 % understand each other, by the rules of the Bosch specification
/// (section 9) for 16 quanta a bit, a sample point at 87.5 % and a synchronisation jump width of 2. Up to this
/// deviation no bit can be misread, so controllers are taken to run in step.
const TOLERATED_PPM: u32 = 4_000;
