//! What must hold after each input.

mod answers;
mod before;

use std::collections::{BTreeSet, VecDeque};

use core::time::Duration;

use link_core::Instant;
use link_core::ethernet::{LinkEvent, Machine};
use powerlink_core::dictionary::{ObjectAddress, Values};
use powerlink_core::indicator::StatusLed;
use powerlink_core::nmt::{Cause, NmtState};
use powerlink_core::node::{NodeEvent, Options, Readiness};
use powerlink_core::wire::{ErrorCode, NmtCommandId};

use super::device::{MOST_OUTPUTS, Node, UNREADABLE};
use super::heard::Heard;
use super::signalling::Signalling;
use super::states::{States, Step};
pub(super) use before::Before;
use before::{cumulative, fields};

/// What was done to the node.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Why {
    /// With what PR and RS would have been, where they matter.
    Heard(Heard, Option<u8>),
    Link(LinkEvent),
    Tick,
    PowerOn,
    Reset,
    SwitchOff,
    Ready,
    Other,
}

/// The second program.
pub(super) struct Model {
    options: Options,
    states: States,
    /// When `NotActive` ends.
    silence_ends: Option<Instant>,
    /// The values of the last `ResetConfiguration`.
    active: Values,
    requests: VecDeque<NmtCommandId>,
    pub(super) signalling: Signalling,
    pub(super) are_inputs_valid: bool,
    /// At the last SoC, by the mapping that is in use.
    are_inputs_readable: bool,
    /// Every transaction of every client.
    pub(super) transactions: BTreeSet<(u8, u8)>,
    /// Whose SDO connections are open.
    connected: BTreeSet<u8>,
    status_led: StatusLed,
    error_led: bool,
}

impl Model {
    pub(super) fn new(node: &Node) -> Self {
        let options = node.config().options;
        Self {
            options,
            states: States::new(options.readiness == Readiness::Automatic),
            silence_ends: None,
            active: node.config().values,
            requests: VecDeque::new(),
            signalling: Signalling::new(options.clears_before_answer),
            are_inputs_valid: true,
            are_inputs_readable: true,
            transactions: BTreeSet::new(),
            connected: BTreeSet::new(),
            status_led: StatusLed::Off,
            error_led: false,
        }
    }

    /// The application asked for a command.
    pub(super) fn asked(&mut self, command: NmtCommandId, is_taken: bool) {
        let is_extended = matches!(command.0, 0x41..=0x44 | 0x48..=0x4B);
        let has_room = self.states.state.is_powerlink_mode() && self.requests.len() < 4;
        assert_eq!(is_taken, has_room && !is_extended);
        if is_taken {
            self.requests.push_back(command);
        }
    }

    pub(super) fn judge(
        &mut self,
        why: Why,
        before: &Before,
        sent: &[Vec<u8>],
        events: &[NodeEvent],
        node: &Node,
        now: Instant,
    ) {
        let changes: Vec<_> = events
            .iter()
            .filter_map(|event| match *event {
                NodeEvent::StateChanged { from, to, cause } => Some((from, to, cause)),
                _ => None,
            })
            .collect();
        let has_failed = changes.iter().any(|&(_, _, cause)| cause == Cause::CycleError);
        let takes_time = matches!(why, Why::Heard(..) | Why::Link(_) | Why::Tick);
        let mut expected = Vec::new();
        if takes_time && self.silence_ends.is_some_and(|end| end < now) {
            expected.extend(self.follow(Cause::BasicEthernetTimeout));
        }
        let heard_in = self.states.state;
        self.answers(why, heard_in, has_failed, before, sent);
        let cause = self.cause(why, heard_in, now);
        expected.extend(cause.map(|cause| self.follow(cause)).unwrap_or_default());
        if takes_time && self.silence_ends.is_some_and(|end| end <= now) {
            expected.extend(self.follow(Cause::BasicEthernetTimeout));
        }
        self.states(&changes, &expected, has_failed, why, events);
        assert_eq!(node.state(), self.states.state, "after {why:?}");
        self.follow_resets(&changes, node, now);
        self.connections(why, events, &changes);
        self.indicators(events, node);
        self.counters(why, before, node);
        foreign_frames(why, heard_in, before, events, node);
        self.outputs(why, before, &changes, node);
        self.values(why, before, events, node);
        let deadline = node.deadline().map(|deadline| deadline.at);
        assert!(!takes_time || deadline.is_none_or(|at| at > now), "{deadline:?} at {now:?}");
    }

    fn follow(&mut self, cause: Cause) -> Vec<Step> {
        let steps = self.states.follow(cause);
        if !steps.is_empty() {
            self.silence_ends = None;
        }
        steps
    }

    /// What an input means to the state.
    fn cause(&mut self, why: Why, state: NmtState, now: Instant) -> Option<Cause> {
        let heard = match why {
            Why::PowerOn => return Some(Cause::PowerOn),
            Why::Reset => return Some(Cause::LocalReset),
            Why::SwitchOff => return Some(Cause::SwitchOff),
            Why::Ready => return Some(Cause::ApplicationReady),
            Why::Link(_) | Why::Tick | Why::Other => return None,
            Why::Heard(heard, _) => heard,
        };
        match heard {
            Heard::Soc => Some(Cause::Soc),
            Heard::Soa { .. } => Some(Cause::Soa),
            Heard::Command(cause) => Some(cause),
            Heard::Preq { .. } | Heard::Pres if state == NmtState::NotActive => {
                if self.options.poll_ends_not_active {
                    return Some(if heard == Heard::Pres { Cause::Pres } else { Cause::Preq });
                }
                if self.options.poll_restarts_basic_ethernet {
                    self.silence_begins(now);
                }
                None
            }
            Heard::Preq { size, room, .. } => match state {
                NmtState::ReadyToOperate | NmtState::Operational => {
                    let is_invalid = size > usize::from(self.active.preq_limit) || size > room;
                    is_invalid.then_some(Cause::InternalError)
                }
                _ => Some(Cause::Preq),
            },
            Heard::Pres => self.options.pres_ends_basic_ethernet.then_some(Cause::Pres),
            Heard::Sdo { .. } | Heard::Ignored | Heard::Foreign | Heard::Nothing => None,
        }
    }

    fn silence_begins(&mut self, now: Instant) {
        let wait = Duration::from_micros(self.active.basic_ethernet_timeout.into());
        self.silence_ends = (!wait.is_zero()).then(|| now + wait);
    }

    /// One state after the other, as expected; a cycle error comes when it comes, and says why.
    fn states(
        &mut self,
        changes: &[(NmtState, NmtState, Cause)],
        expected: &[Step],
        has_failed: bool,
        why: Why,
        events: &[NodeEvent],
    ) {
        let mut last = None;
        for &(from, to, cause) in changes {
            assert!(last.is_none_or(|last| last == from), "a gap in {changes:?}");
            last = Some(to);
            if cause == Cause::CycleError {
                assert!(from.is_cyclic() && to == NmtState::PreOperational1, "{changes:?}");
            }
        }
        let reset_by_client = matches!(why, Why::Heard(..) | Why::Tick)
            && changes.first().is_some_and(|&(_, to, cause)| {
                expected.first() != Some(&(to, cause))
                    && matches!(
                        cause,
                        Cause::ResetNode
                            | Cause::ResetCommunication
                            | Cause::ResetConfiguration
                            | Cause::SwReset
                    )
            });
        if has_failed {
            let codes = [0x8163, 0x8164, 0x8235, 0x8242, 0x8244, 0x8245].map(ErrorCode);
            let tells = |event: &NodeEvent| matches!(event, NodeEvent::Error(code) if codes.contains(code));
            assert!(events.iter().any(tells), "a cycle error without an error: {events:?}");
        } else if reset_by_client {
            // 0x1F9E, once its answer is sent or its client is gone.
            assert!(self.transactions.iter().next().is_some(), "nobody wrote 0x1F9E");
        } else {
            let steps: Vec<Step> = changes.iter().map(|&(_, to, cause)| (to, cause)).collect();
            assert_eq!(steps, expected, "after {why:?}");
            return;
        }
        if let Some(last) = last {
            self.states.settle(last);
            self.silence_ends = None;
        }
    }

    fn follow_resets(&mut self, changes: &[(NmtState, NmtState, Cause)], node: &Node, now: Instant) {
        for &(_, to, _) in changes {
            match to {
                NmtState::Initialising => {
                    self.signalling = Signalling::new(self.options.clears_before_answer);
                    self.requests.clear();
                }
                NmtState::NotActive => {
                    self.active = node.dictionary().values;
                    self.silence_begins(now);
                }
                _ if to.is_initialisation() || to == NmtState::Off => self.requests.clear(),
                _ => {}
            }
        }
        if self.states.state != NmtState::NotActive {
            self.silence_ends = None;
        }
    }

    /// Connections are opened once, and closed once: in the end by a reset.
    fn connections(&mut self, why: Why, events: &[NodeEvent], changes: &[(NmtState, NmtState, Cause)]) {
        for event in events {
            match *event {
                NodeEvent::SdoOpened { client } => {
                    assert!(self.connected.insert(client.0), "{client} was connected after {why:?}");
                }
                NodeEvent::SdoClosed { client, .. } => {
                    assert!(self.connected.remove(&client.0), "{client} was not connected after {why:?}");
                }
                _ => {}
            }
        }
        let is_reset = changes.iter().any(|&(_, to, _)| to.is_initialisation() || to == NmtState::Off);
        assert!(!is_reset || self.connected.is_empty(), "connected after a reset: {:?}", self.connected);
    }

    fn indicators(&mut self, events: &[NodeEvent], node: &Node) {
        for event in events {
            match *event {
                NodeEvent::StatusLed(led) => self.status_led = led,
                NodeEvent::ErrorLed(is_on) => {
                    assert_ne!(is_on, self.error_led, "it was so before");
                    self.error_led = is_on;
                }
                NodeEvent::BufferTooShort => panic!("there was room"),
                _ => {}
            }
        }
        let expected = match node.state() {
            NmtState::PreOperational1 => StatusLed::SingleFlash,
            NmtState::PreOperational2 => StatusLed::DoubleFlash,
            NmtState::ReadyToOperate => StatusLed::TripleFlash,
            NmtState::Operational => StatusLed::On,
            NmtState::Stopped => StatusLed::Blinking,
            NmtState::BasicEthernet => StatusLed::Flickering,
            _ => StatusLed::Off,
        };
        assert_eq!(self.status_led, expected, "in {}", node.state());
        assert_eq!(self.error_led, node.error_led());
    }

    fn counters(&self, why: Why, before: &Before, node: &Node) {
        let after = fields(node.counters());
        for (at, (old, new)) in before.counters.into_iter().zip(after).enumerate() {
            assert!(new >= old, "counter {at} shrank after {why:?}");
        }
        // A client may set them.
        if !matches!(why, Why::Heard(Heard::Sdo { .. }, _)) {
            for (old, new) in before.cumulative.iter().zip(cumulative(node)) {
                assert!((0..=2).contains(&new.wrapping_sub(*old)), "{old} to {new} after {why:?}");
            }
        }
        assert_eq!(node.counters().events_lost, 0, "there is room for all that one input leads to");
    }

    /// What process data could not carry.
    fn values(&mut self, why: Why, before: &Before, events: &[NodeEvent], node: &Node) {
        let is_soc = matches!(why, Why::Heard(Heard::Soc, _));
        if is_soc {
            let input = ObjectAddress::new(0x6000, 1);
            let is_mapped = node.dictionary().mappings.transmit.entries().any(|entry| entry.object == input);
            self.are_inputs_readable = !is_mapped || node.objects().inputs.0 != UNREADABLE;
        }
        let is_mapped_anew = events.contains(&NodeEvent::ObjectWritten(TRANSMIT_MAPPING))
            || node.dictionary().mappings.transmit.len() != before.mapped;
        if is_mapped_anew && matches!(why, Why::Heard(Heard::Sdo { .. }, _)) {
            self.are_inputs_readable = false;
        }
        let tells_of_input = events.iter().any(|event| matches!(event, NodeEvent::ValueUnreadable { .. }));
        let is_unreadable = is_soc && !self.are_inputs_readable;
        assert!(is_unreadable || !tells_of_input, "{events:?} after {why:?}");
        assert!(!is_unreadable || tells_of_input || !node.state().is_cyclic(), "an input is lost in silence");
        if events.iter().any(|event| matches!(event, NodeEvent::ValueRefused { .. })) {
            let is_exchange = match why {
                Why::Heard(Heard::Preq { flags, .. }, _) => flags & 0x01 != 0,
                Why::Heard(Heard::Pres, _) => true,
                _ => false,
            };
            assert!(is_exchange, "{events:?} after {why:?}");
        }
        assert!(node.objects().outputs.1 <= MOST_OUTPUTS, "out of the range of 0x6201/1");
    }

    fn outputs(&self, why: Why, before: &Before, changes: &[(NmtState, NmtState, Cause)], node: &Node) {
        let may_change = match why {
            Why::Heard(Heard::Preq { .. } | Heard::Pres | Heard::Sdo { .. }, _) => true,
            _ => changes.iter().any(|&(_, to, _)| to == NmtState::ResetApplication),
        };
        assert!(may_change || node.objects().outputs == before.outputs, "outputs change by {why:?}");
        if let Why::Heard(Heard::Preq { .. } | Heard::Pres, _) = why {
            let from = changes.first().map_or(node.state(), |&(from, ..)| from);
            let is_exchanging = matches!(from, NmtState::ReadyToOperate | NmtState::Operational);
            assert!(is_exchanging || node.objects().outputs == before.outputs, "outputs change in {from}");
        }
    }
}

/// What only the managing node sends is counted and told, if it comes from another node.
fn foreign_frames(why: Why, state: NmtState, before: &Before, events: &[NodeEvent], node: &Node) {
    let is_foreign = matches!(why, Why::Heard(Heard::Foreign, _)) && state.is_communicating();
    let told = events.iter().filter(|event| matches!(event, NodeEvent::ForeignFrame { .. })).count();
    let counted = node.counters().foreign_frames - before.foreign_frames;
    assert_eq!((counted, told), (u32::from(is_foreign), usize::from(is_foreign)), "after {why:?} in {state}");
}

/// How many entries of the PRes count.
const TRANSMIT_MAPPING: ObjectAddress = ObjectAddress::new(0x1A00, 0);
