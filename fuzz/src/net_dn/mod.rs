//! Whole networks: two masters that want the same slaves, a slave that may have the MAC ID of another, and in some of them a
//! UCMM-capable slave and a tool that repairs faulted nodes.
//!
//! The bus is the simplest that there is: of all frames in flight the one with the lowest identifier is sent next, and
//! everybody hears it. Byte 0 is what the network is like:
//!
//! | Bits | Content |
//! |---|---|
//! | 1-0 | the place of the third slave; 0 and 1 are those of the others, 2 is that of the UCMM-capable one |
//! | 4 | the UCMM-capable slave and the tool are there; the second master tries the UCMM first |
//! | 5 | the bus-off interrupt of all nodes is 1: after bus-off on line they come back |
//! | 6 | the UCMM-capable slave has no unconnected port in group 2 |
//!
//! Then each operation is one byte with its argument behind it; below 0xF0 it is taken modulo 8:
//!
//! | Byte | Operation | Argument |
//! |---|---|---|
//! | 0-2 | the network runs | [span](crate::input::span) |
//! | 3 | the power of a node fails and comes back | which |
//! | 4 | a node misses the next frames | which in bits 2-0, how many in bits 7-3 |
//! | 5 | a master runs with these outputs; 0: it is idle | value, bit 7 the master |
//! | 6 | the inputs of the slaves change | value |
//! | 7 | a stranger asks for a slave, or says something else | which |
//! | 0xF0-0xF7 | the tool does something | what in bits 2-0, to which slave in bits 4-3, a new MAC ID in bits 7-5 |
//! | 0xF8-0xFF | a controller goes bus-off | whose |
//!
//! What must hold is judged by an observer who sees who really sends what: it is the module `referee`.

mod node;
mod referee;
#[cfg(test)]
mod tests;

use core::time::Duration;

use devicenet_core::MacId;
use devicenet_core::master;
use devicenet_core::message::{DelayOffset, NodeSelection};
use devicenet_core::slave::{self, SlaveEvent};
use link_core::frame::standard_id;
use link_core::{Action, Frame, Input, Instant, LinkCommand, LinkEvent, TxOutcome};

use devicenet_tests::line::mac as mac_id;

use node::{Device, Node, Plan, Role, known_as};
use referee::Referee;

/// Lets a network live as the bytes say.
pub fn run(data: &[u8]) {
    let Some((plan, operations)) = crate::input::plan_and_operations(data, MOST_OPERATIONS) else { return };
    let mut network = Network::new(plan);
    for [op, argument] in operations {
        network.apply(op, argument);
    }
    network.come_to_rest();
}

struct Network {
    nodes: Vec<Node>,
    now: Instant,
    referee: Referee,
}

impl Network {
    fn new(plan: u8) -> Self {
        let plan = Plan(plan);
        let (macs, nodes): (Vec<u8>, Vec<Node>) = plan.nodes().into_iter().unzip();
        let known = macs.iter().zip(&nodes).map(|(&mac, node)| (mac, node.device.role()));
        let referee = Referee::new(known, plan.bus_off_interrupt());
        let mut network = Self { referee, nodes, now: Instant::ZERO };
        for at in 0..network.nodes.len() {
            network.input(at, Input::Link(LinkEvent::Up));
        }
        network
    }

    fn apply(&mut self, op: u8, argument: u8) {
        let anyone = usize::from(argument) % self.nodes.len();
        match op {
            0xF0..=0xF7 => return self.use_tool(argument),
            0xF8.. => return self.bus_off(anyone),
            _ => {}
        }
        match op % 8 {
            0..=2 => self.run_for(crate::input::span(argument).min(LONGEST_RUN)),
            3 => {
                self.referee.power_cycle(anyone);
                (self.nodes[anyone].off, self.nodes[anyone].returns) = (false, None);
                self.input(anyone, Input::Link(LinkEvent::Down));
                self.drop_all(anyone);
                self.input(anyone, Input::Link(LinkEvent::Up));
            }
            4 => {
                let at = usize::from(argument & 7) % self.nodes.len();
                self.nodes[at].deaf = argument >> 3;
            }
            5 => {
                let at = usize::from(argument >> 7);
                if let Device::Master(master) = &mut self.nodes[at].device {
                    master.set_run(argument & 0x7F != 0);
                    let listed: Vec<MacId> = master.scan_list().map(|entry| entry.mac_id).collect();
                    for slave in listed {
                        master.set_output(slave, &[argument]).expect("it takes a byte");
                    }
                }
                self.drain(at);
            }
            6 => {
                for (at, node) in (0..).zip(&mut self.nodes) {
                    if let Some(block) = node.device.block_mut() {
                        block.inputs = [argument, at];
                    }
                }
            }
            _ => self.stranger(argument),
        }
    }

    fn use_tool(&mut self, argument: u8) {
        let Some(at) = self.nodes.iter().position(|node| node.device.role() == Role::Tool) else { return };
        let now = self.now;
        let Device::Tool(tool) = &mut self.nodes[at].device else { return };
        let device = known_as(FIRST_SLAVE + u32::from(argument >> 3 & 3));
        // What it may not do now it refuses.
        let _ = match argument & 7 {
            0 | 1 => tool.claim(now),
            2 => tool.who(now, DelayOffset::SERIAL),
            3 => tool.identify(now, NodeSelection::ALL),
            4 => tool.identify_device(now, device),
            5 | 6 => tool.change_mac_id(now, device, mac_id(NEW_MACS[usize::from(argument >> 5)])),
            _ => {
                tool.release(now);
                self.referee.released(at);
                Ok(())
            }
        };
        self.drain(at);
    }

    /// The controller of a node has had too many errors: it is off the bus, and what it had to send is lost.
    fn bus_off(&mut self, at: usize) {
        if core::mem::replace(&mut self.nodes[at].off, true) {
            return;
        }
        self.nodes[at].returns = None;
        self.referee.bus_off(at, self.now);
        self.input(at, Input::Link(LinkEvent::BusOff));
        self.drop_all(at);
    }

    fn drop_all(&mut self, at: usize) {
        for (token, _) in core::mem::take(&mut self.nodes[at].in_flight) {
            self.input(at, Input::TxDone(token, TxOutcome::Dropped));
        }
    }

    /// MAC ID 40, which is nobody here: it asks for slaves, releases them, polls them under no right, checks, and knows of the
    /// UCMM and of the offline connection set.
    fn stranger(&mut self, what: u8) {
        let slave = u16::from(SLAVES[usize::from(what & 1)]);
        let capable = UCMM_SLAVE;
        let (id, data): (u16, &[u8]) = match what >> 1 & 15 {
            0 => (0x406 | slave << 3, &[40, 0x4B, 3, 1, 0x03, 40]),
            1 => (0x406 | slave << 3, &[40, 0x4C, 3, 1, 0x03]),
            2 => (0x404 | slave << 3, &[40, 0x10, 5, 2, 9, 0, 0]),
            3 => (0x407 | slave << 3, &[0x00, 0x77, 0x77, 1, 0, 0, 0]),
            4 => (0x407 | slave << 3, &[0x80, 0x77, 0x77, 1, 0, 0, 0]),
            5 => (0x780 | 40, &[slave as u8, 0x4B, 0, 0x30]),
            6 => (0x7ED, &[0x3F, 0x4B, 2]),
            7 => (0x404 | slave << 3, &[0xA8, 0x00, 1, 2, 3]),
            // It opens a connection, uses it to ask for the slave, and closes one that may be another's.
            8 => (0x780 | 40, &[capable, 0x4B, 0, 0x30 | (what & 1)]),
            9 => (0x600 | 40 | (u16::from(what) & 1) << 6, &[capable, 0x4B, 3, 1, 0x02, 40]),
            10 => (0x780 | 40, &[capable, 0x4C, 6 + (what & 1), 0]),
            11 => (0x600 | 40, &[capable | 0x80, 0x00, 0x10, 5, 6, 9]),
            12 => (0x406 | u16::from(capable) << 3, &[40, 0x4B, 3, 1, 0x03, 40]),
            // Another tool asks for the offline connection set, or says that it has it.
            13 => (0x7EF, &[40, 0x4B, 0x77, 0x77, 1, 0, 0, 0]),
            14 => (0x7EE, &[40, 0xCB, 0x77, 0x77, 1, 0, 0, 0]),
            _ => (0x7ED, &[13, 0x4D, 0x34, 0x12, 5, 0, 0, 0]),
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
            let deadline = self.nodes.iter().filter_map(Node::deadline).min();
            match deadline.filter(|deadline| *deadline <= until) {
                Some(deadline) => {
                    self.now = self.now.max(deadline);
                    for at in 0..self.nodes.len() {
                        self.wake(at);
                    }
                }
                None => break,
            }
        }
        self.now = self.now.max(until);
    }

    /// A node whose time has come.
    fn wake(&mut self, at: usize) {
        if self.nodes[at].returns.is_some_and(|returns| returns <= self.now) {
            (self.nodes[at].off, self.nodes[at].returns) = (false, None);
            self.referee.returned(at);
            self.input(at, Input::Link(LinkEvent::Up));
        }
        if self.nodes[at].device.deadline().is_some_and(|next| next <= self.now) {
            self.input(at, Input::Tick);
        }
    }

    /// Everybody but the sender hears it, unless they are off the bus or miss it.
    fn deliver(&mut self, sender: Option<usize>, frame: &Frame) {
        for at in (0..self.nodes.len()).filter(|at| Some(*at) != sender) {
            if self.nodes[at].off {
                continue;
            }
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
            match node.device.poll(self.now) {
                None => return self.judge(at),
                Some(Action::Transmit(token, frame)) => {
                    assert!(!node.off, "{frame}: its controller is bus-off");
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
                Some(Action::Link(LinkCommand::Reset)) => {
                    assert!(node.off, "a controller is reset that is on the bus");
                    self.referee.restarts(at, self.now);
                    node.returns = Some(self.now + RECOVERY);
                }
                Some(
                    Action::Event(_) | Action::Link(LinkCommand::SetMode(_) | LinkCommand::SetFilter(_)),
                ) => {}
            }
        }
        panic!("more than {MOST_ACTIONS} actions at once");
    }

    /// What a node knows must be what was sent.
    fn judge(&self, at: usize) {
        let device = &self.nodes[at].device;
        if let Some(block) = device.block() {
            self.referee.outputs(at, block.outputs[0]);
        }
        if let Device::Master(master) = device {
            for entry in master.scan_list() {
                let input = master.input_data(entry.mac_id, master::IoInstance::Poll);
                self.referee.inputs(at, entry.mac_id.number(), input);
            }
        }
    }

    /// Undisturbed, every slave on line that is alone with its MAC ID, and is not the stranger's for ever, has exactly one
    /// master, which knows it.
    fn come_to_rest(&mut self) {
        self.nodes.iter_mut().for_each(|node| node.deaf = 0);
        self.run_for(REST);
        let online: Vec<usize> =
            (0..self.nodes.len()).filter(|&at| self.referee.is_online(at, self.now)).collect();
        let masters = online.iter().filter_map(|&at| match &self.nodes[at].device {
            Device::Master(master) => Some((self.referee.mac(at), &**master)),
            Device::Slave(_) | Device::Capable(_) | Device::Tool(_) => None,
        });
        let masters: Vec<_> = masters.collect();
        for &at in online.iter().filter(|&&at| self.nodes[at].device.role() == Role::Slave) {
            let mac = self.referee.mac(at);
            let is_listed = masters.iter().any(|(_, master)| master.state(mac_id(mac)).is_some());
            // Twins that missed each other's checks are both on line.
            let is_alone = online.iter().filter(|&&other| self.referee.mac(other) == mac).count() == 1;
            if !is_listed || !is_alone {
                continue;
            }
            let runs = masters.iter().filter_map(|(number, master)| {
                let runs = master.state(mac_id(mac)) == Some(master::SlaveState::Running);
                runs.then_some(*number)
            });
            let runs: Vec<u8> = runs.collect();
            let owner: Vec<u8> = self.referee.owner(at).into_iter().collect();
            // It has set the expected packet rate to 0, which ends never, and it never asks whose the slave is.
            if owner == [STRANGER] {
                continue;
            }
            assert_eq!(runs, owner, "who runs slave {mac}, and who owns it");
            assert_eq!(owner.len(), 1, "slave {mac} is left alone");
        }
    }
}

impl Node {
    /// When something happens in it by itself.
    fn deadline(&self) -> Option<Instant> {
        self.device.deadline().into_iter().chain(self.returns).min()
    }
}

const MASTERS: [u8; 2] = [4, 5];
const SLAVES: [u8; 2] = [10, 11];
const UCMM_SLAVE: u8 = 12;
const TOOL: u8 = 62;
/// Nobody here.
const STRANGER: u8 = 40;
/// The serial number of the first slave.
const FIRST_SLAVE: u32 = 3;
/// What the tool gives away: those of slaves and of a master, free ones, and its own.
const NEW_MACS: [u8; 8] = [SLAVES[0], SLAVES[1], UCMM_SLAVE, 13, 14, MASTERS[1], 40, TOOL];
/// At 500 kbit/s.
const FRAME: Duration = Duration::from_micros(250);
/// 128 times 11 bits.
const RECOVERY: Duration = Duration::from_micros(2816);
const LONGEST_RUN: Duration = Duration::from_secs(12);
/// Longer than any time-out and any pause of a master.
const REST: Duration = Duration::from_secs(90);
const MOST_OPERATIONS: usize = 40;
const MOST_ACTIONS: usize = 64;
