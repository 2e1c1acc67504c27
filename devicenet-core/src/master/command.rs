//! What the application can ask, and tell.

use core::time::Duration;

use cip_core::codec::{Wire, Writer};
use cip_core::message::{AttributeRequest, Request, Response, Target};
use heapless::Vec;
use link_core::Instant;

use super::board::NotAdded;
use super::event::{Counters, SlaveCounters};
use super::machine::{Master, Timer};
use super::scan_list::{IoInstance, ScanEntry, ScanListError};
use super::slot::{Output, Sending, Slot, SlotTimer, TalkStage};

use super::state::{Cause, SlaveState, Stage};
use super::status::ScannerStatus;
use super::writes::AttributeWrite;
use crate::access::{self, Access, Fault, StateKind};
use crate::client::StartError;
use crate::id::MacId;
use crate::slave;

/// Why a command was not carried out.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CommandError {
    /// The scan list does not allow it.
    #[error(transparent)]
    ScanList(#[from] ScanListError),
    /// Output data have the size that the scan list says.
    #[error("{found} bytes of output data, {expected} in the scan list: send as many")]
    OutputLength {
        /// In the scan list.
        expected: usize,
        /// Given.
        found: usize,
    },
    /// Explicit messages of the application have to wait until the slave runs.
    #[error("the slave is not running: wait for its StateChanged event")]
    NotRunning,
    /// One request at a time.
    #[error("a request to this slave is under way: wait for its Response or RequestFailed event")]
    Busy,
    /// The path of the request names no class.
    #[error("the path of the request names no object: give it a class and an instance")]
    NoObject,
    /// The request cannot be sent.
    #[error(transparent)]
    Request(StartError),
    /// Network access refuses it.
    #[error(transparent)]
    Access(#[from] access::CommandError),
}

impl<const SLAVES: usize, const MESSAGE: usize> Master<SLAVES, MESSAGE> {
    /// Adds a slave, which is brought up at once if the master is on line.
    pub fn add_slave(&mut self, now: Instant, entry: ScanEntry) -> Result<(), ScanListError> {
        self.advance(now);
        if entry.mac_id == self.access().mac_id() {
            return Err(ScanListError::OwnMacId(entry.mac_id));
        }
        entry.check(MESSAGE)?;
        let group = self.slots.iter().find_map(|slot| slot.entry.multicast_poll);
        match (entry.multicast_poll, group) {
            (Some(poll), Some(group)) if poll.consume != group.consume => {
                return Err(ScanListError::GroupSize { expected: group.consume, found: poll.consume });
            }
            _ => {}
        }
        let mut slot = Slot::new(entry, self.access().mac_id());
        slot.timers.advance(now);
        if self.on_line {
            slot.enter(Stage::Waiting, Cause::MasterOnLine);
            slot.timers.set_after(SlotTimer::Retry, Duration::ZERO);
        }
        self.board.add(&mut self.slots, slot).map_err(|why| match why {
            NotAdded::Listed => ScanListError::AlreadyListed(entry.mac_id),
            NotAdded::Full => ScanListError::Full(SLAVES),
        })?;
        if let (Some(poll), None) = (entry.multicast_poll, group) {
            self.multicast_output = Output::zeroed(poll.consume.into());
        }
        self.filter_due = self.on_line;
        Ok(())
    }

    /// Removes a slave. Its connections are not released: they time out, unless their expected packet rate is 0.
    pub fn remove_slave(&mut self, slave: MacId) -> Result<(), ScanListError> {
        if !self.board.remove(&mut self.slots, slave) {
            return Err(ScanListError::NotListed(slave));
        }
        self.cycle.forget(slave);
        self.filter_due = self.on_line;
        Ok(())
    }

    /// Starts anew, as after a power cycle: the way out of a fault of its own network access. All slaves are brought up
    /// again.
    pub fn reset(&mut self, now: Instant) {
        self.advance(now);
        self.node.reset(now);
        self.follow_access();
    }

    /// Starts anew with another MAC ID.
    pub fn set_mac_id(&mut self, now: Instant, mac_id: MacId) -> Result<(), CommandError> {
        self.advance(now);
        if self.board.listed().contains(mac_id) {
            return Err(ScanListError::AlreadyListed(mac_id).into());
        }
        self.node.set_mac_id(now, mac_id)?;
        self.follow_access();
        Ok(())
    }

    /// What is written to a slave before its I/O starts, in this order.
    pub fn set_configuration(
        &mut self,
        slave: MacId,
        writes: &[AttributeWrite<'_>],
    ) -> Result<(), ScanListError> {
        let slot = self.board.get_mut(&mut self.slots, slave).ok_or(ScanListError::NotListed(slave))?;
        let mut buffer = [0; MESSAGE];
        let mut out = Writer::new(&mut buffer);
        for write in writes {
            write.emit(&mut out).map_err(|_| ScanListError::TooManyWrites(MESSAGE))?;
        }
        slot.writes = Vec::from_slice(out.written()).map_err(|_| ScanListError::TooManyWrites(MESSAGE))?;
        Ok(())
    }

    /// Run, or idle: an idle master sends its commands without data. A new master is idle.
    pub fn set_run(&mut self, run: bool) {
        if self.run == run {
            return;
        }
        self.run = run;
        for slot in self.board.all_mut(&mut self.slots) {
            if slot.sends_output() && slot.is_running() {
                slot.output_changed();
            }
        }
    }

    /// The output data of a slave: with its next poll, or at once if it is not polled.
    pub fn set_output(&mut self, slave: MacId, data: &[u8]) -> Result<(), CommandError> {
        let slot = self.board.get_mut(&mut self.slots, slave).ok_or(ScanListError::NotListed(slave))?;
        if !slot.output.set(data)? {
            return Ok(());
        }
        if slot.sends_output() && slot.is_running() {
            slot.output_changed();
        }
        Ok(())
    }

    /// The output bit of a slave in the bit-strobe command.
    pub fn set_strobe_bit(&mut self, slave: MacId, bit: bool) -> Result<(), CommandError> {
        let slot = self.board.get_mut(&mut self.slots, slave).ok_or(ScanListError::NotListed(slave))?;
        slot.output.strobe_bit = bit;
        Ok(())
    }

    /// The output data of the multicast poll group: as many bytes as its slaves consume.
    pub fn set_multicast_output(&mut self, data: &[u8]) -> Result<(), CommandError> {
        self.multicast_output.set(data).map(|_| ())
    }

    /// What a slave produced last over an instance; `None` if nothing yet, or not since it was lost.
    #[must_use]
    pub fn input_data(&self, slave: MacId, instance: IoInstance) -> Option<&[u8]> {
        let input = self.board.get(&self.slots, slave)?.input(instance)?;
        input.received.then_some(input.data.as_slice())
    }

    /// Asks a slave that runs. The answer is a [`Response`](super::SlaveEvent::Response) or
    /// [`RequestFailed`](super::SlaveEvent::RequestFailed) event. A service that may be carried out twice can be tried more
    /// than once.
    pub fn request(
        &mut self,
        now: Instant,
        slave: MacId,
        request: &Request<'_>,
        tries: u8,
    ) -> Result<(), CommandError> {
        let (Some(class), Some(instance)) = (request.target.class(), request.target.instance()) else {
            return Err(CommandError::NoObject);
        };
        self.talk(now, slave, tries, |talk| {
            talk.service = request.service;
            talk.class = class;
            talk.instance = instance;
            talk.attribute = match request.target {
                Target::Path(path) => path.logical().ok().and_then(|path| path.attribute),
                Target::Object { .. } => None,
            };
            request.data
        })
    }

    /// Reads or writes one attribute of a slave that runs; see [`request`](Self::request).
    pub fn request_attribute(
        &mut self,
        now: Instant,
        slave: MacId,
        request: &AttributeRequest<'_>,
        tries: u8,
    ) -> Result<(), CommandError> {
        self.talk(now, slave, tries, |talk| {
            talk.service = request.service;
            talk.class = request.class;
            talk.instance = request.instance;
            talk.attribute = Some(request.attribute);
            request.value
        })
    }

    fn talk<'a>(
        &mut self,
        now: Instant,
        slave: MacId,
        tries: u8,
        fill: impl FnOnce(&mut super::slot::Talk<MESSAGE>) -> &'a [u8],
    ) -> Result<(), CommandError> {
        self.advance(now);
        let own = self.access().mac_id();
        let slot = self.board.get_mut(&mut self.slots, slave).ok_or(ScanListError::NotListed(slave))?;
        if !slot.is_running() {
            return Err(CommandError::NotRunning);
        }
        slot.end_verification(&self.config, own);
        if slot.talk.stage != TalkStage::Idle || slot.conversation.is_busy() {
            return Err(CommandError::Busy);
        }
        let data = fill(&mut slot.talk);
        slot.talk.tries = tries;
        let started = match Vec::from_slice(data) {
            Ok(data) => {
                slot.talk.data = data;
                slot.begin_talk(&self.config, own)
            }
            Err(_) => Err(StartError::TooLong { capacity: MESSAGE }),
        };
        if started.is_err() {
            // It is no response either.
            slot.talk.data.clear();
            slot.close(&self.config, own);
        }
        started.map_err(CommandError::Request)
    }

    /// The response that the last [`Response`](super::SlaveEvent::Response) event told of.
    #[must_use]
    pub fn response(&self, slave: MacId) -> Option<Response<'_>> {
        let slot = self.board.get(&self.slots, slave)?;
        match slot.talk.stage {
            TalkStage::Idle | TalkStage::Closing | TalkStage::Verifying => {
                Response::parse(&slot.talk.data).ok()
            }
            TalkStage::Connecting | TalkStage::Asking { .. } => None,
        }
    }

    /// Brings a slave up anew, for example after its configuration was changed.
    pub fn restart_slave(&mut self, now: Instant, slave: MacId) -> Result<(), CommandError> {
        self.advance(now);
        let slot = self.board.get_mut(&mut self.slots, slave).ok_or(ScanListError::NotListed(slave))?;
        if slot.stage != Stage::Offline {
            slot.failures = 0;
            slot.abandon_talk();
            slot.wait(Cause::Commanded, ScannerStatus::INITIALISING, Duration::ZERO);
        }
        Ok(())
    }

    /// Its own network access.
    #[must_use]
    pub const fn access(&self) -> &Access {
        self.node.access()
    }

    /// What is counted for the master as a node that answers others.
    #[must_use]
    pub const fn node_counters(&self) -> &slave::Counters {
        self.node.counters()
    }

    /// True in run mode.
    #[must_use]
    pub const fn is_running(&self) -> bool {
        self.run
    }

    /// The scan list, in the order of the MAC IDs.
    pub fn scan_list(&self) -> impl ExactSizeIterator<Item = &ScanEntry> {
        self.slots.iter().map(|slot| &slot.entry)
    }

    /// Where the master is with a slave.
    #[must_use]
    pub fn state(&self, slave: MacId) -> Option<SlaveState> {
        self.board.get(&self.slots, slave).map(|slot| slot.stage.state())
    }

    /// The scanner status of a slave.
    #[must_use]
    pub fn status(&self, slave: MacId) -> Option<ScannerStatus> {
        self.board.get(&self.slots, slave).map(|slot| slot.status)
    }

    /// The scanner's own status.
    ///
    /// | Status | When |
    /// |---|---|
    /// | 70 | another node has its MAC ID |
    /// | 91 | bus-off |
    /// | 92 | the link is down |
    /// | 79 | nobody acknowledges what it sends |
    /// | 84 | it checks its MAC ID |
    /// | 74 | its controller has lost frames in the last ten seconds |
    /// | 75, 76 | the scan list is empty; with 76 other nodes were heard |
    /// | 80 | it is idle |
    #[must_use]
    pub fn own_status(&self) -> ScannerStatus {
        match self.access().fault() {
            Some(Fault::DuplicateMacId) => ScannerStatus::DUPLICATE_MAC_ID,
            Some(Fault::BusOff) => ScannerStatus::BUS_OFF,
            None if self.access().state().kind() == StateKind::NonExistent => ScannerStatus::NO_NETWORK_POWER,
            None if self.unacknowledged => ScannerStatus::TRANSMIT_FAILED,
            None if !self.on_line => ScannerStatus::INITIALISING,
            None if self.timers.at(Timer::Overrun).is_some() => ScannerStatus::DATA_OVERRUN,
            None if self.board.listed().is_empty() && self.counters.unrelated == 0 => {
                ScannerStatus::NO_TRAFFIC
            }
            None if self.board.listed().is_empty() => ScannerStatus::NO_DIRECT_TRAFFIC,
            None if !self.run => ScannerStatus::SCANNER_IDLE,
            None => ScannerStatus::NORMAL,
        }
    }

    /// What is counted for a slave.
    #[must_use]
    pub fn slave_counters(&self, slave: MacId) -> Option<&SlaveCounters> {
        self.board.get(&self.slots, slave).map(|slot| &slot.counters)
    }

    /// What is counted for the master.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Moves every stored moment `span` towards zero, so that states that differ in the time of day only are equal.
    pub fn shift_time(&mut self, span: Duration) {
        self.node.shift_time(span);
        self.timers.shift(span);
        self.board.shift(&mut self.slots, span);
        self.candidate.timers.shift(span);
    }
}

impl<const N: usize> Slot<N> {
    fn output_changed(&mut self) {
        match self.output.sending {
            Sending::Idle | Sending::Due(0) => self.output.sending = Sending::Due(0),
            Sending::Due(_) | Sending::HandedOut => self.output.changed = true,
        }
    }
}

impl<const N: usize> Output<N> {
    /// Takes new data; true if they differ.
    fn set(&mut self, data: &[u8]) -> Result<bool, CommandError> {
        let expected = self.wanted.len();
        if data.len() != expected {
            return Err(CommandError::OutputLength { expected, found: data.len() });
        }
        let changed = self.wanted != data;
        self.wanted.copy_from_slice(data);
        Ok(changed)
    }
}
