//! Explicit connections that clients open through the UCMM: instances 6 and up of the Connection object.

use cip_core::connection::{ExplicitCause, ExplicitConnection, ExplicitState, Settings};
use cip_core::message::BodyFormat;
use cip_core::object::Failure;
use link_core::Instant;

use super::application::Application;
use super::connection_object::GONE;
use super::event::{SlaveEvent, count};
use super::machine::{DynamicTransfer, Slave};
use super::node::{Changed, Node};
use super::timer::Timer;
use crate::id::{Identifier, MacId};

/// One of them, open or not.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Dynamic {
    pub(super) connection: ExplicitConnection,
    pub(super) client: MacId,
    pub(super) format: BodyFormat,
    pub(super) group: Group,
    /// Of the requests: from the client's pool in the groups 1 and 3, from ours in group 2.
    pub(super) request: u8,
    /// Of the responses, always from our pool.
    pub(super) response: u8,
}

/// The message groups that a connection can be in.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Group {
    One,
    Two,
    Three,
}

impl Dynamic {
    pub(super) const CLOSED: Self = Self {
        connection: ExplicitConnection::NON_EXISTENT,
        client: MacId::MIN,
        format: BodyFormat::Class8Instance8,
        group: Group::Three,
        request: 0,
        response: 0,
    };

    pub(super) fn is_open(&self) -> bool {
        self.connection.state() != ExplicitState::NonExistent
    }

    /// Where its requests come.
    pub(super) fn consumed(&self, own: MacId) -> Option<Identifier> {
        match self.group {
            Group::One => Identifier::group1(self.request, self.client),
            Group::Two => Identifier::group2(own, self.request),
            Group::Three => Identifier::group3(self.request, self.client),
        }
    }

    /// Where its responses go.
    pub(super) fn produced(&self, own: MacId) -> Option<Identifier> {
        match self.group {
            Group::One => Identifier::group1(self.response, own),
            Group::Two => Identifier::group2(own, self.response),
            Group::Three => Identifier::group3(self.response, own),
        }
    }

    /// The MAC ID that the header of a request carries.
    pub(super) fn expected_header(&self, own: MacId) -> MacId {
        match self.group {
            Group::One | Group::Three => own,
            Group::Two => self.client,
        }
    }

    /// Attribute 6.
    pub(super) const fn characteristics(&self) -> u8 {
        match self.group {
            Group::One => 0x00,
            Group::Two => 0x21,
            Group::Three => 0x33,
        }
    }
}

impl<A: Application, const DYNAMIC: usize> Node<A, DYNAMIC> {
    pub(super) fn is_open(&self, index: u8) -> bool {
        self.dynamic.get(usize::from(index)).is_some_and(Dynamic::is_open)
    }

    pub(super) fn is_any_open(&self) -> bool {
        self.dynamic.iter().any(Dynamic::is_open)
    }

    /// The one door of a connection that was opened dynamically.
    pub(super) fn dynamic_step(&mut self, index: u8, cause: ExplicitCause) -> Result<(), Failure> {
        let Some(dynamic) = self.dynamic.get_mut(usize::from(index)) else {
            return Err(GONE);
        };
        let from = dynamic.connection.state();
        let result = dynamic.connection.handle(cause);
        let (to, settings) = (dynamic.connection.state(), *dynamic.connection.settings());
        #[cfg(test)]
        super::tests::edges::record_explicit(from, cause, to);
        if from != to {
            self.report(SlaveEvent::Explicit { instance: instance(index), from, to, cause });
            self.changed.insert(Changed::CONNECTIONS);
        }
        if let Some(timers) = self.dynamic_timers.get_mut(usize::from(index)) {
            let (rate, multiplier) = (settings.expected_packet_rate(), settings.multiplier());
            result?.apply(timers, Timer::Explicit, rate, multiplier);
        }
        Ok(())
    }

    pub(super) fn dynamic_settings_mut(&mut self, index: u8) -> Result<&mut Settings, Failure> {
        let dynamic = self.dynamic.get_mut(usize::from(index));
        dynamic.map(|one| one.connection.settings_mut()).ok_or(GONE)
    }

    pub(super) fn dynamic_timed_out(&mut self, index: u8) {
        count::<A>(&mut self.events.counters.timed_out);
        let io_established = self.is_io_established();
        let _ = self.dynamic_step(index, ExplicitCause::WatchdogExpired { io_established });
    }

    pub(super) fn lose_dynamic(&mut self) {
        for index in indices::<DYNAMIC>() {
            let _ = self.dynamic_step(index, ExplicitCause::NetworkLost);
        }
    }

    fn take_expired_dynamic(&mut self, until: Instant) -> Option<(u8, Timer)> {
        let ends = indices::<DYNAMIC>()
            .zip(&self.dynamic_timers)
            .filter_map(|(index, timers)| Some((timers.next()?.at, index)));
        let (_, index) = ends.min()?;
        Some((index, self.dynamic_timers.get_mut(usize::from(index))?.take_expired(until)?))
    }

    /// The end of the last I/O connection is the end of those that waited for it.
    pub(super) fn end_deferred(&mut self) {
        for index in indices::<DYNAMIC>() {
            let _ = self.dynamic_step(index, ExplicitCause::IoEnded);
        }
    }
}

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Slave<A, MESSAGE, DYNAMIC> {
    /// Serves every wait of these connections that is over at `until`, the one that ended first before the others.
    pub(super) fn expire_dynamic(&mut self, until: Instant) {
        while DYNAMIC > 0
            && let Some((index, timer)) = self.node.take_expired_dynamic(until)
        {
            let Some(DynamicTransfer { transfer, .. }) = self.transfers.get_mut(usize::from(index)) else {
                return;
            };
            match timer {
                Timer::Explicit => self.node.dynamic_timed_out(index),
                Timer::FragmentAcknowledge => {
                    if transfer.not_acknowledged() {
                        let instance = instance(index);
                        self.node.report(SlaveEvent::ResponseAbandoned { instance });
                    }
                }
                Timer::Reassembly => transfer.reassembly_over(),
                Timer::Io(_) | Timer::Trigger | Timer::Inhibit | Timer::Acknowledge | Timer::Heartbeat => {}
            }
        }
    }
}

/// All of them, by their place.
pub(super) fn indices<const DYNAMIC: usize>() -> impl Iterator<Item = u8> {
    0..u8::try_from(DYNAMIC).unwrap_or(u8::MAX)
}

/// The instance of the Connection object.
pub(super) const fn instance(index: u8) -> u8 {
    index.saturating_add(FIRST_INSTANCE)
}

/// After those of the predefined set.
pub(super) const FIRST_INSTANCE: u8 = 6;
