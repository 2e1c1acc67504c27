//! Leaving the network on purpose: Reset, and a new MAC ID. The response goes out first.

use cip_core::message::ResetType;
use link_core::timers::TimerSet;
use link_core::{BitRate, Instant};

use super::allocation::Door;
use super::application::{Application, Parts};
use super::config::Options;
use super::event::{Ignored, SlaveEvent};
use super::machine::{Errand, Needed, Slave, changes};
use crate::access::MacIdSource;
use crate::id::MacId;

/// What follows when the response has been sent.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Departure {
    why: Why,
    door: Door,
    stage: Stage,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Why {
    Reset(ResetType),
    MacId(MacId),
}

/// How far it is.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Stage {
    /// The response is to be sent.
    Response,
    /// The shutdown message is to be sent.
    Shutdown,
}

impl Departure {
    pub(super) const fn reset(kind: ResetType, door: Door) -> Self {
        Self { why: Why::Reset(kind), door, stage: Stage::Response }
    }

    pub(super) const fn mac_id(mac: MacId, door: Door) -> Self {
        Self { why: Why::MacId(mac), door, stage: Stage::Response }
    }

    pub(super) const fn is_reset(&self) -> bool {
        matches!(self.why, Why::Reset(_))
    }

    pub(super) const fn is_shutting_down(&self) -> bool {
        matches!(self.stage, Stage::Shutdown)
    }
}

impl<A: Application, const MESSAGE: usize, const DYNAMIC: usize> Slave<A, MESSAGE, DYNAMIC> {
    /// A node that is about to leave serves nobody: the response that is on its way is the last.
    pub(super) const fn check_departure(&self) -> Result<(), Ignored> {
        if self.node.departure.is_some() { Err(Ignored::Leaving) } else { Ok(()) }
    }

    /// Goes on if the response has been sent.
    pub(super) fn follow_departure(&mut self) {
        let Some(departure) = &mut self.node.departure else { return };
        if A::PARTS.contains(Parts::SHUTDOWN_MESSAGE) && departure.stage != Stage::Response {
            return;
        }
        let is_sent = match departure.door {
            Door::Dynamic(index) if DYNAMIC > 0 => {
                self.transfers.get(usize::from(index)).is_none_or(|transfer| transfer.transfer.is_quiet())
            }
            Door::Predefined | Door::Unconnected | Door::Dynamic(_) => self.explicit.is_quiet(),
        };
        if !is_sent {
            return;
        }
        let says_so = A::PARTS.contains(Parts::SHUTDOWN_MESSAGE)
            && self.node.options.contains(Options::SHUTDOWN_MESSAGE);
        if says_so && self.node.access.is_online() {
            departure.stage = Stage::Shutdown;
        } else {
            self.leave();
        }
    }

    /// The response, and the shutdown message if there was to be one, have been sent, or never will be.
    pub(super) fn leave(&mut self) {
        let now = self.node.timers.now();
        match self.node.departure.take() {
            Some(Departure { why: Why::MacId(mac), .. }) if A::PARTS.contains(Parts::SETTINGS) => {
                // That it can be set was checked when the request was answered.
                let _ = self.node.access.set_mac_id_within::<Needed<A>>(now, mac);
                self.look_for_errands();
            }
            Some(Departure { why: Why::Reset(kind), .. }) => {
                let mac = self.reset_configuration(kind);
                self.reset_with(now, mac);
                self.node.events.raise::<A>(SlaveEvent::Reset(kind));
            }
            Some(Departure { why: Why::MacId(_), .. }) | None => {}
        }
    }

    /// Starts anew, as after a power cycle; a stored bit rate takes effect.
    pub fn reset(&mut self, now: Instant) {
        self.node.advance(now);
        self.reset_with(now, self.node.access.mac_id());
        self.expect_output();
        self.follow();
    }

    /// Starts anew with another MAC ID, as an operator's command; over the network the DeviceNet object does it.
    ///
    /// # Errors
    /// [`MacIdFromSwitches`](crate::access::CommandError::MacIdFromSwitches) if switches set it.
    pub fn set_mac_id(&mut self, now: Instant, mac: MacId) -> Result<(), crate::access::CommandError> {
        self.node.advance(now);
        self.node.access.set_mac_id_within::<Needed<A>>(now, mac)?;
        self.look_for_errands();
        self.expect_output();
        self.follow();
        Ok(())
    }

    fn reset_with(&mut self, now: Instant, mac: MacId) {
        self.look_for_errands();
        if has_rates::<A>() && self.node.port.active != self.node.port.stored {
            self.node.port.active = self.node.port.stored;
            self.errand = Errand::Mode;
        }
        if changes::<A>() {
            self.node.acknowledge = cip_core::object::AcknowledgeSettings::default();
        }
        self.node.access.reset_within::<Needed<A>>(now, mac);
    }

    /// Reset types 1 and 2: what is stored becomes as it was out of the box. Returns the MAC ID to start with.
    fn reset_configuration(&mut self, kind: ResetType) -> MacId {
        let mac = self.node.access.mac_id();
        let is_out_of_box = kind == ResetType::OUT_OF_BOX || kind == ResetType::OUT_OF_BOX_KEEP_COMMUNICATION;
        if !is_out_of_box || !A::PARTS.intersects(STORED) {
            return mac;
        }
        if A::PARTS.contains(Parts::HEARTBEAT)
            && self.node.heartbeat_interval.is_some_and(|seconds| seconds != 0)
        {
            self.node.heartbeat_interval = Some(0);
            self.node.events.raise::<A>(SlaveEvent::StoreHeartbeatInterval(0));
        }
        if kind == ResetType::OUT_OF_BOX_KEEP_COMMUNICATION || !A::PARTS.contains(Parts::SETTINGS) {
            return mac;
        }
        if A::PARTS.contains(Parts::OPTIONAL_ATTRIBUTES) && self.node.access.quick_connect() {
            self.node.access.set_quick_connect(false);
            self.node.events.raise::<A>(SlaveEvent::StoreQuickConnect(false));
        }
        if !self.node.port.rate_from_switches {
            self.node.port.stored = BitRate::K125;
            self.node.events.raise::<A>(SlaveEvent::StoreBitRate(BitRate::K125));
        }
        if self.node.access.config().mac_id_source == MacIdSource::Switches {
            return mac;
        }
        self.node.events.raise::<A>(SlaveEvent::StoreMacId(MacId::DEFAULT));
        MacId::DEFAULT
    }
}

/// Whether the node can have another bit rate than the one it began with.
pub(super) const fn has_rates<A: Application>() -> bool {
    A::PARTS.intersects(Parts::SETTINGS.union(Parts::BIT_RATE_DETECTION))
}

/// The parts of which something is kept over power cycles.
const STORED: Parts = Parts::SETTINGS.union(Parts::HEARTBEAT).union(Parts::OPTIONAL_ATTRIBUTES);
