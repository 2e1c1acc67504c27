//! Who owns a slave, and what ends with a connection.

use cip_core::connection::{ExplicitCause, ExplicitState, IoCause, IoState};
use cip_core::message::AllocationChoice;

use super::application::{Application, IoKind, Parts};
use super::config::Options;
use super::machine::changes;
use super::node::{BOTH, Changed, Node, Parent, bits_of};

impl<A: Application, const DYNAMIC: usize> Node<A, DYNAMIC> {
    /// The network is gone: nothing of any connection is left.
    pub(super) fn lose_network(&mut self) {
        IoKind::each::<A>(|kind| {
            // Nobody waits for an answer.
            let _ = self.io_step(kind, IoCause::NetworkLost);
        });
        let _ = self.explicit_step(ExplicitCause::NetworkLost);
        self.lose_dynamic();
        self.settle();
    }

    /// What follows from the end of a connection: who hung on it, and whether the slave is still owned.
    pub(super) fn settle(&mut self) {
        if !self.changed.contains(Changed::CONNECTIONS) {
            return;
        }
        self.changed.remove(Changed::CONNECTIONS);
        self.changed.insert(Changed::FILTER);
        if !self.is_io_established() {
            let _ = self.explicit_step(ExplicitCause::IoEnded);
            self.end_deferred();
        }
        let parent_exists = match self.parent {
            Parent::Dynamic(index) if DYNAMIC > 0 => self.is_open(index),
            Parent::Predefined | Parent::Dynamic(_) => self.explicit.state() != ExplicitState::NonExistent,
        };
        let alone = !self.is_io_established() && self.explicit.state() == ExplicitState::NonExistent;
        if !parent_exists && (alone || self.options.contains(Options::DROP_CONFIGURING_WITH_EXPLICIT)) {
            IoKind::each::<A>(|kind| {
                let _ = self.io_step(kind, IoCause::ExplicitGone);
            });
        }
        self.forget_what_is_gone();
        if alone && !parent_exists {
            self.end_ownership();
        }
        self.changed.remove(Changed::CONNECTIONS);
    }

    /// Bits of connections that do not exist any more.
    fn forget_what_is_gone(&mut self) {
        if self.explicit.state() == ExplicitState::NonExistent {
            self.drop_bits(AllocationChoice::EXPLICIT);
        }
        IoKind::each::<A>(|kind| {
            if self.io(kind).state() == IoState::NonExistent {
                self.drop_bits(bits_of(kind));
            }
        });
        if changes::<A>() && !self.held.intersects(BOTH) {
            self.drop_bits(AllocationChoice::ACK_SUPPRESSION);
        }
    }

    /// What is allocated has changed, or whose it is: that is told, and nothing else follows.
    pub(super) fn allocation_changed(&mut self) {
        if A::PARTS.contains(Parts::REPORTS) {
            self.changed.insert(Changed::ALLOCATION);
        }
    }

    fn drop_bits(&mut self, bits: AllocationChoice) {
        if self.held.intersects(bits) {
            self.held.remove(bits);
            self.allocation_changed();
        }
    }

    fn end_ownership(&mut self) {
        if self.master.take().is_some() {
            self.allocation_changed();
        }
        if !self.options.contains(Options::KEEP_TIMED_OUT) {
            self.release_timed_out();
            self.forget_what_is_gone();
        }
    }

    /// Instances that timed out are deleted.
    pub(super) fn release_timed_out(&mut self) {
        IoKind::each::<A>(|kind| {
            if self.io(kind).state() == IoState::TimedOut {
                let _ = self.io_step(kind, IoCause::Released);
            }
        });
    }
}
