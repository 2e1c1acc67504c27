//! A CAN controller, bit by bit: what it drives, and what it makes of the bit that it samples.
//!
//! ```text
//!   Joining --11 recessive--> Idle <------------------------------- Suspend
//!                              | SOF, own or another's                 ^ passive and was transmitter
//!                              v                                       |
//!                            Frame --all well--------------------> Intermission
//!                              | error                              |  ^    | dominant
//!                              v                                    |  |    v
//!                        Flag or PassiveFlag --> AfterFlag --> Delimiter   Flag (overload)
//! ```

use link_core::wire::{Bit, Bits, Field, bits};
use link_core::{BusErrorKind, Frame};

use super::counters::{Counters, ErrorState};
use super::decoder::{Decoder, Step};
use super::phase::{Detected, Effect, Flag, Phase};

/// The bit-level state of a controller.
#[derive(Clone, Debug)]
pub(crate) struct Engine {
    pub(crate) counters: Counters,
    pub(crate) phase: Phase,
    pub(crate) listen_only: bool,
    /// Originated the present frame and has not lost arbitration; kept until the bus is idle.
    transmitter: bool,
    stream: Option<Bits>,
    /// The bit on its way.
    sending: Option<Bit>,
    drives_recessive: bool,
    decoder: Decoder,
    /// An error-passive sender was not acknowledged: TEC counts only if its passive flag meets a dominant bit.
    ack_error_pending: bool,
    /// Makes it see a dominant bit where a receiver may object for the last time.
    pub(crate) spoil_end: bool,
}

impl Engine {
    pub(crate) fn new() -> Self {
        Self {
            counters: Counters::default(),
            phase: Phase::Off,
            listen_only: false,
            transmitter: false,
            stream: None,
            sending: None,
            drives_recessive: true,
            decoder: Decoder::default(),
            ack_error_pending: false,
            spoil_end: false,
        }
    }

    /// Starts in `phase`, with nothing on its way.
    pub(crate) fn enter(&mut self, phase: Phase) {
        self.phase = phase;
        self.transmitter = false;
        self.stream = None;
        self.sending = None;
        self.drives_recessive = true;
        self.ack_error_pending = false;
    }

    /// Is at the beginning of an intermission, after a frame of its own or of another.
    pub(crate) fn pause(&mut self, transmitter: bool) {
        self.enter(Phase::Intermission { seen: 0 });
        self.transmitter = transmitter;
    }

    /// Sends `frame` from the next bit on. Only in [`Phase::Idle`].
    pub(crate) fn start(&mut self, frame: &Frame) {
        self.enter(Phase::Frame);
        self.transmitter = true;
        self.stream = Some(bits(frame));
        self.decoder = Decoder::default();
    }

    /// Sends `frame`, with another's start of frame for its own. Only after [`Effect::StartOfFrame`].
    pub(crate) fn join(&mut self, frame: &Frame) {
        self.transmitter = true;
        let mut stream = bits(frame);
        stream.next();
        self.stream = Some(stream);
    }

    /// Begins a bit. Returns what it drives: `true` is recessive.
    pub(crate) fn begin_bit(&mut self) -> bool {
        self.drives_recessive = match self.phase {
            Phase::Frame => {
                self.sending = self.stream.as_mut().and_then(Iterator::next);
                match self.sending {
                    Some(bit) => bit.recessive,
                    None => self.listen_only || !self.decoder.acknowledges_now(),
                }
            }
            Phase::Flag { .. } => false,
            Phase::Off
            | Phase::Joining { .. }
            | Phase::Idle
            | Phase::PassiveFlag { .. }
            | Phase::AfterFlag { .. }
            | Phase::Delimiter { .. }
            | Phase::Intermission { .. }
            | Phase::Suspend { .. } => true,
        };
        self.drives_recessive
    }

    /// What it drives in the present bit.
    pub(crate) const fn drives_recessive(&self) -> bool {
        self.drives_recessive
    }

    /// Ends a bit that was sampled as `recessive`.
    pub(crate) fn sample(&mut self, recessive: bool) -> Effect {
        match self.phase {
            Phase::Off => Effect::None,
            Phase::Joining { left, run } => self.sample_joining(recessive, left, run),
            Phase::Idle if recessive => Effect::None,
            Phase::Idle => self.receive_start(true),
            Phase::Frame => self.sample_frame(recessive),
            Phase::Flag { sent, overload } => self.sample_flag(recessive, sent, overload),
            Phase::PassiveFlag { run, last } => {
                self.sample_passive_flag(recessive, run, last);
                Effect::None
            }
            Phase::AfterFlag { dominant, first, overload } => {
                self.sample_after_flag(recessive, dominant, first, overload);
                Effect::None
            }
            Phase::Delimiter { seen } => self.sample_delimiter(recessive, seen),
            Phase::Intermission { seen } => self.sample_intermission(recessive, seen),
            Phase::Suspend { left } => {
                if !recessive {
                    return self.receive_start(false);
                }
                self.phase = if left > 1 { Phase::Suspend { left: left - 1 } } else { Phase::Idle };
                Effect::None
            }
        }
    }

    fn sample_joining(&mut self, recessive: bool, left: u16, run: u16) -> Effect {
        let run = if recessive { run + 1 } else { 0 };
        if run < JOINING_RUN {
            self.phase = Phase::Joining { left, run };
            return Effect::None;
        }
        if left > 1 {
            self.phase = Phase::Joining { left: left - 1, run: 0 };
            return Effect::None;
        }
        self.phase = Phase::Idle;
        Effect::Joined
    }

    fn receive_start(&mut self, may_join: bool) -> Effect {
        self.enter(Phase::Frame);
        self.decoder = Decoder::default();
        self.decoder.push(false);
        Effect::StartOfFrame { may_join }
    }

    fn sample_frame(&mut self, sampled: bool) -> Effect {
        let spoiled = self.spoil_end && !self.transmitter && self.decoder.at_last_but_one_bit();
        let recessive = sampled && !spoiled;
        let step = self.decoder.push(recessive);
        match self.sending.take() {
            Some(bit) => self.sent_bit(bit, recessive, step),
            None => self.received_bit(recessive, step),
        }
    }

    fn sent_bit(&mut self, bit: Bit, recessive: bool, step: Step) -> Effect {
        let place = (self.decoder.position() - 1, bit.field);
        if bit.field == Field::AckSlot {
            return if recessive { self.error(BusErrorKind::Ack, Some(place)) } else { Effect::None };
        }
        if bit.recessive == recessive {
            if step != Step::Complete {
                return Effect::None;
            }
            self.stream = None;
            self.counters.sent();
            self.phase = Phase::Intermission { seen: 0 };
            return Effect::Sent;
        }
        if !recessive && bit.field == Field::Arbitration && !bit.stuff {
            self.stream = None;
            self.transmitter = false;
            return Effect::LostArbitration { bit: place.0 };
        }
        let stuff_in_arbitration = bit.stuff && bit.field <= Field::Arbitration && !recessive;
        self.error(if stuff_in_arbitration { BusErrorKind::Stuff } else { BusErrorKind::Bit }, Some(place))
    }

    fn received_bit(&mut self, recessive: bool, step: Step) -> Effect {
        if recessive && !self.drives_recessive {
            // Its acknowledgement did not reach the bus.
            return self.error(BusErrorKind::Bit, Some(self.decoder.last_place()));
        }
        match step {
            Step::Fine => Effect::None,
            Step::StuffError => self.error(BusErrorKind::Stuff, Some(self.decoder.last_place())),
            Step::FormError => self.error(BusErrorKind::Form, Some(self.decoder.last_place())),
            Step::CrcError => self.error(BusErrorKind::Crc, Some(self.decoder.last_place())),
            Step::Complete | Step::CompleteThenDominant => {
                if !self.listen_only {
                    self.counters.received();
                }
                self.spoil_end = false;
                if step == Step::Complete {
                    self.phase = Phase::Intermission { seen: 0 };
                } else {
                    self.overload();
                }
                self.decoder.frame().map_or(Effect::None, Effect::Received)
            }
        }
    }

    fn sample_flag(&mut self, recessive: bool, sent: u8, overload: bool) -> Effect {
        if recessive {
            return self.bit_error_in_flag();
        }
        self.phase = if sent + 1 < FLAG_BITS {
            Phase::Flag { sent: sent + 1, overload }
        } else {
            Phase::AfterFlag { dominant: 0, first: true, overload }
        };
        Effect::None
    }

    fn sample_passive_flag(&mut self, recessive: bool, run: u8, last: bool) {
        if !recessive && std::mem::take(&mut self.ack_error_pending) {
            self.counters.transmit_error();
        }
        let run = if run > 0 && recessive == last { run + 1 } else { 1 };
        self.phase = if run < FLAG_BITS {
            Phase::PassiveFlag { run, last: recessive }
        } else {
            self.ack_error_pending = false;
            Phase::AfterFlag { dominant: 0, first: true, overload: false }
        };
        self.leave_if_bus_off();
    }

    fn sample_after_flag(&mut self, recessive: bool, dominant: u8, first: bool, overload: bool) {
        if recessive {
            self.phase = Phase::Delimiter { seen: 1 };
            return;
        }
        if first && !overload && !self.transmitter {
            self.counters.severe_receive_error();
        }
        // Eight dominant bits after a flag, and each eight more, count as an error.
        let dominant = dominant + 1;
        if dominant == DOMINANT_TOLERATED {
            if self.transmitter {
                self.counters.transmit_error();
            } else {
                self.counters.severe_receive_error();
            }
        }
        self.phase = Phase::AfterFlag { dominant: dominant % DOMINANT_TOLERATED, first: false, overload };
        self.leave_if_bus_off();
    }

    fn sample_delimiter(&mut self, recessive: bool, seen: u8) -> Effect {
        match (recessive, seen + 1 == DELIMITER_BITS) {
            (true, false) => self.phase = Phase::Delimiter { seen: seen + 1 },
            (true, true) => self.phase = Phase::Intermission { seen: 0 },
            (false, false) => return self.error(BusErrorKind::Form, None),
            (false, true) => self.overload(),
        }
        Effect::None
    }

    fn sample_intermission(&mut self, recessive: bool, seen: u8) -> Effect {
        let suspends = self.transmitter && self.counters.state() == ErrorState::Passive;
        match (recessive, seen + 1 == INTERMISSION_BITS) {
            (true, false) => self.phase = Phase::Intermission { seen: seen + 1 },
            (true, true) => {
                self.enter(if suspends { Phase::Suspend { left: SUSPEND_BITS } } else { Phase::Idle })
            }
            (false, false) => self.overload(),
            (false, true) => return self.receive_start(!suspends),
        }
        Effect::None
    }

    /// Counts an error and begins to flag it.
    fn error(&mut self, kind: BusErrorKind, place: Option<(u32, Field)>) -> Effect {
        self.stream = None;
        self.spoil_end = false;
        let sender = self.transmitter;
        if self.listen_only {
            // Eleven recessive bits later a frame may begin, for everybody.
            self.phase = Phase::Joining { left: 1, run: 0 };
            return Effect::Error(Detected { kind, place, sender, flag: Flag::None });
        }
        // The error that makes it error-passive is still flagged actively.
        let passive = self.counters.state() == ErrorState::Passive;
        let in_arbitration = place.is_some_and(|(_, field)| field <= Field::Arbitration);
        match (sender, kind) {
            (true, BusErrorKind::Ack) if passive => self.ack_error_pending = true,
            (true, BusErrorKind::Stuff) if in_arbitration => {}
            (true, _) => self.counters.transmit_error(),
            (false, _) => self.counters.receive_error(),
        }
        let flag = self.begin_flag(passive);
        Effect::Error(Detected { kind, place, sender, flag })
    }

    fn bit_error_in_flag(&mut self) -> Effect {
        let passive = self.counters.state() == ErrorState::Passive;
        if self.transmitter {
            self.counters.transmit_error();
        } else {
            self.counters.severe_receive_error();
        }
        let flag = self.begin_flag(passive);
        Effect::Error(Detected { kind: BusErrorKind::Bit, place: None, sender: self.transmitter, flag })
    }

    fn begin_flag(&mut self, passive: bool) -> Flag {
        self.phase = if passive {
            Phase::PassiveFlag { run: 0, last: true }
        } else {
            Phase::Flag { sent: 0, overload: false }
        };
        self.leave_if_bus_off();
        if passive { Flag::Passive } else { Flag::Active }
    }

    fn overload(&mut self) {
        self.phase = if self.listen_only {
            Phase::Joining { left: 1, run: 0 }
        } else {
            Phase::Flag { sent: 0, overload: true }
        };
    }

    fn leave_if_bus_off(&mut self) {
        if self.counters.state() == ErrorState::BusOff {
            self.enter(Phase::Off);
        }
    }
}

/// Recessive bits that show that no frame is on the bus.
pub(crate) const JOINING_RUN: u16 = 11;
/// Sequences of them after bus-off.
pub(crate) const RECOVERY_SEQUENCES: u16 = 128;
/// Suspend transmission.
pub(crate) const SUSPEND_BITS: u8 = 8;
const FLAG_BITS: u8 = 6;
const DELIMITER_BITS: u8 = 8;
const DOMINANT_TOLERATED: u8 = 8;
const INTERMISSION_BITS: u8 = 3;
