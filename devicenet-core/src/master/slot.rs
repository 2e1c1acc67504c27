//! What the master keeps for one slave.

use core::time::Duration;

use cip_core::code::{AttributeId, ClassId, InstanceId, ServiceCode};
use cip_core::fragment::IoReassembly;
use cip_core::message::BodyFormat;
use heapless::Vec;
use link_core::Timers;
use link_core::timers::TimerKey;

use super::event::{SlaveCounters, SlaveEvent};
use super::scan_list::{IoInstance, ScanEntry};
use super::state::{Cause, EDGES, SlaveState, Stage};
use super::status::ScannerStatus;
use crate::client::{Conversation, Route, Waits};
use crate::counter::count;
use crate::id::MacId;

/// One slave: its entry, its state, its data.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Slot<const N: usize> {
    pub(super) entry: ScanEntry,
    /// Attribute writes before the I/O starts; see [`super::writes`].
    pub(super) writes: Vec<u8, N>,
    pub(super) stage: Stage,
    pub(super) status: ScannerStatus,
    pub(super) conversation: Conversation<N>,
    /// The connection that the UCMM opened.
    pub(super) opened: Option<InstanceId>,
    /// The body format of the explicit connection of the predefined set.
    pub(super) format: BodyFormat,
    /// Nobody answered when it was last contacted.
    pub(super) absent: bool,
    /// It answered to the UCMM, not on the unconnected port, when it was last contacted.
    pub(super) ucmm: bool,
    /// The other door has not been tried in this attempt.
    pub(super) other_door: bool,
    /// Failed attempts since it last ran, for the back-off.
    pub(super) failures: u8,
    pub(super) talk: Talk<N>,
    pub(super) output: Output<N>,
    pub(super) inputs: [Input<N>; 4],
    pub(super) acknowledge_due: bool,
    pub(super) timers: Timers<SlotTimer, 8>,
    pub(super) counters: SlaveCounters,
    pub(super) events: Vec<SlaveEvent, EVENTS>,
    pub(super) events_lost: u16,
}

/// The application's request.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Talk<const N: usize> {
    pub(super) stage: TalkStage,
    pub(super) service: ServiceCode,
    pub(super) class: ClassId,
    pub(super) instance: InstanceId,
    pub(super) attribute: Option<AttributeId>,
    pub(super) tries: u8,
    /// The service data; then the response from the service byte on.
    pub(super) data: Vec<u8, N>,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum TalkStage {
    /// Nothing was asked, or the response is there.
    Idle,
    /// The explicit connection is made anew.
    Connecting,
    /// `reconnect`: if nobody answers, the connection may have timed out.
    Asking { reconnect: bool },
    /// The response is there; the connection that the UCMM opened for it is closed.
    Closing,
    /// The application asked nothing: the slave is asked whose it is.
    Verifying,
}

/// What a slave, or a multicast group, consumes.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Output<const N: usize> {
    /// As the application set it.
    pub(super) wanted: Vec<u8, N>,
    /// As it is being sent, so that no message is torn.
    pub(super) sent: Vec<u8, N>,
    pub(super) strobe_bit: bool,
    /// Without poll: what is to be sent by itself.
    pub(super) sending: Sending,
    /// Without poll: it changed while it was sent.
    pub(super) changed: bool,
}

/// Where a message is that is sent without being part of the scan.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Sending {
    Idle,
    /// From this fragment on.
    Due(usize),
    HandedOut,
}

/// What the slave produces over one instance.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Input<const N: usize> {
    pub(super) reassembly: IoReassembly<N>,
    pub(super) data: Vec<u8, N>,
    pub(super) received: bool,
    /// The expected packet rate that the slave said it uses, in ms.
    pub(super) rate: u16,
    /// What the last message was like.
    pub(super) status: ScannerStatus,
}

/// The waits for one slave.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum SlotTimer {
    Conversation,
    Retry,
    Watchdog(IoInstance),
    /// The transmission trigger of the output data.
    Trigger,
    /// A check of its MAC ID was heard while it was configured or ran, and nobody has objected.
    Restart,
}

impl TimerKey<8> for SlotTimer {
    const ALL: [Self; 8] = [
        Self::Conversation,
        Self::Retry,
        Self::Watchdog(IoInstance::Poll),
        Self::Watchdog(IoInstance::BitStrobe),
        Self::Watchdog(IoInstance::ChangeOfState),
        Self::Watchdog(IoInstance::MulticastPoll),
        Self::Trigger,
        Self::Restart,
    ];
    const WHY: [&'static str; 8] = [
        "explicit response",
        "next attempt at a slave",
        "slave watchdog",
        "slave watchdog",
        "slave watchdog",
        "slave watchdog",
        "output transmission trigger",
        "objection to a duplicate MAC ID check",
    ];

    fn index(self) -> usize {
        match self {
            Self::Conversation => 0,
            Self::Retry => 1,
            Self::Watchdog(instance) => instance.index().saturating_add(2),
            Self::Trigger => 6,
            Self::Restart => 7,
        }
    }
}

impl<const N: usize> Slot<N> {
    pub(super) fn new(entry: ScanEntry, own: MacId) -> Self {
        let input = |instance| {
            let size = entry.agreed(instance).and_then(|agreed| agreed.produce).unwrap_or(0);
            Input {
                reassembly: IoReassembly::new(size.into()),
                data: Vec::new(),
                received: false,
                rate: 0,
                status: ScannerStatus::NORMAL,
            }
        };
        Self {
            entry,
            writes: Vec::new(),
            stage: Stage::Offline,
            status: ScannerStatus::INITIALISING,
            conversation: Conversation::new(Route::group2_unconnected(own, entry.mac_id), Waits::UNCONNECTED),
            opened: None,
            format: BodyFormat::Class8Instance8,
            absent: false,
            ucmm: false,
            other_door: false,
            failures: 0,
            talk: Talk {
                stage: TalkStage::Idle,
                service: ServiceCode::NO_OPERATION,
                class: ClassId::IDENTITY,
                instance: InstanceId::CLASS,
                attribute: None,
                tries: 0,
                data: Vec::new(),
            },
            output: Output::zeroed(entry.output_len()),
            inputs: IoInstance::ALL.map(input),
            acknowledge_due: false,
            timers: Timers::new(),
            counters: SlaveCounters::default(),
            events: Vec::new(),
            events_lost: 0,
        }
    }

    pub(super) fn input(&self, instance: IoInstance) -> Option<&Input<N>> {
        self.inputs.get(instance.index())
    }

    pub(super) fn input_mut(&mut self, instance: IoInstance) -> Option<&mut Input<N>> {
        self.inputs.get_mut(instance.index())
    }

    pub(super) const fn is_running(&self) -> bool {
        matches!(self.stage, Stage::Running)
    }

    /// Whether the output data are sent by themselves instead of with a poll command.
    pub(super) const fn sends_output(&self) -> bool {
        self.entry.poll.is_none() && self.entry.change_of_state.is_some()
    }

    /// The one door between states.
    pub(super) fn enter(&mut self, next: Stage, cause: Cause) {
        let (from, to) = (self.stage.state(), next.state());
        debug_assert!(
            EDGES.iter().any(|edge| (edge.from, edge.cause, edge.to) == (from, cause, to)),
            "{from} -> {to}: {cause} is not in the table"
        );
        #[cfg(test)]
        super::tests::edges::record(from, cause, to);
        if to != SlaveState::Running {
            for instance in IoInstance::ALL {
                self.timers.clear(SlotTimer::Watchdog(instance));
                if let Some(input) = self.input_mut(instance) {
                    input.reassembly.discard();
                    input.received = false;
                    input.status = ScannerStatus::NORMAL;
                }
            }
            self.timers.clear(SlotTimer::Trigger);
            self.timers.clear(SlotTimer::Restart);
            self.acknowledge_due = false;
            self.output.sending = Sending::Idle;
            self.output.changed = false;
        }
        self.stage = next;
        self.raise(SlaveEvent::StateChanged { from, to, cause });
    }

    pub(super) fn set_status(&mut self, status: ScannerStatus) {
        if self.status != status {
            self.status = status;
            self.raise(SlaveEvent::Status(status));
        }
    }

    /// What a message over one instance was like. The slave shows the first instance that is not as it should be.
    pub(super) fn set_io_status(&mut self, instance: IoInstance, status: ScannerStatus) {
        if let Some(input) = self.input_mut(instance) {
            input.status = status;
        }
        let mut statuses = self.inputs.iter().map(|input| input.status);
        let shown = statuses.find(|status| *status != ScannerStatus::NORMAL).unwrap_or_default();
        self.set_status(shown);
    }

    pub(super) fn raise(&mut self, event: SlaveEvent) {
        if self.events.push(event).is_err() {
            count(&mut self.events_lost);
        }
    }

    /// Carries out what the conversation wants of its timer.
    pub(super) fn keep_time(&mut self) {
        self.conversation.take_timer().apply(&mut self.timers, SlotTimer::Conversation);
    }

    /// Starts or restarts the watchdog of an instance: four times the expected packet rate, none for 0.
    pub(super) fn feed_watchdog(&mut self, instance: IoInstance) {
        let rate = self.input(instance).map_or(0, |input| input.rate);
        if rate != 0 {
            let span = Duration::from_millis(u64::from(rate).saturating_mul(WATCHDOG_FACTOR));
            self.timers.set_after(SlotTimer::Watchdog(instance), span);
        }
    }
}

impl<const N: usize> Output<N> {
    /// So many zeros.
    pub(super) fn zeroed(len: usize) -> Self {
        let mut wanted = Vec::new();
        let fits = wanted.resize(len, 0);
        debug_assert!(fits.is_ok(), "the scan list was checked");
        Self { wanted, sent: Vec::new(), strobe_bit: false, sending: Sending::Idle, changed: false }
    }
}

/// The inactivity time-out in expected packet rates.
const WATCHDOG_FACTOR: u64 = 4;
/// As many as one input can raise, and some that were not fetched.
const EVENTS: usize = 8;
