//! The machine: its parts, its clock, its one door between states.

use core::time::Duration;

use link_core::ethernet::{Action, Input, Machine};
use link_core::timers::TimerKey;
use link_core::{Deadline, Instant, Queue, Timers};

use super::config::{Config, ConfigError, Readiness};
use super::event::{NodeCounters, NodeEvent, count};
use crate::NodeId;
use crate::cycle::Cycle;
use crate::dictionary::{Dictionary, ObjectSet, Values};
use crate::error::Signalling;
use crate::indicator::{StatusLed, error_led};
use crate::nmt::{Cause, Nmt, NmtState};
use crate::pdo::{Mapping, Mappings};
use crate::sdo::{CONNECTIONS, Server};
use crate::wire::{EntryType, ErrorCode, ErrorEntry, NetTime, NmtCommandId};

/// A controlled node; see the [module](super) text.
///
/// `O` are the objects of the application, `PRES` the most process data of its PRes, `SDO` the longest value that is read or
/// written.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct ControlledNode<O, const PRES: usize = 36, const SDO: usize = 256> {
    pub(super) config: Config,
    pub(super) objects: O,
    pub(super) nmt: Nmt,
    pub(super) cycle: Cycle,
    pub(super) dictionary: Dictionary,
    pub(super) signalling: Signalling,
    pub(super) server: Server<SDO>,
    /// The values that count in the cycle: those of the last `ResetConfiguration`.
    pub(super) active: Values,
    /// The static error bit field of the StatusResponse.
    pub(super) static_errors: [u8; 8],
    pub(super) requests: Queue<Request, REQUESTS>,
    /// The process data of the next PRes.
    pub(super) inputs: [u8; PRES],
    pub(super) poll: Poll,
    /// What the SoA asked for.
    pub(super) reply: Option<Reply>,
    /// What an SDO client asked for, once the answer on its connection is sent.
    pub(super) reset_after_answer: Option<(usize, Cause)>,
    /// Whether the application says that its inputs are valid.
    pub(super) are_inputs_valid: bool,
    /// Whether all of them could be read at the last SoC, by the mapping that is in use.
    pub(super) are_inputs_read: bool,
    /// Of the last SoC.
    pub(super) net_time: NetTime,
    /// Of the last SoC, µs.
    pub(super) relative_time: u64,
    pub(super) error_led: bool,
    pub(super) counters: NodeCounters,
    pub(super) timers: Timers<Timer, 4>,
    pub(super) events: Queue<NodeEvent, EVENTS>,
}

/// What the node knows of the polls of the managing node.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Poll {
    /// A PReq is to be answered.
    pub(super) is_due: bool,
    /// MS of that PReq.
    pub(super) is_multiplexed: bool,
    /// What the PReq leads to, once it is answered.
    pub(super) then: Option<Cause>,
    /// RD of the last PReq.
    pub(super) had_valid_data: bool,
    /// MC of the last SoC.
    pub(super) multiplexed_cycle: bool,
    /// A PReq came since the multiplexed cycle began, or none was due in it.
    pub(super) in_multiplexed_cycle: bool,
}

/// An NMT command that the application asks for.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Request {
    pub(super) command: NmtCommandId,
    pub(super) target: NodeId,
}

/// What is to be sent because of a SoA.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Reply {
    Ident,
    Status {
        /// ER, if it counts only after the answer.
        late_reset: Option<bool>,
    },
    NmtRequest,
    Generic,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Timer {
    BasicEthernet,
    Soc,
    Sdo0,
    Sdo1,
}

impl TimerKey<4> for Timer {
    const ALL: [Self; 4] = [Self::BasicEthernet, Self::Soc, Self::Sdo0, Self::Sdo1];
    const WHY: [&'static str; 4] = ["basic Ethernet timeout", "loss of SoC", "SDO client", "SDO client"];

    fn index(self) -> usize {
        match self {
            Self::BasicEthernet => 0,
            Self::Soc => 1,
            Self::Sdo0 => 2,
            Self::Sdo1 => 3,
        }
    }
}

impl<O: ObjectSet, const PRES: usize, const SDO: usize> Machine for ControlledNode<O, PRES, SDO> {
    type Event = NodeEvent;

    fn input(&mut self, now: Instant, input: Input<'_>) {
        let now = self.timers.advance_inline(now);
        if self.timers.is_due(now) {
            return self.input_when_due(now, input);
        }
        match input {
            Input::Frame(bytes) => self.frame(bytes),
            Input::Link(_) | Input::Tick => self.take(input),
        }
    }

    fn poll<'b>(&mut self, now: Instant, buffer: &'b mut [u8]) -> Option<Action<'b, NodeEvent>> {
        self.timers.advance_inline(now);
        self.output(buffer)
    }

    fn deadline(&self) -> Option<Deadline> {
        if self.has_output() { Some(Deadline::now(self.timers.now())) } else { self.timers.next() }
    }
}

impl<O: ObjectSet, const PRES: usize, const SDO: usize> ControlledNode<O, PRES, SDO> {
    /// A node without power: [`power_on`](Self::power_on) starts it.
    ///
    /// # Errors
    /// [`ConfigError`] if the default mapping cannot be used, a value is out of its range, or the PRes is longer than `PRES`.
    pub fn new(config: Config, objects: O) -> Result<Self, ConfigError> {
        const { assert!(PRES >= 36 && PRES <= 1490, "0x1F98/1 is 36 to 1490") };
        let limit = config.values.pres_limit;
        if usize::from(limit) > PRES || limit < 36 {
            return Err(ConfigError::PresLimit { limit, room: PRES });
        }
        if let Some(at) = config.values.out_of_range() {
            return Err(ConfigError::Value(at));
        }
        let mappings = mappings::<O>(&config).map_err(ConfigError::Mapping)?;
        let room = u16::try_from(PRES).unwrap_or(u16::MAX);
        let dictionary =
            Dictionary::new(config.device, config.node, config.mac, config.values, mappings, room);
        Ok(Self {
            objects,
            nmt: Nmt::new(),
            cycle: Cycle::new(config.options.poll_without_soc),
            dictionary,
            signalling: Signalling::new(config.options.status_entries),
            server: Server::new(),
            active: config.values,
            static_errors: [0; 8],
            requests: Queue::new(),
            inputs: [0; PRES],
            poll: Poll::default(),
            reply: None,
            reset_after_answer: None,
            are_inputs_valid: true,
            are_inputs_read: true,
            net_time: NetTime::default(),
            relative_time: 0,
            error_led: false,
            counters: NodeCounters::default(),
            timers: Timers::new(),
            events: Queue::new(),
            config,
        })
    }

    fn take(&mut self, input: Input<'_>) {
        match input {
            Input::Frame(bytes) => self.frame(bytes),
            Input::Link(event) => self.link(event),
            Input::Tick => {}
        }
    }

    /// A wait that ended before this moment ended before this input; one that ends now ends after it.
    #[cold]
    fn input_when_due(&mut self, now: Instant, input: Input<'_>) {
        self.expire(now.preceding());
        self.take(input);
        self.expire(now);
    }

    /// Follows a cause. Returns whether the state changed by it.
    pub(super) fn cause(&mut self, cause: Cause) -> bool {
        let Some(edge) = self.nmt.apply(cause) else { return false };
        let (from, to) = (edge.from, edge.to);
        if from == to && to == NmtState::PreOperational2 {
            // CT5: the first of two conditions.
            return true;
        }
        self.entered(from, to, cause);
        if to == NmtState::PreOperational2 && self.config.options.readiness == Readiness::Automatic {
            self.cause(Cause::ApplicationReady);
        }
        true
    }

    fn entered(&mut self, from: NmtState, to: NmtState, cause: Cause) {
        self.dictionary.state = to;
        self.raise(NodeEvent::StateChanged { from, to, cause });
        if StatusLed::of(from) != StatusLed::of(to) {
            self.raise(NodeEvent::StatusLed(StatusLed::of(to)));
        }
        if let Some(is_on) = error_led(cause, to)
            && self.error_led != is_on
        {
            self.error_led = is_on;
            self.raise(NodeEvent::ErrorLed(is_on));
        }
        self.timers.clear(Timer::BasicEthernet);
        if !to.is_cyclic() {
            self.timers.clear(Timer::Soc);
            self.cycle.leave();
            self.poll.had_valid_data = false;
        }
        match to {
            NmtState::Off => self.fall_silent(),
            NmtState::Initialising => {
                self.fall_silent();
                self.signalling = Signalling::new(self.config.options.status_entries);
                self.static_errors = [0; 8];
            }
            NmtState::ResetApplication => {
                self.fall_silent();
                self.objects.restore();
            }
            NmtState::ResetCommunication => {
                self.fall_silent();
                self.dictionary.values = self.config.values;
                self.dictionary.error_register = 0;
                self.dictionary.counters.reset();
                // They were accepted when the node was made.
                self.dictionary.mappings = mappings::<O>(&self.config).unwrap_or_default();
            }
            NmtState::ResetConfiguration => self.fall_silent(),
            NmtState::NotActive => {
                self.active = self.dictionary.values;
                self.wait_for_the_network();
            }
            // The multiplexed cycle in which the node gets ready is not a whole one.
            NmtState::ReadyToOperate => self.poll.in_multiplexed_cycle = true,
            NmtState::PreOperational1
            | NmtState::PreOperational2
            | NmtState::Operational
            | NmtState::Stopped
            | NmtState::BasicEthernet => {}
        }
    }

    /// Leaves POWERLINK mode: nothing is answered any more.
    fn fall_silent(&mut self) {
        self.timers.clear_all();
        for index in 0..CONNECTIONS {
            if let Some(client) = self.server.close(index) {
                self.raise(NodeEvent::SdoClosed { client, by_timeout: false });
            }
        }
        self.requests.clear();
        (self.poll, self.reply, self.reset_after_answer) = (Poll::default(), None, None);
    }

    /// Waits for any frame of a managing node, and settles for plain Ethernet otherwise.
    pub(super) fn wait_for_the_network(&mut self) {
        if self.active.basic_ethernet_timeout > 0 {
            let wait = Duration::from_micros(self.active.basic_ethernet_timeout.into());
            self.timers.set_after(Timer::BasicEthernet, wait);
        }
    }

    fn expire(&mut self, now: Instant) {
        // Each timer that is started again is later than `now`, or the loop ends by their number.
        for _ in 0..MAX_EXPIRED {
            let soc_was_due = self.timers.at(Timer::Soc);
            match self.timers.take_expired(now) {
                Some(Timer::BasicEthernet) => {
                    self.cause(Cause::BasicEthernetTimeout);
                }
                Some(Timer::Soc) => self.soc_timeout(soc_was_due.unwrap_or(now), now),
                Some(Timer::Sdo0) => self.client_timeout(0),
                Some(Timer::Sdo1) => self.client_timeout(1),
                None => return,
            }
        }
    }

    /// An error of POWERLINK: into the history, to the managing node and to the application.
    pub(super) fn error(&mut self, code: ErrorCode) {
        let entry = ErrorEntry { kind: EntryType::POWERLINK_EVENT, code, time: self.net_time, additional: 0 };
        self.log(entry);
    }

    pub(super) fn log(&mut self, entry: ErrorEntry) {
        self.dictionary.log(entry);
        if !self.signalling.report(entry) {
            count(&mut self.counters.errors_untold);
        }
        self.raise(NodeEvent::Error(entry.code));
    }

    pub(super) fn raise(&mut self, event: NodeEvent) {
        if self.events.push(event).is_err() {
            count(&mut self.counters.events_lost);
        }
    }
}

fn mappings<O: ObjectSet>(config: &Config) -> Result<Mappings, crate::wire::AbortCode> {
    let mut mappings = Mappings::new();
    let (values, given) = (&config.values, &config.mapping);
    mappings.transmit = Mapping::with::<O>(given.transmit, true, values.pres_limit.into())?;
    if let Some(first) = mappings.receive.first_mut() {
        *first = Mapping::with::<O>(given.receive, false, values.preq_limit.into())?;
    }
    Ok(mappings)
}

/// NMT requests that wait for an invitation.
pub(super) const REQUESTS: usize = 4;
const EVENTS: usize = 24;
const MAX_EXPIRED: usize = 16;
