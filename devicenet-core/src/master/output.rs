//! What the master sends: three lanes with one frame in flight each.
//!
//! | Lane | Token | Frames |
//! |---|---|---|
//! | answers | 0x1001 | acknowledges of change-of-state and cyclic messages, output data outside of the scan |
//! | scan | 0x1002 | bit-strobe, multicast poll and poll commands |
//! | explicit | 0x1003 | requests, fragments and acknowledges; every slave in its turn |
//!
//! A scan has room for some explicit messages, so that neither starves the other: see [`cycle`](super::cycle).

use core::time::Duration;

use cip_core::fragment::{FragmentByte, FragmentKind, IO_FRAGMENT_LEN, IO_UNFRAGMENTED_LEN};
use link_core::{Action, Frame, TxOutcome, TxToken};

use super::board::{Known, View};
use super::cycle::Position;
use super::event::{MasterEvent, count, count32};
use super::machine::{Master, Timer};
use super::scan_list::IoInstance;
use super::set::SlaveSet;
use super::slot::{Output, Sending, Slot, SlotTimer};

use crate::client::Conversation;
use crate::id::{Identifier, MacId, Purpose};
use crate::message::{self, BitStrobeCommand, Wire};

/// What is in flight.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Lanes {
    answers: Lane,
    scan: Lane,
    explicit: Lane,
    /// The explicit lane carries a request to an unconnected port, which another master may send as well.
    contested: bool,
    /// It was taken back after a collision, and is wanted again.
    taken_back: bool,
    /// The MAC ID whose turn it is in the explicit lane, and among the answers; or the next one that has something to send.
    turn: u8,
    answer_turn: u8,
}

#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
struct Lane {
    carries: Option<Carried>,
    withdrawal: Withdrawal,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
enum Withdrawal {
    #[default]
    None,
    Due,
    /// Its `TxDone` tells what came of it.
    Told,
}

/// Who may send the next explicit message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Turn {
    Slave(MacId),
    /// The device at MAC ID 63 that may replace a slave.
    Candidate,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Carried {
    /// What nobody wants to know about any more.
    Abandoned,
    Acknowledge,
    Output {
        slave: MacId,
        fragment: usize,
    },
    BitStrobe,
    Multicast {
        fragment: usize,
    },
    Poll {
        slave: MacId,
        fragment: usize,
    },
    Explicit {
        slave: MacId,
    },
    /// To the device at MAC ID 63 that may replace a slave.
    Candidate,
}

impl Lane {
    const fn withdraw(&mut self) {
        if let Withdrawal::None = self.withdrawal {
            self.withdrawal = Withdrawal::Due;
        }
    }
}

impl Lanes {
    /// The number of frames in flight at most.
    pub(super) const COUNT: usize = 3;

    /// Whether a token is of a lane, and not of the node that the master is.
    pub(super) const fn own(token: TxToken) -> bool {
        token.0 >= ANSWERS.0
    }

    /// Nothing that is in flight is wanted any more.
    pub(super) fn abandon(&mut self) {
        for lane in [&mut self.answers, &mut self.scan, &mut self.explicit] {
            match lane.carries {
                // The conversation waits for its frame.
                Some(Carried::Explicit { .. } | Carried::Candidate) => lane.withdraw(),
                Some(_) => {
                    lane.carries = Some(Carried::Abandoned);
                    lane.withdraw();
                }
                None => {}
            }
        }
    }

    /// Whether a command of the scan is in flight.
    pub(super) const fn carries_command(&self) -> bool {
        self.scan.carries.is_some()
    }

    pub(super) const fn carries_explicit(&self) -> bool {
        self.explicit.carries.is_some()
    }

    /// Takes back a request that may collide with another master's; true if there is one.
    pub(super) const fn take_back(&mut self) -> bool {
        let takes = self.contested && !self.taken_back && self.explicit.carries.is_some();
        if takes {
            self.taken_back = true;
            self.explicit.withdraw();
        }
        takes
    }

    pub(super) fn withdraw(&mut self) -> Option<Action<MasterEvent>> {
        let lanes = [(ANSWERS, &mut self.answers), (SCAN, &mut self.scan), (EXPLICIT, &mut self.explicit)];
        let (token, lane) = lanes.into_iter().find(|(_, lane)| lane.withdrawal == Withdrawal::Due)?;
        lane.withdrawal = Withdrawal::Told;
        Some(Action::Withdraw(token))
    }

    fn must_withdraw(&self) -> bool {
        [&self.answers, &self.scan, &self.explicit].iter().any(|lane| lane.withdrawal == Withdrawal::Due)
    }
}

impl<const SLAVES: usize, const MESSAGE: usize> Master<SLAVES, MESSAGE> {
    pub(super) fn has_output(&self) -> bool {
        self.lanes.must_withdraw()
            || self.node.has_output()
            || self.shown != self.network_status()
            || self.filter_due
            || self.scan_done.is_some()
            || self.candidate.event.is_some()
            || !self.board.with(&self.slots, Known::HasEvents).is_empty()
            || (self.on_line
                && (self.answer_due().is_some() || self.command_due() || self.explicit_due().is_some()))
    }

    pub(super) fn transmit(&mut self) -> Option<Action<MasterEvent>> {
        if !self.on_line {
            return None;
        }
        self.answer().or_else(|| self.command()).or_else(|| self.explicit())
    }

    fn answer_due(&self) -> Option<MacId> {
        if self.lanes.answers.carries.is_some() {
            return None;
        }
        let due = self.board.with(&self.slots, Known::HasAnswer);
        due.from(self.lanes.answer_turn).first().or_else(|| due.first())
    }

    fn answer(&mut self) -> Option<Action<MasterEvent>> {
        let slave = self.answer_due()?;
        let run = self.run;
        let slot = self.board.get_mut(&mut self.slots, slave)?;
        self.lanes.answer_turn = slave.number().saturating_add(1);
        let (carried, frame) = if core::mem::take(&mut slot.acknowledge_due) {
            let frame = Identifier::change_of_state_acknowledge(slave).frame(&[])?;
            (Carried::Acknowledge, frame)
        } else {
            let Sending::Due(fragment) = slot.output.sending else { return None };
            slot.output.sending = Sending::HandedOut;
            let fragmented = slot.output.is_fragmented();
            let data = slot.output.message(run, fragment);
            let frame = io_frame(Identifier::poll_command(slave), data, fragmented, fragment)?;
            (Carried::Output { slave, fragment }, frame)
        };
        self.lanes.answers.carries = Some(carried);
        Some(Action::Transmit(ANSWERS, frame))
    }

    const fn command_due(&self) -> bool {
        self.lanes.scan.carries.is_none()
            && match self.cycle.position {
                Position::Stopped | Position::Pause => false,
                Position::BitStrobe | Position::Multicast { .. } | Position::Poll { .. } => true,
            }
    }

    fn command(&mut self) -> Option<Action<MasterEvent>> {
        if !self.command_due() {
            return None;
        }
        let own = self.access().mac_id();
        let (carried, frame) = match self.cycle.position {
            Position::Stopped | Position::Pause => return None,
            Position::BitStrobe => (Carried::BitStrobe, self.strobe()?),
            Position::Multicast { fragment } => {
                let fragmented = self.multicast_output.is_fragmented();
                let data = self.multicast_output.message(self.run, fragment);
                let id = Identifier::multicast_poll_command(own);
                (Carried::Multicast { fragment }, io_frame(id, data, fragmented, fragment)?)
            }
            Position::Poll { slave, fragment } => {
                let run = self.run;
                let slot = self.board.get_mut(&mut self.slots, slave)?;
                let fragmented = slot.output.is_fragmented();
                let data = slot.output.message(run, fragment);
                let frame = io_frame(Identifier::poll_command(slave), data, fragmented, fragment)?;
                (Carried::Poll { slave, fragment }, frame)
            }
        };
        self.lanes.scan.carries = Some(carried);
        Some(Action::Transmit(SCAN, frame))
    }

    fn strobe(&self) -> Option<Frame> {
        let id = Identifier::bit_strobe_command(self.access().mac_id());
        if !self.run {
            return id.frame(&[]);
        }
        let strobe = self.board.with(&self.slots, Known::IsStrobed).fold(
            BitStrobeCommand::default(),
            |strobe, slave| {
                strobe.with(
                    slave,
                    self.board.get(&self.slots, slave).is_some_and(|slot| slot.output.strobe_bit),
                )
            },
        );
        let mut bytes = [0; Frame::MAX_DATA];
        let mut out = cip_core::codec::Writer::new(&mut bytes);
        strobe.emit(&mut out).ok()?;
        id.frame(out.written())
    }

    /// Whose turn it is. The device at MAC ID 63 comes after the last slave.
    fn explicit_due(&self) -> Option<Turn> {
        if self.lanes.explicit.carries.is_some() || !self.cycle.explicit_may_pass() {
            return None;
        }
        let backs_off = self.timers.at(Timer::BackOff).is_some();
        let may_pass = |conversation: &Conversation<MESSAGE>| {
            conversation.has_output() && !(backs_off && is_contested(conversation.route().request()))
        };
        let mut due = self.board.with(&self.slots, Known::HasRequest);
        if backs_off {
            for slave in due {
                if !self.board.get(&self.slots, slave).is_some_and(|slot| may_pass(&slot.conversation)) {
                    due.remove(slave);
                }
            }
        }
        let candidate = || may_pass(&self.candidate.conversation).then_some(Turn::Candidate);
        let after = due.from(self.lanes.turn).first().map(Turn::Slave);
        after.or_else(candidate).or_else(|| due.first().map(Turn::Slave))
    }

    fn explicit(&mut self) -> Option<Action<MasterEvent>> {
        let turn = self.explicit_due()?;
        let (carried, next, conversation) = match turn {
            Turn::Slave(slave) => {
                let conversation = &mut self.board.get_mut(&mut self.slots, slave)?.conversation;
                (Carried::Explicit { slave }, slave.number().saturating_add(1), conversation)
            }
            Turn::Candidate => (Carried::Candidate, 0, &mut self.candidate.conversation),
        };
        let frame = conversation.poll()?;
        self.lanes.explicit.carries = Some(carried);
        self.lanes.contested = Identifier::of_frame(&frame).is_some_and(is_contested);
        self.lanes.taken_back = false;
        self.lanes.turn = next;
        self.cycle.explicit_given = self.cycle.explicit_given.saturating_add(1);
        self.give_way();
        Some(Action::Transmit(EXPLICIT, frame))
    }

    pub(super) fn tx_done(&mut self, token: TxToken, outcome: TxOutcome) {
        if token != SCAN {
            self.cycle.gave_way();
        }
        let lane = match token {
            ANSWERS => &mut self.lanes.answers,
            SCAN => &mut self.lanes.scan,
            EXPLICIT => &mut self.lanes.explicit,
            _ => return count(&mut self.counters.stray_tx_done),
        };
        lane.withdrawal = Withdrawal::None;
        let again = token == EXPLICIT && self.lanes.taken_back && outcome == TxOutcome::Withdrawn;
        let Some(carried) = lane.carries.take() else { return count(&mut self.counters.stray_tx_done) };
        let sent = outcome == TxOutcome::Sent;
        if sent {
            self.unacknowledged = false;
        } else {
            count32(&mut self.counters.not_sent);
        }
        match carried {
            Carried::Acknowledge | Carried::Abandoned => {}
            Carried::Output { slave, fragment } => {
                if let Some(slot) = self.board.get_mut(&mut self.slots, slave) {
                    slot.output_sent(fragment, sent);
                }
            }
            Carried::BitStrobe => {
                if sent {
                    self.expect_all(IoInstance::BitStrobe, self.board.with(&self.slots, Known::IsStrobed));
                }
                self.next_command(Position::Multicast { fragment: 0 });
            }
            Carried::Multicast { fragment } => self.multicast_sent(fragment, sent),
            Carried::Poll { slave, fragment } => self.poll_sent(slave, fragment, sent),
            Carried::Explicit { slave } => {
                if let Some(slot) = self.board.get_mut(&mut self.slots, slave) {
                    told(&mut slot.conversation, outcome, again);
                    slot.keep_time();
                    let asks = slot.conversation.is_busy() && sent;
                    self.cycle.unanswered = self.cycle.unanswered.saturating_add(asks.into());
                }
            }
            Carried::Candidate => {
                told(&mut self.candidate.conversation, outcome, again);
                self.candidate.keep_time();
            }
        }
    }

    /// The next fragment, or the first poll. A command that was given back unsent is not repeated, nor is the rest of it
    /// sent: the next scan comes soon enough.
    fn multicast_sent(&mut self, fragment: usize, sent: bool) {
        match self.multicast_output.next_fragment(fragment).filter(|_| sent) {
            Some(fragment) => self.next_command(Position::Multicast { fragment }),
            None => {
                if sent {
                    self.expect_all(
                        IoInstance::MulticastPoll,
                        self.board.with(&self.slots, Known::IsPolledInGroup),
                    );
                }
                let first = self.cycle.poll_after(
                    View::new(&self.board, &self.slots),
                    None,
                    self.config.background_ratio,
                );
                self.next_command(first);
            }
        }
    }

    /// The same for a poll.
    fn poll_sent(&mut self, slave: MacId, fragment: usize, sent: bool) {
        let slot = self.board.get_mut(&mut self.slots, slave).filter(|slot| sent && slot.is_running());
        if let Some(slot) = slot {
            if let Some(fragment) = slot.output.next_fragment(fragment) {
                return self.next_command(Position::Poll { slave, fragment });
            }
            count32(&mut slot.counters.commands);
            self.cycle.expect(IoInstance::Poll, slave);
        }
        let next = self.cycle.poll_after(
            View::new(&self.board, &self.slots),
            Some(slave),
            self.config.background_ratio,
        );
        self.next_command(next);
    }

    fn next_command(&mut self, position: Position) {
        self.cycle.position = position;
        self.cycle.skip_idle(View::new(&self.board, &self.slots), self.config.background_ratio);
        if self.cycle.position == Position::Pause {
            self.pause();
        }
    }

    /// Passes over slaves that were lost or removed before their turn came.
    pub(super) fn skip_idle(&mut self) {
        let before = self.cycle.position;
        self.cycle.skip_idle(View::new(&self.board, &self.slots), self.config.background_ratio);
        if self.cycle.position == Position::Pause && before != Position::Pause {
            self.pause();
        }
    }

    /// Takes back what is in flight to a slave that was lost or removed: no outputs for who does not run.
    pub(super) fn follow_slaves(&mut self) {
        let runs = |slave: &MacId| self.board.get(&self.slots, *slave).is_some_and(Slot::is_running);
        let speaks = |slave: &MacId| {
            self.board.get(&self.slots, *slave).is_some_and(|slot| !slot.conversation.is_cancelled())
        };
        let answer =
            matches!(&self.lanes.answers.carries, Some(Carried::Output { slave, .. }) if !runs(slave));
        let poll = matches!(&self.lanes.scan.carries, Some(Carried::Poll { slave, .. }) if !runs(slave));
        let explicit =
            matches!(&self.lanes.explicit.carries, Some(Carried::Explicit { slave }) if !speaks(slave));
        if answer {
            self.lanes.answers.carries = Some(Carried::Abandoned);
            self.lanes.answers.withdraw();
        }
        if poll {
            self.lanes.scan.withdraw();
        }
        if explicit {
            self.lanes.explicit.withdraw();
        }
    }

    fn expect_all(&mut self, instance: IoInstance, slaves: SlaveSet) {
        for slave in slaves {
            if let Some(slot) = self.board.get_mut(&mut self.slots, slave) {
                count32(&mut slot.counters.commands);
                self.cycle.expect(instance, slave);
            }
        }
    }
}

impl<const N: usize> Slot<N> {
    /// The transmission trigger of the output data is over.
    pub(super) fn trigger_output(&mut self) {
        if self.is_running() && self.output.sending == Sending::Idle {
            self.output.sending = Sending::Due(0);
        }
    }

    fn output_sent(&mut self, fragment: usize, sent: bool) {
        // It was lost meanwhile, whether or not it runs again.
        if self.output.sending != Sending::HandedOut {
            return;
        }
        if !sent {
            self.output.sending = Sending::Idle;
            self.output.changed = false;
            return self.timers.set_after(SlotTimer::Trigger, GIVEN_BACK);
        }
        if let Some(next) = self.output.next_fragment(fragment) {
            self.output.sending = Sending::Due(next);
            return;
        }
        self.output.sending = Sending::Idle;
        // The trigger runs from the end of the message on.
        let rate = self.input(IoInstance::Poll).map_or(0, |input| input.rate);
        if rate != 0 {
            self.timers.set_after(SlotTimer::Trigger, Duration::from_millis(rate.into()));
        }
        if core::mem::take(&mut self.output.changed) {
            self.output.sending = Sending::Due(0);
        }
    }
}

impl<const N: usize> Output<N> {
    pub(super) fn is_fragmented(&self) -> bool {
        self.wanted.len() > IO_UNFRAGMENTED_LEN
    }

    /// The message of which fragment `fragment` is sent next; empty while the master is idle. It does not change from its
    /// first fragment to its last.
    fn message(&mut self, run: bool, fragment: usize) -> &[u8] {
        if fragment == 0 {
            self.sent.clear();
            if run {
                self.sent.clone_from(&self.wanted);
            }
        }
        &self.sent
    }

    /// The fragment after `fragment`.
    fn next_fragment(&self, fragment: usize) -> Option<usize> {
        let next = fragment.saturating_add(1);
        let more = self.is_fragmented() && next.saturating_mul(IO_FRAGMENT_LEN) < self.sent.len();
        more.then_some(next)
    }
}

/// One frame of an I/O message.
fn io_frame(id: Identifier, data: &[u8], fragmented: bool, fragment: usize) -> Option<Frame> {
    if !fragmented || data.is_empty() {
        return id.frame(data);
    }
    let start = fragment.saturating_mul(IO_FRAGMENT_LEN);
    let rest = data.get(start..)?;
    let part = rest.get(..IO_FRAGMENT_LEN).unwrap_or(rest);
    let count = u8::try_from(fragment).ok()?;
    let byte = match (fragment, rest.len() > IO_FRAGMENT_LEN) {
        (0, false) => FragmentByte::FIRST_AND_ONLY,
        (0, true) => FragmentByte::FIRST,
        (_, true) => FragmentByte::new(FragmentKind::Middle, count),
        (_, false) => FragmentByte::new(FragmentKind::Last, count),
    };
    message::frame(id, &message::IoFragment { fragment: byte, data: part })
}

/// Whether other masters use the same identifier.
fn is_contested(id: Identifier) -> bool {
    id.purpose() == Purpose::Group2UnconnectedRequest
}

/// What became of a frame of a conversation; `again`: it was taken back, and is wanted again.
fn told<const N: usize>(conversation: &mut Conversation<N>, outcome: TxOutcome, again: bool) {
    if again {
        conversation.taken_back();
    } else {
        conversation.tx_done(outcome);
    }
}

/// Before output data that the controller gave back are sent again.
const GIVEN_BACK: Duration = Duration::from_millis(10);
const ANSWERS: TxToken = TxToken(0x1001);
const SCAN: TxToken = TxToken(0x1002);
const EXPLICIT: TxToken = TxToken(0x1003);
