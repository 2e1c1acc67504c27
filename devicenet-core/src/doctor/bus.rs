//! The bus itself: load, errors, foreign traffic, and the controllers on it.

use core::time::Duration;

use link_core::{BitRate, BusErrorKind, Frame, Instant, LinkEvent};

use super::config::DoctorConfig;
use super::finding::{Facts, Foreign};
use super::ledger::{Ledger, Sign};
use super::patient::Seen;
use super::rule::{Rule, Severity};
use super::window::Window;
use crate::id::MacId;

/// What is counted of the bus.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Bus {
    /// Bits of frames.
    load: Window,
    /// Errors other than missing acknowledges.
    errors: Window,
    first_error: Option<Instant>,
    last_kind: BusErrorKind,
    /// Missing acknowledges since the last good frame: when the first was, and how many.
    unacknowledged: Option<(Instant, u32)>,
    /// When that was over last.
    deaf_until: Instant,
    /// The own controller takes no part in the bus: nothing is heard.
    pub(super) is_blind: bool,
}

impl Bus {
    pub(super) const fn new() -> Self {
        Self {
            load: Window::new(),
            errors: Window::new(),
            first_error: None,
            last_kind: BusErrorKind::Other,
            unacknowledged: None,
            deaf_until: Instant::ZERO,
            is_blind: false,
        }
    }

    /// A frame that got through.
    pub(super) fn frame<const N: usize>(
        &mut self,
        config: &DoctorConfig,
        ledger: &mut Ledger<N>,
        at: Instant,
        frame: &Frame,
    ) {
        if let Some((_, count)) = self.unacknowledged.take() {
            ledger.end(Rule::NotAcknowledged, None, at);
            if count >= MOST_UNACKNOWLEDGED {
                self.deaf_until = at;
            }
        }
        if config.bit_rate.is_some() {
            self.pass(config, ledger, at);
            self.load.add(frame.bit_len().saturating_add(INTERMISSION));
        }
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
            let count = self.errors.so_far();
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
        if permille > limit {
            let sign = Sign {
                rule: Rule::BusLoad,
                severity: Severity::Warning,
                node: None,
                facts: Facts::Load { peak_permille: permille },
                since: now.saturating_sub(config.load_window),
                at: now,
                frames: [None; 2],
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
        match (node, event) {
            (None, LinkEvent::BusOff | LinkEvent::Down) => self.is_blind = true,
            (None, LinkEvent::Up) => self.is_blind = false,
            _ => {}
        }
        match event {
            LinkEvent::BusOff => {
                ledger.see(&sign(Rule::BusOff, Severity::Error, Facts::None));
                ledger.end(Rule::ErrorPassive, node, at);
            }
            LinkEvent::ErrorPassive => {
                ledger.see(&sign(Rule::ErrorPassive, Severity::Warning, Facts::None));
            }
            LinkEvent::ErrorActive => ledger.end(Rule::ErrorPassive, node, at),
            LinkEvent::Up => {
                ledger.end(Rule::BusOff, node, at);
                ledger.end(Rule::ErrorPassive, node, at);
            }
            LinkEvent::BusError(BusErrorKind::Ack) => {
                let (since, count) = self.unacknowledged.unwrap_or((at, 0));
                let count = count.saturating_add(1);
                self.unacknowledged = Some((since, count));
                if count >= MOST_UNACKNOWLEDGED && at.saturating_since(since) >= ALONE {
                    let facts = Facts::Errors { kind: BusErrorKind::Ack, in_window: count };
                    ledger.see(&Sign { since, ..sign(Rule::NotAcknowledged, Severity::Error, facts) });
                }
            }
            LinkEvent::BusError(kind) => self.error(config, ledger, kind, Seen { n: n.unwrap_or(0), at }, n),
            LinkEvent::Overrun { lost } => {
                ledger.see(&sign(Rule::Overrun, Severity::Warning, Facts::Lost(lost)));
            }
            LinkEvent::Down
            | LinkEvent::ErrorWarning
            | LinkEvent::Counters { .. }
            | LinkEvent::ModeSet(_)
            | LinkEvent::FilterSet
            | LinkEvent::Refused(_) => {}
        }
    }

    fn error<const N: usize>(
        &mut self,
        config: &DoctorConfig,
        ledger: &mut Ledger<N>,
        kind: BusErrorKind,
        seen: Seen,
        n: Option<u64>,
    ) {
        let since = *self.first_error.get_or_insert(seen.at);
        self.errors.advance(seen.at, config.error_window);
        self.errors.add(1);
        self.last_kind = kind;
        let in_window = self.errors.so_far();
        if in_window < config.error_frames {
            return;
        }
        let is_flood = in_window >= config.error_frames.saturating_mul(FLOOD);
        ledger.see(&Sign {
            rule: Rule::ErrorFrames,
            severity: if is_flood { Severity::Error } else { Severity::Warning },
            node: None,
            facts: Facts::Errors { kind, in_window },
            since,
            at: seen.at,
            frames: [n, None],
        });
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
const ALONE: Duration = Duration::from_secs(1);
/// So many times the errors that are too many are an error and not a warning.
const FLOOD: u32 = 10;
/// Shorter than this nothing is looked at by time alone.
pub(super) const LOOK_EVERY: Duration = Duration::from_millis(10);
