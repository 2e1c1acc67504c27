//! What the master sends, in the order of its [lanes](super::lanes): answers, the scan, explicit messages.
//!
//! A scan has room for some explicit messages, so that neither starves the other: see [`cycle`](super::cycle).

use cip_core::fragment::{FragmentByte, FragmentKind, IO_FRAGMENT_LEN, IO_UNFRAGMENTED_LEN};
use link_core::{Action, Frame};

use super::board::Known;
use super::cycle::Position;
use super::event::MasterEvent;
use super::lanes::{ANSWERS, Carried, EXPLICIT, SCAN, Turn};
use super::machine::{Master, Timer};
use super::slot::{Output, Sending};
use crate::client::Conversation;
use crate::id::{Identifier, MacId, Purpose};
use crate::message::{self, BitStrobeCommand, Wire};

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
    pub(super) fn next_fragment(&self, fragment: usize) -> Option<usize> {
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
