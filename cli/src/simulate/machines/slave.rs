//! A slave.

use devicenet_core::MacId;
use devicenet_core::access::Access;
use devicenet_core::master::ScannerStatus;
use devicenet_core::slave::{
    BitRateConfig, Config, Counters, Event, IoKind, Options, Slave, SlaveEvent, Switches,
};
use link_core::{Action, BitRate, Deadline, Input, Instant, LinkCommand, Machine, Mode};

use super::access_config;
use super::device::Device;
use crate::scenario::SlaveNode;
use crate::simulate::Guest;
use crate::simulate::event::NodeEvent;

/// A slave of a scenario.
#[derive(Clone, Debug)]
pub(crate) struct SlaveMachine {
    slave: Server,
    kept: Kept,
    /// The rate that the controller has at power-up, by its switch.
    switch: BitRate,
    /// The controller is to be told the stored bit rate.
    mode_due: bool,
    /// The outputs that were told, by instance.
    told: [Vec<u8>; 4],
    /// Connections whose outputs are to be looked at.
    due: Vec<IoKind>,
    /// Frames that passed its filter, since power-up.
    received: u64,
}

/// What is kept without power.
#[derive(Clone, Debug)]
struct Kept {
    mac: MacId,
    bit_rate: BitRate,
    quick_connect: bool,
    heartbeat: Option<u8>,
    /// What is at the sensors does not depend on power.
    input: Vec<u8>,
}

#[derive(Clone, Debug)]
enum Server {
    Group2Only(Box<Slave<Device, MESSAGE, 0>>),
    Ucmm(Box<Slave<Device, MESSAGE, CONNECTIONS>>),
}

/// Does the same with whichever slave it is.
macro_rules! with {
    ($server:expr, $slave:ident => $what:expr) => {
        match $server {
            Server::Group2Only($slave) => $what,
            Server::Ucmm($slave) => $what,
        }
    };
}

impl SlaveMachine {
    pub(in crate::simulate) fn new(node: &SlaveNode, bit_rate: BitRate) -> Self {
        let kept = Kept {
            mac: access_config(&node.access).mac_id,
            bit_rate,
            quick_connect: node.access.quick_connect,
            heartbeat: node.heartbeat,
            input: node.input.clone(),
        };
        Self::with(node, bit_rate, kept)
    }

    /// As it starts after `self` has lost its power.
    pub(in crate::simulate) fn restarted(&self, node: &SlaveNode) -> Self {
        Self::with(node, self.switch, self.kept.clone())
    }

    fn with(node: &SlaveNode, switch: BitRate, kept: Kept) -> Self {
        let mut device = Device::new(node);
        device.input.clone_from(&kept.input);
        let mut config = Config::new(&node.access.device, kept.mac);
        config.access = devicenet_core::access::Config {
            mac_id: kept.mac,
            quick_connect: kept.quick_connect,
            ..access_config(&node.access)
        };
        config.bit_rate = BitRateConfig {
            detect: node.detects_bit_rate,
            from_switches: node.access.switches,
            ..BitRateConfig::new(kept.bit_rate)
        };
        config.heartbeat_interval = kept.heartbeat;
        config.options.set(Options::SHUTDOWN_MESSAGE, node.shutdown_message);
        config.options.set(Options::UNCONNECTED_PORT, node.unconnected_port);
        let mut slave = if node.ucmm {
            Server::Ucmm(server(config, device))
        } else {
            Server::Group2Only(server(config, device))
        };
        if node.access.switches {
            let rate = match switch {
                BitRate::K250 => 1,
                BitRate::K500 => 2,
                _ => 0,
            };
            let switches = Switches { mac_id: kept.mac.number(), bit_rate: rate };
            with!(&mut slave, slave => slave.set_switches(switches));
        }
        let told = IoKind::ALL.map(|kind| with!(&slave, slave => slave.application().output(kind).to_vec()));
        let mode_due = switch != kept.bit_rate && !node.detects_bit_rate;
        Self { slave, kept, switch, mode_due, told, due: Vec::new(), received: 0 }
    }

    pub(crate) fn access(&self) -> &Access {
        with!(&self.slave, slave => slave.access())
    }

    pub(in crate::simulate) fn counters(&self) -> Counters {
        with!(&self.slave, slave => *slave.counters())
    }

    /// Frames that passed the filter that it asked for, since power-up.
    pub(crate) const fn received(&self) -> u64 {
        self.received
    }

    pub(in crate::simulate) fn reset(&mut self, now: Instant) {
        with!(&mut self.slave, slave => slave.reset(now));
    }

    pub(in crate::simulate) const fn keep_mac_id(&mut self, mac: MacId) {
        self.kept.mac = mac;
    }

    /// The switch is turned; the controller follows by itself.
    pub(in crate::simulate) const fn turn_bit_rate_switch(&mut self, rate: BitRate) {
        (self.switch, self.kept.bit_rate) = (rate, rate);
    }

    pub(crate) fn set_input(&mut self, now: Instant, data: &[u8]) {
        self.keep_input(data);
        with!(&mut self.slave, slave => {
            if slave.application().input != data {
                slave.application_mut().input = data.to_vec();
                slave.inputs_changed(now);
            }
        });
    }

    pub(in crate::simulate) fn keep_input(&mut self, data: &[u8]) {
        self.kept.input = data.to_vec();
    }

    /// Keeps what is to be kept, and makes what is told complete; `None` tells nothing new.
    fn follow(&mut self, event: Event) -> Option<NodeEvent> {
        let event = match event {
            Event::Access(event) => return Some(NodeEvent::Access(event)),
            Event::Slave(event) => event,
        };
        match event {
            SlaveEvent::Received(kind) => {
                self.due.push(kind);
                return None;
            }
            SlaveEvent::Mode(kind, _) => self.due.push(kind),
            SlaveEvent::Io { connection, to, .. } => {
                let is_owned = to == cip_core::connection::IoState::Established;
                with!(&mut self.slave, slave => slave.application_mut().own(connection, is_owned));
            }
            SlaveEvent::StoreMacId(mac) => self.kept.mac = mac,
            SlaveEvent::StoreBitRate(rate) => self.kept.bit_rate = rate,
            SlaveEvent::StoreQuickConnect(on) => self.kept.quick_connect = on,
            SlaveEvent::StoreHeartbeatInterval(seconds) => self.kept.heartbeat = Some(seconds),
            _ => {}
        }
        Some(NodeEvent::Slave(event))
    }

    /// Outputs that have changed.
    fn output(&mut self) -> Option<NodeEvent> {
        while let Some(kind) = self.due.pop() {
            let output = with!(&self.slave, slave => slave.application().output(kind));
            let told = &mut self.told[usize::from(kind.instance().0) - 2];
            if output != told.as_slice() {
                told.clear();
                told.extend_from_slice(output);
                return Some(NodeEvent::Output { connection: kind, data: told.as_slice().into() });
            }
        }
        None
    }
}

impl Guest for SlaveMachine {
    /// It is gone as one whose power is.
    fn leave(&mut self, _: Instant) {}

    fn held(&self) -> Vec<MacId> {
        Vec::new()
    }

    fn allocated(&self) -> Vec<MacId> {
        Vec::new()
    }

    fn unserved(&self) -> Vec<(MacId, ScannerStatus)> {
        Vec::new()
    }

    fn access(&self) -> &Access {
        self.access()
    }
}

impl Machine for SlaveMachine {
    type Event = NodeEvent;

    fn input(&mut self, now: Instant, input: Input) {
        self.received += u64::from(matches!(input, Input::Frame(_)));
        with!(&mut self.slave, slave => slave.input(now, input));
    }

    fn poll(&mut self, now: Instant) -> Option<Action<NodeEvent>> {
        if core::mem::take(&mut self.mode_due) {
            let mode = Mode { bit_rate: self.kept.bit_rate, listen_only: false };
            return Some(Action::Link(LinkCommand::SetMode(mode)));
        }
        loop {
            if let Some(event) = self.output() {
                return Some(Action::Event(event));
            }
            let action =
                with!(&mut self.slave, slave => slave.poll(now))?.map_event(|event| self.follow(event));
            if let Some(action) = action.transpose() {
                return Some(action);
            }
        }
    }

    fn deadline(&self) -> Option<Deadline> {
        with!(&self.slave, slave => slave.deadline())
    }

    fn max_in_flight(&self) -> usize {
        with!(&self.slave, slave => slave.max_in_flight())
    }
}

#[expect(clippy::expect_used, reason = "the sizes were checked with the scenario")]
fn server<const DYNAMIC: usize>(config: Config, device: Device) -> Box<Slave<Device, MESSAGE, DYNAMIC>> {
    Box::new(Slave::new(config, device).expect("a device of a scenario"))
}

/// Of explicit messages.
const MESSAGE: usize = 512;
/// That clients of a slave with the UCMM can open.
const CONNECTIONS: usize = 8;
