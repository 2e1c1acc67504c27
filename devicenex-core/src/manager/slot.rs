//! What the manager keeps for one planned device.

use cip_core::client::Waits;
use heapless::Vec;
use link_core::Timers;
use link_core::timers::TimerKey;

use super::database::{PlannedDevice, SPARES};
use super::event::PlannedEvent;
use super::made::{Looked, Made, Setting, Stage};
use super::state::{Cause, DeviceState, EDGES};
use crate::client::{Conversation, Route};
use crate::id::OperationalAddress;
use crate::message::DeviceIdentity;

/// One planned device: its entry, who has its address, what is being done about it.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Slot<const CONNECTIONS: usize> {
    pub(super) plan: PlannedDevice<CONNECTIONS>,
    pub(super) state: DeviceState,
    /// Who has the address, gets it, or had it.
    pub(super) device: Option<DeviceIdentity>,
    /// Who was lost, until somebody is on line again.
    pub(super) was: Option<DeviceIdentity>,
    /// Whoever may have the address gets it, spares included.
    pub(super) open: bool,
    /// That nobody can stand in.
    pub(super) no_spare: Tell,
    /// A ROAM is to be sent.
    pub(super) roam_due: bool,
    /// How many were sent.
    pub(super) roams: u8,
    /// Those that did not take the address: they are passed over for a while.
    pub(super) unwilling: Vec<DeviceIdentity, SPARES>,
    /// Who has the address though it is planned for another, and was told to have it.
    pub(super) holder: Option<Option<DeviceIdentity>>,
    /// How often it was still there when it was looked at again.
    pub(super) conflicts: u8,
    /// What has been read so far of the identity of whoever has the address.
    pub(super) probe: Probe,
    pub(super) conversation: Conversation<MESSAGE>,
    pub(super) task: Task,
    /// The explicit connection of the predefined set was refused: a dynamic one is asked for.
    pub(super) dynamic: bool,
    /// The explicit connection with the device, while it is being configured.
    pub(super) explicit: Option<Route>,
    /// In the order of the plan.
    pub(super) made: [Made; CONNECTIONS],
    /// The dynamic connections of the device that may be the one that is looked for.
    pub(super) listed: Option<Vec<u8, LISTED>>,
    /// The connection on which nothing was heard.
    pub(super) timed_out: Option<u8>,
    /// The connection that was asked for its state last.
    pub(super) polled: u8,
    pub(super) poll_due: bool,
    /// A setting was not answered, and the explicit connection opened anew for it.
    pub(super) reopened: bool,
    /// How many of the attributes were read.
    pub(super) reads: u8,
    pub(super) timers: Timers<SlotTimer, 5>,
}

/// What is told once.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Tell {
    No,
    Due,
    Told,
}

/// What the present transaction is about.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Task {
    None,
    /// Who has the address.
    Probe,
    /// A connection is asked for.
    Connect(u8),
    /// The explicit connection is asked for, to configure one.
    OpenExplicit(u8),
    /// An attribute of a connection is set.
    Write(u8, Setting),
    /// The connections of the device are listed, to find a dynamic one.
    List(u8),
    /// A connection that may be there is looked at.
    Check(u8, Looked),
    /// A dynamic connection is deleted, to be made anew.
    Delete(u8),
    /// A connection that should be there is asked for its state.
    Poll(u8),
    /// The device is asked for its address.
    Alive,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Probe {
    pub(super) vendor: Option<u16>,
    pub(super) product_code: Option<u16>,
    pub(super) major_revision: Option<u8>,
    pub(super) serial: Option<u32>,
}

/// The waits for one device.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum SlotTimer {
    Conversation,
    /// Of the state.
    Wait,
    Poll,
    /// Before a connection that was refused is asked for again.
    Retry,
    /// Before a device that did not take the address may have it again.
    Shun,
}

impl TimerKey<5> for SlotTimer {
    const ALL: [Self; 5] = [Self::Conversation, Self::Wait, Self::Poll, Self::Retry, Self::Shun];
    const WHY: [&'static str; 5] = [
        "response of a device",
        "a device",
        "poll of a connection's state",
        "next attempt at a connection",
        "next attempt at a device that did not take its address",
    ];

    fn index(self) -> usize {
        match self {
            Self::Conversation => 0,
            Self::Wait => 1,
            Self::Poll => 2,
            Self::Retry => 3,
            Self::Shun => 4,
        }
    }
}

impl<const CONNECTIONS: usize> Slot<CONNECTIONS> {
    pub(super) fn new(plan: PlannedDevice<CONNECTIONS>, own: OperationalAddress, waits: Waits) -> Self {
        Self {
            conversation: Conversation::new(Route::connectionless(own, plan.address), waits),
            plan,
            state: DeviceState::Idle,
            device: None,
            was: None,
            open: false,
            no_spare: Tell::No,
            roam_due: false,
            roams: 0,
            unwilling: Vec::new(),
            holder: None,
            conflicts: 0,
            probe: Probe::default(),
            task: Task::None,
            dynamic: false,
            explicit: None,
            made: [const { Made::NEW }; CONNECTIONS],
            listed: None,
            timed_out: None,
            polled: 0,
            poll_due: false,
            reopened: false,
            reads: 0,
            timers: Timers::new(),
        }
    }

    pub(super) const fn address(&self) -> OperationalAddress {
        self.plan.address
    }

    /// The one door between states. The owner tells the event.
    pub(super) fn enter(&mut self, next: DeviceState, cause: Cause) -> PlannedEvent {
        let from = self.state;
        debug_assert!(
            EDGES.iter().any(|edge| (edge.from, edge.cause, edge.to) == (from, cause, next)),
            "no transition from {from} to {next} by {cause}"
        );
        #[cfg(test)]
        super::tests::edges::record(from, cause, next);
        self.timers.clear(SlotTimer::Wait);
        self.roam_due = false;
        match next {
            DeviceState::Idle
            | DeviceState::Probing
            | DeviceState::Missing
            | DeviceState::Found
            | DeviceState::Joining
            | DeviceState::Lost
            | DeviceState::Conflict => self.forget_connections(),
            // A device that is there already may have its connections.
            DeviceState::Connecting
                if matches!(cause, Cause::Identified | Cause::HelloResponse | Cause::Answered) =>
            {
                self.stop_talking();
                self.doubt_connections();
            }
            DeviceState::Retrying => self.stop_talking(),
            DeviceState::Assigned | DeviceState::Connecting | DeviceState::Running => {}
        }
        self.state = next;
        PlannedEvent::StateChanged { from, to: next, cause }
    }

    /// The planned connections and what has become of them.
    pub(super) fn connections_mut(
        &mut self,
    ) -> impl Iterator<Item = (u8, &super::PlannedConnection, &mut Made)> {
        (0_u8..)
            .zip(self.plan.connections.iter().zip(&mut self.made))
            .map(|(n, (plan, made))| (n, plan, made))
    }

    pub(super) fn made(&self, connection: u8) -> Option<&Made> {
        self.made.get(usize::from(connection))
    }

    pub(super) fn made_mut(&mut self, connection: u8) -> Option<&mut Made> {
        self.made.get_mut(usize::from(connection))
    }

    pub(super) fn planned(&self, connection: u8) -> Option<super::PlannedConnection> {
        self.plan.connections.get(usize::from(connection)).copied()
    }

    /// Nothing is left of what was said and made.
    pub(super) fn forget_connections(&mut self) {
        self.stop_talking();
        self.timers.clear(SlotTimer::Poll);
        self.timers.clear(SlotTimer::Retry);
        self.poll_due = false;
        self.timed_out = None;
        for made in &mut self.made {
            made.set(Stage::Idle);
            made.produces = None;
            made.consumes = None;
            made.instance = None;
            made.rate = None;
        }
    }

    /// They may be there, or not.
    fn doubt_connections(&mut self) {
        for (_, plan, made) in self.connections_mut() {
            if made.instance.is_none() {
                made.instance = plan.number().map(|instance| instance.0);
            }
            if !matches!(made.stage, Stage::Refused(_)) {
                made.set(Stage::Unknown);
            }
        }
    }

    /// It did not take the address; the last ones of these are remembered.
    pub(super) fn shun(&mut self, device: DeviceIdentity) {
        if self.unwilling.is_full() {
            self.unwilling.remove(0);
        }
        let pushed = self.unwilling.push(device);
        debug_assert!(pushed.is_ok());
    }

    pub(super) fn shuns(&self, device: &DeviceIdentity) -> bool {
        self.unwilling.contains(device)
    }

    pub(super) fn forgive(&mut self) {
        self.unwilling.clear();
        self.timers.clear(SlotTimer::Shun);
    }

    /// A dynamic connection that is not one of those that are known is a candidate.
    pub(super) fn list(&mut self, numbers: &[u8]) {
        let is_known = |number: u8| self.made.iter().any(|made| made.instance == Some(number.into()));
        let candidates = numbers.iter().copied().filter(|number| *number >= 128 && !is_known(*number));
        self.listed = Some(candidates.take(LISTED).collect());
    }

    /// Whether every planned connection is there.
    pub(super) fn is_complete(&self) -> bool {
        self.made.iter().take(self.plan.connections.len()).all(|made| made.stage == Stage::Established)
    }

    pub(super) fn stop_talking(&mut self) {
        self.conversation.cancel();
        self.task = Task::None;
        self.listed = None;
        self.explicit = None;
        self.dynamic = false;
        self.keep_time();
    }

    /// Carries out what the conversation wants of its timer.
    pub(super) fn keep_time(&mut self) {
        self.conversation.take_timer().apply(&mut self.timers, SlotTimer::Conversation);
    }
}

/// So many of the dynamic connections of a device are looked at.
const LISTED: usize = 14;
/// The longest request is ten bytes: an attribute of four in the 16/16 format; the answers are shorter.
const MESSAGE: usize = 16;
