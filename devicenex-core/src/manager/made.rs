//! What the manager keeps for one planned connection.

use core::time::Duration;

use cip_core::code::GeneralStatus;
use link_core::Timers;
use link_core::timers::TimerKey;

use super::database::PlannedConnection;
use crate::connection::ConnectionId;

/// A planned connection as it is.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Made {
    pub(super) stage: Stage,
    /// The number of the instance, once it is known.
    pub(super) instance: Option<u16>,
    /// On which the device produces.
    pub(super) produces: Option<ConnectionId>,
    /// In ms, once it is known what the device keeps.
    pub(super) rate: Option<u16>,
    /// What is to be set yet.
    pub(super) due: Settings,
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
    /// It is there, and cannot be made what it should be: to be deleted, and asked for again.
    Ending,
    /// To be asked for after a while.
    Refused(Option<GeneralStatus>),
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

    const fn bit(self) -> u8 {
        match self {
            Self::Trigger => 1 << 0,
            Self::ConsumedId => 1 << 1,
            Self::WatchdogAction => 1 << 2,
            Self::PacketRate => 1 << 3,
        }
    }
}

/// Which of them are to be set.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub(super) struct Settings(u8);

impl Settings {
    pub(super) const fn insert(&mut self, setting: Setting) {
        self.0 |= setting.bit();
    }

    pub(super) const fn remove(&mut self, setting: Setting) {
        self.0 &= !setting.bit();
    }

    pub(super) fn first(self) -> Option<Setting> {
        Setting::ALL.into_iter().find(|setting| self.0 & setting.bit() != 0)
    }
}

/// What is read of a connection that may be there.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Looked {
    State,
    ProducedId,
    ConsumedId,
    Trigger,
    WatchdogAction,
    PacketRate,
}

/// The wait for the next message of a producer.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Watch;

impl TimerKey<1> for Watch {
    const ALL: [Self; 1] = [Self];
    const WHY: [&'static str; 1] = ["message of a producer"];

    fn index(self) -> usize {
        0
    }
}

impl Made {
    pub(super) const NEW: Self = Self {
        stage: Stage::Idle,
        instance: None,
        produces: None,
        rate: None,
        due: Settings(0),
        consumes: None,
        watch: Timers::new(),
    };

    /// It is to be made anew; a dynamic one that is there must be deleted first.
    pub(super) fn renew(&mut self, plan: &PlannedConnection) {
        let is_dynamic = plan.instance.is_none();
        self.set(if is_dynamic && self.instance.is_some() { Stage::Ending } else { Stage::Idle });
    }

    /// It is not there: a dynamic one will have another number.
    pub(super) fn gone(&mut self, plan: &PlannedConnection) {
        self.set(Stage::Idle);
        self.instance = plan.number().map(|number| number.0);
    }

    /// Only an established connection is watched.
    pub(super) fn set(&mut self, stage: Stage) {
        self.stage = stage;
        self.watch.clear(Watch);
    }

    /// Something was heard of it, at that moment: four packet rates until something must be heard again.
    pub(super) fn feed(&mut self, now: link_core::Instant, at_least: Duration) {
        let rate = self.rate.unwrap_or_default();
        if rate != 0 {
            self.watch.advance(now);
            let span = Duration::from_millis(u64::from(rate).saturating_mul(4)).max(at_least);
            self.watch.set_after(Watch, span);
        }
    }
}
