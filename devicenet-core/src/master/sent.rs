//! What became of the frames that were handed out, and what follows from it.

use core::time::Duration;

use link_core::{TxOutcome, TxToken};

use super::board::{Known, View};
use super::cycle::Position;
use super::lanes::{ANSWERS, Carried, EXPLICIT, SCAN, Withdrawal};
use super::machine::Master;
use super::scan_list::IoInstance;
use super::set::SlaveSet;
use super::slot::{Sending, Slot, SlotTimer};
use crate::client::Conversation;
use crate::counter::{count, count_wide};
use crate::id::MacId;

impl<const SLAVES: usize, const MESSAGE: usize> Master<SLAVES, MESSAGE> {
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
            count_wide(&mut self.counters.not_sent);
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
            count_wide(&mut slot.counters.commands);
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
                count_wide(&mut slot.counters.commands);
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
