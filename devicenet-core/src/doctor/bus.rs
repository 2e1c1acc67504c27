//! The bus itself: load, errors, foreign traffic, and the controllers on it.

use core::time::Duration;

use link_core::{BitRate, BusErrorKind, Frame, Instant, LinkEvent};

use super::config::DoctorConfig;
use super::errors::{self, ErrorCounts};
use super::finding::{Facts, Foreign};
use super::ledger::{Ledger, Sign};
use super::patient::Seen;
use super::rule::{Rule, Severity};
use super::window::Window;
use crate::id::{Identifier, MacId, Purpose};

/// What is counted of the bus.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Bus {
    /// Bits of frames.
    load: Window,
    /// The number of the last frame.
    newest: Option<u64>,
    /// Errors other than missing acknowledges.
    errors: Window<{ ErrorCounts::KINDS }>,
    /// The first and the last of the present burst.
    first_error: Option<Instant>,
    pub(super) last_error: Option<Instant>,
    /// Missing acknowledges since the last good frame: when the first was, and how many.
    unacknowledged: Option<(Instant, u32)>,
    /// The last frame, if it was a duplicate MAC ID check request.
    check: Option<(Instant, Frame)>,
    /// Form errors in a row without a frame in between: when the last was, and how many.
    form_errors: Option<(Instant, u32)>,
    /// When that was over last.
    deaf_until: Instant,
    /// The own controller takes no part in the bus: nothing is heard.
    pub(super) is_blind: bool,
}

impl Bus {
    pub(super) const fn new() -> Self {
        Self {
            load: Window::new(),
            newest: None,
            errors: Window::new(),
            first_error: None,
            last_error: None,
            unacknowledged: None,
            check: None,
            form_errors: None,
            deaf_until: Instant::ZERO,
            is_blind: false,
        }
    }

    /// A frame that got through.
    pub(super) fn frame<const N: usize>(
        &mut self,
        config: &DoctorConfig,
        ledger: &mut Ledger<N>,
        seen: Seen,
        frame: &Frame,
    ) {
        let at = seen.at;
        if self.is_blind {
            self.takes_part(ledger, None, at);
        }
        self.form_errors = None;
        if self.is_sent_again(at, frame) {
            self.not_acknowledged(ledger, None, seen.at, Some(seen.n));
        } else if let Some((_, count)) = self.unacknowledged.take() {
            ledger.end(Rule::NotAcknowledged, None, at);
            if count >= MOST_UNACKNOWLEDGED {
                self.deaf_until = at;
                // The load was that of the attempts.
                self.load = Window::new();
            }
        }
        if config.bit_rate.is_some() {
            self.pass(config, ledger, at);
            self.load.add(0, frame.bit_len().saturating_add(INTERMISSION));
        }
        self.newest = Some(seen.n);
    }

    /// What was measured was not the load.
    pub(super) fn measure_anew<const N: usize>(&mut self, ledger: &mut Ledger<N>, now: Instant) {
        self.load = Window::new();
        ledger.end(Rule::BusLoad, None, now);
    }

    /// Time passes.
    pub(super) fn pass<const N: usize>(
        &mut self,
        config: &DoctorConfig,
        ledger: &mut Ledger<N>,
        now: Instant,
    ) {
        if let Some(bit_rate) = config.bit_rate
            && self.load.advance(now, config.load_window)
        {
            self.judge_load(config, bit_rate, ledger, now);
        }
        if self.first_error.is_some() && self.errors.advance(now, config.error_window) {
            let count = ErrorCounts::new(self.errors.so_far()).total();
            if count < config.error_frames.div_ceil(2) {
                ledger.end(Rule::ErrorFrames, None, now);
            }
            if count == 0 {
                (self.first_error, self.errors) = (None, Window::new());
            }
        }
    }

    fn judge_load<const N: usize>(
        &mut self,
        config: &DoctorConfig,
        bit_rate: BitRate,
        ledger: &mut Ledger<N>,
        now: Instant,
    ) {
        let Some(bits) = self.load.whole() else { return };
        let window = u64::try_from(config.load_window.as_micros()).unwrap_or(u64::MAX);
        // Bits that the window has room for, times a million.
        let room = u64::from(bit_rate.0).saturating_mul(window);
        let permille = bits.saturating_mul(1_000_000_000).checked_div(room).unwrap_or(0);
        // More than there is room for: the bit rate is another one.
        let permille = u16::try_from(permille).unwrap_or(u16::MAX);
        if permille > IMPOSSIBLE {
            return;
        }
        let limit = u16::from(config.load_percent).saturating_mul(10);
        // Who is alone fills the bus by trying again.
        let is_alone = self.unacknowledged.is_some_and(|(_, count)| count >= MOST_UNACKNOWLEDGED);
        if permille > limit && !is_alone {
            let sign = Sign {
                rule: Rule::BusLoad,
                severity: Severity::Warning,
                node: None,
                facts: Facts::Load { peak_permille: permille },
                since: now.saturating_sub(config.load_window),
                at: now,
                frames: [self.newest, None],
            };
            ledger.see(&sign);
        } else if permille < limit.saturating_sub(HYSTERESIS) {
            ledger.end(Rule::BusLoad, None, now);
        }
    }

    /// Up to when nobody has acknowledged, so that even those who tried were not heard.
    pub(super) const fn deaf_until(&self, now: Instant) -> Instant {
        if self.unacknowledged.is_some() { now } else { self.deaf_until }
    }

    /// What a controller tells: that of a node, or the own one.
    pub(super) fn link<const N: usize>(
        &mut self,
        config: &DoctorConfig,
        ledger: &mut Ledger<N>,
        node: Option<MacId>,
        at: Instant,
        n: Option<u64>,
        event: LinkEvent,
    ) {
        let sign =
            |rule, severity, facts| Sign { rule, severity, node, facts, since: at, at, frames: [n, None] };
        match event {
            LinkEvent::BusOff => {
                self.is_blind |= node.is_none();
                ledger.see(&sign(Rule::BusOff, Severity::Error, Facts::None));
                ledger.end(Rule::ErrorPassive, node, at);
            }
            LinkEvent::Down => self.is_blind |= node.is_none(),
            LinkEvent::ErrorPassive => {
                self.takes_part(ledger, node, at);
                ledger.see(&sign(Rule::ErrorPassive, Severity::Warning, Facts::None));
            }
            // From the warning limit on, a controller is error-active still, or again.
            LinkEvent::Up | LinkEvent::ErrorActive | LinkEvent::ErrorWarning => {
                self.takes_part(ledger, node, at);
                ledger.end(Rule::ErrorPassive, node, at);
            }
            LinkEvent::BusError(BusErrorKind::Ack) => self.not_acknowledged(ledger, node, at, n),
            LinkEvent::BusError(kind) => self.error(config, ledger, kind, Seen { n: n.unwrap_or(0), at }, n),
            LinkEvent::Overrun { lost } => {
                ledger.see(&sign(Rule::Overrun, Severity::Warning, Facts::Lost(lost)));
            }
            LinkEvent::Counters { .. }
            | LinkEvent::ModeSet(_)
            | LinkEvent::FilterSet
            | LinkEvent::Refused(_) => {}
        }
    }

    /// What was sent has no acknowledge.
    fn not_acknowledged<const N: usize>(
        &mut self,
        ledger: &mut Ledger<N>,
        node: Option<MacId>,
        at: Instant,
        n: Option<u64>,
    ) {
        let (since, count) = self.unacknowledged.unwrap_or((at, 0));
        let count = count.saturating_add(1);
        self.unacknowledged = Some((since, count));
        if count >= MOST_UNACKNOWLEDGED && at.saturating_since(since) >= ALONE {
            ledger.see(&Sign {
                rule: Rule::NotAcknowledged,
                severity: Severity::Error,
                node,
                facts: Facts::Attempts(count),
                since,
                at,
                frames: [n, None],
            });
        }
    }

    /// A duplicate MAC ID check request again at once. The next is due after a second: it is the same, which nobody has acknowledged.
    /// A listener hears it as a frame in order when its sender is error-passive.
    fn is_sent_again(&mut self, at: Instant, frame: &Frame) -> bool {
        let is_check = Identifier::of_frame(frame)
            .is_some_and(|identifier| identifier.purpose() == Purpose::DuplicateMacCheck)
            && frame.data().first().is_some_and(|first| first & RESPONSE == 0);
        let before = core::mem::replace(&mut self.check, is_check.then_some((at, *frame)));
        before.is_some_and(|(last, before)| before == *frame && at.saturating_since(last) <= CHECKS_AGAIN)
    }

    /// A controller that hears, or is in any error state, is not bus-off. Not every one tells that it was restarted.
    fn takes_part<const N: usize>(&mut self, ledger: &mut Ledger<N>, node: Option<MacId>, at: Instant) {
        self.is_blind &= node.is_some();
        ledger.end(Rule::BusOff, node, at);
    }

    fn error<const N: usize>(
        &mut self,
        config: &DoctorConfig,
        ledger: &mut Ledger<N>,
        kind: BusErrorKind,
        seen: Seen,
        n: Option<u64>,
    ) {
        if kind == BusErrorKind::Form && self.is_of_a_lone_sender(seen.at) {
            return;
        }
        let last = self.last_error.replace(seen.at);
        let is_apart = last.is_none_or(|last| seen.at.saturating_since(last) > APART);
        let first = self.first_error.filter(|_| !is_apart);
        let since = *self.first_error.insert(first.unwrap_or(seen.at));
        self.errors.advance(seen.at, config.error_window);
        self.errors.add(errors::index(kind), 1);
        let kinds = ErrorCounts::new(self.errors.so_far());
        let in_window = kinds.total();
        if in_window < config.error_frames {
            return;
        }
        let is_flood = in_window >= config.error_frames.saturating_mul(FLOOD);
        ledger.see(&Sign {
            rule: Rule::ErrorFrames,
            severity: if is_flood { Severity::Error } else { Severity::Warning },
            node: None,
            facts: Facts::Errors { kinds, window: config.error_window },
            since,
            at: seen.at,
            frames: [n, None],
        });
    }

    /// Who sends without being acknowledged begins an error flag where the delimiter of the acknowledge is, which is a form
    /// error to whoever listens, and tries again at once, until it is error-passive. All of that is one error.
    fn is_of_a_lone_sender(&mut self, at: Instant) -> bool {
        let before = self.form_errors.filter(|(last, _)| at.saturating_since(*last) <= TRIES_AGAIN);
        let count = before.map_or(0, |(_, count)| count).saturating_add(1);
        self.form_errors = Some((at, count));
        (2..=UNTIL_ERROR_PASSIVE).contains(&count)
    }
}

/// A frame that no DeviceNet node may send.
pub(super) fn foreign<const N: usize>(ledger: &mut Ledger<N>, foreign: Foreign, seen: Seen) {
    ledger.see(&Sign {
        rule: Rule::ForeignTraffic,
        severity: Severity::Warning,
        node: None,
        facts: Facts::Foreign(foreign),
        since: seen.at,
        at: seen.at,
        frames: [Some(seen.n), None],
    });
}

/// Bits between two frames.
const INTERMISSION: u32 = 3;
/// Thousandths, with some for time stamps that are not exact.
const IMPOSSIBLE: u16 = 1_030;
/// The load must fall by so many thousandths below the limit.
const HYSTERESIS: u16 = 50;
/// Without a frame in between.
const MOST_UNACKNOWLEDGED: u32 = 10;
/// Whoever is switched on first is alone for a moment.
const ALONE: Duration = Duration::from_millis(500);
/// The longest frame at the lowest bit rate with its error frame, and time for the node to begin.
const TRIES_AGAIN: Duration = Duration::from_millis(2);
/// The same at the pace of a slow adapter.
const CHECKS_AGAIN: Duration = Duration::from_millis(20);
/// The bit of the first data byte that tells a duplicate MAC ID check response from a request.
const RESPONSE: u8 = 0x80;
/// Each failed attempt adds 8 to the transmit error counter; at 128 a sender is error-passive, and heard by those who listen.
const UNTIL_ERROR_PASSIVE: u32 = 16;
/// After so long a pause errors are another burst. Ten within ten seconds are closer on the average.
const APART: Duration = Duration::from_secs(2);
/// So many times the errors that are too many are an error and not a warning.
const FLOOD: u32 = 10;
/// Shorter than this nothing is looked at by time alone.
pub(super) const LOOK_EVERY: Duration = Duration::from_millis(10);
