//! Whole networks: two masters that want the same two slaves, and a third slave that may have the MAC ID of another.
//!
//! The bus is the simplest that there is: of all frames in flight the one with the lowest identifier is sent next, and
//! everybody hears it. Byte 0 is the place of the third slave: bits 1-0, of which 0 and 1 are those of the others. Then each
//! operation is one byte, modulo 8, with its argument behind it:
//!
//! | Byte | Operation | Argument |
//! |---|---|---|
//! | 0-2 | the network runs | [span](crate::input::span) |
//! | 3 | the power of a node fails and comes back | which |
//! | 4 | a node misses the next frames | which in bits 2-0, how many in bits 7-3 |
//! | 5 | a master runs with these outputs; 0: it is idle | value, bit 7 the master |
//! | 6 | the inputs of the slaves change | value |
//! | 7 | a stranger asks for a slave, or says something else | which |
//!
//! What must hold is judged by an observer who sees who really sends what: it is the module `referee`.

mod referee;

use core::time::Duration;

use arbitrary::Unstructured;
use cip_core::code::DeviceType;
use cip_core::identity::{DeviceIdentity, ProductName, Revision};
use cip_core::message::AllocationChoice;
use cip_core::object::Identity;
use devicenet_core::MacId;
use devicenet_core::master::{self, Master, PollConnection, ScanEntry};
use devicenet_core::slave::{self, Application, Group2OnlyServer, IoKind, SlaveEvent};
use link_core::frame::standard_id;
use link_core::{Action, Frame, Input, Instant, LinkEvent, Machine, TxOutcome, TxToken};

use referee::Referee;

/// Lets a network live as the bytes say.
pub fn run(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let Ok(third) = input.arbitrary::<u8>() else { return };
    let mut network = Network::new(third);
    let mut left = MOST_OPERATIONS;
    while let (false, Ok([op, argument])) = (input.is_empty() || left == 0, input.arbitrary::<[u8; 2]>()) {
        network.apply(op, argument);
        left -= 1;
    }
    network.come_to_rest();
}

/// Two bytes in, one byte out, by poll.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct Block {
    device: DeviceIdentity,
    inputs: [u8; 2],
    outputs: [u8; 1],
}

impl Application for Block {
    const IO: AllocationChoice = AllocationChoice::POLL;
    type Long = ();

    fn identity(&self) -> Identity<'_> {
        Identity::new(&self.device)
    }

    fn produced(&self, _: IoKind) -> &[u8] {
        &self.inputs
    }

    fn consumed(&mut self, _: IoKind) -> &mut [u8] {
        &mut self.outputs
    }
}

enum Device {
    Master(Box<Master<2, 32>>),
    Slave(Box<Group2OnlyServer<Block>>),
}

/// A node, and its controller.
struct Node {
    mac: u8,
    device: Device,
    in_flight: Vec<(TxToken, Frame)>,
    /// So many frames are not heard.
    deaf: u8,
}

struct Network {
    nodes: Vec<Node>,
    now: Instant,
    referee: Referee,
}

impl Network {
    fn new(third: u8) -> Self {
        let macs = [MASTERS[0], MASTERS[1], SLAVES[0], SLAVES[1], SLAVES[0] + third % 4];
        let mut nodes: Vec<Node> = Vec::new();
        for (serial, mac) in (1..).zip(macs) {
            let device = if serial <= 2 {
                Device::Master(scanner(serial, mac))
            } else {
                Device::Slave(block(serial, mac))
            };
            nodes.push(Node { mac, device, in_flight: Vec::new(), deaf: 0 });
        }
        let mut network = Self { referee: Referee::new(&macs), nodes, now: Instant::ZERO };
        for at in 0..macs.len() {
            network.input(at, Input::Link(LinkEvent::Up));
        }
        network
    }

    fn apply(&mut self, op: u8, argument: u8) {
        match op % 8 {
            0..=2 => self.run_for(crate::input::span(argument).min(LONGEST_RUN)),
            3 => {
                let at = usize::from(argument) % self.nodes.len();
                self.referee.power_cycle(at);
                self.input(at, Input::Link(LinkEvent::Down));
                for (token, _) in core::mem::take(&mut self.nodes[at].in_flight) {
                    self.input(at, Input::TxDone(token, TxOutcome::Dropped));
                }
                self.input(at, Input::Link(LinkEvent::Up));
            }
            4 => {
                let at = usize::from(argument & 7) % self.nodes.len();
                self.nodes[at].deaf = argument >> 3;
            }
            5 => {
                if let Device::Master(master) = &mut self.nodes[usize::from(argument >> 7)].device {
                    master.set_run(argument & 0x7F != 0);
                    for slave in SLAVES {
                        master
                            .set_output(mac_id(slave), &[argument])
                            .expect("it is listed, and takes a byte");
                    }
                }
                self.drain(usize::from(argument >> 7));
            }
            6 => {
                for node in &mut self.nodes {
                    if let Device::Slave(slave) = &mut node.device {
                        slave.application_mut().inputs = [argument, node.mac];
                    }
                }
            }
            _ => self.stranger(argument),
        }
    }

    /// MAC ID 40, which is nobody here: it asks for slaves, releases them, polls them under no right, and checks.
    fn stranger(&mut self, what: u8) {
        let slave = u16::from(SLAVES[usize::from(what & 1)]);
        let (id, data): (u16, &[u8]) = match what >> 1 & 7 {
            0 => (0x406 | slave << 3, &[40, 0x4B, 3, 1, 0x03, 40]),
            1 => (0x406 | slave << 3, &[40, 0x4C, 3, 1, 0x03]),
            2 => (0x404 | slave << 3, &[40, 0x10, 5, 2, 9, 0, 0]),
            3 => (0x407 | slave << 3, &[0x00, 0x77, 0x77, 1, 0, 0, 0]),
            4 => (0x407 | slave << 3, &[0x80, 0x77, 0x77, 1, 0, 0, 0]),
            5 => (0x780 | 40, &[slave as u8, 0x4B, 0, 0x30]),
            6 => (0x7ED, &[0x3F, 0x4B, 2]),
            _ => (0x404 | slave << 3, &[0xA8, 0x00, 1, 2, 3]),
        };
        let frame = Frame::new(standard_id(id), data).expect("at most eight bytes");
        self.deliver(None, &frame);
    }

    fn run_for(&mut self, span: Duration) {
        let until = self.now + span;
        loop {
            let next = self.nodes.iter().enumerate().flat_map(|(at, node)| {
                node.in_flight.iter().enumerate().map(move |(place, (_, frame))| (frame.raw_id(), at, place))
            });
            if let Some((_, at, place)) = next.min() {
                let (token, frame) = self.nodes[at].in_flight.remove(place);
                self.now += FRAME;
                self.referee.sent(at, self.now, &frame);
                self.deliver(Some(at), &frame);
                self.input(at, Input::TxDone(token, TxOutcome::Sent));
                continue;
            }
            let deadline = self.nodes.iter().filter_map(|node| node.device.deadline()).min();
            match deadline.filter(|deadline| *deadline <= until) {
                Some(deadline) => {
                    self.now = self.now.max(deadline);
                    for at in 0..self.nodes.len() {
                        if self.nodes[at].device.deadline().is_some_and(|next| next <= self.now) {
                            self.input(at, Input::Tick);
                        }
                    }
                }
                None => break,
            }
        }
        self.now = self.now.max(until);
    }

    /// Everybody but the sender hears it, unless they miss it.
    fn deliver(&mut self, sender: Option<usize>, frame: &Frame) {
        for at in (0..self.nodes.len()).filter(|at| Some(*at) != sender) {
            if self.nodes[at].deaf > 0 {
                self.nodes[at].deaf -= 1;
                continue;
            }
            self.referee.heard(at, self.now, sender, frame);
            self.input(at, Input::Frame(*frame));
        }
    }

    fn input(&mut self, at: usize, input: Input) {
        let now = self.now;
        self.nodes[at].device.input(now, input);
        self.drain(at);
    }

    fn drain(&mut self, at: usize) {
        for _ in 0..MOST_ACTIONS {
            let node = &mut self.nodes[at];
            let action = match &mut node.device {
                Device::Master(master) => master.poll(self.now).map(|action| action.map_event(|_| None)),
                Device::Slave(slave) => slave.poll(self.now).map(|action| action.map_event(Some)),
            };
            match action {
                None => return self.judge(at),
                Some(Action::Transmit(token, frame)) => {
                    assert!(
                        node.in_flight.iter().all(|(other, _)| *other != token),
                        "{frame}: its token is in flight"
                    );
                    node.in_flight.push((token, frame));
                    assert!(node.in_flight.len() <= node.device.max_in_flight());
                }
                Some(Action::Withdraw(token)) => {
                    if let Some(place) = node.in_flight.iter().position(|(other, _)| *other == token) {
                        node.in_flight.remove(place);
                        node.device.input(self.now, Input::TxDone(token, TxOutcome::Withdrawn));
                    }
                }
                Some(Action::Event(Some(slave::Event::Slave(SlaveEvent::Allocation { master, .. })))) => {
                    self.referee.owned(at, master.map(MacId::number));
                }
                Some(Action::Event(Some(slave::Event::Slave(SlaveEvent::Received(_))))) => {
                    self.referee.consumed(at)
                }
                Some(Action::Event(_) | Action::Link(_)) => {}
            }
        }
        panic!("more than {MOST_ACTIONS} actions at once");
    }

    /// What a node knows must be what was sent.
    fn judge(&self, at: usize) {
        match &self.nodes[at].device {
            Device::Slave(slave) => self.referee.outputs(at, slave.application().outputs[0]),
            Device::Master(master) => {
                for slave in SLAVES {
                    let input = master.input_data(mac_id(slave), master::IoInstance::Poll);
                    self.referee.inputs(at, slave, input);
                }
            }
        }
    }

    /// Undisturbed, every slave on line that is alone with its MAC ID has exactly one master, which knows it.
    fn come_to_rest(&mut self) {
        self.nodes.iter_mut().for_each(|node| node.deaf = 0);
        self.run_for(REST);
        let masters: Vec<usize> = (0..2).filter(|&at| self.referee.is_online(at, self.now)).collect();
        for at in 2..self.nodes.len() {
            let mac = self.nodes[at].mac;
            let online = |at: &usize| self.nodes[*at].mac == mac && self.referee.is_online(*at, self.now);
            // Twins that missed each other's checks are both on line.
            let is_alone = (2..self.nodes.len()).filter(online).eq([at]);
            if masters.is_empty() || !SLAVES.contains(&mac) || !is_alone {
                continue;
            }
            let running = |&&master: &&usize| match &self.nodes[master].device {
                Device::Master(scanner) => scanner.state(mac_id(mac)) == Some(master::SlaveState::Running),
                Device::Slave(_) => false,
            };
            let runs: Vec<u8> =
                masters.iter().filter(running).map(|&master| self.nodes[master].mac).collect();
            let owner: Vec<u8> = self.referee.owner(at).into_iter().collect();
            assert_eq!(runs, owner, "who runs slave {mac}, and who owns it");
            assert_eq!(owner.len(), 1, "slave {mac} is left alone");
        }
    }
}

impl Device {
    fn input(&mut self, now: Instant, input: Input) {
        match self {
            Self::Master(master) => master.input(now, input),
            Self::Slave(slave) => slave.input(now, input),
        }
    }

    fn deadline(&self) -> Option<Instant> {
        let deadline = match self {
            Self::Master(master) => master.deadline(),
            Self::Slave(slave) => slave.deadline(),
        };
        deadline.map(|deadline| deadline.at)
    }

    fn max_in_flight(&self) -> usize {
        match self {
            Self::Master(master) => master.max_in_flight(),
            Self::Slave(slave) => slave.max_in_flight(),
        }
    }
}

fn scanner(serial: u32, mac: u8) -> Box<Master<2, 32>> {
    let mut config = master::Config::new(identity(serial), mac_id(mac));
    // Slow, so that a run has more to do with what happens than with polls.
    config.interscan_delay = Duration::from_millis(500);
    // Two masters that knock at the same moments for ever would be a network of its own.
    config.retry_after = Duration::from_millis(1000 + 300 * u64::from(serial));
    let mut master = Master::new(config);
    for slave in SLAVES {
        let poll = PollConnection { produce: 2, consume: 1, expected_packet_rate: 1500 };
        let entry = ScanEntry { poll: Some(poll), ..ScanEntry::explicit_only(mac_id(slave)) };
        master.add_slave(Instant::ZERO, entry).expect("there is room");
    }
    Box::new(master)
}

fn block(serial: u32, mac: u8) -> Box<Group2OnlyServer<Block>> {
    let device = identity(serial);
    let config = slave::Config::new(&device, mac_id(mac));
    let block = Block { device, inputs: [0, mac], outputs: [0] };
    Box::new(Group2OnlyServer::new(config, block).expect("its messages fit into frames"))
}

/// A fictitious vendor.
fn identity(serial: u32) -> DeviceIdentity {
    DeviceIdentity {
        vendor: 0x1234.into(),
        device_type: DeviceType::GENERIC,
        product_code: 1,
        revision: Revision::new(1, 1).expect("not zero"),
        serial,
        name: ProductName::new("node").expect("short"),
    }
}

fn mac_id(number: u8) -> MacId {
    MacId::new(number).expect("up to 63")
}

const MASTERS: [u8; 2] = [4, 5];
const SLAVES: [u8; 2] = [10, 11];
/// At 500 kbit/s.
const FRAME: Duration = Duration::from_micros(250);
const LONGEST_RUN: Duration = Duration::from_secs(12);
/// Longer than any time-out and any pause of a master.
const REST: Duration = Duration::from_secs(90);
const MOST_OPERATIONS: usize = 40;
const MOST_ACTIONS: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;

    fn after(bytes: &[u8]) -> Network {
        run(bytes);
        let mut network = Network::new(bytes[0]);
        for op in bytes[1..].chunks(2) {
            network.apply(op[0], op[1]);
        }
        network
    }

    #[test]
    fn every_slave_has_one_of_the_masters() {
        let network = after(&[2, 0, 0xC5, 5, 7, 5, 0x87, 0, 0xC5]);
        for at in [2, 3] {
            assert!(network.referee.owner(at).is_some_and(|owner| MASTERS.contains(&owner)));
        }
    }

    #[test]
    fn of_two_nodes_with_one_mac_id_one_is_on_line_at_most() {
        let network = after(&[0, 0, 0xC5]);
        let online = [2, 4].map(|at| network.referee.is_online(at, network.now));
        assert_ne!(online, [true, true]);
    }
}
