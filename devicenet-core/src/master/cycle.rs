//! The scan: which I/O command comes next.
//!
//! ```text
//! strobe | multicast poll | poll 1, poll 2, ... poll n | responses that are missing, explicit messages | strobe ...
//!        commands back-to-back                          |<-- interscan delay, at least ------------------->|
//! ```
//!
//! A poll is not held up by the response to the one before: responses carry the slave's MAC ID. Source: Networking with
//! DeviceNet (Circuit Cellar 99, 1998); 1771-SDN manual (interscan delay, foreground to background poll ratio).
//!
//! Without an interscan delay the scan alone would fill the bus, and what has a higher identifier than its commands
//! (explicit messages, heartbeats and duplicate MAC ID checks of most nodes) would lose every arbitration. So a scan
//! gives way before the next begins: until nobody has begun to send for a moment and the master's own explicit messages
//! are answered, but for no more frames than those that take their share of the scan, and one more. The master itself
//! sends no more explicit messages in a scan than their share, unless the interscan delay leaves them time. The share is
//! one for every eighth slave that is polled, or for each slave that is brought up, whichever is more: a slave that is not
//! polled yet may take the time of its poll.
//!
//! After an error on the bus it gives way for longer in this scan and in the next, 2 ms, the time of a frame and some more. Two nodes fresh from the
//! factory that check MAC ID 63 in the same bit destroy each other's frames until both are error-passive; then one gets
//! through, and the other needs some idle bits to end its error flag and delimiter. In a scan that goes on three bits after
//! that frame it counts eight errors for every frame instead, and is soon bus-off.

use super::board::{Known, View};
use super::scan_list::IoInstance;
use super::set::SlaveSet;
use super::slot::Slot;
use crate::id::MacId;

/// Where the scan is.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Cycle {
    pub(super) position: Position,
    pub(super) number: u32,
    /// The slaves whose responses are missing, by instance.
    awaited: [SlaveSet; 4],
    /// The interscan delay is over.
    pub(super) delay_over: bool,
    /// So is the wait for missing responses.
    pub(super) wait_over: bool,
    /// Explicit messages that were handed out since the scan began.
    pub(super) explicit_given: u16,
    /// Frames outside of the scan that the bus carried since all commands were out.
    pub(super) given_way: u16,
    /// Explicit messages of this scan that are to be answered.
    pub(super) unanswered: u16,
    /// Nobody has sent for a moment.
    pub(super) quiet: bool,
    /// There was an error on the bus in this scan or in the one before: the scans in which it counts.
    pub(super) disturbed: u8,
    /// How many explicit messages the master may send in this scan.
    share: u16,
    commanded: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Position {
    /// Nobody is to be scanned.
    Stopped,
    BitStrobe,
    Multicast {
        fragment: usize,
    },
    Poll {
        slave: MacId,
        fragment: usize,
    },
    /// All commands are out.
    Pause,
}

impl Cycle {
    pub(super) const fn new() -> Self {
        Self {
            position: Position::Stopped,
            number: 0,
            awaited: [SlaveSet::EMPTY; 4],
            delay_over: false,
            wait_over: false,
            explicit_given: 0,
            given_way: 0,
            unanswered: 0,
            quiet: false,
            disturbed: 0,
            share: 1,
            commanded: false,
        }
    }

    pub(super) fn stop(&mut self) {
        *self = Self { number: self.number, ..Self::new() };
    }

    /// Begins a scan.
    pub(super) fn begin<const S: usize, const N: usize>(&mut self, slots: View<'_, S, N>, ratio: u16) {
        self.number = self.number.wrapping_add(1);
        self.awaited = [SlaveSet::EMPTY; 4];
        self.delay_over = false;
        self.wait_over = false;
        self.explicit_given = 0;
        self.given_way = 0;
        self.unanswered = 0;
        self.quiet = false;
        self.disturbed = self.disturbed.saturating_sub(1);
        let polled = slots.with(Known::IsPolled).len();
        let configured = slots.with(Known::IsConfigured).len();
        let share = polled.wrapping_div(POLLS_PER_EXPLICIT).max(configured).max(1);
        self.share = u16::try_from(share).unwrap_or(u16::MAX);
        self.commanded = false;
        self.position = Position::BitStrobe;
        self.skip_idle(slots, ratio);
    }

    /// Goes on to the next command that has somebody to go to.
    pub(super) fn skip_idle<const S: usize, const N: usize>(&mut self, slots: View<'_, S, N>, ratio: u16) {
        if self.position == Position::BitStrobe && slots.with(Known::IsStrobed).is_empty() {
            self.position = Position::Multicast { fragment: 0 };
        }
        if matches!(self.position, Position::Multicast { .. })
            && slots.with(Known::IsPolledInGroup).is_empty()
        {
            self.position = self.poll_after(slots, None, ratio);
        }
        if let Position::Poll { slave, .. } = self.position
            && !slots.with(Known::IsPolled).contains(slave)
        {
            self.position = self.poll_after(slots, Some(slave), ratio);
        }
    }

    /// The first poll command, or the one after that of a slave.
    pub(super) fn poll_after<const S: usize, const N: usize>(
        &self,
        slots: View<'_, S, N>,
        after: Option<MacId>,
        ratio: u16,
    ) -> Position {
        let mut polled = slots.with(Known::IsPolled);
        if self.number.checked_rem(ratio.into()).unwrap_or(0) != 0 {
            polled = polled.difference(slots.with(Known::IsBackground));
        }
        let next = after.map_or(polled, |after| polled.after(after)).first();
        next.map_or(Position::Pause, |slave| Position::Poll { slave, fragment: 0 })
    }

    /// Whether anybody would be scanned.
    pub(super) fn is_needed<const S: usize, const N: usize>(slots: View<'_, S, N>) -> bool {
        let scanned = [Known::IsStrobed, Known::IsPolledInGroup, Known::IsPolled];
        scanned.into_iter().any(|what| !slots.with(what).is_empty())
    }

    /// A response is expected from now on.
    pub(super) fn expect(&mut self, instance: IoInstance, slave: MacId) {
        self.commanded = true;
        if let Some(awaited) = self.awaited.get_mut(instance.index()) {
            awaited.insert(slave);
        }
    }

    /// It is there, or will never be.
    pub(super) fn satisfy(&mut self, instance: IoInstance, slave: MacId) {
        if let Some(awaited) = self.awaited.get_mut(instance.index()) {
            awaited.remove(slave);
        }
    }

    /// Nothing of that slave is expected any more.
    pub(super) fn forget(&mut self, slave: MacId) {
        for awaited in &mut self.awaited {
            awaited.remove(slave);
        }
    }

    /// The slaves of which a response is missing.
    pub(super) fn missing(&self) -> SlaveSet {
        self.awaited.iter().fold(SlaveSet::EMPTY, |missing, awaited| missing.union(*awaited))
    }

    /// Whether a command was sent since the scan began.
    pub(super) fn sent_commands(&self) -> bool {
        self.commanded
    }

    /// There was an error on the bus: this scan and the next give way for longer.
    pub(super) fn was_disturbed(&mut self) {
        self.disturbed = 2;
        self.gave_way();
    }

    /// A frame outside of the scan was on the bus.
    pub(super) fn gave_way(&mut self) {
        if self.position == Position::Pause {
            self.given_way = self.given_way.saturating_add(1);
        }
    }

    /// Whether the master may send one more explicit message.
    pub(super) fn explicit_may_pass(&self) -> bool {
        let alone = match self.position {
            Position::Stopped => true,
            Position::Pause => !self.delay_over,
            Position::BitStrobe | Position::Multicast { .. } | Position::Poll { .. } => false,
        };
        alone || self.explicit_given < self.share
    }

    /// Whether the next scan may begin.
    pub(super) fn is_over(&self) -> bool {
        let complete = self.missing().is_empty();
        let gave_way = self.quiet || self.given_way > self.share.saturating_mul(2);
        self.position == Position::Pause && self.delay_over && (complete || self.wait_over) && gave_way
    }
}

/// Whether a slave is scanned over an instance. Change-of-state data of the master are sent outside of the scan.
pub(super) fn takes_part<const N: usize>(slot: &Slot<N>, instance: IoInstance) -> bool {
    slot.is_running()
        && match instance {
            IoInstance::Poll => slot.entry.poll.is_some(),
            IoInstance::BitStrobe => slot.entry.bit_strobe.is_some(),
            IoInstance::MulticastPoll => slot.entry.multicast_poll.is_some(),
            IoInstance::ChangeOfState => false,
        }
}

/// A scan of so many slaves has room for one explicit message of the master, and for its response.
const POLLS_PER_EXPLICIT: u32 = 8;
