//! What the manager keeps for one planned device.

use core::time::Duration;

use cip_core::client::Waits;
use cip_core::code::GeneralStatus;
use link_core::Timers;
use link_core::timers::TimerKey;

use super::database::PlannedDevice;
use super::event::PlannedEvent;
use super::state::{Cause, DeviceState, EDGES};
use crate::client::{Conversation, Route};
use crate::connection::ConnectionId;
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
    /// The connection on which nothing was heard.
    pub(super) timed_out: Option<u8>,
    /// The connection that was asked for its state last.
    pub(super) polled: u8,
    pub(super) poll_due: bool,
    /// A setting was not answered, and the explicit connection opened anew for it.
    pub(super) reopened: bool,
    /// How many of the attributes were read.
    pub(super) reads: u8,
    pub(super) timers: Timers<SlotTimer, 4>,
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
    /// A connection that may be there is looked at.
    Check(u8, Looked),
    /// A connection that should be there is asked for its state.
    Poll(u8),
    /// The device is asked for its address.
    Alive,
}

/// What is set on a connection that is being configured.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(super) enum Setting {
    Trigger,
    ConsumedId,
    WatchdogAction,
    PacketRate,
}

impl Setting {
    /// In the order in which they are set; the packet rate establishes the connection.
    pub(super) const ALL: [Self; 4] =
        [Self::Trigger, Self::ConsumedId, Self::WatchdogAction, Self::PacketRate];

    pub(super) const fn next(self) -> Option<Self> {
        match self {
            Self::Trigger => Some(Self::ConsumedId),
            Self::ConsumedId => Some(Self::WatchdogAction),
            Self::WatchdogAction => Some(Self::PacketRate),
            Self::PacketRate => None,
        }
    }
}

/// What is read of a connection that may be there.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Looked {
    State,
    ProducedId,
    ConsumedId,
    PacketRate,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Probe {
    pub(super) vendor: Option<u16>,
    pub(super) product_code: Option<u16>,
    pub(super) major_revision: Option<u8>,
    pub(super) serial: Option<u32>,
}

/// A planned connection as it is.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Made {
    pub(super) stage: Stage,
    /// The number of the instance, once it is known.
    pub(super) instance: Option<u16>,
    /// On which the device produces.
    pub(super) produces: Option<ConnectionId>,
    /// In ms.
    pub(super) rate: u16,
    /// What it was told to consume, or said that it does.
    pub(super) consumes: Option<ConnectionId>,
    pub(super) watch: Timers<Watch, 1>,
}

/// How far a connection is.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Stage {
    /// To be asked for.
    Idle,
    /// It may be there: to be looked at.
    Unknown,
    /// It is there, and this is to be set next.
    Configuring(Setting),
    Established,
    /// To be asked for after a while.
    Refused(Option<GeneralStatus>),
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
}

/// The wait for the next message of a producer.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Watch;

impl TimerKey<4> for SlotTimer {
    const ALL: [Self; 4] = [Self::Conversation, Self::Wait, Self::Poll, Self::Retry];
    const WHY: [&'static str; 4] =
        ["response of a device", "a device", "poll of a connection's state", "next attempt at a connection"];

    fn index(self) -> usize {
        match self {
            Self::Conversation => 0,
            Self::Wait => 1,
            Self::Poll => 2,
            Self::Retry => 3,
        }
    }
}

impl TimerKey<1> for Watch {
    const ALL: [Self; 1] = [Self];
    const WHY: [&'static str; 1] = ["message of a producer"];

    fn index(self) -> usize {
        0
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
            probe: Probe::default(),
            task: Task::None,
            dynamic: false,
            explicit: None,
            made: [const { Made::NEW }; CONNECTIONS],
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
        }
    }

    /// They may be there, or not.
    fn doubt_connections(&mut self) {
        for (_, plan, made) in self.connections_mut() {
            if made.instance.is_none() {
                made.instance = plan.number().map(|instance| instance.0);
            }
            if !matches!(made.stage, Stage::Refused(_)) && made.instance.is_some() {
                made.set(Stage::Unknown);
            }
        }
    }

    /// Whether every planned connection is there.
    pub(super) fn is_complete(&self) -> bool {
        self.made.iter().take(self.plan.connections.len()).all(|made| made.stage == Stage::Established)
    }

    pub(super) fn stop_talking(&mut self) {
        self.conversation.cancel();
        self.task = Task::None;
        self.explicit = None;
        self.dynamic = false;
        self.keep_time();
    }

    /// Carries out what the conversation wants of its timer.
    pub(super) fn keep_time(&mut self) {
        self.conversation.take_timer().apply(&mut self.timers, SlotTimer::Conversation);
    }
}

impl Made {
    const NEW: Self = Self {
        stage: Stage::Idle,
        instance: None,
        produces: None,
        rate: 0,
        consumes: None,
        watch: Timers::new(),
    };

    /// Only an established connection is watched.
    pub(super) fn set(&mut self, stage: Stage) {
        self.stage = stage;
        self.watch.clear(Watch);
    }

    /// Something was heard of it, at that moment: four packet rates until something must be heard again.
    pub(super) fn feed(&mut self, now: link_core::Instant, at_least: Duration) {
        if self.rate != 0 {
            self.watch.advance(now);
            let span = Duration::from_millis(u64::from(self.rate).saturating_mul(4)).max(at_least);
            self.watch.set_after(Watch, span);
        }
    }
}

/// The longest request is ten bytes: an attribute of four in the 16/16 format; the answers are shorter.
const MESSAGE: usize = 16;
