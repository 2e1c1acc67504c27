//! What follows from an input before anything is sent: on line or off, connections, modes, what is to be told.

use cip_core::connection::ExplicitState;

use super::application::Application;
use super::event::SlaveEvent;
use super::machine::Slave;
use super::node::Changed;

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Slave<A, MESSAGE, DYNAMIC> {
    /// What follows from the changes of an input before anything is sent.
    #[inline]
    pub(super) fn follow(&mut self) {
        // What network access does is an errand.
        if self.may_have_errand() || self.node.departure.is_some() || !self.node.changed.is_empty() {
            self.follow_changes();
        }
    }

    #[inline(never)]
    fn follow_changes(&mut self) {
        self.follow_departure();
        if self.online != self.node.access.is_online() {
            self.online = self.node.access.is_online();
            if self.online { self.go_online() } else { self.go_offline() }
        }
        if self.node.changed.is_empty() {
            return;
        }
        self.look_for_errands();
        if self.node.changed.contains(Changed::CONNECTIONS) {
            self.node.settle();
            self.close_transfers();
        }
        self.follow_modes();
        if self.node.changed.contains(Changed::HEARTBEAT) {
            self.start_heartbeat();
        }
        if self.node.changed.contains(Changed::ALLOCATION) {
            let (choice, master) = (self.node.choice(), self.node.master);
            self.node.report(SlaveEvent::Allocation { choice, master });
        }
        // The port is told of the filter with the other actions.
        self.node.changed = self.node.changed.intersection(Changed::FILTER);
    }

    fn go_online(&mut self) {
        self.node.changed.insert(Changed::FILTER);
        self.start_heartbeat();
    }

    fn go_offline(&mut self) {
        self.look_for_errands();
        let dropped = self.node.access.is_off_the_bus();
        self.node.lose_network();
        self.node.lines.stop_all(dropped);
        self.explicit.clear(&mut self.node.timers);
        for (dynamic, timers) in self.transfers.iter_mut().zip(&mut self.node.dynamic_timers) {
            dynamic.transfer.clear(timers);
            dynamic.unwanted = dynamic.in_flight && !dropped;
        }
        self.answers.clear();
        self.stop_heartbeat();
        // Network access has its own, and that of the slave is set anew on line. `must_set_filter` relies on it that off line
        // nobody asks for one.
        self.node.changed.remove(Changed::FILTER);
        // Whoever wanted to leave has left by other means; what was accepted is carried out all the same.
        self.leave();
    }

    fn close_transfers(&mut self) {
        if self.node.explicit.state() == ExplicitState::NonExistent {
            self.explicit.close(&mut self.node.timers);
        }
        let timers = &mut self.node.dynamic_timers;
        for ((dynamic, timers), transfer) in self.node.dynamic.iter().zip(timers).zip(&mut self.transfers) {
            if !dynamic.is_open() {
                transfer.transfer.close(timers);
            }
        }
    }
}
