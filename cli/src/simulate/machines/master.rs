//! A master.

use core::time::Duration;
use std::collections::HashMap;

use cip_core::code::{ClassId, InstanceId, ServiceCode};
use cip_core::message::{AllocationChoice, Request, Response, Target};
use devicenet_core::MacId;
use devicenet_core::access::Access;
use devicenet_core::master::{
    AttributeWrite, CommandError, Config, IoInstance, Master, MasterEvent, ScanEntry, ScannerStatus,
    SlaveCounters, SlaveEvent, SlaveState,
};
use devicenet_core::slave;
use link_core::{Action, Deadline, Input, Instant, Machine};

use super::access_config;
use crate::scenario::{MasterNode, Output};
use crate::simulate::Guest;
use crate::simulate::event::NodeEvent;

/// A master of a scenario.
#[derive(Clone, Debug)]
pub(crate) struct MasterMachine {
    master: Box<Master<63, MESSAGE>>,
    /// The MAC ID is kept without power.
    mac: MacId,
    /// The input data that were told.
    told: HashMap<(MacId, IoInstance), Vec<u8>>,
    own_status: ScannerStatus,
    scans: ScanTimes,
    last_scan: Option<Instant>,
    /// Once it is to be gone soon: the slaves that were asked to release their connections, and which.
    leaving: Option<HashMap<MacId, AllocationChoice>>,
}

/// How long scans took, from the end of one to the end of the next.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::simulate) struct ScanTimes {
    pub(in crate::simulate) count: u32,
    pub(in crate::simulate) shortest: Duration,
    pub(in crate::simulate) longest: Duration,
    pub(in crate::simulate) sum: Duration,
}

impl MasterMachine {
    pub(in crate::simulate) fn new(node: &MasterNode) -> Self {
        Self::with(node, access_config(&node.access).mac_id)
    }

    /// As it starts after `self` has lost its power; what was counted is not lost.
    pub(in crate::simulate) fn restarted(&self, node: &MasterNode) -> Self {
        Self { scans: self.scans, ..Self::with(node, self.mac) }
    }

    #[expect(clippy::expect_used, reason = "the scan list was checked with the scenario")]
    fn with(node: &MasterNode, mac: MacId) -> Self {
        let access = devicenet_core::access::Config { mac_id: mac, ..access_config(&node.access) };
        let mut config = Config {
            interscan_delay: node.interscan_delay,
            response_wait: node.response_wait,
            background_ratio: node.background_ratio,
            first_contact: node.first_contact,
            retry_after: node.retry_after,
            retry_at_most: node.retry_at_most,
            replacement: node.replacement,
            replacement_retry: node.replacement_retry,
            ..Config::new(node.access.device.clone(), mac)
        };
        config.node.access = access;
        let mut master = Box::new(Master::new(config));
        // With a switch that was turned, the master can have the MAC ID of a slave: it does without that slave.
        for slave in node.scan.iter().filter(|slave| slave.entry.mac_id != mac) {
            let mac = slave.entry.mac_id;
            master.add_slave(Instant::ZERO, slave.entry).expect("an entry of a scenario");
            let writes: Vec<AttributeWrite<'_>> = (slave.writes.iter())
                .map(|write| AttributeWrite {
                    class: write.class,
                    instance: write.instance,
                    attribute: write.attribute,
                    value: &write.value,
                })
                .collect();
            master.set_configuration(mac, &writes).expect("a configuration of a scenario");
            master.set_output(mac, &slave.output).expect("outputs of a scenario");
            master.set_strobe_bit(mac, slave.strobe_bit).expect("a slave of a scenario");
        }
        // Without the only slave of its group there is no such command.
        if master.scan_list().any(|entry| entry.multicast_poll.is_some()) {
            master.set_multicast_output(&node.multicast_output).expect("outputs of a scenario");
        }
        master.set_run(node.run);
        let own_status = master.own_status();
        Self {
            master,
            mac,
            told: HashMap::new(),
            own_status,
            scans: ScanTimes::default(),
            last_scan: None,
            leaving: None,
        }
    }

    pub(crate) const fn access(&self) -> &Access {
        self.master.access()
    }

    pub(in crate::simulate) fn counters(&self, slave: MacId) -> Option<SlaveCounters> {
        self.master.slave_counters(slave).copied()
    }

    pub(in crate::simulate) const fn scans(&self) -> ScanTimes {
        self.scans
    }

    pub(in crate::simulate) const fn keep_mac_id(&mut self, mac: MacId) {
        self.mac = mac;
    }

    pub(in crate::simulate) fn set_run(&mut self, run: bool) {
        self.master.set_run(run);
    }

    pub(crate) fn set_output(&mut self, output: &Output) -> Result<(), CommandError> {
        match output {
            Output::Slave(mac, data) => self.master.set_output(mac_id(*mac), data),
            Output::StrobeBit(mac, bit) => self.master.set_strobe_bit(mac_id(*mac), *bit),
            Output::Multicast(data) => self.master.set_multicast_output(data),
        }
    }

    /// Has every slave that runs release its connections, and takes those off the scan list that have none. One that is brought
    /// up at the moment is waited for.
    fn let_go(&mut self, now: Instant) {
        let Some(asked) = &mut self.leaving else { return };
        let entries: Vec<ScanEntry> = self.master.scan_list().copied().collect();
        for entry in entries {
            let slave = entry.mac_id;
            match self.master.state(slave) {
                Some(SlaveState::Running) if asked.contains_key(&slave) => continue,
                Some(SlaveState::Running) => {
                    // Acknowledge suppression is no connection.
                    let io = entry.choice().difference(AllocationChoice::ACK_SUPPRESSION);
                    let held = io.union(AllocationChoice::EXPLICIT);
                    match release(&mut self.master, now, slave, held) {
                        Ok(()) => {
                            asked.insert(slave, held);
                            continue;
                        }
                        Err(CommandError::Busy) => continue,
                        Err(_) => {}
                    }
                }
                Some(SlaveState::Contacting | SlaveState::Configuring) => continue,
                Some(SlaveState::Offline | SlaveState::Waiting) | None => {}
            }
            // It is in the list.
            let _ = self.master.remove_slave(slave);
        }
    }

    /// A slave has answered its release. One whose explicit connection is none of the predefined set refuses to release that, and
    /// all the rest with it.
    fn let_gone(&mut self, now: Instant, slave: MacId) {
        let Some(held) = self.leaving.as_mut().and_then(|asked| asked.get_mut(&slave)) else { return };
        let io = held.difference(AllocationChoice::EXPLICIT);
        match self.master.response(slave) {
            Some(Response::Success { .. }) => {
                // It is in the list.
                let _ = self.master.remove_slave(slave);
            }
            Some(Response::Error { .. }) if *held != io && !io.is_empty() => {
                *held = io;
                // When it cannot be asked, it is still held.
                let _ = release(&mut self.master, now, slave, io);
            }
            Some(Response::Error { .. }) | None => {}
        }
    }

    /// Makes what is told complete; `None` tells nothing new.
    fn follow(&mut self, now: Instant, event: MasterEvent) -> Option<NodeEvent> {
        match event {
            MasterEvent::Slave { mac_id, event: SlaveEvent::Response } => self.let_gone(now, mac_id),
            MasterEvent::Access(event) => return Some(NodeEvent::Access(event)),
            MasterEvent::Node(event) => {
                if let slave::SlaveEvent::StoreMacId(mac) = event {
                    self.mac = mac;
                }
                return Some(NodeEvent::Slave(event));
            }
            MasterEvent::NetworkStatus(status) => {
                return Some(NodeEvent::Slave(slave::SlaveEvent::NetworkStatus(status)));
            }
            MasterEvent::Slave { mac_id, event: SlaveEvent::Input(instance) } => {
                let data = self.master.input_data(mac_id, instance)?;
                let told = self.told.entry((mac_id, instance)).or_default();
                if told.as_slice() == data {
                    return None;
                }
                told.clear();
                told.extend_from_slice(data);
                return Some(NodeEvent::Input { slave: mac_id, connection: instance, data: data.into() });
            }
            MasterEvent::Slave {
                mac_id,
                event: SlaveEvent::StateChanged { from: SlaveState::Running, .. },
            } => {
                self.told.retain(|(slave, _), _| *slave != mac_id);
                let is_running = |slave: &devicenet_core::master::ScanEntry| {
                    self.master.state(slave.mac_id) == Some(SlaveState::Running)
                };
                if !self.master.scan_list().any(is_running) {
                    // The next scan begins anew.
                    self.last_scan = None;
                }
            }
            MasterEvent::ScanDone { .. } => {
                if let Some(last) = self.last_scan.replace(now) {
                    self.scans.add(now.saturating_since(last));
                }
            }
            // A release that was not answered is sent again, as long as there is time.
            MasterEvent::Slave { mac_id, event: SlaveEvent::RequestFailed(_) } => {
                if let Some(asked) = &mut self.leaving {
                    asked.remove(&mac_id);
                }
            }
            MasterEvent::Slave { .. } | MasterEvent::Replacement(_) | MasterEvent::EventsLost { .. } => {}
        }
        Some(NodeEvent::Master(event))
    }
}

impl ScanTimes {
    fn add(&mut self, time: Duration) {
        self.shortest = if self.count == 0 { time } else { self.shortest.min(time) };
        self.longest = self.longest.max(time);
        self.sum += time;
        self.count += 1;
    }
}

/// Asks a slave that runs to release connections of the predefined set.
pub(crate) fn release<const MESSAGE: usize>(
    master: &mut Master<63, MESSAGE>,
    now: Instant,
    slave: MacId,
    choice: AllocationChoice,
) -> Result<(), CommandError> {
    let target = Target::Object { class: ClassId::DEVICENET, instance: InstanceId(1) };
    let data = &[choice.bits()];
    master.request(now, slave, &Request { service: ServiceCode::RELEASE, target, data }, 1)
}

impl Guest for MasterMachine {
    fn leave(&mut self, now: Instant) {
        self.leaving = Some(HashMap::new());
        self.let_go(now);
    }

    fn held(&self) -> Vec<MacId> {
        let is_held = |slave: &MacId| {
            !matches!(self.master.state(*slave), None | Some(SlaveState::Offline | SlaveState::Waiting))
        };
        self.master.scan_list().map(|entry| entry.mac_id).filter(is_held).collect()
    }

    fn allocated(&self) -> Vec<MacId> {
        let has_answered = |slave: &MacId| {
            matches!(self.master.state(*slave), Some(SlaveState::Configuring | SlaveState::Running))
        };
        self.master.scan_list().map(|entry| entry.mac_id).filter(has_answered).collect()
    }

    fn unserved(&self) -> Vec<(MacId, ScannerStatus)> {
        let entries = self.master.scan_list().map(|entry| entry.mac_id);
        let idle = entries.filter(|slave| self.master.state(*slave) != Some(SlaveState::Running));
        idle.filter_map(|slave| Some((slave, self.master.status(slave)?))).collect()
    }

    fn access(&self) -> &Access {
        self.master.access()
    }
}

impl Machine for MasterMachine {
    type Event = NodeEvent;

    fn input(&mut self, now: Instant, input: Input) {
        self.master.input(now, input);
    }

    fn poll(&mut self, now: Instant) -> Option<Action<NodeEvent>> {
        while let Some(action) = self.master.poll(now) {
            match action.without_event() {
                Err(event) => {
                    let news = self.follow(now, event);
                    self.let_go(now);
                    if let Some(event) = news {
                        return Some(Action::Event(event));
                    }
                }
                Ok(action) => return Some(action),
            }
        }
        let status = self.master.own_status();
        let is_new = core::mem::replace(&mut self.own_status, status) != status;
        is_new.then_some(Action::Event(NodeEvent::ScannerStatus(status)))
    }

    fn deadline(&self) -> Option<Deadline> {
        self.master.deadline()
    }

    fn max_in_flight(&self) -> usize {
        self.master.max_in_flight()
    }
}

fn mac_id(mac: u8) -> MacId {
    // It was checked with the scenario.
    MacId::new(mac).unwrap_or(MacId::DEFAULT)
}

/// The longest I/O message, and room for a slave's configuration.
const MESSAGE: usize = 448;
